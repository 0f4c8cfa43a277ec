"""`check` and `explain`: findings as people, pipelines and pull requests want them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assistant.cli.compiling import STANDARD, TWICE, standard_input, working
from assistant.cli.presentation import FindingFormat, print_findings, print_for_programs, say
from assistant.findings.fail_on import FailOn
from assistant.program.diagnostics import Refused, fold_files

if TYPE_CHECKING:
    from assistant.compiler.checking import Checked
    from assistant.sources.placements import Placing


@dataclass(frozen=True, slots=True)
class Options:
    """What all sources of one command are checked with."""

    robot: str | None
    process: Path | None
    unit: str | None
    cell: Path | None
    from_language: str | None
    placement: Placing | None = None


def run_check(
    sources: Sequence[str], options: Options, format: FindingFormat, fail_on: FailOn
) -> int:
    from assistant.findings.project_severities import settle

    with working(f"checking {', '.join(sources)}"):
        checked = _checked(sources, options)
        settled = settle(checked.findings, checked.texts)
    if format is not FindingFormat.TEXT:
        print_for_programs(settled.left, settled.ignored, format, fail_on, checked.paths)
    else:
        print_findings(fold_files(settled.left), explained=True)
        count = len(settled.left)
        ignored = f", {len(settled.ignored)} ignored" if settled.ignored else ""
        say(f"{checked.files} checked, {count} finding{'s' * (count != 1)}{ignored}")
    return fail_on.status(settled.left, unreadable=checked.unreadable)


def run_explain(codes: Sequence[str]) -> int:
    from assistant.findings.rulebook import explain

    sys.stdout.write(explain(codes))
    return 0


def _checked(sources: Sequence[str], options: Options) -> Checked:
    from assistant.compiler.checking import Checked, check_files, check_text
    from assistant.compiler.scenes import in_cell

    checked, cell = Checked(), in_cell(options.cell, options.robot)
    given: dict[str, Any] = {
        "robot": options.robot,
        "process": options.process,
        "unit": options.unit,
        "cell": cell,
    }
    if STANDARD in sources:
        if list(sources).count(STANDARD) > 1:
            raise Refused(TWICE(), exit_status=2)
        text, spoken = standard_input(options.from_language)
        checked = check_text(text, language=spoken, **given)
    files = [source for source in sources if source != STANDARD]
    given["placement"] = options.placement
    more = check_files(files, language=options.from_language, **given)
    return Checked(
        [*cell.findings, *checked.findings, *more.findings],
        checked.files + more.files,
        {**checked.texts, **more.texts},
        checked.unreadable or more.unreadable,
        [*checked.paths, *more.paths],
    )
