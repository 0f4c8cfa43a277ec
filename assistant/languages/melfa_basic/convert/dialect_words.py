"""Names and words of one dialect in another one, and the original names in the heading.

`Names` shortens variables and labels, `Words` replaces statements, functions and variables that a
dialect writes in other words or lacks. A converted program keeps its original names in its
heading, so that converting it back restores them:

    ' robot-assistant: melfa-basic-4
    ' named: PSCREWPO = PScrewPosition
    ' labelled: ASSYEND = ASSY_END
    ' steps: L100, L160
    ' robot-assistant: end

A program that was written by this tool has such a heading already (see text.header); the lines go
into it, and its own short names follow.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from itertools import takewhile
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tables.variables import RESERVED_WORDS, TYPE_MARKS, free_name
from assistant.languages.melfa_basic.text import header as headers
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.control_flow import (
    is_block_word,
    labels_named,
    labels_written,
    targets_in,
)
from assistant.languages.melfa_basic.tree.walk import word_of
from assistant.program.program import TakenNames
from assistant.program.rewriting import records, rewrite

NAME_TABLES: Final = ("named", "stems", "labelled")


@dataclass(slots=True)
class Names:
    """Name in upper case → the name that it gets; KINDS are its tables.

    named: of variables. stems: of tables of positions, whose names differ in the number behind
    the stem. labelled: of labels.
    """

    named: dict[str, str] = field(default_factory=dict)
    stems: dict[str, str] = field(default_factory=dict)
    labelled: dict[str, str] = field(default_factory=dict)


def is_program_name(name: str) -> bool:
    """True if a name belongs to the program, not to a status variable, function or word of the
    language.
    """
    return all(
        known(name) is None
        for known in (vocabulary.status, vocabulary.function, vocabulary.statement)
    )


def variables_of(items: Sequence[s.Item]) -> Iterator[str]:
    """Names of the program's own variables and functions, as they are written."""
    for item in items:
        match item:
            case s.Line():
                for record in records(item.statement):
                    if isinstance(record, s.Variable | s.FunctionParameter | s.DefFunction):
                        if is_program_name(record.name):
                            yield record.name
                    elif isinstance(record, s.Function):
                        yield record.name
            case s.Data():
                yield item.variable.name
            case PositionRows():
                yield item.stem + str(int(item.numbers.max()))
            case MoveRows():
                yield item.stem + str(int(item.end.max()))


def stems_of(items: Sequence[s.Item]) -> set[str]:
    """Return the stems of table names, in upper case: their numbers must not change."""
    return {i.stem.upper() for i in items if isinstance(i, PositionRows | MoveRows)}


def short_names(files: Sequence[Sequence[s.Item]], dialect: Dialect) -> Names:
    """Short names for what is too long for the dialect: the same in all files of a program."""
    names = Names()
    written = {n.upper() for items in files for n in variables_of(items)}
    taken = TakenNames((*(n for n in written if len(n) <= dialect.names), *RESERVED_WORDS))
    for stem in sorted({stem for items in files for stem in stems_of(items)}):
        # The longest number decides how much of the stem has to go, as all names keep their
        # numbers.
        digits = max(len(n) - len(stem) for n in written if _numbered_name(n, stem))
        if len(stem) + digits > dialect.names:
            stems = {n.rstrip("0123456789") for n in written} | set(names.stems.values())
            names.stems[stem] = free_name(stem, dialect.names - digits, stems)
    for name in sorted(written):
        # Names of tables get their short names through the stem.
        if len(name) > dialect.names and name.rstrip("0123456789") not in names.stems:
            names.named[name] = free_name(name, dialect.names, taken)
    labels = {n.upper() for items in files for n in labels_written(items)}
    labels.update(*(labels_named(items) for items in files))
    short = TakenNames((*(n for n in labels if _plain_label(n, dialect)), *RESERVED_WORDS))
    for name in sorted(labels - short):
        # MELFA-BASIC IV allows `_` only in labels of the base program.
        plain = name.replace("_", "") if dialect.upper else name
        names.labelled[name] = free_name(plain, dialect.labels, short)
    return names


