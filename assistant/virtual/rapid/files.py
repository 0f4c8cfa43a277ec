"""Instructions and functions for files on the controller's disk.

Manual of instructions and functions, Open, Write, ReadStr and similar ones. A file that is opened
with the option `Bin` is for bytes, any other for lines; ReadBin reads both. Written data is on the
disk at once.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Final

from assistant.base.file_access import read_file, write_whole
from assistant.virtual.events import Sent
from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.disk import CODES, MODES, UNITS, Stream
from assistant.virtual.rapid.expressions import LONGEST_TEXT, whole
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.records import NUMBER_DATA, TEXT_DATA, number
from assistant.virtual.rapid.value_text import read_value
from assistant.virtual.rapid.values import NUMBER, Array, Handle, single, text_of

_SERIAL: Final = re.compile(r"com\d:", re.IGNORECASE)
LINE: Final = "\n"
ENDS: Final = "\r\n"
r"""Characters that are always added to those of \Delim."""


def _path(given: Given, index: int) -> Path:
    return given.machine.controller.disk.path(given.text(index))


def _asks_outside(given: Given) -> None:
    """Note that an awaited change may come from outside the run."""
    if given.machine.controller.disk.outside:
        given.machine.hangs_on.add("outside")


def _handle(given: Given, type: str, index: int = 0) -> Handle:
    value = given.place(index).get()
    if not isinstance(value, Handle) or value.type != type:
        raise Fault(f"what is no {type} is used as one")
    return value


def _stream(given: Given, binary: bool | None = None) -> Stream:
    """The file that is open. binary: what it has to be opened for, None for either."""
    stream = _handle(given, "iodev").inside
    if not isinstance(stream, Stream):
        raise Fault("a file that is not open", "ERR_FILEACC")
    if binary is not None and stream.binary is not binary:
        raise Fault("a file of bytes is used as one of lines, or the other way", "ERR_FILEACC")
    return stream


def _open(given: Given) -> None:
    handle, said = _handle(given, "iodev", 1), given.machine.task.kernel.peers
    # A serial port without a peer is a name of a file like any other.
    if said is not None and _SERIAL.fullmatch(given.text(0)):
        handle.inside = Stream.of_peer(said, given.has("bin"))
        return
    modes = [mode for mode in MODES if given.has(mode)]
    if len(modes) != 1:
        raise NotSimulated("Open of a file without one of Read, Write and Append")
    file = given.optional("file", "string")
    if isinstance(handle.inside, Stream):
        raise NotSimulated("Open of what is open")
    path = given.machine.controller.disk.path(given.text(0), file if isinstance(file, str) else "")
    handle.inside = Stream.open(path, modes[0], given.has("bin"))
    # A program may end without Close.
    given.machine.at_end.append(handle.inside.close)


def _close(given: Given) -> None:
    handle = _handle(given, "iodev")
    if isinstance(handle.inside, Stream):
        handle.inside.close()
    handle.inside = None


def _write(given: Given) -> None:
    values = [given.optional(kind, kind) for kind in _KINDS.split() if given.has(kind)]
    texts = [given.text(1), *(text_of(value) for value in values if value is not None)]
    line = "".join(texts) + ("" if given.has("nonewline") else LINE)
    _put(given, line.encode(CODES, "replace"), binary=False)


def _write_bytes(given: Given) -> None:
    buffer, count = given.value(1), whole(given.number(2), "a number of bytes")
    if not isinstance(buffer, Array) or not 0 <= count <= len(buffer.items):
        raise Fault(f"{count} bytes of what does not have them", "ERR_OUTOFBND")
    codes = [whole(number(item), "a byte") for item in buffer.items[:count]]
    if not all(0 <= code < 256 for code in codes):
        raise Fault("a byte that is not 0 to 255", UNSURE)
    _put(given, bytes(codes), binary=True)


def _write_text(given: Given) -> None:
    _put(given, given.text(1).encode(CODES, "replace"), binary=True)


def _put(given: Given, data: bytes, *, binary: bool) -> None:
    stream = _stream(given, binary)
    stream.write(data)
    if stream.is_line:
        given.machine.task.tell(Sent(data))


def _rewind(given: Given) -> None:
    _stream(given).rewind()


def _read_line(given: Given) -> str:
    """ReadStr, without the delimiter; `EOF` where nothing is left."""
    _asks_outside(given)
    stream = _stream(given, binary=False)
    stated = given.optional_number("line")
    if stated is not None:
        line = whole(stated, "the number of a line")
        if line < 1:
            raise Fault(f"the line {line} of a file", UNSURE)
        stream.rewind()
        for _ in range(line - 1):
            stream.skip_line()
    text = stream.until(_delimiters(given), LONGEST_TEXT, given.has("discardheaders"))
    if text is None:
        return TEXT_DATA["eof"]
    return text.removesuffix("\r") if given.has("removecr") else text


def _delimiters(given: Given) -> str:
    stated = given.optional("delim", "string")
    return stated + ENDS if isinstance(stated, str) else LINE


def _read_number(given: Given) -> float:
    _asks_outside(given)
    text = _stream(given, binary=False).until(_delimiters(given), LONGEST_TEXT)
    if text is None:
        return NUMBER_DATA["eof_num"]
    value = read_value(text, NUMBER, given.machine.types)
    if not isinstance(value, float):
        raise Fault(f"`{text}` as a number", "ERR_RCVDATA")
    return value


def _read_byte(given: Given) -> float:
    byte = _stream(given).read(1)
    return float(byte[0]) if byte else NUMBER_DATA["eof_bin"]


def _read_text(given: Given) -> str:
    count = whole(given.number(1), "a number of characters")
    if count > LONGEST_TEXT:
        raise Fault(f"{count} characters for a string", "ERR_STRTOOLNG")
    if count < 0:
        raise Fault(f"{count} characters are asked for", UNSURE)
    found = _stream(given, binary=True).read(count)
    return found.decode(CODES) if found or not count else TEXT_DATA["eof"]


def _is_file(given: Given) -> bool:
    """Without a switch whether it exists; with one whether it is of that type."""
    _asks_outside(given)
    path = _path(given, 0)
    asked = [check for name, check in _TYPES.items() if given.has(name)]
    if not asked:
        return path.exists()
    if not path.exists():
        raise Fault(f"there is no `{path.name}`", "ERR_FILEACC")
    return asked[0](path)


def _size(given: Given) -> float:
    _asks_outside(given)
    path = _path(given, 0)
    if not path.is_file():
        raise Fault(f"there is no file `{path.name}`", "ERR_FILEACC")
    return single(float(path.stat().st_size))


def _changes(act: Callable[[Given], object]) -> Callable[[Given], None]:
    """Turn errors of the computer's file system into errors that the program can recover from."""

    def does(given: Given) -> None:
        try:
            act(given)
        except OSError as error:
            raise Fault(f"the disk is not changed: {error.strerror}", "ERR_FILEACC") from None

    return does


