"""Files on the disk of the controller.

Instructions and functions manual, Open, Write, ReadStr, Rewind, IsFile and their kin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.rapid.disk import MODES, OpenFile, opened
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.predefined import NUMBERS, TEXTS
from assistant.virtual.rapid.values import Handle, text_of

LONGEST: Final = 80
LINE_END: Final = "\n"
KINDS: Final = ("num", "bool", "pos", "orient", "dnum")


def _handle(given: Given) -> Handle:
    handle = given.place(0).get()
    if not isinstance(handle, Handle) or handle.type != "iodev":
        raise Fault("what is no file is used as one")
    return handle


def _file(given: Given) -> OpenFile:
    inside = _handle(given).inside
    if not isinstance(inside, OpenFile):
        raise Fault("a file that is not open", "ERR_FILEACC")
    return inside


def _open(given: Given) -> None:
    machine = given.machine
    name, file = given.text(0), given.optional("file", "string")
    handle = given.place(1).get()
    if not isinstance(handle, Handle) or handle.type != "iodev":
        raise Fault("what is no file is opened as one")
    if handle.inside is not None:
        raise NotSimulated("Open of what is open")
    modes = [mode for mode in MODES if given.has(mode)]
    if len(modes) != 1:
        raise NotSimulated("Open of a file without one of Read, Write and Append")
    path = machine.controller.disk.path(name, file if isinstance(file, str) else "")
    found = opened(path, modes[0])
    handle.inside = found
    machine.at_end.append(found.close)


def _close(given: Given) -> None:
    _file(given).close()
    _handle(given).inside = None


def _rewind(given: Given) -> None:
    _file(given).rewind()


def _write(given: Given) -> None:
    values = [given.optional(kind, kind) for kind in KINDS if given.has(kind)]
    said = [given.text(1), *(text_of(value) for value in values if value is not None)]
    _file(given).write("".join(said) + ("" if given.has("nonewline") else LINE_END))


def _read(given: Given) -> str:
    _asks_outside(given)
    ends = LINE_END + _delimiters(given)
    line = _file(given).read(ends, LONGEST, given.has("discardheaders"))
    if line is None:
        return TEXTS["eof"]
    return line.removesuffix("\r") if given.has("removecr") else line


def _read_number(given: Given) -> float:
    _asks_outside(given)
    line = _file(given).read(LINE_END + _delimiters(given), LONGEST, headers=False)
    if line is None:
        return NUMBERS["eof_num"]
    try:
        return float(line)
    except ValueError:
        raise Fault(f"`{line}` is no number", "ERR_RCVDATA") from None


def _delimiters(given: Given) -> str:
    more = given.optional("delim", "string")
    return more if isinstance(more, str) else ""


def _asks_outside(given: Given) -> None:
    if given.machine.controller.disk.outside:
        given.machine.hangs_on.add("outside")


def _is_file(given: Given) -> bool:
    """Whether there is such a file; of a kind that is asked for, which there has to be."""
    _asks_outside(given)
    path = given.machine.controller.disk.path(given.text(0))
    asked = [
        kind
        for kind in ("directory", "regfile", "fifo", "blockspec", "charspec")
        if given.has(kind)
    ]
    if not asked:
        return path.exists()
    if not path.exists():
        raise Fault(f"there is no `{path.name}`", "ERR_FILEACC")
    return (asked == ["directory"] and path.is_dir()) or (asked == ["regfile"] and path.is_file())


def _size(given: Given) -> float:
    _asks_outside(given)
    path = given.machine.controller.disk.path(given.text(0))
    if not path.is_file():
        raise Fault(f"there is no file `{path.name}`", "ERR_FILEACC")
    return float(path.stat().st_size)


def _changes(act: Callable[[Given], None]) -> Callable[[Given], None]:
    """What the disk does not allow is an error that the program can recover from."""

    def does(given: Given) -> None:
        try:
            act(given)
        except FileExistsError as error:
            raise Fault(str(error.strerror), "ERR_FILEEXIST") from None
        except OSError as error:
            raise Fault(str(error.strerror), "ERR_FILEACC") from None

    return does


@_changes
def _remove(given: Given) -> None:
    given.machine.controller.disk.path(given.text(0)).unlink()


@_changes
def _make_folder(given: Given) -> None:
    given.machine.controller.disk.path(given.text(0)).mkdir()


@_changes
def _remove_folder(given: Given) -> None:
    given.machine.controller.disk.path(given.text(0)).rmdir()


@_changes
def _rename(given: Given) -> None:
    disk = given.machine.controller.disk
    old, new = disk.path(given.text(0)), disk.path(given.text(1))
    if new.exists():
        raise Fault(f"there is a `{new.name}` already", "ERR_FILEEXIST")
    old.rename(new)


@_changes
def _copy(given: Given) -> None:
    disk = given.machine.controller.disk
    old, new = disk.path(given.text(0)), disk.path(given.text(1))
    if new.exists():
        raise Fault(f"there is a `{new.name}` already", "ERR_FILEEXIST")
    new.write_bytes(old.read_bytes())


INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        takes("Open", 2, _open, "file read write append"),
        takes("Close", 1, _close),
        takes("Rewind", 1, _rewind),
        takes("Write", 2, _write, f"{' '.join(KINDS)} nonewline"),
        takes("RemoveFile", 1, _remove),
        takes("RenameFile", 2, _rename),
        takes("CopyFile", 2, _copy),
        takes("MakeDir", 1, _make_folder),
        takes("RemoveDir", 1, _remove_folder),
    )
)
FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        takes("ReadStr", 1, _read, "delim removecr discardheaders time"),
        takes("ReadNum", 1, _read_number, "delim time"),
        takes("IsFile", 1, _is_file, "directory fifo regfile blockspec charspec"),
        takes("FileSize", 1, _size),
    )
)
r"""Files that are read and written at once or in bytes (`\Bin`), and serial lines, are not
simulated.
"""