def _plain_label(name: str, dialect: Dialect) -> bool:
    plain = not dialect.upper or "_" not in name.removeprefix("L_")  # `*L_…`: of the base program
    return len(name) <= dialect.labels and plain


def _numbered_name(name: str, stem: str) -> bool:
    return name.startswith(stem) and name[len(stem) :].isdigit()


def with_names(items: Iterable[s.Item], names: Names, *, upper: bool) -> list[s.Item]:
    """The lines with their names exchanged; upper: and all of them in upper case."""

    def exchanged(name: str, table: Mapping[str, str]) -> str:
        return table.get(name.upper(), name.upper() if upper else name)

    def spelled(name: str) -> str:
        """The controller's own names are spelled as its tool does."""
        if is_program_name(name):
            stem = name.rstrip("0123456789")
            short = names.stems.get(stem.upper())
            return exchanged(name, names.named) if short is None else short + name[len(stem) :]
        if upper:
            return name.upper()
        if row := vocabulary.known(name):
            return row.name.removesuffix("$")
        word = vocabulary.statement(name)
        return name if word is None else word.word

    def change(part: Any) -> Any:
        match part:
            case s.Variable() | s.DefFunction() | s.Function() | s.FunctionParameter():
                name = spelled(part.name)
                return part if name == part.name else replace(part, name=name)
            case s.Target(place=str() as place):
                label = exchanged(place, names.labelled)
                return part if label == place else s.Target(label)
            case s.Line(label=str() as label):
                new = exchanged(label, names.labelled)
                return part if new == label else replace(part, label=new)
            case PositionRows() | MoveRows():
                stem = exchanged(part.stem, names.stems)
                # The source text of the span holds the old names.
                return part if stem == part.stem else replace(part, stem=stem, span=None)
        return part

    return [rewrite(item, change) for item in items]


def _declared_types(items: Iterable[s.Item]) -> dict[str, str]:
    """Types that `Def` states, by upper-case name."""
    found: dict[str, str] = {}
    for item in items:
        statement = item.statement if isinstance(item, s.Line) else None
        if isinstance(statement, s.Static):
            statement = statement.definition
        if isinstance(statement, s.DefNames):
            found.update((v.key, statement.type) for v in statement.variables)
    return found


_LABEL_LISTS: Final = ("steps", "long", "constant")


@dataclass(slots=True)
class OriginalNames(Names):
    """The original names behind short names, and more that a dialect cannot express; all in upper
    case.

    steps: labels that replace step numbers. long: numbers that were 32-bit integers. constant:
    assigned variables that were constants.
    """

    steps: dict[str, None] = field(default_factory=dict)
    long: dict[str, None] = field(default_factory=dict)
    constant: dict[str, None] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return any(getattr(self, kind) for kind in (*NAME_TABLES, *_LABEL_LISTS))

    def lines(self) -> Iterator[str]:
        """The comment texts, without their mark."""
        for kind in NAME_TABLES:
            yield from headers.packed(kind, (f"{k} = {v}" for k, v in getattr(self, kind).items()))
        for kind in _LABEL_LISTS:
            yield from headers.packed(kind, getattr(self, kind))


_NAME_PAIR: Final = re.compile(r"([A-Z][A-Z0-9_]*) = ([A-Za-z][A-Za-z0-9_]*)")
_NAME: Final = re.compile(r"[A-Z][A-Z0-9_]*")
_SHORT_NAME: Final = re.compile(r"(?<=[ ,])([A-Z][A-Z0-9_]*)(?= = )")


def take_original_names(items: Sequence[s.Item]) -> tuple[list[s.Item], OriginalNames]:
    """The lines without what an earlier conversion has put into the heading, and that.

    A heading that holds nothing else goes as well.
    """
    memory = OriginalNames()
    start, end = _heading(items)
    if end <= start:
        return list(items), memory
    kept = [i for i in items[start + 1 : end] if not _remember_entry(_comment_text(i), memory)]
    if not kept:
        return [*items[:start], *items[end + 1 :]], memory
    return [*items[: start + 1], *kept, *items[end:]], memory


