"""`compare`: the differences between two programs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, error
from assistant.cli.answering import Outcomes
from assistant.cli.compiling import working
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.cli.pages import PageRequest
    from assistant.compiler.comparison import Comparison, Difference
    from assistant.compiler.motion_proof import Proving
    from assistant.compiler.source_map import Place

WITHOUT_PARTNER: Final = error(
    "CL015",
    "there is no program `{name}` in `{folder}`",
    "compare it with another one by naming both files",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class CompareOptions:
    """The options of the command; see `compiler.comparing.compare`."""

    robot: str | None
    from_robot: str | None
    process: tuple[Path, ...]
    cell: Path | None
    names: Path | None
    language: str | None
    entry: str | None
    proving: Proving
    text: bool = False

    def read(self) -> list[str]:
        """The files beside the programs."""
        given = (*self.process, self.cell, self.names, self.proving.script)
        return [str(path) for path in given if path is not None]


def run_compare(
    first: str, second: str, options: CompareOptions, format: Format, asked: PageRequest
) -> int:
    """Return 0 if the programs are equal, 1 if they differ, 2 if they cannot be compared.

    asked: the page with both programs side by side. Raises Refused (exit status 2) for a file name
    that is not a page's.
    """
    from assistant.cli.sheets import compared_page
    from assistant.compiler.comparison import compare, counterparts

    asked.only_page()
    pairs = counterparts(first, second, options.language)
    answers = Outcomes()
    done: list[Comparison] = []
    for one, other in pairs.both:
        with answers.of(one.name), working(f"comparing {one.name}"):
            done.append(
                compare(
                    one.program(options.from_robot),
                    other.program(options.robot),
                    robot=options.robot,
                    from_robot=options.from_robot,
                    process=options.process,
                    cell=options.cell,
                    names=options.names,
                    language=options.language,
                    entry=options.entry,
                    proving=options.proving,
                    text=options.text,
                )
            )
    lone = [WITHOUT_PARTNER(path=name, name=name, folder=folder) for name, folder in pairs.lone]
    status = max(
        [2 if answers.refusals else 0, int(bool(lone)), *(each.exit_status for each in done)]
    )
    refusals = [*answers.refusals, *lone]
    files: list[Path] = []
    if asked:
        read = [*(part.name for pair in pairs.both for part in pair), *options.read()]
        files, findings = compared_page(asked, done, refusals, read)
        refusals += findings
    if format is Format.JSON:
        print_json(_comparison_record(done, refusals, status) | {"written": list(map(str, files))})
        return status
    print_findings(refusals)
    for each in done:
        _print_comparison(each)
    if len(pairs.both) > 1:
        equal = sum(each.equal for each in done)
        say(f"{len(pairs.both)} pairs of programs, {equal} of them equal")
    for path in files:
        say(f"wrote {path}")
    return status


def _print_comparison(done: Comparison) -> None:
    """Print the differences with both lines, then what was compared and the answer."""
    from assistant.compiler.comparison import PROGRAMS_DIFFER

    print_findings(one for one in done.findings if one.code != PROGRAMS_DIFFER.code)
    for row in done.rows:
        if not row.alike:
            for sign, name, at in zip("-+", done.names, (row.first, row.second), strict=True):
                if at is not None:
                    say(f"{sign} {_difference_line(name, at)}")
    for one in done.differences:
        for name, place, behind in zip(done.names, one.places, one.behind, strict=True):
            say(_difference_line(name, place))
            if behind is not None and behind != place:
                say(f"  behind line {behind.line}: {behind.text}")
        say(f"  {one.what}; with {one.inputs}")
    say(f"{done.names[0]}, {done.names[1]}: {done.line()}")


def _difference_line(name: str, place: Place | None) -> str:
    if place is None:
        return f"{name}: does nothing there"
    return f"{place.path or name}:{place.line}: {place.text}"


def _comparison_record(
    done: list[Comparison], refusals: list[Diagnostic], status: int
) -> dict[str, Any]:
    from assistant.findings.formats import finding_record

    return {
        "ok": status == 0,
        "comparisons": [
            {
                "first": one.names[0],
                "second": one.names[1],
                "answer": one.answer,
                "differences": list(map(_difference_record, one.differences)),
                "compared": one.motion.record(),
                "names": dict(one.pairs),
                "statements": [
                    {
                        "alike": row.alike,
                        "places": [_place_record(row.first), _place_record(row.second)],
                    }
                    for row in one.rows
                ],
                "findings": list(map(finding_record, one.findings)),
            }
            for one in done
        ],
        "findings": list(map(finding_record, refusals)),
    }


def _difference_record(one: Difference) -> dict[str, Any]:
    return {
        "what": one.what,
        "inputs": one.inputs,
        "places": list(map(_place_record, one.places)),
        "behind": list(map(_place_record, one.behind)),
    }


def _place_record(place: Place | None) -> dict[str, Any] | None:
    return None if place is None else {"path": place.path, "line": place.line, "text": place.text}
