"""The commands of a project as a whole: `build`, and `check` without files."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from assistant.cli.compiling import working
from assistant.cli.options import FindingFormatOption
from assistant.cli.presentation import (
    FindingFormat,
    print_findings,
    print_for_programs,
    print_json,
    say,
)

if TYPE_CHECKING:
    from assistant.project import Build

JobsOption = Annotated[
    int | None,
    typer.Option("--jobs", "-j", min=1, help="Processes at a time; default one a processor."),
]


def build(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAMES]", help="Programs or targets of assistant.toml."),
    ] = None,
    jobs: JobsOption = None,
    anew: Annotated[
        bool, typer.Option("--anew", help="Also what has not changed since the last build.")
    ] = False,
    format: FindingFormatOption = FindingFormat.TEXT,
) -> None:
    """Compile the programs of the project for its targets, into build/TARGET/."""
    raise typer.Exit(run_build(names or (), jobs, anew, format))


COMMANDS: Final = (build,)


def run_build(names: Sequence[str], jobs: int | None, anew: bool, format: FindingFormat) -> int:
    from assistant.project import State, build, project_of

    done = build(project_of(), names, jobs=jobs, anew=anew, working=_building)
    if format is FindingFormat.JSON:
        print_json(_answer(done))
    elif format is not FindingFormat.TEXT:
        print_for_programs(done.findings, (), format)
    else:
        print_findings(done.findings)
        for one in done.programs:
            said = ", ".join(map(_shown, one.files)) if one.state is State.BUILT else ""
            say(f"{one.target}: {one.program} {one.state}{said and ': '}{said}")
            for line in one.proof:
                say(f"  {line}")
    return done.status


def _building(count: int) -> AbstractContextManager[None]:
    return working(f"building {count} program{'s' * (count != 1)}")


def _answer(done: Build) -> dict[str, object]:
    from assistant.findings.formats import finding_record

    return {
        "ok": done.ok,
        "programs": [
            {
                "target": one.target,
                "program": one.program,
                "state": str(one.state),
                "files": [_shown(file) for file in one.files],
                "proof": list(one.proof),
            }
            for one in done.programs
        ],
        "findings": [finding_record(finding) for finding in done.findings],
    }


def _shown(file: Path) -> str:
    here = Path.cwd()
    return str(file.relative_to(here) if file.is_relative_to(here) else file)