def put_original_names(
    items: Sequence[s.Item], memory: OriginalNames, dialect: str, *, marked: bool = False
) -> list[s.Item]:
    """The lines with the dialect and the memory in the heading.

    marked: with a heading that names the dialect, even if there is nothing else to say.
    """
    told = [_comment(text) for text in memory.lines()]
    start, end = _heading(items)
    if end > start:
        mark, first = "' " + headers.MARK + dialect, items[start]
        if isinstance(first, s.Line) and first.comment != mark:
            first = replace(first, comment=mark)
        return [*items[:start], first, *items[start + 1 : end], *told, *items[end:]]
    if not told and not marked:
        return list(items)
    heading = [_comment(headers.MARK + dialect), *told, _comment(headers.END)]
    return [*heading, *items]


def with_heading_names(items: Sequence[s.Item], names: Mapping[str, str]) -> list[s.Item]:
    """The lines with the short names in the heading exchanged, by upper-case name."""
    start, end = _heading(items)
    lines = list(items)
    for at in range(start + 1, end):
        item = lines[at]
        if not isinstance(item, s.Line) or item.comment is None:
            continue
        text = _SHORT_NAME.sub(lambda m: names.get(m.group(1).upper(), m.group(1)), item.comment)
        if text != item.comment:
            lines[at] = replace(item, comment=text)
    return lines


def _heading(items: Sequence[s.Item]) -> tuple[int, int]:
    """Return the places of the first and last line of the heading; (0, 0) without a heading."""
    texts = takewhile(lambda text: text is not None, map(_comment_text, items))
    return headers.bounds([text or "" for text in texts]) or (0, 0)


def _comment_text(item: s.Item) -> str | None:
    """The text of a line that is a comment only."""
    if not isinstance(item, s.Line) or item.statement is not None or item.label is not None:
        return None
    comment = item.comment or ""
    return comment[1:].strip() if comment.startswith("'") else None


def _comment(text: str) -> s.Line:
    return s.Line(comment="' " + text.removeprefix("' "))


def _remember_entry(text: str | None, memory: OriginalNames) -> bool:
    key, _, value = (text or "").partition(": ")
    if key in NAME_TABLES:
        pairs = (_NAME_PAIR.fullmatch(entry) for entry in value.split(", "))
        getattr(memory, key).update({p.group(1): p.group(2) for p in pairs if p})
        return True
    if key in _LABEL_LISTS:
        names = (entry for entry in value.split(", ") if _NAME.fullmatch(entry))
        getattr(memory, key).update(dict.fromkeys(names))
        return True
    return False


Complain = Callable[[s.Item, str, str], None]

_GROUPS: Final = {
    name.upper(): (bits, out)
    for dialect in DIALECTS.values()
    for bits, names in dialect.groups.items()
    for out, name in enumerate(names)
}
"""Status variables of signal groups: how many bits, and whether they are outputs."""

_IO_TYPES: Final = {4: {"DWORD": "Integer"}, 5: {"INTEGER": "DWord"}, 6: {"INTEGER": "DWord"}}
"""`Def Io` of 32 bits in the levels of the dialects."""

_INITIAL: Final = {"Tool": "P_NTool", "Base": "P_NBase"}
"""Equivalents of number 0: no tool and no base."""


_STAY: Final = "do without it, or stay with the dialect that has it"


def in_new_words(record: Any) -> Any:
    """Groups of signals by the names that MELFA-BASIC V and VI have for them."""
    if isinstance(record, s.Variable) and (group := _GROUPS.get(record.key)) is not None:
        bits, out = group
        return replace(record, name=DIALECTS["melfa-basic-6"].groups[bits][out])
    return record


