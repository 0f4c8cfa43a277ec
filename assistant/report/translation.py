"""The report on translated programs: text, records, Markdown, names, and what costs most.

Each statement is translated, translated with a change, or not translated, with a reason. `costs`
joins reasons that differ in names and numbers only. `names_csv` tells what each name has become.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import TABLE_NOUNS, Diagnostic, Severity, Span
from assistant.compiler.loader import language_of
from assistant.compiler.retarget import JOINTS_OF_OTHER_MAKER
from assistant.compiler.source_map import Place, Places
from assistant.compiler.translation import Level, ReportRow, Translation
from assistant.findings.formats import records_of
from assistant.program.program import Program, walk
from assistant.program.statements import Follow, Label
from assistant.program.undeclared_names import Wanted
from assistant.report.markdown import cell, code, findings_markdown
from assistant.sources.cell_values import kind_in_words

_MOST_COSTS: Final = 10
"""Most reasons in a program's report."""


@dataclass(frozen=True, slots=True)
class Cost:
    """A reason that statements have in common.

    count: of the statements with this as their first reason not to be translated, or only with a
    change. cure: its fix. message: of the first of them, which is at `place`. rows: of all of them,
    in their order.
    """

    code: str
    level: Level
    count: int
    message: str
    cure: str
    place: Place
    rows: tuple[ReportRow, ...] = ()

    def record(self) -> dict[str, Any]:
        return {
            "code": self.code,
            "level": self.level,
            "statements": self.count,
            "message": self.message,
            "cure": self.cure,
            "path": self.place.path,
            "line": self.place.line,
        }


def costs(rows: Iterable[ReportRow], most: int = _MOST_COSTS) -> list[Cost]:
    """Return the reasons of the most statements; those of untranslated statements come first."""
    found: dict[tuple[Level, str, str], list[ReportRow]] = {}
    for row in rows:
        if row.level != "supported" and row.reasons:
            first = row.reasons[0]
            found.setdefault((row.level, first.code, _common_message(first.message)), []).append(
                row
            )
    every = (_cost_record(alike, alike[0].reasons[0]) for alike in found.values())
    ordered = sorted(every, key=lambda c: (c.level != "not", -c.count, c.code))
    return ordered[:most]


def _costs_by_code(rows: Iterable[ReportRow]) -> list[Cost]:
    """Return the reasons of changes, those of the most statements first.

    A statement counts for each of its codes; notes count where nothing else is said of it. A
    finding about a whole handler counts once, for the first of its statements. A code with more
    than `_MOST_MESSAGES` messages is one reason, with the first of them.
    """
    found: dict[str, dict[str, tuple[Diagnostic, list[ReportRow]]]] = {}
    told: set[tuple[str, str, Span]] = set()
    for row in rows:
        main = [one for one in row.reasons if one.severity is not Severity.INFO] or row.reasons
        for reason in {one.code: one for one in reversed(main)}.values():
            if reason.span is not None:
                place = reason.code, reason.message, reason.span
                if place in told:
                    continue
                told.add(place)
            alike = found.setdefault(reason.code, {})
            alike.setdefault(_common_message(reason.message), (reason, []))[1].append(row)
    every = []
    for of_code in found.values():
        if len(of_code) > _MOST_MESSAGES:
            (first, _), *_ = of_code.values()
            every.append(
                _cost_record([row for _, alike in of_code.values() for row in alike], first)
            )
        else:
            every += [_cost_record(alike, first) for first, alike in of_code.values()]
    return sorted(every, key=lambda c: (-c.count, c.code))


def _cost_record(alike: Sequence[ReportRow], first: Diagnostic) -> Cost:
    row, count = alike[0], sum(one.count for one in alike)
    return Cost(first.code, row.level, count, first.message, first.cure, row.place, tuple(alike))


_MOST_MESSAGES: Final = 4
"""Most messages of a code that a summary lists separately."""
_QUOTED_NAME: Final = re.compile(r"`([A-Za-z_]\w*)[^`\w][^`]*`")
_ANY_NUMBER: Final = re.compile(r"(?<![\w`])[-+]?[0-9][0-9.,]*")


def _common_message(message: str) -> str:
    """A message without what differs from statement to statement: arguments and numbers."""
    return _ANY_NUMBER.sub("#", _QUOTED_NAME.sub(r"`\1`", message))


_STANDARD_INPUT: Final = "standard input"


@dataclass(frozen=True, slots=True)
class Translated:
    """A translation with what its source is called, and the file of values that it lacks."""

    source: str
    translation: Translation
    cell: FilePath | None = None


