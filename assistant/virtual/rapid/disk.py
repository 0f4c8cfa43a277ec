"""The disk of a controller: folders of this computer under the names that programs know."""

from __future__ import annotations

import re
import shutil
import tempfile
import weakref
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final, Literal

from assistant.virtual.rapid.ends import Fault, NotSimulated

Mode = Literal["read", "write", "append"]
MODES: Final[Mapping[Mode, Literal["rb", "wb", "ab"]]] = {
    "read": "rb",
    "write": "wb",
    "append": "ab",
}
HOME: Final = "HOME"
UNITS: Final = (HOME, "TEMP", "RAMDISK")
"""What stands in front of a path; HOME where nothing does (reference, 4.3)."""
_UNIT: Final = re.compile(r"([^/\\]*):[/\\]?(.*)", re.DOTALL)


class Disk:
    """home: the folder that is `HOME:`; the other units, and `HOME:` if it is None, begin empty and
    go away with the disk. outside: whether others may change its files while programs run, so that
    who waits for a file waits in real time.
    """

    def __init__(self, home: str | Path | None = None, outside: bool = False) -> None:
        self.home = None if home is None else Path(home).resolve()
        self.outside = outside
        self._own: Path | None = None

    def path(self, name: str, file: str = "") -> Path:
        """Of a file by the name that a program has for it; raises Fault for one that is not there.

        file: in the folder `name`.
        """
        found = _UNIT.fullmatch(name)
        unit, inside = (found[1].upper(), found[2]) if found else (HOME, name)
        if unit not in UNITS or inside.startswith(("/", "\\")):
            raise NotSimulated(f"the file `{name}{file}`: of {', '.join(UNITS)} are files here")
        root = self._root(unit)
        path = (root / inside.replace("\\", "/") / file.replace("\\", "/")).resolve()
        if path != root and root not in path.parents:
            raise Fault(f"`{name}{file}` is not inside of {unit}:", "ERR_FILEACC")
        return path

    def _root(self, unit: str) -> Path:
        if unit == HOME and self.home is not None:
            return self.home
        if self._own is None:
            self._own = Path(tempfile.mkdtemp(prefix="rapid-disk-")).resolve()
            weakref.finalize(self, shutil.rmtree, self._own, True)
        root = self._own / unit
        root.mkdir(exist_ok=True)
        return root


@dataclass(slots=True, eq=False)
class OpenFile:
    """A file that a program reads or writes, in characters of Latin-1."""

    mode: Mode
    stream: BinaryIO

    def write(self, text: str) -> None:
        if self.mode == "read":
            raise Fault("a file that was opened to be read is written", "ERR_FILEACC")
        self.stream.write(text.encode("latin-1", "replace"))
        self.stream.flush()

    def read(self, delimiters: str, most: int, headers: bool) -> str | None:
        """Characters before the next delimiter, which is left out; None at the end of the file.

        headers: leave out delimiters in front.
        """
        if self.mode != "read":
            raise Fault("a file that was opened to be written is read", "ERR_FILEACC")
        found = bytearray()
        stops = delimiters.encode("latin-1", "replace")
        while True:
            byte = self.stream.read(1)
            if not byte:
                return found.decode("latin-1") if found else None
            if byte in stops:
                if headers and not found:
                    continue
                return found.decode("latin-1")
            if len(found) == most:
                self.stream.seek(-1, 1)
                return found.decode("latin-1")
            found += byte

    def rewind(self) -> None:
        self.stream.seek(0)

    def close(self) -> None:
        self.stream.close()


def opened(path: Path, mode: Mode) -> OpenFile:
    try:
        return OpenFile(mode, path.open(MODES[mode]))
    except OSError as error:
        raise Fault(f"`{path.name}` cannot be opened: {error.strerror}", "ERR_FILEOPEN") from None
