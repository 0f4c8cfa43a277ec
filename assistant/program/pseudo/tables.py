"""Side tables: the columns of a long path in a `.npz` file beside the text.

The text keeps what a person reviews (speeds, blends, tools, frames, number of rows) and the
sha256 sum of the file, so that a changed table shows in a diff and a wrong one is refused.
A column that is the same in every row is stored once, positions aside, so that the file is
never smaller than the number of rows that it claims.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any, Final, cast

import numpy as np
from lark import Token
from numpy.typing import NDArray

from assistant.program.diagnostics import Unreadable
from assistant.program.expressions import Name
from assistant.program.motion import Blend, Speed
from assistant.program.path import UNSTATED, Kind, Path
from assistant.program.program import identifier
from assistant.program.pseudo.findings import (
    BAD_TABLE,
    NO_FOLDER,
    NO_TABLE,
    NOT_BARE,
    OTHER_TABLE,
    Wrong,
)
from assistant.program.pseudo.rows import path_faults, text_codes
from assistant.program.pseudo.values import blend_text, speed_text
from assistant.program.pseudo.words import name_text, quoted
from assistant.program.system.budgets import most_unpacked
from assistant.program.text import read_bytes

SideTables = FilePath | str | Mapping[str, bytes] | None
"""Where side tables are: a folder, or the files' bytes by name."""

COLUMNS: Final[dict[str, tuple[str, tuple[int, ...]]]] = {
    "kinds": ("|u1", ()),
    "positions": ("<f8", (3,)),
    "quaternions": ("<f8", (4,)),
    "configurations": ("|i1", (6,)),
    "external": ("<f8", (6,)),
    "speed": ("<i4", ()),
    "blend": ("<i4", ()),
    "tool": ("<i4", ()),
    "frame": ("<i4", ()),
}
"""Member of the file → its type, and the shape of one row."""

_HEADER: Final = 4096
"""More bytes than the header of such a member has."""


class TableWriter:
    """The side tables of one text, each under a name of its own."""

    def __init__(self, program: str) -> None:
        self._program = program
        self.tables: dict[str, bytes] = {}

    def lines(self, path: Path) -> list[str]:
        """Keeps the columns of a path; gives the lines that refer to them."""
        taken = {name.removesuffix(".npz") for name in self.tables}
        name = identifier(f"{self._program}_{path.name}", taken) + ".npz"
        tables = {
            "speed": [speed_text(s) for s in path.speeds],
            "blend": [blend_text(b) for b in path.blends],
            "tool": [name_text(t) for t in path.tools],
            "frame": [name_text(f) for f in path.frames],
        }
        index = {word: text_codes(getattr(path, word), texts) for word, texts in tables.items()}
        data = self.tables[name] = _packed(
            path, {word: column for word, (column, _) in index.items()}
        )
        digest = hashlib.sha256(data).hexdigest()
        head = f"follow {name_text(path.name)} from {quoted(name)} rows {len(path)} sha256 {digest}"
        return [
            head,
            *(f"  {word} {text}" for word, (_, used) in index.items() for text in used),
            "end",
        ]


class TableReader:
    """A path in a side table: the entries of its tables, line by line, then the path."""

    def __init__(self, name: str, file: Token, file_name: str, rows: int, digest: str) -> None:
        self._name, self._file, self._file_name = name, file, file_name
        self._rows, self._digest = rows, digest
        self.speeds: list[Speed | Name] = []
        self.blends: list[Blend | Name] = []
        self.tools: list[str] = []
        self.frames: list[str] = []

    def path(self, side_tables: SideTables) -> Path:
        """Raises Wrong if the file is missing, is another one, or does not fit the text."""
        data = self._data(side_tables)
        if hashlib.sha256(data).hexdigest() != self._digest:
            raise Wrong(OTHER_TABLE, self._file, name=self._file_name)
        try:
            columns: dict[str, Any] = {**_unpacked(data, self._rows)}
        except (*_DAMAGE, MemoryError) as error:
            raise self._damaged(str(error) or type(error).__name__) from None
        try:
            path = Path.of(
                self._name,
                columns.pop("positions"),
                columns.pop("quaternions"),
                speeds=self.speeds,
                blends=self.blends,
                tools=self.tools,
                frames=self.frames,
                **columns,
            )
        except ValueError as error:
            raise self._damaged(str(error)) from None
        if len(path) and path.kinds.max() > max(Kind):
            raise self._damaged("a row is of no known kind")
        if not _are_branches(path.configurations):
            raise self._damaged("a row is of no arm branch")
        for row, rule, fields in path_faults(path):
            raise self._damaged(f"row {row + 1}: {rule.message.format(**fields)}")
        return path

    def _data(self, side_tables: SideTables) -> bytes:
        name = self._file_name
        if name != FilePath(name).name or set(name) & set("/\\:\0") or name in ("", ".", ".."):
            raise Wrong(NOT_BARE, self._file, name=name)
        if side_tables is None:
            raise Wrong(NO_FOLDER, self._file, name=name)
        if isinstance(side_tables, Mapping):
            if name not in side_tables:
                raise Wrong(NO_TABLE, self._file, name=name, reason="there is no such table")
            return side_tables[name]
        try:
            return read_bytes(FilePath(side_tables) / name)
        except Unreadable as error:
            reason = error.findings[0].message
            raise Wrong(NO_TABLE, self._file, name=name, reason=reason) from None

    def _damaged(self, reason: str) -> Wrong:
        return Wrong(BAD_TABLE, self._file, name=self._file_name, reason=reason)