def _report_text(done: Sequence[Translated]) -> str:
    """One line a statement, as compilers write them, and a line of totals each."""
    lines = [*beginning(done, ()), *(line for one in done for line in report_lines(one))]
    return "".join(f"{line}\n" for line in lines)


def report_lines(one: Translated) -> Iterator[str]:
    translation = one.translation
    for row in translation.rows:
        yield f"{_place_text(row.place)}: {row.level}: {_statement_text(row)}{_outcome_text(row)}"
        for reason in row.reasons:
            yield f"    {reason.code} {reason.message}" + (
                f"; {reason.cure}" if reason.cure else ""
            )
    yield from reason_lines(one)


_MOST_PLACES: Final = {"not": 5, "partial": 2}
"""Most positions of one reason in a summary."""
_LEVEL_WORDS: Final = {"not": "not translated", "partial": "translated with a change"}
_MOST_USES: Final = 3
"""Most positions of a name in the table of what is to be filled in."""
_MOST_OF_PART: Final = 99.9
"""Most percent that are shown of a translation that is not complete."""
_DOUBT: Final = "?"
"""Follows a kind that the uses leave open."""


def beginning(done: Sequence[Translated], again: Sequence[str]) -> Iterator[str]:
    """Yield how much of each program is translated, what is to be filled in, and how to go on.

    again: the commands that go on.
    """
    for one in done:
        yield f"{one.source}: {share_in_words(one.translation)}"
    if len(done) > 1:
        yield f"{len(done)} programs, {sum(one.translation.ok for one in done)} of them complete"
    cells = dict.fromkeys(one.cell for one in done if one.translation.wanting)
    for path in cells:
        found = [one for one in done if one.cell == path]
        missing = {(w.kind, w.name.lower()): w for one in found for w in one.translation.wanting}
        yield ""
        values = "1 value" if len(missing) == 1 else f"{len(missing):,} values"
        yield f"to be filled in: {values}" + ("" if path is None else f", in {path}")
        yield from _wanted_table(list(missing.values()))
    for one in done:
        others = one.translation.beginnings[1:]
        if others:
            shown = ", ".join(others[:_MOST_USES])
            more = len(others) - _MOST_USES
            shown += f" and {more:,} more" if more > 0 else ""
            yield f"{one.source}: --entry may name another procedure: {shown}"
    armless = sum(
        row.count
        for one in done
        for row in one.translation.rows.noted
        if any(reason.code == JOINTS_OF_OTHER_MAKER.code for reason in row.reasons)
    )
    unnamed = any(one.translation.armless for one in done)
    if unnamed and not armless:
        yield "reach, limits and configurations are checked with --robot NAME, the arm that runs it"
    if armless:
        statements = "1 statement needs" if armless == 1 else f"{armless:,} statements need"
        yield f"{statements} the arm that will run it: add --robot NAME of `robot-assistant robots`"
    yield from (f"then: {command}" for command in again)
    if cells or again or armless or unnamed:
        yield ""


def _wanted_table(missing: Sequence[Wanted]) -> Iterator[str]:
    """Yield the names of a table with their kinds and uses, and what a `?` there means."""
    rows = [("name", "kind", "used in"), *map(_wanted_row, missing)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)][:2]
    for *columns, uses in rows:
        first = "  ".join(text.ljust(width) for text, width in zip(columns, widths, strict=True))
        yield f"  {first}  {uses}".rstrip()
    if any(one.perhaps for one in missing):
        kinds = {one.perhaps for one in missing if one.perhaps}
        unclear = ["whether it is a signal or data"] if kinds - {"type"} else []
        unclear += ["which type it has"] if "type" in kinds else []
        yield f"  {_DOUBT}: the uses do not show {' or '.join(unclear)}; the file tells how"


def _wanted_row(one: Wanted) -> tuple[str, str, str]:
    more = len(one.uses) - _MOST_USES
    uses = ", ".join(one.uses[:_MOST_USES]) + (f" and {more:,} more" if more > 0 else "")
    return one.name, kind_in_words(one) + (_DOUBT if one.perhaps else ""), uses


def share_in_words(translation: Translation) -> str:
    """Return how much is translated, whether it is complete, and how far a proof reached."""
    proven = "" if translation.motion is None else f"; {translation.motion.reach()}"
    unchecked = "; no arm is named, so reach, limits and configurations are not checked"
    return f"{_written_in_words(translation)}{proven}{unchecked * translation.armless}"


