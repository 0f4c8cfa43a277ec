"""A project as a unit: `init`, `build`, and `check` without files."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path

from assistant.base.diagnostics import FailOn, Refused, error, fold_files
from assistant.cli.command import argument, command, option
from assistant.cli.options import EditOptions, FindingFormatOption, UnitOption
from assistant.cli.presentation import (
    FindingFormat,
    print_findings,
    print_for_programs,
    print_json,
    say,
    working,
)


@command
class Build:
    """Compile the programs of the project for its targets, into build/TARGET/."""

    names: tuple[str, ...] = argument(
        "Programs or targets of assistant.toml.", default=(), metavar="NAME"
    )
    jobs: int | None = option(
        "Processes at a time; default one a processor.", "--jobs", "-j", min=1
    )
    anew: bool = option("Also what has not changed since the last build.")
    edits: EditOptions
    format: FindingFormatOption

    def run(self) -> int:
        from assistant.project import State, build, project_of
        from assistant.project.builds import build_record

        done = build(
            project_of(),
            self.names,
            jobs=self.jobs,
            anew=self.anew,
            working=_build_spinner,
            wishes=self.edits.choices,
        )
        if self.format is FindingFormat.JSON:
            print_json(build_record(done, _path_from_here))
        elif self.format is not FindingFormat.TEXT:
            print_for_programs(done.findings, (), self.format)
        else:
            print_findings(done.findings)
            for one in done.programs:
                said = (
                    ", ".join(map(_path_from_here, one.files)) if one.state is State.BUILT else ""
                )
                say(f"{one.target}: {one.program} {one.state}{said and ': '}{said}")
                for line in one.proof:
                    say(f"  {line}")
                for diff in one.diffs.values():
                    say(diff.rstrip("\n"))
        return done.status


@command
class Init:
    """Start a project: an example or your drawings, and files for git, pre-commit and CI."""

    paths: tuple[Path, ...] = argument(
        "Folder of the project, made if it is missing; drawings that it is to work.",
        default=(),
        metavar="[FOLDER] [DRAWING]...",
    )
    unit: UnitOption

    def run(self) -> int:
        from assistant.project.new_project import BLANK_KEYS, start_project
        from assistant.sources.process.placement import DRAWING_SUFFIXES

        drawings = [
            path
            for path in self.paths
            if path.suffix.lower() in DRAWING_SUFFIXES and not path.is_dir()
        ]
        folders = [path for path in self.paths if path not in drawings]
        if len(folders) > 1:
            raise Refused(_ONE_FOLDER(name=folders[1]), exit_status=2)
        if self.unit is not None and not drawings:
            raise Refused(_NO_DRAWING(), exit_status=2)
        folder = folders[0] if folders else Path()
        started = start_project(folder, drawings, self.unit)
        print_findings(started.findings)
        for file in started.written:
            say(f"wrote {file}")
        for file in started.blank:
            say(f"fill in {' and '.join(BLANK_KEYS)} in {file}")
        inside = "" if folder.resolve() == Path.cwd() else f"in {folder}: "
        first = (
            "check, then build and deploy"
            if started.blank
            else "build, then robot-assistant deploy"
        )
        say(f"next, {inside}robot-assistant {first}")
        return 0


_ONE_FOLDER = error(
    "CL051",
    "a project has one folder, and `{name}` is another one",
    "name one folder, and drawings that end in .dxf",
)
_NO_DRAWING = error(
    "CL052", "--unit is of drawings, and none is named", "name one, or leave it out"
)


def check_project(given: Mapping[str, object], format: FindingFormat, fail_on: FailOn) -> int:
    """`check` of the project here. given: options of files, by name."""
    from assistant.project import project_of, rules
    from assistant.project.builds import check

    stated = [option for option, value in given.items() if value is not None]
    if stated:
        raise Refused(*(rules.ONLY_WITH_FILES(option=one) for one in stated), exit_status=2)
    done = check(project_of(), working=lambda count: working(f"checking {_program_count(count)}"))
    if format is not FindingFormat.TEXT:
        print_for_programs(done.findings, done.ignored, format, fail_on, done.sources)
    else:
        print_findings(fold_files(done.findings), explained=True)
        count = len(done.findings)
        ignored = f", {len(done.ignored)} ignored" if done.ignored else ""
        say(
            f"{_program_count(done.programs)} checked, {count} finding{'s' * (count != 1)}{ignored}"
        )
    return fail_on.status(done.findings, unreadable=done.unreadable)


def _build_spinner(count: int) -> AbstractContextManager[None]:
    return working(f"building {_program_count(count)}")


def _program_count(count: int) -> str:
    return f"{count} program{'s' * (count != 1)}"


def _path_from_here(file: Path) -> str:
    here = Path.cwd()
    return str(file.relative_to(here) if file.is_relative_to(here) else file)
