"""Names of variables and labels as the dialect takes them, and back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.languages.melfa_basic.tables.words import RESERVED, free
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.program.rewriting import records, rewrite


@dataclass(slots=True)
class Names:
    """Upper-case name → the name that it gets, apart for variables and labels.

    stems: of tables of positions, whose names differ in the number behind the stem.
    """

    variables: dict[str, str] = field(default_factory=dict)
    stems: dict[str, str] = field(default_factory=dict)
    labels: dict[str, str] = field(default_factory=dict)


def is_own(name: str) -> bool:
    """Whether a name is the program's: no status variable, function or word of the language."""
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
                        if is_own(record.name):
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
    """What the names of tables begin with, in upper case: their numbers must stay."""
    return {i.stem.upper() for i in items if isinstance(i, PositionRows | MoveRows)}


def shortened(files: Sequence[Sequence[s.Item]], dialect: Dialect) -> Names:
    """Short names for what is too long for the dialect: the same in all files of a program."""
    names = Names()
    written = {n.upper() for items in files for n in variables_of(items)}
    taken = {n for n in written if len(n) <= dialect.names} | RESERVED
    for stem in sorted({stem for items in files for stem in stems_of(items)}):
        digits = max(len(n) - len(stem) for n in written if _numbered(n, stem))
        if len(stem) + digits > dialect.names:
            stems = {n.rstrip("0123456789") for n in written} | set(names.stems.values())
            names.stems[stem] = free(stem, dialect.names - digits, stems)
    for name in sorted(written):
        if len(name) > dialect.names and name.rstrip("0123456789") not in names.stems:
            names.variables[name] = free(name, dialect.names, taken)
    labels = {label for items in files for label in _labels(items)}
    short = {n for n in labels if _plain_label(n, dialect)} | RESERVED
    for name in sorted(labels - short):
        plain = name.replace("_", "") if dialect.upper else name
        names.labels[name] = free(plain, dialect.labels, short)
    return names


def _plain_label(name: str, dialect: Dialect) -> bool:
    plain = not dialect.upper or "_" not in name.removeprefix("L_")  # `*L_…`: of the base program
    return len(name) <= dialect.labels and plain


def _labels(items: Sequence[s.Item]) -> Iterator[str]:
    for item in items:
        if isinstance(item, s.Line):
            if item.label is not None:
                yield item.label.upper()
            for record in records(item.statement):
                if isinstance(record, s.Target) and isinstance(record.place, str):
                    yield record.place.upper()


def _numbered(name: str, stem: str) -> bool:
    return name.startswith(stem) and name[len(stem) :].isdigit()


def renamed(items: Sequence[s.Item], names: Names, *, upper: bool) -> list[s.Item]:
    """The lines with their names exchanged; upper: and all of them in upper case."""
    change = _Change(names, upper)
    return [change.item(item) for item in items]


class _Change:
    def __init__(self, names: Names, upper: bool) -> None:
        self.names, self.upper = names, upper

    def item(self, item: s.Item) -> s.Item:
        match item:
            case s.Line():
                changed: s.Line = rewrite(item, self.record)
                if item.label is not None:
                    label = self.name(item.label, self.names.labels)
                    changed = changed if label == item.label else replace(changed, label=label)
                return changed
            case s.Data():
                return rewrite(item, self.record)
            case PositionRows() | MoveRows():
                stem = self.name(item.stem, self.names.stems)
                return item if stem == item.stem else replace(item, stem=stem, span=None)
        return item

    def name(self, name: str, table: Mapping[str, str]) -> str:
        return table.get(name.upper(), name.upper() if self.upper else name)

    def variable(self, name: str) -> str:
        stem = name.rstrip("0123456789")
        if stem.upper() in self.names.stems:
            return self.names.stems[stem.upper()] + name[len(stem) :]
        return self.name(name, self.names.variables)

    def record(self, record: Any) -> Any:
        match record:
            case s.Variable() | s.DefFunction() | s.Function() | s.FunctionParameter():
                name = self.spelled(record.name)
                return record if name == record.name else replace(record, name=name)
            case s.Target(place=str() as place):
                label = self.name(place, self.names.labels)
                return record if label == place else s.Target(label)
        return record

    def spelled(self, name: str) -> str:
        """The controller's own names are spelled as its tool does."""
        if is_own(name):
            return self.variable(name)
        if self.upper:
            return name.upper()
        if known := vocabulary.status(name) or vocabulary.function(name):
            return known.name.removesuffix("$")
        word = vocabulary.statement(name)
        return name if word is None else word.word


def declared_types(items: Iterable[s.Item]) -> dict[str, str]:
    """Types that `Def` states, by upper-case name."""
    found: dict[str, str] = {}
    for item in items:
        statement = item.statement if isinstance(item, s.Line) else None
        if isinstance(statement, s.Static):
            statement = statement.definition
        if isinstance(statement, s.DefNames):
            found.update((v.key, statement.type) for v in statement.variables)
    return found
