"""The disk of a controller: folders of this computer under the names that programs know."""

from __future__ import annotations

import re
import shutil
import tempfile
import weakref
from collections.abc import Iterable, Mapping
from io import BytesIO
from pathlib import Path
from typing import IO, ClassVar, Final, Literal

from assistant.base.data_classes import dataclass
from assistant.base.file_access import check_regular
from assistant.virtual.rapid.control_flow import Fault, NotSimulated

Mode = Literal["read", "write", "append"]
MODES: Final[Mapping[Mode, Literal["rb", "wb", "ab"]]] = {
    "read": "rb",
    "write": "wb",
    "append": "ab",
}
CODES: Final = "latin-1"
HOME: Final = "HOME"
UNITS: Final = (HOME, "TEMP", "RAMDISK")
"""Units in front of a path; HOME is the default (reference, 4.3)."""
_UNIT: Final = re.compile(r"([^/\\]*):[/\\]?(.*)", re.DOTALL)


class Disk:
    """Disk of a controller. home: the folder that is `HOME:`; the other units, and `HOME:` without
    it, begin empty and vanish with the disk. outside: whether others may change its files while
    programs run, so that a wait for a file takes real time.
    """

    def __init__(self, home: str | Path | None = None, outside: bool = False) -> None:
        self.home = None if home is None else Path(home).resolve()
        self.outside = outside
        self._own: Path | None = None

    def path(self, name: str, file: str = "") -> Path:
        """Return the path of a file by its name in the program; raises Fault for one outside its
        unit.

        file: in the folder `name`.
        """
        found = _UNIT.fullmatch(name)
        unit, inside = (found[1].upper(), found[2]) if found else (HOME, name)
        if unit not in UNITS or inside.startswith(("/", "\\")):
            raise NotSimulated(f"the file `{name}{file}`: of {', '.join(UNITS)} are files here")
        # The file system of the computer raises a bare ValueError for it.
        if "\0" in inside + file:
            raise Fault("a name with a character 0", "ERR_FILEACC")
        root = self.folder(unit)
        # resolve() also follows links that lead out of the folder.
        path = (root / inside.replace("\\", "/") / file.replace("\\", "/")).resolve()
        if path != root and root not in path.parents:
            raise Fault(f"`{name}{file}` is not inside of {unit}:", "ERR_FILEACC")
        return path

    def folder(self, unit: str) -> Path:
        """Return the folder of this computer for a unit of the disk."""
        if unit == HOME and self.home is not None:
            return self.home
        # The folder is made at the first use: most runs have no files.
        if self._own is None:
            self._own = Path(tempfile.mkdtemp(prefix="rapid-disk-")).resolve()
            # True: errors at the removal are ignored.
            weakref.finalize(self, shutil.rmtree, self._own, True)
        root = self._own / unit
        root.mkdir(exist_ok=True)
        return root


@dataclass(slots=True, eq=False)
class Stream:
    """A file that a program opened. binary: for bytes, else for lines in Latin-1.

    is_line: True if written data goes out over a serial line.
    """

    is_line: ClassVar[bool] = False

    file: IO[bytes]
    mode: Mode
    binary: bool

    @staticmethod
    def open(path: Path, mode: Mode, binary: bool) -> Stream:
        try:
            if path.exists():
                # A pipe would block the run until somebody writes.
                check_regular(path)
            return Stream(path.open(MODES[mode]), mode, binary)
        except OSError as error:
            message = f"`{path.name}` cannot be opened: {error.strerror}"
            raise Fault(message, "ERR_FILEOPEN") from None

    @staticmethod
    def of_peer(texts: Iterable[str], binary: bool) -> Stream:
        """A serial port at whose other end somebody says some texts."""
        said = "".join(f"{text}\n" for text in texts).encode(CODES)
        return _Both(BytesIO(said), "read", binary)

    def read(self, count: int) -> bytes:
        if self.mode != "read":
            raise Fault("a file that was opened to be written is read", "ERR_FILEACC")
        return self.file.read(count)

    def write(self, data: bytes) -> None:
        """It is on the disk at once."""
        if self.mode == "read":
            raise Fault("a file that was opened to be read is written", "ERR_FILEACC")
        self.file.write(data)
        self.file.flush()

    def until(self, delimiters: str, most: int, headers: bool = False) -> str | None:
        """Characters before the next delimiter, which is left out; None at the end of the file.

        headers: leave out delimiters in front.
        """
        found = bytearray()
        stops = delimiters.encode(CODES, "replace")
        while byte := self.read(1):
            if byte in stops:
                if headers and not found:
                    continue
                return found.decode(CODES)
            if len(found) == most:
                # The byte belongs to the next string.
                self.file.seek(-1, 1)
                return found.decode(CODES)
            found += byte
        return found.decode(CODES) if found else None

    def rewind(self) -> None:
        self.file.seek(0)

    def skip_line(self) -> None:
        # Refuses a file that was opened to be written.
        self.read(0)
        self.file.readline()

    def close(self) -> None:
        self.file.close()


class _Both(Stream):
    """A stream whose written data goes elsewhere."""

    __slots__ = ()
    is_line = True

    def write(self, data: bytes) -> None:
        """Nobody looks at it."""
