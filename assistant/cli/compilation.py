"""Compile sources into a robot language: `compile`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors
from assistant.cli.command import command, option
from assistant.cli.options import (
    CellOption,
    DrawingOptions,
    EditOptions,
    FindingFormatOption,
    FramesOption,
    GrammarOption,
    PlottedPageOptions,
    ProofOptions,
    RobotOption,
    SharingOptions,
    SightOptions,
    Sources,
    WrittenOptions,
    complete_language,
    with_project_defaults,
)
from assistant.cli.output_files import Outcomes, output_folders, output_paths, write_with_edits
from assistant.cli.presentation import (
    FindingFormat,
    print_findings,
    print_for_programs,
    print_json,
    say,
    working,
)
from assistant.cli.source_input import STANDARD, TWICE, keep_sources, load_named

if TYPE_CHECKING:
    from assistant.compiler import Compiled
    from assistant.compiler.arms import InCell

_NOT_ONE_FILE = error("CL002", "there are {count} files to print", "name a folder with --output")
_ONE_NAME = error(
    "CL073",
    "several programs cannot all be called `{name}`",
    "make one of them with `--together`, or compile them one by one",
)
_NO_LANGUAGE = error(
    "CL053",
    "nothing says in which language the program is to be written",
    "name it with --language, one of {known}, or make the source a program of a target in "
    "assistant.toml",
)
_NOT_ALIKE = error(
    "CL054",
    "the project has these sources in several languages, on several robots or in several cells",
    "compile them one by one, or all of the project with `robot-assistant build`",
)


@command
class Compile:
    """Write sources in a robot language, read back and compared before anything is written."""

    sources: Sources
    language: str | None = option(
        "Language to write; default the project's.",
        "--language",
        "-l",
        project="language",
        completions=complete_language,
    )
    robot: RobotOption
    reader: DrawingOptions
    cell: CellOption
    output: str = option(
        "Folder for the files; - prints a single one.", "--output", "-o", default="."
    )
    most_targets: int | None = option(
        "Targets of one program unit; default the language's own limit.", project="most_targets"
    )
    frames: FramesOption
    grammar: GrammarOption
    written: WrittenOptions
    called: str | None = option(
        "What others call the program; default main.", "--as", metavar="NAME"
    )
    no_main: bool = option("Without a main: others call the procedures of the layers.")
    together: str | None = option("All sources as one program of this name.", metavar="NAME")
    sight: SightOptions
    proof: ProofOptions
    edits: EditOptions
    page: PlottedPageOptions
    sharing: SharingOptions
    format: FindingFormatOption

    def run(self) -> int:
        """0 if all sources are written, else 1; 2 if one could not be read."""
        from assistant.compiler.arms import open_cell, robot_of
        from assistant.compiler.loader import language_of
        from assistant.compiler.merge_edits import Keeper
        from assistant.findings.severities import apply_severities

        page = self.page
        page.check()
        self.reader.check()
        self.proof.check()
        if self.sources.count(STANDARD) > 1:
            raise Refused(TWICE(), exit_status=2)
        first = self.sources if self.together is None else self.sources[:1]
        wanted = {source: self._completed(source) for source in dict.fromkeys(first)}
        settings = {(str(one.language), one.robot, one.cell) for one in wanted.values()}
        if len(settings) > 1:
            raise Refused(_NOT_ALIKE(), exit_status=2)
        ((language, robot, cell),) = settings
        language_of(language)
        for one in wanted.values():
            robot_of(one.written.from_robot)
        stands = replace(open_cell(cell, robot), seeing=self.sight.seeing)
        answers = Outcomes()
        apart = dict.fromkeys(self.sources)
        if self.called is not None and self.together is None and len(apart) > 1:
            raise Refused(_ONE_NAME(name=self.called), exit_status=2)
        given = []
        named = [*apart] if self.together is None else [self.together]
        # A process that shares several sources starts no others for the units of one.
        alone = len(named) == 1 and self.sharing.on is None
        within = SharingOptions(jobs=self.sharing.jobs if alone else 1)
        for source in named:
            one = replace(wanted.get(source, self), language=language, robot=robot, sharing=within)
            given.append((source, (one, source, stands)))
        with self.sharing.used() as jobs:
            jobs = 1 if STANDARD in apart else jobs
            done = answers.of_each(_compiled_source, given, jobs, "compiling")
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
        if files and self.output == STANDARD:
            data = [data for made in files.values() for data in made.values()]
            if len(data) != 1:
                raise Refused(_NOT_ONE_FILE(count=len(data)), exit_status=2)
            sys.stdout.buffer.write(data[0])
        elif files:
            keep_sources(self.sources, output_paths(files, folders, self.output))
            keeper = Keeper(language, robot, stands if cell else None, self.edits.choices)
            kept = write_with_edits(files, folders, self.output, keeper)
            findings += apply_severities(kept.findings).left
            ok, written, diffs = ok and not has_errors(kept.findings), kept.written, kept.diffs
        if page:
            from assistant.cli.report_pages import write_compiled_page

            with working("drawing the page"):
                unlike = [] if self.output == STANDARD else _unlike(files, folders, self.output)
                pages, told = write_compiled_page(page, self.reader, stands, done, findings, unlike)
            written = [*written, *map(str, pages)]
            findings += told
        if self.format is FindingFormat.JSON:
            print_json({**_answer(done, findings, written, ok), "edits": diffs})
        elif self.format is not FindingFormat.TEXT:
            print_for_programs(findings, (), self.format)
        else:
            print_findings(fold(findings))
            if self.output != STANDARD:
                for source, compiled in done:
                    for line in compiled.proof_lines():
                        say(f"{source}: {line}")
                for name in written:
                    say(f"wrote {name}")
                for diff in diffs.values():
                    say(diff.rstrip("\n"))
        return max(answers.status, 0 if ok else 1)

    def _completed(self, source: str) -> Compile:
        """Return the options with what the project of a source states; raise Refused without a
        language.
        """
        one = with_project_defaults(source, self)
        if one.language is None:
            from assistant.base.source_text import is_file, read_bytes
            from assistant.languages import names

            if source != STANDARD and not is_file(source):
                read_bytes(source)  # says why it cannot be read, which is the first thing to mend
            raise Refused(_NO_LANGUAGE(path=source, known=", ".join(names())), exit_status=2)
        return one

    def _compiled(self, source: str, stands: InCell) -> Compiled:
        from assistant.compiler import compile
        from assistant.compiler.combine import combine_sources

        assert self.language is not None
        reader = self.reader
        if self.together is None:
            given = load_named(source, self.written.from_language, self.written.from_robot, reader)
        else:
            given = combine_sources(
                tuple(dict.fromkeys(self.sources)),
                self.together,
                process=reader.process,
                unit=reader.unit,
                placement=reader.placement,
                around=stands.around,
            )
        return compile(
            given or source,
            language=self.language,
            robot=self.robot,
            process=reader.process,
            unit=reader.unit,
            placement=reader.placement,
            cell=stands,
            from_robot=self.written.from_robot,
            most_targets=self.most_targets,
            frames=self.frames.value,
            grammar=self.grammar.value,
            entry=self.written.entry,
            called=self.called,
            main=False if self.no_main else None,
            proving=self.proof.proving,
            jobs=self.sharing.jobs,
        )


def _compiled_source(given: tuple[Compile, str, InCell]) -> Compiled:
    options, source, stands = given
    return options._compiled(source, stands)


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


def _answer(
    done: Sequence[tuple[str, Compiled]],
    findings: Sequence[Diagnostic],
    written: Sequence[str],
    ok: bool,
) -> dict[str, Any]:
    from assistant.findings.formats import records_of

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
        "findings": records_of(findings),
        "written": list(written),
    }