class Words:
    """Says the lines of one program in the words of a dialect; complains of what it lacks."""

    def __init__(self, dialect: Dialect, memory: OriginalNames, complain: Complain) -> None:
        self.dialect, self.memory, self.complain = dialect, memory, complain
        self.types: dict[str, str] = {}
        self.declared: dict[str, str] = {}
        self.suffixes: dict[str, str] = {}
        self.here: s.Item = s.Blank()

    def lines(self, items: Sequence[s.Item]) -> list[s.Item]:
        self.types = _declared_types(items)
        made: list[s.Item] = []
        for item in items:
            made += self.line(item) if isinstance(item, s.Line) else [item]
        if not self.declared:
            return made
        # The heading has to stay in front of all statements.
        at = next((i for i, item in enumerate(made) if not _is_comment(item)), len(made))
        news = [
            s.Line(statement=s.DefNames(kind, (s.Variable(name),)))
            for kind in dict.fromkeys(self.declared.values())
            for name, of in self.declared.items()
            if of == kind
        ]
        return [*made[:at], *news, *made[at:]]

    def line(self, item: s.Line) -> list[s.Item]:
        if item.statement is None:
            return [item]
        self.here = item
        changed = rewrite(item, self.record)
        if self.dialect.level == 4 and isinstance(changed.statement, s.Const):
            return self.constant(changed, changed.statement)
        return [changed]

    # ------------------------------------------------------------------- records

    def record(self, record: Any) -> Any:
        """One part of a statement, after the parts in it."""
        match record:
            case s.Variable():
                return self.variable(record)
            case s.Number(suffix=mark) if mark and self.dialect.level == 4:
                return replace(record, suffix="")
            # MELFA-BASIC IV has no 32-bit integers; `Double` holds each of them exactly.
            case s.DefNames(type="Long", variables=variables) if self.dialect.level == 4:
                self.memory.long |= dict.fromkeys(v.key for v in variables)
                return replace(record, type="Double")
            case s.DefIo(type=kind):
                known = _IO_TYPES[self.dialect.level].get(kind.upper())
                return record if known is None else replace(record, type=known)
            case s.Command("Tool" | "Base" as word, (s.Number(value=0),)) if (
                self.dialect.level == 4
            ):
                return replace(record, arguments=(s.Variable(_INITIAL[word]),))
            case s.Const() if self.dialect.level == 4:
                return record  # becomes an assignment
        if self.dialect.level == 4 and (form := _later_form(record)) is not None:
            self.lacks(*form)
        if isinstance(record, s.Statement):
            row = vocabulary.statement(word_of(record))
            if row is not None:
                self.has(row.word, row)
        return record

    def has(self, name: str, row: vocabulary.Row, otherwise: str = _STAY) -> None:
        """Complains of a word that the dialect lacks."""
        if self.dialect.level not in row.dialects:
            cure = f"write instead: {row.instead}" if row.instead else otherwise
            self.lacks(f"`{name}`", cure)

    def lacks(self, what: str, cure: str) -> None:
        self.complain(self.here, what, cure)

    # ----------------------------------------------------------------- variables

    def variable(self, node: s.Variable) -> s.Variable:
        group = _GROUPS.get(node.key)
        if group is not None:
            bits, out = group
            names = self.dialect.groups.get(bits)
            if names is None:
                most = max(self.dialect.groups)
                self.lacks(f"`{node.name}`", f"read or write {most} bits at a time")
                return node
            return node if names[out].upper() == node.key else replace(node, name=names[out])
        row = vocabulary.known(node.name, called=node.arguments is not None)
        if row is not None:
            is_function = isinstance(row, vocabulary.Function)
            self.has(row.name, row, "compute it another way" if is_function else _STAY)
            return node
        return self.plain(node) if self.dialect.level == 4 and is_program_name(node.name) else node

    def plain(self, node: s.Variable) -> s.Variable:
        """Without a type mark, which is a declaration instead."""
        mark = node.suffix
        # The name of a `Def FN` function holds its type.
        if not mark or node.key.startswith("FN"):
            return node
        if mark == "$":
            # `C…$` is how MELFA-BASIC IV itself marks a text.
            if node.key.startswith("C"):
                return node if self.types.get(node.key) != "Char" else replace(node, suffix="")
            kind = "Char"
        else:
            kind = TYPE_MARKS[mark].word
        other = self.suffixes.setdefault(node.key, mark)
        # Without marks the two would become one variable.
        if (other == "$") != (mark == "$"):
            self.lacks(f"both `{node.name}{other}` and `{node.name}{mark}`", "rename one")
        if node.key not in self.types:
            if node.arguments is not None:
                cure = "name it by its type: M… for numbers, C…$ for texts"
                self.lacks(f"the array `{node.name}{mark}`", cure)
            if kind == "Long":
                self.memory.long[node.key] = None
            self.declared[node.key] = "Double" if kind == "Long" else kind
        return replace(node, suffix="")

    # ----------------------------------------------------------------- constants

    def constant(self, line: s.Line, node: s.Const) -> list[s.Item]:
        """Replace a `Const` by an assignment at the same place."""
        self.memory.constant[node.variable.key] = None
        made: list[s.Item] = []
        if node.type:
            kind = "Double" if node.type == "Long" else node.type
            made.append(s.Line(statement=s.DefNames(kind, (node.variable,)), span=line.span))
        return [*made, replace(line, statement=s.Assign(node.variable, node.value))]


