"""Statements, functions and variables that a dialect says in other words, or not at all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.melfa_basic.convert.names import (
    Names,
    declared_types,
    is_program_name,
    variables_of,
    with_names,
)
from assistant.languages.melfa_basic.convert.original_names import OriginalNames
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tables.variables import TYPE_MARKS
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import is_block_word
from assistant.languages.melfa_basic.tree.targets import targets_in
from assistant.languages.melfa_basic.tree.walk import word_of
from assistant.program.rewriting import records, rewrite

Complain = Callable[[s.Item, str, str], None]

GROUPS: Final = {
    name.upper(): (bits, out)
    for dialect in DIALECTS.values()
    for bits, names in dialect.groups.items()
    for out, name in enumerate(names)
}
"""Status variables of signal groups: how many bits, and whether they are outputs."""

IO_TYPES: Final = {4: {"DWORD": "Integer"}, 5: {"INTEGER": "DWord"}, 6: {"INTEGER": "DWord"}}
"""`Def Io` of 32 bits in the levels of the dialects."""

INITIAL: Final = {"Tool": "P_NTool", "Base": "P_NBase"}
"""What number 0 stands for."""


STAY: Final = "do without it, or stay with the dialect that has it"


def in_new_words(record: Any) -> Any:
    """Groups of signals by the names that MELFA-BASIC V and VI have for them."""
    if isinstance(record, s.Variable) and (group := GROUPS.get(record.key)) is not None:
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
        self.types = declared_types(items)
        made: list[s.Item] = []
        for item in items:
            made += self.line(item) if isinstance(item, s.Line) else [item]
        if not self.declared:
            return made
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
            case s.DefNames(type="Long", variables=variables) if self.dialect.level == 4:
                self.memory.long |= dict.fromkeys(v.key for v in variables)
                return replace(record, type="Double")
            case s.DefIo(type=kind):
                known = IO_TYPES[self.dialect.level].get(kind.upper())
                return record if known is None else replace(record, type=known)
            case s.Command("Tool" | "Base" as word, (s.Number(value=0),)) if (
                self.dialect.level == 4
            ):
                return replace(record, arguments=(s.Variable(INITIAL[word]),))
            case s.Const() if self.dialect.level == 4:
                return record  # becomes an assignment
        if self.dialect.level == 4 and (form := _later_form(record)) is not None:
            self.lacks(*form)
        if isinstance(record, s.Statement):
            row = vocabulary.statement(word_of(record))
            if row is not None:
                self.has(row.word, row)
        return record

    def has(self, name: str, row: vocabulary.Row, otherwise: str = STAY) -> None:
        """Complains of a word that the dialect lacks."""
        if self.dialect.level not in row.dialects:
            cure = f"write instead: {row.instead}" if row.instead else otherwise
            self.lacks(f"`{name}`", cure)

    def lacks(self, what: str, cure: str) -> None:
        self.complain(self.here, what, cure)

    # ----------------------------------------------------------------- variables

    def variable(self, node: s.Variable) -> s.Variable:
        group = GROUPS.get(node.key)
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
            self.has(row.name, row, "compute it another way" if is_function else STAY)
            return node
        return self.plain(node) if self.dialect.level == 4 and is_program_name(node.name) else node

    def plain(self, node: s.Variable) -> s.Variable:
        """Without a type mark, which is a declaration instead."""
        mark = node.suffix
        if not mark or node.key.startswith("FN"):
            return node
        if mark == "$":
            if node.key.startswith("C"):
                return node if self.types.get(node.key) != "Char" else replace(node, suffix="")
            kind = "Char"
        else:
            kind = TYPE_MARKS[mark].word
        other = self.suffixes.setdefault(node.key, mark)
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
        """`Const` as the assignment that stands where it stood."""
        self.memory.constant[node.variable.key] = None
        made: list[s.Item] = []
        if node.type:
            kind = "Double" if node.type == "Long" else node.type
            made.append(s.Line(statement=s.DefNames(kind, (node.variable,)), span=line.span))
        return [*made, replace(line, statement=s.Assign(node.variable, node.value))]


def _later_form(record: Any) -> tuple[str, str] | None:
    """What IV has, but not in this form, and what to write."""
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
    """A line of a higher dialect in a lower one's words, None if it may not stand there alone.

    It names nothing of its program: no variable, no label, no other line.
    """
    if any(variables_of([line])) or any(targets_in([line])) or _needs_others(line.statement):
        return None
    complaints: list[str] = []
    said = Words(dialect, OriginalNames(), lambda _, what, cure: complaints.append(what + cure))
    made = with_names(said.lines([line]), Names(), upper=dialect.upper)
    alone = made[0] if len(made) == 1 else None
    return alone if isinstance(alone, s.Line) and not complaints else None


def _needs_others(statement: s.Statement | None) -> bool:
    """Whether a statement means something only together with the lines around it."""
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
                del memory.constant[target.key]
                kind = ""
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
    """Constants that stand behind a label or a jump, where an assignment may not be passed."""
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