_DAMAGE: Final = (
    zipfile.BadZipFile,
    zlib.error,
    ValueError,
    KeyError,
    EOFError,
    OSError,
    NotImplementedError,
    RuntimeError,
)
"""What reading a damaged archive can raise."""


def _packed(path: Path, index: Mapping[str, NDArray[np.int32]]) -> bytes:
    columns = {}
    for name, (dtype, _) in COLUMNS.items():
        column = np.asarray(index.get(name, getattr(path, name)), dtype=dtype)
        if name != "positions" and _is_constant(column):
            column = column[:1]
        columns[name] = np.ascontiguousarray(column)
    buffer = io.BytesIO()
    np.savez(buffer, **columns)  # type: ignore[arg-type]
    return buffer.getvalue()


def _is_constant(column: NDArray[np.generic]) -> bool:
    """Bit for bit, so that NaN and the sign of zero count as what they are."""
    plain = np.ascontiguousarray(column)
    bits = plain.view(f"u{plain.dtype.itemsize}")
    return bool((bits == bits[:1]).all())


def _unpacked(data: bytes, rows: int) -> dict[str, NDArray[np.generic]]:
    """The columns of a file; raises one of `_DAMAGE`.

    Shapes and types are looked at before any memory is taken for them, and no Python object
    is ever made from the file.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = sorted(archive.namelist())
        if names != sorted(f"{name}.npy" for name in COLUMNS):
            raise ValueError("its members are not the columns of a path")
        size = sum(member.file_size for member in archive.infolist())
        if size > most_unpacked():
            raise ValueError(f"it unpacks to {size / 1e6:.0f} MB")
        return {
            name: _member(archive, name, rows, dtype, width)
            for name, (dtype, width) in COLUMNS.items()
        }


def _member(
    archive: zipfile.ZipFile, name: str, rows: int, dtype: str, width: tuple[int, ...]
) -> NDArray[np.generic]:
    wanted = np.dtype(dtype)
    most = rows * wanted.itemsize * (width[0] if width else 1) + _HEADER
    if archive.getinfo(f"{name}.npy").file_size > most:
        raise ValueError(f"`{name}` has more rows than the text says")
    with archive.open(f"{name}.npy") as member:
        if np.lib.format.read_magic(member) != (1, 0):
            raise ValueError(f"`{name}` is of an unknown version")
        shape, by_columns, found = np.lib.format.read_array_header_1_0(member)
        shapes = [(rows, *width)] + [(1, *width)] * (name != "positions")
        if found != wanted or by_columns or shape not in shapes:
            raise ValueError(f"`{name}` is {found} of shape {shape}")
        values = np.frombuffer(member.read(), dtype=wanted).reshape(shape)
    native = values.astype(wanted.newbyteorder("="), copy=False)
    return cast("NDArray[np.generic]", np.broadcast_to(native, (rows, *width)))


def _are_branches(configurations: NDArray[np.int8]) -> bool:
    """Whether each row of (n, 6) is an arm branch, or states none."""
    first, rest = configurations[:, 0], configurations[:, 1:3]
    return bool(np.isin(first, (UNSTATED, 0, 1)).all() and np.isin(rest, (0, 1)).all())
