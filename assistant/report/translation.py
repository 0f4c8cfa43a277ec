"""The report on translated programs: lines of text, records, Markdown."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.compiler.source_map import Place
from assistant.compiler.translation import ReportRow, Translation
from assistant.findings.formats import finding_record
from assistant.report.costs import MOST_COSTS, costs
from assistant.report.markdown import cell, code, findings_markdown

STANDARD_INPUT: Final = "standard input"


@dataclass(frozen=True, slots=True)
class Translated:
    """A translation with what its source is called."""

    source: str
    translation: Translation


def report_text(done: Sequence[Translated]) -> str:
    """One line a statement, as compilers write them, and a line of totals each."""
    return "".join(f"{line}\n" for one in done for line in report_lines(one))


def report_lines(one: Translated) -> Iterator[str]:
    translation = one.translation
    for row in translation.rows:
        yield f"{_place_text(row.place)}: {row.level}: {_statement_text(row)}{_outcome_text(row)}"
        for reason in row.reasons:
            yield f"    {reason.code} {reason.message}" + (
                f"; {reason.cure}" if reason.cure else ""
            )
    yield f"{one.source}: {level_totals(translation)}"
    yield from reason_lines(one)


MOST_PLACES: Final = {"not": 5, "partial": 2}
"""Of one reason, that a summary shows."""
_LEVEL_WORDS: Final = {"not": "not said", "partial": "said with a change"}


def summary(one: Translated) -> Iterator[str]:
    """How much is said, then what is not and what is changed, by reasons, with first places."""
    translation = one.translation
    yield f"{one.source}: {translated_share(translation):.1f} % said: {level_totals(translation)}"
    for level in ("not", "partial"):
        rows = [row for row in translation.rows.noted if row.level == level]
        every = costs(rows, len(rows))
        for cost in every[:MOST_COSTS]:
            cure = f"; {cost.cure}" if cost.cure else ""
            yield f"  {cost.count:,} {_LEVEL_WORDS[level]}: {cost.code} {cost.message}{cure}"
            shown = cost.rows[: MOST_PLACES[level]]
            yield from (
                f"    {_place_text(row.place)}: {_statement_text(row)}{_outcome_text(row)}"
                for row in shown
            )
            if len(shown) < len(cost.rows):
                yield f"    and {len(cost.rows) - len(shown):,} more"
        if len(every) > MOST_COSTS:
            rest = sum(cost.count for cost in every[MOST_COSTS:])
            yield f"  {rest:,} {_LEVEL_WORDS[level]} for {len(every) - MOST_COSTS:,} other reasons"


def reason_lines(one: Translated) -> Iterator[str]:
    """What most statements are not said for, a line each; none of a program that is whole."""
    for cost in costs(row for row in one.translation.rows.noted if row.level == "not"):
        cure = f"; {cost.cure}" if cost.cure else ""
        statements = "statement" if cost.count == 1 else "statements"
        yield (
            f"{one.source}: {cost.count:,} {statements} not, first at {_place_text(cost.place)}: "
            f"{cost.code} {cost.message}{cure}"
        )


def report_markdown(done: Sequence[Translated]) -> str:
    """For a pull request: of each program how much is said, and what costs most."""
    told = ["| program | supported | partial | not | said |", "|---|---:|---:|---:|---:|"]
    for one in done:
        counts = " | ".join(f"{count:,}" for count in one.translation.totals.values())
        told.append(
            f"| {cell(one.source)} | {counts} | {translated_share(one.translation):.1f} % |"
        )
    for one in done:
        told += _program_markdown(one)
    return "\n".join(told) + "\n"


def _program_markdown(one: Translated) -> Iterator[str]:
    translation = one.translation
    yield from ("", f"### {code(one.source)} in {translation.language}", "")
    yield from (f"- {code(line)}" for line in translation.written.proof_lines())
    if translation.draft:
        yield "- the files are a draft, with a stop for each statement that is not said"
    yield from findings_markdown(translation.whole)
    most = costs(translation.rows.noted)
    if most:
        yield from (
            "",
            "| statements | | reason | what to do | first in |",
            "|---:|---|---|---|---|",
        )
    for cost in most:
        where = f"{cost.place.path or STANDARD_INPUT}:{cost.place.line}"
        yield (
            f"| {cost.count:,} | {cost.level} | {cell(f'{cost.code} {cost.message}')} "
            f"| {cell(cost.cure) if cost.cure else ''} | {cell(where)} |"
        )


def translated_share(translation: Translation) -> float:
    """Percent of the statements that are said, some with a change."""
    totals = translation.totals
    return 100 * (1 - totals["not"] / max(1, sum(totals.values())))


def level_totals(translation: Translation) -> str:
    """How many statements there are at each level, in words."""
    return ", ".join(f"{count:,} {level}" for level, count in translation.totals.items())


def report_record(one: Translated) -> dict[str, Any]:
    """The translation as plain data."""
    translation = one.translation
    return {
        "source": one.source,
        "language": translation.language,
        "ok": translation.ok,
        "draft": translation.draft,
        "totals": translation.totals,
        "said_percent": round(translated_share(translation), 1),
        "reasons": [cost.record() for cost in costs(translation.rows.noted)],
        "statements": [_row_record(row) for row in translation.rows],
        "findings": [finding_record(f) for f in translation.whole],
        "files": sorted(translation.files),
        "proof": translation.proof.record(),
        "motion": None if translation.motion is None else translation.motion.record(),
    }


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
    return f"{place.path or STANDARD_INPUT}:{place.line}"


def _statement_text(row: ReportRow) -> str:
    return f"{row.text} ({row.count} rows)" if row.count > 1 else row.text


def _outcome_text(row: ReportRow) -> str:
    return f" -> {_place_text(row.went[0])}" if row.went else ""


def _report_json(done: Sequence[Translated]) -> str:
    return json.dumps([report_record(one) for one in done], indent=2, ensure_ascii=False) + "\n"


REPORT_WRITERS: Final[dict[str, Callable[[Sequence[Translated]], str]]] = {
    ".md": report_markdown,
    ".json": _report_json,
    ".txt": report_text,
}
"""What a report file is written as, by its suffix."""


def report_bytes(
    done: Sequence[Translated], file: FilePath, refusals: Sequence[Diagnostic] = ()
) -> bytes:
    """The report as the suffix of its file asks for; text for any other.

    refusals: why programs are in no translation; in each form but the page.
    """
    suffix = file.suffix.lower()
    said = REPORT_WRITERS.get(suffix, report_text)(done)
    if suffix == ".json":
        records = [*map(report_record, done), *_refusal_records(refusals)]
        said = json.dumps(records, indent=2, ensure_ascii=False) + "\n"
    elif suffix == ".md":
        said = "".join(f"{line}\n" for line in findings_markdown(refusals)) + said
    elif REPORT_WRITERS.get(suffix, report_text) is report_text:
        of_all = (finding for one in done for finding in one.translation.whole)
        said += "".join(map(_finding_text, (*of_all, *refusals)))
    return said.encode("utf-8")


def _refusal_records(refusals: Sequence[Diagnostic]) -> Iterator[dict[str, Any]]:
    """A record for each source that could not be read, as plain data."""
    for source in dict.fromkeys(finding.path for finding in refusals):
        found = [finding_record(finding) for finding in refusals if finding.path == source]
        yield {"source": source, "ok": False, "findings": found}


def _finding_text(finding: Diagnostic) -> str:
    where = f"{finding.where()}: " if finding.where() else ""
    cure = f"; {finding.cure}" if finding.cure else ""
    return f"{where}{finding.severity}: {finding.code} {finding.message}{cure}\n"
