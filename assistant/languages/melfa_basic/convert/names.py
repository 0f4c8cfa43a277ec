"""Names of variables and labels as the dialect takes them, and back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.languages.melfa_basic.tables.words import RESERVED_WORDS, free_name
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.targets import labels_named, labels_written
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
    """What the names of tables begin with, in upper case: their numbers must stay."""
    return {i.stem.upper() for i in items if isinstance(i, PositionRows | MoveRows)}


def short_names(files: Sequence[Sequence[s.Item]], dialect: Dialect) -> Names:
    """Short names for what is too long for the dialect: the same in all files of a program."""
    names = Names()
    written = {n.upper() for items in files for n in variables_of(items)}
    taken = TakenNames((*(n for n in written if len(n) <= dialect.names), *RESERVED_WORDS))
    for stem in sorted({stem for items in files for stem in stems_of(items)}):
        digits = max(len(n) - len(stem) for n in written if _numbered_name(n, stem))
        if len(stem) + digits > dialect.names:
            stems = {n.rstrip("0123456789") for n in written} | set(names.stems.values())
            names.stems[stem] = free_name(stem, dialect.names - digits, stems)
    for name in sorted(written):
        if len(name) > dialect.names and name.rstrip("0123456789") not in names.stems:
            names.named[name] = free_name(name, dialect.names, taken)
    labels = {n.upper() for items in files for n in labels_written(items)}
    labels.update(*(labels_named(items) for items in files))
    short = TakenNames((*(n for n in labels if _plain_label(n, dialect)), *RESERVED_WORDS))
    for name in sorted(labels - short):
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
                return part if stem == part.stem else replace(part, stem=stem, span=None)
        return part

    return [rewrite(item, change) for item in items]


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
