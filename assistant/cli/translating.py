"""`translate`: robot programs in another language, with a report on every statement."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.cli.compiling import (
    NO_FILE_NAME,
    SAME_FILE,
    STANDARD,
    TWICE,
    keep_sources,
    standard_input,
    working,
)
from assistant.cli.presentation import (
    FindingFormat,
    FramesAs,
    print_findings,
    print_for_programs,
    print_json,
    say,
)
from assistant.program.diagnostics import Diagnostic, Refused, has_errors

if TYPE_CHECKING:
    from assistant.compiler import Loaded
    from assistant.report.translation import Translated

STYLES: Final = {"supported": "green", "partial": "yellow", "not": "bold red"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """What all programs of one command are translated with."""

    to: str
    robot: str | None
    from_robot: str | None
    process: Path | None
    frames: FramesAs
    from_language: str | None
    draft: bool
    entry: str | None


def run_translate(
    programs: Sequence[str],
    options: Options,
    *,
    output: str,
    report: Path | None,
    format: FindingFormat,
) -> int:
    """0 if everything is said, 1 if something is not, 2 if a program cannot be read."""
    from assistant.findings.formats import finding_record
    from assistant.report.translation import Translated, record

    if list(programs).count(STANDARD) > 1:
        raise Refused(TWICE(), exit_status=2)
    if report is not None and not report.name:
        raise Refused(NO_FILE_NAME(name=report), exit_status=2)
    status, done, refusals = 0, list[Translated](), list[Diagnostic]()
    for program in dict.fromkeys(programs):
        try:
            for name in _files(program, options.from_language):
                with working(f"translating {name}"):
                    done.append(_translated(name, options))
        except Refused as refused:
            refusals += [f.within(program) for f in refused.findings]
            status = max(status, refused.exit_status)
    files, clash = _together(done)
    refusals += clash
    if has_errors(clash) or not all(one.translation.ok for one in done):
        status = max(status, 1)
    written = _write(files if not clash and status < 2 else {}, output, report, done)
    if format is FindingFormat.TEXT:
        print_findings(refusals)
        for one in done:
            _show(one)
        for path in written:
            say(f"wrote {path}")
    elif format is FindingFormat.JSON:
        answer = {
            "ok": status == 0, "programs": list(map(record, done)), "written": written,
            "findings": list(map(finding_record, refusals)),
        }  # fmt: skip
        print_json(answer)
    else:
        found = [f for one in done for f in one.translation.findings]
        print_for_programs([*refusals, *found], (), format)
    return status


def _files(program: str, language: str | None) -> Iterator[str]:
    """The file itself, or the programs of a folder: what others there call is part of those."""
    from assistant.compiler.formatting import programs_in
    from assistant.compiler.loading import whole_programs

    if program == STANDARD or not Path(program).is_dir():
        yield program
    else:
        yield from whole_programs(list(programs_in(program, language)), language)


def _translated(name: str, options: Options) -> Translated:
    from assistant.compiler import translate
    from assistant.report.translation import Translated

    source: str | Loaded = name
    if name == STANDARD:
        source = _standard_input(options)
    translation = translate(
        source,
        to=options.to,
        robot=options.robot,
        from_robot=options.from_robot,
        process=options.process,
        frames=options.frames.value,
        language=options.from_language,
        draft=options.draft,
        entry=options.entry,
    )
    return Translated("standard input" if name == STANDARD else name, translation)


def _standard_input(options: Options) -> Loaded:
    from assistant.compiler.arms import robot_of
    from assistant.compiler.loading import load_text

    text, spoken = standard_input(options.from_language)
    arm = robot_of(options.from_robot)
    return load_text(text, process=options.process, robot=arm, language=spoken)


def _together(done: Sequence[Translated]) -> tuple[dict[str, bytes], list[Diagnostic]]:
    """The files of all programs, and a finding for each name that two of them claim."""
    files: dict[str, bytes] = {}
    owner: dict[str, str] = {}
    clash = []
    for one in done:
        for name, data in one.translation.files.items():
            other = owner.setdefault(name.lower(), one.source)
            if other != one.source:
                clash.append(SAME_FILE(first=other, second=one.source, name=name))
            files[name] = data
    return files, clash


def _write(
    files: dict[str, bytes], output: str, report: Path | None, done: Sequence[Translated]
) -> list[str]:
    from assistant.compiler.output import write_files
    from assistant.report.translation import written

    reported = [] if report is None else [report]
    keep_sources(
        [one.source for one in done], [*(Path(output) / name for name in files), *reported]
    )
    paths = list(write_files(files, output)) if files else []
    if report is not None:
        paths += write_files({report.name: written(done, report)}, report.parent)
    return [str(path) for path in paths]


def _show(one: Translated) -> None:
    """A table on a terminal, one line a statement elsewhere; findings on the whole program."""
    from assistant.report.translation import lines, totals

    translation = one.translation
    print_findings(f.within(one.source) for f in translation.whole)
    if sys.stdout.isatty():
        _table(one)
        say(f"{one.source}: {totals(translation)}")
    else:
        for line in lines(one):
            say(line)
    say(f"{one.source}: {translation.proof.line()}")
    if translation.draft:
        say(f"{one.source}: the files are a draft, with a stop for each that is not said")


def _table(one: Translated) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table("line", "level", "statement", "why", box=None, pad_edge=False)
    table.columns[0].justify = "right"
    for row in one.translation.rows:
        why = "\n".join(f"{f.code} {f.message}" for f in row.reasons)
        count = f" ({row.count} rows)" if row.count > 1 else ""
        table.add_row(
            str(row.place.line),
            Text(row.level, style=STYLES[row.level]),
            Text(_visible(row.text + count)),
            Text(_visible(why)),
        )
    Console(highlight=False, emoji=False).print(table)


def _visible(text: str) -> str:
    return "".join(c if c.isprintable() or c in " \n" else "�" for c in text)
