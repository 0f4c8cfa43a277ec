"""`compile` and `show`: from arguments to the compiler and back to people."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors
from assistant.cli.output_files import Outcomes, output_folders, output_paths, write_with_edits
from assistant.cli.presentation import (
    FindingFormat,
    FramesAs,
    GrammarAs,
    console,
    print_findings,
    print_for_programs,
    print_json,
    say,
)

if TYPE_CHECKING:
    from assistant.compiler import Compiled, Loaded
    from assistant.compiler.arms import InCell
    from assistant.compiler.merge_edits import MergeChoices
    from assistant.compiler.motion_proof import Proving

    DrawPage = Callable[
        [InCell, Sequence[tuple[str, Compiled]], list[Diagnostic], Sequence[str]], Sequence[Path]
    ]
    """Write the page of compiled programs, add its findings to the list, and return its file; the
    strings are sources whose files on disk differ.
    """
    from assistant.base.source_text import SourceText
    from assistant.project.source_options import SourceOptions
    from assistant.robots import Robot
    from assistant.sources.process import SurroundingsByRobot
    from assistant.sources.process.placement import DrawingPlacement
    from assistant.sources.sights import Seeing

_NOT_ONE_FILE = error("CL002", "there are {count} files to print", "name a folder with --output")
NO_FILE_NAME = error("CL003", "`{name}` is no name of a file", "name the file to write")
TWICE = error("CL004", "standard input can be read only once", "name `-` only once")
_OVER_SOURCE = error(
    "CL007", "`{name}` would be written over the source itself", "name another folder or file"
)
_ONE_NAME = error(
    "CL073",
    "several programs cannot all be called `{name}`",
    "make one of them with `--together`, or compile them one by one",
)
_NO_LANGUAGE = error(
    "CL053",
    "nothing says in which language the program is to be written",
    "name it with --language, or make the source a program of a target in assistant.toml",
)
_NOT_ALIKE = error(
    "CL054",
    "the project has these sources in several languages, on several robots or in several cells",
    "compile them one by one, or all of the project with `robot-assistant build`",
)
STANDARD: Final = "-"
SIDE_TABLES_ABOVE: Final = 1000
"""Rows of a path that a `.pseudo` file on disk still holds in its text."""


def run_compile(
    sources: Sequence[str],
    language: str | None,
    *,
    robot: str | None,
    process: Path | None,
    unit: str | None,
    placement: DrawingPlacement | None,
    cell: Path | None,
    output: str,
    most_targets: int | None,
    frames: FramesAs,
    grammar: GrammarAs,
    from_language: str | None,
    from_robot: str | None,
    format: FindingFormat,
    entry: str | None = None,
    called: str | None = None,
    main: bool | None = None,
    together: str | None = None,
    seeing: Seeing | None = None,
    proving: Proving | None = None,
    wishes: MergeChoices | None = None,
    page: DrawPage | None = None,
) -> int:
    """0 if all sources are written, else 1; 2 if one could not be read.

    page: writes a page of what was compiled.
    """
    from assistant.compiler import compile
    from assistant.compiler.arms import open_cell, robot_of
    from assistant.compiler.combine import combine_sources as joined
    from assistant.compiler.loader import language_of
    from assistant.compiler.merge_edits import Keeper, MergeChoices
    from assistant.findings.severities import apply_severities
    from assistant.project.source_options import SourceOptions

    if list(sources).count(STANDARD) > 1:
        raise Refused(TWICE(), exit_status=2)
    options = SourceOptions(
        *(language, robot, process, unit, cell),
        *(from_language, from_robot, entry, most_targets),
    )
    first = sources if together is None else sources[:1]
    wanted = {source: _to_write(source, options) for source in dict.fromkeys(first)}
    settings = {(str(one.language), one.robot, one.cell) for one in wanted.values()}
    if len(settings) > 1:
        raise Refused(_NOT_ALIKE(), exit_status=2)
    ((language, robot, cell),) = settings
    language_of(language)
    for one in wanted.values():
        robot_of(one.from_robot)
    stands = open_cell(cell, robot)
    stands = stands if seeing is None else replace(stands, seeing=seeing)
    answers = Outcomes()
    done: list[tuple[str, Compiled]] = []
    apart = dict.fromkeys(sources)
    if called is not None and together is None and len(apart) > 1:
        raise Refused(_ONE_NAME(name=called), exit_status=2)
    for source in apart if together is None else (together,):
        one = wanted.get(source, options)
        with answers.of(source), working(f"compiling {source}"):
            if together is None:
                reader = (one.from_language, one.from_robot, one.process, one.unit)
                given = _input(source, *reader, placement)
            else:
                given = joined(
                    tuple(apart),
                    together,
                    process=process,
                    unit=unit,
                    placement=placement,
                    around=stands.around,
                )
            compiled = compile(
                given or source,
                language=language,
                robot=robot,
                process=one.process,
                unit=one.unit,
                placement=placement,
                cell=stands,
                from_robot=one.from_robot,
                most_targets=one.most_targets,
                frames=frames.value,
                grammar=grammar.value,
                entry=one.entry,
                called=called,
                main=main,
                proving=proving,
            )
            done.append((source, compiled))
    findings = [*stands.findings, *answers.refusals]
    files: dict[str, dict[str, bytes]] = {}
    for source, compiled in done:
        settled = apply_severities([f.within(source) for f in compiled.findings]).left
        findings += settled
        if compiled.ok and not has_errors(settled):
            files[source] = compiled.files
    folders, told = output_folders(files)
    findings += told
    ok = len(files) == len(done) and not answers.refusals
    written: list[str] = []
    diffs: dict[str, str] = {}
    if files and output == STANDARD:
        data = [data for made in files.values() for data in made.values()]
        if len(data) != 1:
            raise Refused(_NOT_ONE_FILE(count=len(data)), exit_status=2)
        sys.stdout.buffer.write(data[0])
    elif files:
        keep_sources(sources, output_paths(files, folders, output))
        keeper = Keeper(language, robot, stands if cell else None, wishes or MergeChoices())
        kept = write_with_edits(files, folders, output, keeper)
        findings += apply_severities(kept.findings).left
        ok, written, diffs = ok and not has_errors(kept.findings), kept.written, kept.diffs
    if page is not None:
        with working("drawing the page"):
            unlike = [] if output == STANDARD else _unlike(files, folders, output)
            written = [*written, *map(str, page(stands, done, findings, unlike))]
    if format is FindingFormat.JSON:
        print_json({**_answer(done, findings, written, ok), "edits": diffs})
    elif format is not FindingFormat.TEXT:
        print_for_programs(findings, (), format)
    else:
        print_findings(fold(findings))
        if output != STANDARD:
            for source, compiled in done:
                for line in compiled.proof_lines():
                    say(f"{source}: {line}")
            for name in written:
                say(f"wrote {name}")
            for diff in diffs.values():
                say(diff.rstrip("\n"))
    return max(answers.status, 0 if ok else 1)


def _unlike(
    files: Mapping[str, Mapping[str, bytes]], folders: Mapping[str, str], output: str
) -> list[str]:
    """The sources whose files are other ones on disk than those that were compiled."""
    from assistant.base.source_text import read_bytes

    found = []
    for source, made in files.items():
        places = {path.name: path for path in output_paths({source: made}, folders, output)}
        there = all(place.is_file() for place in places.values())
        if not there or any(read_bytes(places[name]) != data for name, data in made.items()):
            found.append(source)
    return found


def _to_write(source: str, options: SourceOptions) -> SourceOptions:
    """The options of one source, with what its project states; raises Refused without language."""
    from assistant.cli.options import with_project_defaults

    one = with_project_defaults(source, options)
    if one.language is None:
        raise Refused(_NO_LANGUAGE(path=source), exit_status=2)
    return one


def load_given(
    source: str,
    robot: str | Robot | None,
    process: Path | None,
    unit: str | None,
    from_language: str | None,
    entry: str | None = None,
    around: SurroundingsByRobot | None = None,
    placement: DrawingPlacement | None = None,
) -> Loaded:
    """The program of a file, or of standard input if the source says so.

    entry: the procedure that it begins with, None for its own. around: what stands around it.
    """
    from assistant.compiler.arms import robot_of
    from assistant.compiler.loader import with_entry
    from assistant.compiler.program_files import load

    arm = robot_of(robot)
    given = _input(source, from_language, robot, process, unit, placement) or load(
        source,
        process=process,
        robot=arm,
        language=from_language,
        unit=unit,
        around=around,
        placement=placement,
    )
    return replace(given, program=with_entry(given.program, entry))


def _input(
    source: str,
    language: str | None,
    robot: str | Robot | None,
    process: Path | None,
    unit: str | None,
    placement: DrawingPlacement | None,
) -> Loaded | None:
    """The program on standard input if the source says so, or a file of a named language."""
    from assistant.base.length_units import unit_stated
    from assistant.compiler.arms import robot_of
    from assistant.compiler.loader import load_text
    from assistant.compiler.program_files import load
    from assistant.sources.process.placement import check_drawn

    if placement is not None and source == STANDARD:
        check_drawn(Path("standard input"))
    if source != STANDARD:
        if language is None:
            return None
        return load(
            source,
            process=process,
            robot=robot_of(robot),
            language=language,
            unit=unit,
            placement=placement,
        )
    text, spoken = standard_input(language)
    loaded = load_text(text, process=process, robot=robot_of(robot), language=spoken)
    if unit is None:
        return loaded
    return replace(loaded, findings=(*loaded.findings, unit_stated("standard input", unit)))


def standard_input(language: str | None) -> tuple[SourceText, str | None]:
    """The text on standard input, and the robot language that is named or that it shows.

    It is decoded as files of that language are, else as pseudo text. Raises Unreadable if
    there is nothing.
    """
    from assistant import languages
    from assistant.base.source_text import decode, read_input
    from assistant.compiler.loader import PSEUDO_ENCODINGS, language_of

    data = read_input(sys.stdin.buffer)
    if language is None and not _PSEUDO.search(data):
        known = map(languages.get, languages.names())
        language = next((one.name for one in known if one.recognises(data)), None)
    encodings = language_of(language).encodings if language else PSEUDO_ENCODINGS
    return decode(data, "standard input", encodings), language


_PSEUDO: Final = re.compile(rb"^\s*program\b", re.MULTILINE)


def _answer(
    done: Sequence[tuple[str, Compiled]],
    findings: Sequence[Diagnostic],
    written: Sequence[str],
    ok: bool,
) -> dict[str, Any]:
    from assistant.findings.formats import finding_record

    return {
        "ok": ok,
        "sources": [
            {
                "source": source,
                "language": compiled.language,
                "files": sorted(compiled.files),
                "proof": compiled.proof.record(),
                "motion": None if compiled.motion is None else compiled.motion.record(),
            }
            for source, compiled in done
        ],
        "findings": [finding_record(f) for f in findings],
        "written": list(written),
    }


def keep_sources(sources: Sequence[str], written: Sequence[Path]) -> None:
    """Raises Refused (exit status 2) if a file that is to be written is one of the sources."""
    read = [Path(source) for source in sources if source != STANDARD]
    for file in written:
        if file.is_file() and any(one.exists() and one.samefile(file) for one in read):
            raise Refused(_OVER_SOURCE(path=str(file), name=file), exit_status=2)


@contextmanager
def working(what: str) -> Iterator[None]:
    """A spinner on the terminal while something takes its time; nothing elsewhere."""
    if not sys.stderr.isatty():
        yield
        return
    with console().status(what):
        yield
