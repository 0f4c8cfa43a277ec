"""Statements, functions and status variables of MELFA-BASIC: three text tables, one reader.

    statement("mvs").dialects        # {4, 5, 6}: the levels of MELFA-BASIC IV, V and VI
    function("Left").name            # "Left$"
    status("m_in").writable          # False

Names match in any case; an unknown name gives None. Differences between the versions other than
their words are in `dialects`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import Final, Literal, cast

from assistant.base.data_classes import dataclass

Role = Literal["motion", "command", "statement", "part"]
Effect = Literal[
    "reads", "gives", "sets", "needs", "stays", "moves", "jumps", "waits", "lines", "labels"
]

_ROLES: Final = ("motion", "command", "statement", "part")
_EFFECTS: Final = (
    "reads",
    "gives",
    "sets",
    "needs",
    "stays",
    "moves",
    "jumps",
    "waits",
    "lines",
    "labels",
)


@dataclass(frozen=True, slots=True)
class Statement:
    """A statement, or a word inside one.

    word: as the maker's tool spells it, of several words for `Def Inte` and its like.
    role: `motion`, `command` (a word and a list of arguments), `statement` (a separate form)
    or `part` (inside of a statement only). dialects: levels that have it, of 4, 5 and 6.
    least, most: numbers of arguments, omitted ones counted; most: None for no limit.
    effects: what a command does to variables and settings, see the table.
    words: permitted as its first argument. instead: what to write in a version that lacks
    it, empty where nothing does the same.
    """

    word: str
    role: Role
    dialects: frozenset[int]
    least: int = 0
    most: int | None = None
    effects: frozenset[Effect] = frozenset()
    words: tuple[str, ...] = ()
    instead: str = ""


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a function.

    types: of `M` (number), `C` (text), `P` (position) and `J` (joints), all four where it is not
    known. optional: it may be left out. assigned: a variable that receives a result.
    """

    types: str
    optional: bool = False
    assigned: bool = False


@dataclass(frozen=True, slots=True)
class Function:
    """A function that every program may call.

    name: with the `$` of those that give a text. result: a type as in Argument.
    arguments: in order. open: more of the last one may follow. dialects, instead: as in Statement.
    """

    name: str
    result: str
    arguments: tuple[Argument, ...]
    open: bool
    dialects: frozenset[int]
    instead: str = ""

    @property
    def least(self) -> int:
        """Arguments that it needs."""
        return sum(not argument.optional for argument in self.arguments)

    @property
    def most(self) -> int | None:
        """Arguments that it takes, None for no limit."""
        return None if self.open else len(self.arguments)


@dataclass(frozen=True, slots=True)
class Status:
    """A status variable.

    type: `M`, `C`, `P` or `J`. index: what each subscript counts, `slot` or `mechanism` and so on.
    readable, writable: by a program. dialects: as in Statement. setter: the statement that sets
    what it shows, empty for none. instead: as in Statement.
    """

    name: str
    type: str
    index: tuple[str, ...]
    readable: bool
    writable: bool
    dialects: frozenset[int]
    setter: str = ""
    instead: str = ""


Row = Statement | Function | Status
ANY: Final = "MCPJ"


def statement(word: str) -> Statement | None:
    """The statement or word of that name in any case; `End If` is `EndIf`."""
    key = " ".join(word.upper().split())
    return statements().get(key) or statements().get(key.replace(" ", ""))


def function(name: str) -> Function | None:
    """The function of that name in any case, with or without its `$`."""
    return functions().get(name.upper().removesuffix("$"))


def status(name: str) -> Status | None:
    """The status variable of that name in any case, with or without its `$`."""
    return variables().get(name.upper().removesuffix("$"))


def known(name: str, *, called: bool = True) -> Function | Status | None:
    """The status variable of that name, or the function if it is called."""
    return status(name) or (function(name) if called else None)


@cache
def statements() -> Mapping[str, Statement]:
    """Every statement and word by its upper-case name, in the order of the table."""
    return {row.word.upper(): row for row in _statements()}


@cache
def functions() -> Mapping[str, Function]:
    """Every function by its upper-case name without `$`."""
    return {row.name.upper().removesuffix("$"): row for row in map(_function, _rows("functions"))}


@cache
def variables() -> Mapping[str, Status]:
    """Every status variable by its upper-case name."""
    return {row.name.upper(): row for row in map(_variable, _rows("variables"))}


@cache
def words(role: Role) -> tuple[str, ...]:
    """The words of one role, in the order of the table."""
    return tuple(row.word for row in statements().values() if row.role == role)


@cache
def commands(effect: Effect) -> frozenset[str]:
    """The commands of one effect, as spelled in the table."""
    return frozenset(row.word for row in statements().values() if effect in row.effects)


def _statements() -> Iterator[Statement]:
    role: Role = "part"
    for cells in _rows("statements"):
        if cells[0].startswith("["):
            if cells[0][1:-1] not in _ROLES:
                raise ValueError(f"statements.txt: {cells[0]} is no role")
            role = cast(Role, cells[0][1:-1])
            continue
        word, levels, count, listed, first, instead = (*cells, *[""] * 4)[:6]
        effects = frozenset(listed.split())
        if not effects <= set(_EFFECTS):
            raise ValueError(f"statements.txt: {word} has an effect that is none: {listed}")
        least, _, most = (count or "0-").partition("-")
        yield Statement(
            word,
            role,
            _levels(levels),
            int(least),
            int(most) if most else None,
            cast(frozenset[Effect], effects),
            tuple(first.split()),
            instead,
        )


def _function(cells: tuple[str, ...]) -> Function:
    name, result, taken, levels, instead = (*cells, "")[:5]
    parts = taken.split()
    listed = tuple(_argument(part) for part in parts if part != "...")
    return Function(name, result, listed, "..." in parts, _levels(levels), instead)


def _argument(text: str) -> Argument:
    types = text.strip("[]>")
    return Argument(ANY if types == "?" else types, text.startswith("["), text.startswith(">"))


def _variable(cells: tuple[str, ...]) -> Status:
    name, index, access, levels, setter, instead = (*cells, "", "")[:6]
    counted = () if index == "-" else tuple(index.split())
    return Status(
        name, name[0], counted, "R" in access, "W" in access, _levels(levels), setter, instead
    )


def _levels(text: str) -> frozenset[int]:
    return frozenset(map(int, text))


def _rows(table: str) -> Iterator[tuple[str, ...]]:
    """The cells of each line of a table that says something."""
    text = files(__name__).joinpath(table + ".txt").read_text("utf-8")
    for line in text.splitlines():
        # `#Include` is a word of the language, not a comment.
        if line and not line.startswith("# ") and line != "#":
            yield tuple(cell.strip() for cell in line.split("|"))
