"""What each name of translated programs has become: a table of old and new names as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from assistant.base.diagnostics import TABLE_NOUNS, Span
from assistant.compiler.loader import language_of
from assistant.compiler.source_map import Place, Places
from assistant.compiler.translation import Translation
from assistant.program.program import Program, walk
from assistant.program.statements import Follow, Label
from assistant.report.translation import Translated

NAME_COLUMNS: Final = ("program", "kind", "routine", "old", "new", "file", "line")
NAMED_TABLES: Final = (
    "variables", "targets", "joint_targets", "tools", "frames", "signals", "speeds", "blends",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class NamedItem:
    """A name of a program. kind: see `ONE_OF`, or parameter or label. owner: its procedure."""

    kind: str
    owner: str
    name: str
    span: Span | None = field(default=None, compare=False)

    @property
    def key(self) -> tuple[str, str]:
        return self.owner.lower(), self.name.lower()


def names_csv(done: Sequence[Translated]) -> str:
    """A line for each name of each program, with what it is in the files that were written.

    Several lines for what has become several things; nothing is new where it is left out.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(NAME_COLUMNS)
    for one in done:
        for old, new, place in renamed_items(one.translation):
            where = ("", "") if place is None else (place.path or one.source, str(place.line))
            table.writerow((one.source, old.kind, old.owner, old.name, new, *where))
    return text.getvalue()


def renamed_items(translation: Translation) -> Iterator[tuple[NamedItem, str, Place | None]]:
    """Each name of the source, what it is called now, and where it is declared."""
    compiled = translation.compiled
    source, places = compiled.source, compiled.places
    target = language_of(compiled.language)
    if source.origin is not None and language_of(source.origin.language).family == target.family:
        yield from _converted_names(translation)
        return
    there: dict[tuple[str, str], list[NamedItem]] = {}
    made: dict[Span, list[NamedItem]] = {}
    written = translation.written.program if translation.files else Program("none")
    for one in _item_names(written):
        there.setdefault(one.key, []).append(one)
        if one.span is not None:
            made.setdefault(one.span, []).append(one)
    spelled = target.spelled(written)
    known = list(_item_names(source))
    keys = {one.key for one in known}
    spans = {(p.owner.lower(), p.name.lower()): p.span for p in places.parts() if p.name}
    parts = (NamedItem("data", p.owner, p.name, p.span) for p in places.parts() if p.name)
    for old in dict.fromkeys([*known, *(one for one in parts if one.key not in keys)]):
        span = old.span or spans.get(old.key)
        found = there.get(old.key) or made.get(span or Span(-1, -1), [])
        if old.kind == "parameter":  # of the program, where procedures have none
            found = found or there.get(("", f"{old.owner}_{old.name}".lower()), [])
        alike = [one for one in found if one.kind == old.kind] or found
        place = None if span is None else places.of(span)
        news = dict.fromkeys(spelled(one.kind, one.owner, one.name) for one in alike)
        for new in news or [""]:
            yield old, new, place
    yield from _renamed_rows(source, written, places)


def _renamed_rows(
    source: Program, written: Program, places: Places
) -> Iterator[tuple[NamedItem, str, Place | None]]:
    """The same of positions that are rows of paths now, under other names."""
    here, there = (
        [s for s in one.statements() if isinstance(s, Follow)] for one in (source, written)
    )
    if [len(one.path) for one in here] != [len(one.path) for one in there]:
        return
    for one, other in zip(here, there, strict=True):
        for row in range(len(one.path) if one.path.original is not None else 0):
            span = one.row_span(row)
            old = NamedItem(TABLE_NOUNS["targets"], "", one.path.row_name(row), span)
            new = f"{other.path.name}_{row + 1}"
            yield old, new, None if span is None else places.of(span)


def _converted_names(translation: Translation) -> Iterator[tuple[NamedItem, str, Place | None]]:
    """The same of a program in another dialect, whose data stand in the order of the source."""
    places, back = translation.compiled.places, translation.written.proof.lifted
    old = [part for part in places.parts() if part.name]
    new = [part.name for part in Places(back).parts() if part.name] if back else []
    if len(new) == len(old):
        for part, name in zip(old, new, strict=True):
            yield NamedItem("data", part.owner, part.name or ""), name, places.of(part.span)


def _item_names(program: Program) -> Iterator[NamedItem]:
    for procedure in program.procedures:
        yield NamedItem("procedure", "", procedure.name, procedure.span)
        for parameter in procedure.parameters:
            yield NamedItem("parameter", procedure.name, parameter.name)
        for name, variable in procedure.variables.items():
            yield NamedItem("variable", procedure.name, name, variable.span)
        labels = (x.name for x in walk(procedure.body) if isinstance(x, Label))
        yield from (NamedItem("label", procedure.name, name) for name in dict.fromkeys(labels))
    for table in NAMED_TABLES:
        held: Iterable[str] = getattr(program, table)
        for name in held:
            span = program.variables[name].span if table == "variables" else None
            yield NamedItem(TABLE_NOUNS[table], "", name, span)