def _written_in_words(translation: Translation) -> str:
    share = f"{_share_text(translation)} translated: {level_totals(translation)}"
    if not translation.files:
        lacks = ", as no procedure is named that it begins with" if translation.beginnings else ""
        refusal = f": {translation.refusal}" if translation.refusal and not lacks else ""
        return f"{share}; nothing is written{lacks}{refusal}"
    if not translation.draft:
        return share
    gaps, count = translation.totals["not"], len(translation.wanting)
    why = [f"lacks {count:,} value{'s' * (count != 1)}"] if count else []
    why += [f"stops at {gaps:,} statement{'s' * (gaps != 1)}"] if gaps else []
    return f"{share}; a draft, which {' and '.join(why)}" if why else f"{share}; a draft"


def summary(one: Translated) -> Iterator[str]:
    """Yield the untranslated statements by reason and the changed ones by code, with first
    positions.
    """
    noted = list(one.translation.rows.noted)
    lost = costs((row for row in noted if row.level == "not"), len(noted))
    changed = _costs_by_code(row for row in noted if row.level == "partial")
    for level, every in (("not", lost), ("partial", changed)):
        for cost in every[:_MOST_COSTS]:
            cure = f"; {cost.cure}" if cost.cure else ""
            yield f"  {cost.count:,} {_LEVEL_WORDS[level]}: {cost.code} {cost.message}{cure}"
            shown = cost.rows[: _MOST_PLACES[level]]
            yield from (
                f"    {_place_text(row.place)}: {_statement_text(row)}{_outcome_text(row)}"
                for row in shown
            )
            if len(shown) < len(cost.rows):
                yield f"    and {len(cost.rows) - len(shown):,} more"
        rest = Counter[str]()
        for cost in every[_MOST_COSTS:]:
            rest[cost.code] += cost.count
        if rest:
            codes = ", ".join(f"{name} ({count:,})" for name, count in rest.most_common())
            yield f"  {_LEVEL_WORDS[level]} for other reasons: {codes}"


def reason_lines(one: Translated) -> Iterator[str]:
    """Yield the main reasons for untranslated statements, one line each; empty for a completely
    translated program.
    """
    for cost in costs(row for row in one.translation.rows.noted if row.level == "not"):
        cure = f"; {cost.cure}" if cost.cure else ""
        statements = "statement" if cost.count == 1 else "statements"
        yield (
            f"{one.source}: {cost.count:,} {statements} not, first at {_place_text(cost.place)}: "
            f"{cost.code} {cost.message}{cure}"
        )


def report_markdown(done: Sequence[Translated]) -> str:
    """Return a report for a pull request: how much of each program is translated, and the main
    losses.
    """
    told = ["| program | supported | partial | not | translated |", "|---|---:|---:|---:|---:|"]
    for one in done:
        counts = " | ".join(f"{count:,}" for count in one.translation.totals.values())
        told.append(f"| {cell(one.source)} | {counts} | {_share_text(one.translation)} |")
    for one in done:
        told += _program_markdown(one)
    return "\n".join(told) + "\n"


def _program_markdown(one: Translated) -> Iterator[str]:
    translation = one.translation
    yield from ("", f"### {code(one.source)} in {translation.language}", "")
    yield from (f"- {code(line)}" for line in translation.written.proof_lines())
    yield f"- {share_in_words(translation)}"
    if translation.wanting:
        yield from ("", "| to be filled in | kind | used in |", "|---|---|---|")
        for name, kind, uses in map(_wanted_row, translation.wanting):
            yield f"| {cell(name)} | {kind} | {cell(uses)} |"
        yield ""
    yield from findings_markdown(translation.whole)
    most = costs(translation.rows.noted)
    if most:
        yield from (
            "",
            "| statements | | reason | what to do | first in |",
            "|---:|---|---|---|---|",
        )
    for cost in most:
        where = f"{cost.place.path or _STANDARD_INPUT}:{cost.place.line}"
        yield (
            f"| {cost.count:,} | {cost.level} | {cell(f'{cost.code} {cost.message}')} "
            f"| {cell(cost.cure) if cost.cure else ''} | {cell(where)} |"
        )


def translated_share(translation: Translation) -> float:
    """Return the percentage of translated statements, including those with a change."""
    totals = translation.totals
    return 100 * (1 - totals["not"] / max(1, sum(totals.values())))


def _share_text(translation: Translation) -> str:
    """`100 %` only of a complete translation."""
    share = translated_share(translation)
    return "100 %" if share == 100.0 else f"{min(share, _MOST_OF_PART):.1f} %"


def level_totals(translation: Translation) -> str:
    """Return the number of statements at each level, in words."""
    totals = translation.totals
    count = sum(totals.values())
    changed = f", {totals['partial']:,} with a change" if totals["partial"] else ""
    return f"{count - totals['not']:,} of {count:,} statements{changed}"