def _new(given: Given) -> tuple[Path, Path]:
    old, new = _path(given, 0), _path(given, 1)
    if not old.is_file():
        raise Fault(f"there is no file `{old.name}`", "ERR_FILEACC")
    if new.exists():
        raise Fault(f"there is a `{new.name}` already", "ERR_FILEEXIST")
    return old, new


def _rename(given: Given) -> None:
    old, new = _new(given)
    old.rename(new)


def _copy(given: Given) -> None:
    old, new = _new(given)
    write_whole(new, read_file(old))


def _remove_directory(given: Given) -> None:
    path, disk = _path(given, 0), given.machine.controller.disk
    # `HOME:` may be a folder of the user, see `Disk`.
    if path in map(disk.folder, UNITS):
        raise Fault("a unit of the disk cannot be removed", "ERR_FILEACC")
    path.rmdir()


def _open_directory(given: Given) -> None:
    _asks_outside(given)
    handle, path = _handle(given, "dir"), _path(given, 1)
    if not path.is_dir():
        raise Fault(f"there is no directory `{path.name}`", "ERR_FILEACC")
    # Sorted, since the order of the computer's file system differs from run to run.
    handle.inside = iter([".", "..", *sorted(entry.name for entry in path.iterdir())])


def _read_directory(given: Given) -> bool:
    entries = _handle(given, "dir").inside
    if not isinstance(entries, Iterator):
        raise Fault("a directory that is not open", "ERR_FILEACC")
    name = next(entries, None)
    given.place(1).set("" if name is None else str(name))
    return name is not None


def _close_directory(given: Given) -> None:
    _handle(given, "dir").inside = None


_KINDS: Final = "num bool pos orient dnum"
_TYPES: Final[Mapping[str, Callable[[Path], bool]]] = {
    "directory": Path.is_dir,
    "regfile": Path.is_file,
    "fifo": Path.is_fifo,
    "blockspec": Path.is_block_device,
    "charspec": Path.is_char_device,
}

FILE_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("Open", 2, _open, "file read write append bin"),
        table_row("Close", 1, _close),
        table_row("Write", 2, _write, f"{_KINDS} nonewline"),
        table_row("WriteBin", 3, _write_bytes),
        table_row("WriteStrBin", 2, _write_text),
        table_row("Rewind", 1, _rewind),
        table_row("RemoveFile", 1, _changes(lambda given: _path(given, 0).unlink())),
        table_row("RenameFile", 2, _changes(_rename)),
        table_row("CopyFile", 2, _changes(_copy)),
        table_row("MakeDir", 1, _changes(lambda given: _path(given, 0).mkdir())),
        table_row("RemoveDir", 1, _changes(_remove_directory)),
        table_row("OpenDir", 2, _open_directory),
        table_row("CloseDir", 1, _close_directory),
    )
)
FILE_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("ReadStr", 1, _read_line, "delim removecr discardheaders time line"),
        table_row("ReadNum", 1, _read_number, "delim time"),
        table_row("ReadBin", 1, _read_byte, "time"),
        table_row("ReadStrBin", 2, _read_text, "time"),
        table_row("IsFile", 1, _is_file, " ".join(_TYPES)),
        table_row("FileSize", 1, _size),
        table_row("ReadDir", 2, _read_directory),
    )
)