def _later_form(record: Any) -> tuple[str, str] | None:
    """Return a form of a statement that IV lacks although it has the statement, and what to write
    instead.
    """
    match record:
        case s.Command("Tool" | "Base" as word, (s.Number(),)):
            return (
                f"`{printer.statement(record)}`, a number",
                f"write its values: {word} (x,y,z,a,b,c)",
            )
        case s.Command("Fine", (_, s.Variable(key="P" | "J"), *_)):
            said = printer.statement(record)
            return f"`{said}`, in mm or degrees", "write encoder pulses: Fine 100"
        case s.Motion(type=(_, s.Number(value=2))):
            return "`Type …,2`, a way through singular points", "move with Mov past them"
        case s.DefAct(stop="F"):
            return "`Def Act …,F`", "write S or L, or neither"
    return None


def reworded(line: s.Line, dialect: Dialect) -> s.Line | None:
    """Return a line of a higher dialect in a lower one's words; None if it is not valid there on
    its own.

    The line names nothing of its program: no variable, no label, no other line.
    """
    if any(variables_of([line])) or any(targets_in([line])) or _needs_others(line.statement):
        return None
    complaints: list[str] = []
    said = Words(dialect, OriginalNames(), lambda _, what, cure: complaints.append(what + cure))
    made = with_names(said.lines([line]), Names(), upper=dialect.upper)
    alone = made[0] if len(made) == 1 else None
    return alone if isinstance(alone, s.Line) and not complaints else None


def _needs_others(statement: s.Statement | None) -> bool:
    """True if a statement has a meaning only together with the lines around it."""
    if isinstance(statement, s.Command) and statement.keyword in (
        "Break",
        "Wait",
        "Return",
        "FEnd",
    ):
        return True
    return is_block_word(statement) or isinstance(statement, s.Function)


def restored(items: Sequence[s.Item], memory: OriginalNames) -> list[s.Item]:
    """The lines with whole numbers of 32 bits and constants declared as they were."""
    made: list[s.Item] = []
    for item in items:
        if not isinstance(item, s.Line):
            made.append(item)
            continue
        match item.statement:
            case s.DefNames(type="Double", variables=variables) if all(
                v.key in memory.long for v in variables
            ):
                item = replace(item, statement=s.DefNames("Long", variables))
            case s.Assign(target=target, value=value, delay=None) if target.key in memory.constant:
                # Later assignments of the same name were assignments before.
                del memory.constant[target.key]
                kind = ""
                # The declaration right above was made for the constant, and goes with it.
                match made[-1] if made else None:
                    case s.Line(
                        label=None, comment=None, statement=s.DefNames(type=kind, variables=(one,))
                    ):
                        if one == target:
                            made.pop()
                        else:
                            kind = ""
                item = replace(item, statement=s.Const(kind, target, value))
        made.append(item)
    memory.long.clear()
    return made


def unreachable_constants(items: Sequence[s.Item]) -> list[s.Line]:
    """Return the constants after a label or a jump, where control may miss an assignment."""
    found: list[s.Line] = []
    passed = False
    for item in items:
        if not isinstance(item, s.Line):
            continue
        passed = passed or item.label is not None
        if isinstance(item.statement, s.Const):
            if passed:
                found.append(item)
        else:
            passed = passed or any(
                isinstance(r, s.Target | s.CallP | s.If | s.For | s.Select | s.Function)
                or r in (s.Command("Return"), s.Command("End"))
                for r in records(item.statement)
            )
    return found


def _is_comment(item: s.Item) -> bool:
    if isinstance(item, s.Blank):
        return True
    return isinstance(item, s.Line) and item.statement is None and item.label is None