def report_record(one: Translated) -> dict[str, Any]:
    """The translation as plain data."""
    translation = one.translation
    return {
        "source": one.source,
        "language": translation.language,
        "ok": translation.ok,
        "draft": translation.draft,
        "cell": None if one.cell is None else str(one.cell),
        "wanting": [_wanted_record(wanted) for wanted in translation.wanting],
        "totals": translation.totals,
        "said_percent": round(translated_share(translation), 1),
        "reasons": [cost.record() for cost in costs(translation.rows.noted)],
        "statements": [_row_record(row) for row in translation.rows],
        "findings": records_of(translation.whole),
        "files": sorted(translation.files),
        "proof": translation.proof.record(),
        "motion": None if translation.motion is None else translation.motion.record(),
    }


def _wanted_record(one: Wanted) -> dict[str, Any]:
    kind = kind_in_words(one)
    return {"name": one.name, "kind": kind, "perhaps": one.perhaps, "uses": list(one.uses)}


def _row_record(row: ReportRow) -> dict[str, Any]:
    return {
        "path": row.place.path,
        "line": row.place.line,
        "text": row.text,
        "count": row.count,
        "level": row.level,
        "reasons": [
            {"code": f.code, "severity": f.severity, "message": f.message, "cure": f.cure}
            for f in row.reasons
        ],
        "went": [{"file": place.path, "line": place.line} for place in row.went],
    }


def _place_text(place: Place) -> str:
    return f"{place.path or _STANDARD_INPUT}:{place.line}"


def _statement_text(row: ReportRow) -> str:
    return f"{row.text} ({row.count} rows)" if row.count > 1 else row.text


def _outcome_text(row: ReportRow) -> str:
    return f" -> {_place_text(row.went[0])}" if row.went else ""


def _report_json(done: Sequence[Translated]) -> str:
    return json.dumps([report_record(one) for one in done], indent=2, ensure_ascii=False) + "\n"


_REPORT_WRITERS: Final[dict[str, Callable[[Sequence[Translated]], str]]] = {
    ".md": report_markdown,
    ".json": _report_json,
    ".txt": _report_text,
}
"""Writer of a report file, by its suffix."""


def report_bytes(
    done: Sequence[Translated], file: FilePath, refusals: Sequence[Diagnostic] = ()
) -> bytes:
    """The report as the suffix of its file asks for; text for any other.

    refusals: why programs are in no translation; in each form but the page.
    """
    suffix = file.suffix.lower()
    said = _REPORT_WRITERS.get(suffix, _report_text)(done)
    if suffix == ".json":
        records = [*map(report_record, done), *_refusal_records(refusals)]
        said = json.dumps(records, indent=2, ensure_ascii=False) + "\n"
    elif suffix == ".md":
        said = "".join(f"{line}\n" for line in findings_markdown(refusals)) + said
    elif _REPORT_WRITERS.get(suffix, _report_text) is _report_text:
        of_all = (finding for one in done for finding in one.translation.whole)
        said += "".join(map(_finding_text, (*of_all, *refusals)))
    return said.encode("utf-8")


def _refusal_records(refusals: Sequence[Diagnostic]) -> Iterator[dict[str, Any]]:
    """A record for each source that could not be read, as plain data."""
    for source in dict.fromkeys(finding.path for finding in refusals):
        found = records_of(finding for finding in refusals if finding.path == source)
        yield {"source": source, "ok": False, "findings": found}


def _finding_text(finding: Diagnostic) -> str:
    where = f"{finding.where()}: " if finding.where() else ""
    cure = f"; {finding.cure}" if finding.cure else ""
    return f"{where}{finding.severity}: {finding.code} {finding.message}{cure}\n"


_NAME_COLUMNS: Final = ("program", "kind", "routine", "old", "new", "file", "line")
_NAMED_TABLES: Final = (
    "variables", "targets", "joint_targets", "tools", "frames", "signals", "speeds", "blends",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class NamedItem:
    """A name of a program. kind: see `TABLE_NOUNS`, or parameter or label. owner: its procedure."""

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
    table.writerow(_NAME_COLUMNS)
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
            ways = (f"{old.owner}_{old.name}", old.name)
            found = found or next(
                (there[key] for key in (("", way.lower()) for way in ways) if key in there), []
            )
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
    """Yield the names of a program in another dialect, whose data are in the order of the
    source.
    """
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
    for table in _NAMED_TABLES:
        held: Iterable[str] = getattr(program, table)
        for name in held:
            span = program.variables[name].span if table == "variables" else None
            yield NamedItem(TABLE_NOUNS[table], "", name, span)
