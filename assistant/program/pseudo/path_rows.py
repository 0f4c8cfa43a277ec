"""Rows of a path to text and from it, and side tables: the columns of a long path in a `.npz` file.

A row states its motion type and its target; omitted parts (orientation, arm branch, external axes,
speed, blend, tool, frame) are the same as in the row before it.

For a path in a side table, the text holds the parts that a person reviews (speeds, blends, tools,
frames, number of rows) and the sha256 sum of the file, so that a changed table shows in a diff and
a wrong one is refused. A column that is the same in every row is stored once, positions aside, so
that the file is never smaller than the number of rows that it claims.
"""

from __future__ import annotations

import hashlib
import io
import math
import re
import zipfile
import zlib
from array import array
from collections.abc import Hashable, Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any, Final, Generic, TypeVar, cast

import numpy as np
from lark import Token
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Truths
from assistant.base.budgets import most_unpacked
from assistant.base.diagnostics import Rule, Unreadable
from assistant.base.source_text import read_bytes
from assistant.program.expressions import Name
from assistant.program.geometry import BASE, FLANGE, NO_EXTERNAL, UNUSED_AXIS
from assistant.program.motion import (
    UNSTATED,
    Blend,
    Kind,
    Path,
    Speed,
    configuration_of,
    configuration_row,
)
from assistant.program.program import identifier
from assistant.program.pseudo.expressions import (
    UNIT_TOLERANCE,
    blend_text,
    configuration_text,
    read_blend,
    read_configuration,
    read_external,
    read_quaternion,
    read_speed,
    read_vector,
    speed_text,
)
from assistant.program.pseudo.words import (
    BAD_TABLE,
    INCOMPLETE_ROW,
    LONE_TO,
    LONE_VIA,
    NO_FOLDER,
    NO_TABLE,
    NOT_BARE,
    NOT_FINITE,
    NOT_UNIT,
    OTHER_TABLE,
    Node,
    Wrong,
    name_text,
    parse_line,
    quoted,
    read_name,
)

_WORDS: Final = {
    Kind.JOINT: "joint",
    Kind.LINEAR: "linear",
    Kind.VIA: "via",
    Kind.END: "to",
}
_KINDS: Final = {word: int(kind) for kind, word in _WORDS.items()}

_UNSTATED_ROW: Final = (UNSTATED, 0, 0, 0, 0, 0)
_CHUNK: Final = 16384
"""Rows that are turned into text at a time."""

# ------------------------------------------------------------------------------------- to text


def row_lines(path: Path) -> Iterator[str]:
    """One line a row."""
    words = [_WORDS[kind] for kind in Kind]
    # NaN precedes the first row, so that it always states its orientation.
    turns = _changes(path.quaternions, (UNUSED_AXIS,) * 4)
    said = _attribute_texts(path)
    for start in range(0, len(path), _CHUNK):
        stop = min(start + _CHUNK, len(path))
        turned = np.flatnonzero(turns[start:stop]).tolist()
        quaternions = dict(
            zip(turned, _list_texts(path.quaternions[start:stop][turned]), strict=True)
        )
        kinds = path.kinds[start:stop].tolist()
        positions = _list_texts(path.positions[start:stop])
        for i, (kind, position) in enumerate(zip(kinds, positions, strict=True)):
            turn = f" [{quaternions[i]}]" if i in quaternions else ""
            yield f"{words[kind]} [{position}]{turn}{said.get(start + i, '')}"


def text_codes(
    index: NDArray[np.int32], texts: Sequence[str]
) -> tuple[NDArray[np.int32], list[str]]:
    """An index column into the texts that it uses, each once, in the order of first use."""
    if not len(index):
        return np.zeros(0, dtype=np.int32), []
    first_of = {text: i for i, text in reversed(list(enumerate(texts)))}
    same = np.array([first_of[text] for text in texts], dtype=np.int32)[index]
    used, where, back = np.unique(same, return_index=True, return_inverse=True)
    order = np.argsort(where)
    rank = np.empty(len(order), dtype=np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    return rank[back.reshape(-1)], [texts[i] for i in used[order].tolist()]


def _attribute_texts(path: Path) -> dict[int, str]:
    """Return the attributes after the poses of rows, by row; rows without attributes are
    missing.
    """
    said: dict[int, str] = {}
    branches = _changes(path.configurations, _UNSTATED_ROW)
    for i in np.flatnonzero(branches).tolist():
        branch = configuration_of(path.configurations[i])
        said[i] = " unstated" if branch is None else f" {configuration_text(branch)}"
    axes = np.flatnonzero(_changes(path.external, NO_EXTERNAL))
    for i, values in zip(axes.tolist(), _list_texts(path.external[axes]), strict=True):
        # Unused axes at the end are left out, as `read_external` fills them in.
        said[i] = f"{said.get(i, '')} external [{re.sub('(?:^|, )_(?:, _)*$', '', values)}]"
    for word, index, texts, usual in (
        ("speed", path.speed, [speed_text(s) for s in path.speeds], None),
        ("blend", path.blend, [blend_text(b) for b in path.blends], None),
        ("tool", path.tool, [name_text(t) for t in path.tools], FLANGE),
        ("frame", path.frame, [name_text(f) for f in path.frames], BASE),
    ):
        column, used = text_codes(index, texts)
        # A row without a change is as the one before; the usual tool and frame precede the first.
        start = used.index(usual) if usual in used else -1
        for i in np.flatnonzero(np.diff(column, prepend=start)).tolist():
            said[i] = f"{said.get(i, '')} {word} {used[column[i]]}"
    return said


def _changes(column: Floats | NDArray[np.int8], before: Sequence[float]) -> Truths:
    """Return which rows differ from the row before them; `before` precedes the first."""
    rows = np.asarray(column)
    above = np.concatenate([np.asarray([before], dtype=rows.dtype), rows[:-1]])[: len(rows)]
    differ = rows != above
    if rows.dtype.kind == "f":
        # Unused axes are NaN and equal; 0 and -0 are written otherwise, so they differ.
        differ &= ~(np.isnan(rows) & np.isnan(above))
        differ |= np.signbit(rows) != np.signbit(above)
    return np.asarray(differ.any(axis=1))


def _list_texts(rows: Floats) -> list[str]:
    """`x, y, z` for each row of (n, k), every number as `number_text` writes it."""
    if not len(rows):
        return []
    # One `repr` for all rows: a text for each number takes several times as long.
    text = re.sub(r"\.0(?=[,\]])", "", str(rows.tolist())).replace("nan", "_")
    return text[2:-2].split("], [")


# ----------------------------------------------------------------------------------- from text

_Entry = TypeVar("_Entry", bound=Hashable)
_NUMBER: Final = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
_LIST: Final = rf"{_NUMBER}(?:, {_NUMBER})*"
_ROW: Final = re.compile(
    rf"(joint|linear|via|to) \[({_NUMBER}, {_NUMBER}, {_NUMBER})\](?: \[({_LIST})\])?"
    r"( (?:front|back) (?:up|down) (?:noflip|flip) -?\d+ -?\d+ -?\d+| unstated)?"
    rf"(?: external \[({_LIST})\])?((?: (?:speed|blend|tool|frame) .*)?)"
)
"""The usual form of a row; every other goes through the grammar and means the same."""

_Attributes = tuple[Speed | Name | None, Blend | Name | None, str | None, str | None]
_NOTHING_SAID: Final[_Attributes] = (None, None, None, None)


class RowReader:
    """Collects rows into columns; `path` is what they make."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._kinds = bytearray()
        self._positions = array("d")
        self._turns = _HeldColumn(4)
        self._branches = _HeldColumn(6)
        self._axes = _HeldColumn(6)
        self._speeds = _TableColumn[Speed | Name]()
        self._blends = _TableColumn[Blend | Name]()
        self._tools = _TableColumn[str]()
        self._frames = _TableColumn[str]()
        self._seen_branches: dict[str | None, tuple[int, ...] | None] = {None: None}
        self._seen_attributes: dict[str, _Attributes] = {"": _NOTHING_SAID}

    def __len__(self) -> int:
        return len(self._kinds)

    def read(self, text: str) -> None:
        """Adds the row of one line; raises Wrong."""
        found = _ROW.fullmatch(text)
        # The grammar is slow: it reads only rows that are not of the usual form.
        if not (found and self._read_usual(found)):
            self._read_tree(parse_line("row", text))

    def path(self) -> Path:
        """The rows as columns."""
        n = len(self)
        return Path.of(
            self._name,
            np.array(self._positions).reshape(-1, 3),
            self._turns.spread(n),
            kinds=np.frombuffer(bytes(self._kinds), dtype=np.uint8),
            configurations=self._branches.spread(n).astype(np.int8),
            external=self._axes.spread(n),
            speed=self._speeds.spread(n),
            speeds=self._speeds.entries,
            blend=self._blends.spread(n),
            blends=self._blends.entries,
            tool=self._tools.spread(n),
            tools=self._tools.entries,
            frame=self._frames.spread(n),
            frames=self._frames.entries,
        )

    def _read_usual(self, found: re.Match[str]) -> bool:
        """True if the row was read; numbers that need a finding are left to the grammar."""
        kind, position, turn, branch, axes, rest = found.groups()
        point = _floats(position)
        quaternion = None if turn is None else _floats(turn)
        external = None if axes is None else _floats(axes)
        if not all(map(math.isfinite, point)):
            return False
        if quaternion is not None and not (
            len(quaternion) == 4 and abs(math.hypot(*quaternion) - 1.0) <= UNIT_TOLERANCE
        ):
            return False
        if external is not None:
            if len(external) > len(NO_EXTERNAL) or not all(map(math.isfinite, external)):
                return False
            external += [UNUSED_AXIS] * (len(NO_EXTERNAL) - len(external))
        # Rows repeat few branches and attributes: each text is parsed once.
        if branch not in self._seen_branches:
            self._seen_branches[branch] = _branch(parse_line("row", f"to [0, 0, 0]{branch}"))
        if rest not in self._seen_attributes:
            try:
                tree = parse_line("attributes", rest)
            except Wrong:
                return False  # the whole line gives a finding with the right column
            self._seen_attributes[rest] = _attributes(tree)
        self._add(
            kind,
            point,
            quaternion,
            self._seen_branches[branch],
            external,
            self._seen_attributes[rest],
        )
        return True

    def _read_tree(self, tree: Node) -> None:
        kind, position, turn, _, external, attributes = tree.children
        self._add(
            str(kind),
            read_vector(position),
            None if turn is None else read_quaternion(turn),
            _branch(tree),
            None if external is None else read_external(external),
            _attributes(cast(Node, attributes)),
        )

    def _add(
        self,
        kind: str,
        position: Sequence[float],
        turn: Sequence[float] | None,
        branch: Sequence[int] | None,
        external: Sequence[float] | None,
        attributes: _Attributes,
    ) -> None:
        row = len(self._kinds)
        speed, blend, tool, frame = attributes
        # The row is kept even if it lacks a part, so that later rows have something to inherit.
        missing = None
        if row == 0:
            missing = self._start(turn, speed, blend)
        self._kinds.append(_KINDS[kind])
        self._positions.extend(position)
        self._turns.hold(row, turn)
        self._branches.hold(row, branch)
        self._axes.hold(row, external)
        self._speeds.hold(row, speed)
        self._blends.hold(row, blend)
        self._tools.hold(row, tool)
        self._frames.hold(row, frame)
        if missing:
            raise missing

    def _start(self, turn: object, speed: object, blend: object) -> Wrong | None:
        """Set the values before the first row, and return the fault of a first row that lacks a
        part.
        """
        self._turns.hold(0, (1.0, 0.0, 0.0, 0.0))
        self._branches.hold(0, _UNSTATED_ROW)
        self._axes.hold(0, NO_EXTERNAL)
        self._tools.hold(0, FLANGE)
        self._frames.hold(0, BASE)
        for said, what, example in (
            (turn, "orientation", "[1, 0, 0, 0]"),
            (speed, "speed", "speed 100 mm/s"),
            (blend, "blend", "blend fine"),
        ):
            if said is None:
                self._speeds.hold(0, Speed(0.0))
                self._blends.hold(0, Blend())
                return Wrong(INCOMPLETE_ROW, what=what, example=example)
        return None


class _HeldColumn:
    """A column that is stated where it changes: (n, width)."""

    def __init__(self, width: int) -> None:
        self._width = width
        self._rows = array("q")
        self._values = array("d")

    def hold(self, row: int, values: Sequence[float] | None) -> None:
        """From this row on; None leaves it as it was."""
        if values is None:
            return
        # A value at the row of the last one replaces it: `_start` holds defaults there.
        if self._rows and self._rows[-1] == row:
            del self._rows[-1], self._values[-self._width :]
        self._rows.append(row)
        self._values.extend(values)

    def spread(self, n: int) -> Floats:
        """The values of each of n rows."""
        values = np.array(self._values).reshape(-1, self._width)
        # Each value is repeated up to the row of the next one.
        return np.repeat(values, np.diff(np.array(self._rows), append=n), axis=0)


class _TableColumn(Generic[_Entry]):
    """An index column with its table of distinct entries."""

    def __init__(self) -> None:
        self._index: dict[_Entry, int] = {}
        self._held = _HeldColumn(1)

    @property
    def entries(self) -> tuple[_Entry, ...]:
        return tuple(self._index)

    def hold(self, row: int, entry: _Entry | None) -> None:
        if entry is not None:
            self._held.hold(row, (self._index.setdefault(entry, len(self._index)),))

    def spread(self, n: int) -> NDArray[np.int32]:
        return self._held.spread(n).reshape(-1).astype(np.int32)


def _floats(numbers: str) -> list[float]:
    return [float(number) for number in numbers.split(", ")]


def _branch(tree: Node) -> tuple[int, ...] | None:
    """The columns of the arm branch that a row states."""
    branch = tree.children[3]
    if branch is None:
        return None
    return (
        _UNSTATED_ROW
        if isinstance(branch, Token)
        else configuration_row(read_configuration(branch))
    )


def _attributes(tree: Node) -> _Attributes:
    speed, blend, tool, frame = tree.children
    return (
        None if speed is None else read_speed(speed),
        None if blend is None else read_blend(blend),
        None if tool is None else read_name(cast(Node, tool)),
        None if frame is None else read_name(cast(Node, frame)),
    )


# ------------------------------------------------------------------------------- what is wrong


def path_faults(path: Path) -> Iterator[tuple[int, Rule, dict[str, object]]]:
    """Yield faults that no robot could execute, as row, rule and fields; each kind once, at its
    first row.
    """
    finite = np.isfinite(path.positions).all(axis=1)
    length = np.linalg.norm(path.quaternions, axis=1)
    unit = np.abs(length - 1.0) <= UNIT_TOLERANCE
    via, end = path.kinds == Kind.VIA, path.kinds == Kind.END
    followed = np.append(end[1:], False)[: len(path)]
    led = np.insert(via[:-1], 0, False)[: len(path)]
    if not finite.all():
        yield int(finite.argmin()), NOT_FINITE, {"what": "a coordinate"}
    if not unit.all():
        row = int(unit.argmin())
        yield row, NOT_UNIT, {"length": float(length[row])}
    if (via & ~followed).any():
        yield int((via & ~followed).argmax()), LONE_VIA, {}
    if (end & ~led).any():
        yield int((end & ~led).argmax()), LONE_TO, {}


SideTables = FilePath | str | Mapping[str, bytes] | None
"""Side tables: a folder, or the files' bytes by name."""

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
    """The side tables of one text, each under a separate name."""

    def __init__(self, program: str) -> None:
        self._program = program
        self.tables: dict[str, bytes] = {}

    def lines(self, path: Path) -> list[str]:
        """Keeps the columns of a path; gives the lines that refer to them."""
        # File names are unique within the text, also for paths of one name.
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
        # The digest proves that the file is the one of the text, not that it is well-formed.
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
        # A side table must not lead out of the folder, on any system.
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
"""Exceptions that reading a damaged archive can raise."""


def _packed(path: Path, index: Mapping[str, NDArray[np.int32]]) -> bytes:
    columns = {}
    # Index columns refer to the tables of the text, which are in order of use.
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
    """Return the columns of a file; raises one of `_DAMAGE`.

    Shapes and types are checked before any memory is allocated for them, and no Python object is
    ever created from the file.
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
        # Only version 1.0 is written, and its header is short.
        if np.lib.format.read_magic(member) != (1, 0):
            raise ValueError(f"`{name}` is of an unknown version")
        shape, by_columns, found = np.lib.format.read_array_header_1_0(member)
        shapes = [(rows, *width)] + [(1, *width)] * (name != "positions")
        # Fortran order is refused: it is never written.
        if found != wanted or by_columns or shape not in shapes:
            raise ValueError(f"`{name}` is {found} of shape {shape}")
        values = np.frombuffer(member.read(), dtype=wanted).reshape(shape)
    native = values.astype(wanted.newbyteorder("="), copy=False)
    return cast("NDArray[np.generic]", np.broadcast_to(native, (rows, *width)))


def _are_branches(configurations: NDArray[np.int8]) -> bool:
    """True if each row of (n, 6) is an arm branch, or states no branch."""
    first, rest = configurations[:, 0], configurations[:, 1:3]
    return bool(np.isin(first, (UNSTATED, 0, 1)).all() and np.isin(rest, (0, 1)).all())
