"""Translate programs into another language, and count what a language can express of them.

`translate` takes what the folder of a program holds: its project, the controller's files, the cell
file. It writes a draft of what is not complete yet, and the cell file with a place for each value
that programs lack, such as tool data. It reports on every statement: translated, translated with a
change, or not, and why. `coverage` counts the constructs of programs by the same three levels.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors
from assistant.base.source_text import is_folder, lines_of, visible
from assistant.cli.command import argument, command, command_line, option, options
from assistant.cli.options import (
    EntryOption,
    FormatOption,
    FramesOption,
    FromLanguage,
    FromRobot,
    GrammarOption,
    PageOptions,
    ProofOptions,
    RobotOption,
    SharingOptions,
    SightOptions,
    complete_language,
    with_project_defaults,
)
from assistant.cli.output_files import Outcomes, output_folders, output_paths, write_outputs
from assistant.cli.presentation import (
    FindingFormat,
    Format,
    TranslationFormat,
    answer_as,
    print_findings,
    print_for_programs,
    print_json,
    say,
    working,
)
from assistant.cli.report_pages import page_name, write_page
from assistant.cli.source_input import NO_FILE_NAME, STANDARD, TWICE, keep_sources, standard_input

if TYPE_CHECKING:
    from assistant.base.source_text import SourceText
    from assistant.compiler import Loaded
    from assistant.compiler.program_files import Task
    from assistant.languages import Language
    from assistant.languages.coverage import Construct
    from assistant.program.undeclared_names import Wanted
    from assistant.report.translation import Translated


_REPORT_TO_OUTPUT: Final = error(
    "CL014",
    "the report of a translation goes to standard output, so programs cannot",
    "name a folder with --output",
)
_STANDARD_INPUT: Final = "standard input"
"""Name of a program from standard input in answers."""
_LEVEL_STYLES: Final = {"supported": "green", "partial": "yellow", "not": "bold red"}


@options
class ReportOptions(PageOptions):
    """A report in any format, or a page of the result for the browser."""

    report: Path | None = option("Write the report as well: .html, .md, .json, or text.")

    def page(self) -> ReportOptions:
        """Return the options without a report that is not a page."""
        return self if self.html else replace(self, report=None)


@command
class Translate:
    """Write robot programs in another language, and report the result for every statement."""

    programs: tuple[str, ...] = argument("Robot programs, or folders with them; - for input.")
    to: str = option("Language to write.", completions=complete_language, project="language")
    robot: RobotOption
    from_robot: FromRobot
    process: Path | None = option(
        "File with signals, tools, frames of the other cell.",
        "--process",
        "-p",
        project="process",
    )
    cell: Path | None = option(
        "File with bodies, and what programs use and do not declare, with a place for each value "
        "that they lack; default cell.toml beside them, else in the folder of --output.",
        project="cell",
    )
    ask: bool = option("Ask for what the cell file lacks.")
    output: str = option("Folder for the files.", "--output", "-o", default=".")
    page: ReportOptions
    names: Path | None = option("Write a table of the old and the new names, as CSV.")
    every: bool = option("Tell of each statement, also of those that are said.", "--all")
    draft: bool = option(
        "Write programs that are not complete: a stop at the start and for each gap.",
        "--draft/--no-draft",
        default=True,
    )
    frames: FramesOption
    grammar: GrammarOption
    from_language: FromLanguage
    entry: EntryOption
    sight: SightOptions
    proof: ProofOptions
    sharing: SharingOptions
    format: TranslationFormat = option(
        "For people, programs, code scanning or pull requests; markdown is a comment of one.",
        default=TranslationFormat.TEXT,
        callback=answer_as,
    )

    def run(self) -> int:
        """0 if everything is translated, 1 if something is not, 2 if a program is unreadable."""
        from assistant.compiler.loader import language_of
        from assistant.findings.formats import records_of
        from assistant.report.markdown import findings_markdown
        from assistant.report.translation import (
            beginning,
            names_csv,
            report_markdown,
            report_record,
        )
        from assistant.report.translation import report_bytes as report_written

        if self.programs.count(STANDARD) > 1:
            raise Refused(TWICE(), exit_status=2)
        if self.output == STANDARD:
            raise Refused(_REPORT_TO_OUTPUT(), exit_status=2)
        beside = [path for path in (self.page.report, self.names) if path is not None]
        for path in beside:
            if not path.name:
                raise Refused(NO_FILE_NAME(name=path), exit_status=2)
        page = self.page
        page.check_names()
        self._check()
        options = replace(self, to=language_of(self.to).name)
        answers = Outcomes()
        tasks = _translation_tasks(options, answers)
        done = _translate_all(tasks, options, answers)
        if self.ask and _ask_missing_values(done):
            answers = Outcomes()
            done = _translate_all(tasks, options, answers)
        if not self.draft:
            done = [_without_draft(one) for one in done]
        files = {one.source: one.translation.files for one in done if one.translation.files}
        folders, told = output_folders(files)
        refusals = [*answers.refusals, *told]
        reported = partial(report_written, refusals=refusals)
        whole = all(one.translation.ok for one in done)
        status = max(answers.status, 0 if whole else 1)
        keep_sources(
            [file for task in tasks for file in task.files],
            [*output_paths(files, folders, self.output), *beside],
        )
        paths = {task.name: task.files[0] for task in tasks if task.files}
        written, others = write_outputs(files, folders, self.output, paths)
        refusals += others
        status = max(status, 1 if others else 0)
        if page.report is not None and not page.html:
            written += _write_report_file(page.report, reported(done, page.report))
        if page.html or page.opened:
            with working("drawing the page"):
                pages, told = _write_translation_page(
                    page, done, refusals, options, [f for t in tasks for f in t.files]
                )
            written += map(str, pages)
            refusals += told
        if self.names is not None:
            written += _write_report_file(self.names, names_csv(done).encode("utf-8"))
        written += _cell_files_with_blanks(done)
        again = _next_commands(done, options)
        if self.format is TranslationFormat.TEXT:
            for line in beginning(done, again):
                say(line)
            print_findings(refusals)
            told_before = set[tuple[str, str, str | None]]()
            for one in done:
                _print_translation(one, self.every, told_before)
            changed = any(
                row.level != "supported" for one in done for row in one.translation.rows.noted
            )
            if changed and not self.every:
                say("each statement by itself: --all, or --report FILE")
            for file in written:
                say(f"wrote {file}")
        elif self.format is TranslationFormat.JSON:
            answer = {
                "ok": status == 0, "programs": list(map(report_record, done)), "written": written,
                "next": again, "findings": records_of(refusals),
            }  # fmt: skip
            print_json(answer)
        elif self.format is TranslationFormat.MARKDOWN:
            for line in (*findings_markdown(refusals), *lines_of(report_markdown(done))):
                say(line)
        else:
            found = [f for one in done for f in one.translation.findings]
            print_for_programs([*refusals, *found], (), FindingFormat(self.format))
        return status

    def _check(self) -> None:
        """Raises Refused for what no program could be translated with."""
        from assistant.compiler.arms import robot_of
        from assistant.compiler.loader import language_of

        for name in (self.to, self.from_language):
            if name is not None:
                language_of(name)
        robot_of(self.from_robot)
        if self.cell is None:  # it may name one of its own
            robot_of(self.robot)
        self.sight.check()
        self.proof.check()


def _write_translation_page(
    asked: ReportOptions,
    done: Sequence[Translated],
    refusals: Sequence[Diagnostic],
    options: Translate,
    sources: Sequence[str],
) -> tuple[list[Path], list[Diagnostic]]:
    """Write the page of all programs; return its file and the findings about it."""
    from assistant.cli.report_pages import refused_sheets, translated_sheet
    from assistant.compiler.arms import open_cell

    sheets = []
    for one in done:
        stands = open_cell(one.cell, options.robot, values=True)
        sheets.append(translated_sheet(one, stands.scene, stands.robot))
    sheets += refused_sheets(refusals)
    return write_page(asked.page(), sheets, sources, page_name(*sources[:1] or ["program"]))


def _translation_tasks(options: Translate, answers: Outcomes) -> tuple[Task, ...]:
    """Return the files, and those in folders, as tasks of one program each."""
    from assistant.compiler.program_files import OutputFolder, programs_in, tasks_of

    found: dict[str, None] = {}
    language, made = options.from_language, OutputFolder(options.output, options.to)
    for program in options.programs:
        if program == STANDARD or not is_folder(program):
            found[program] = None
        else:
            with answers.of(program):
                told = answers.refusals.append
                found |= dict.fromkeys(programs_in(program, language, told, made))
    return tasks_of(list(found), language)


def _translate_task(given: tuple[Task, Translate]) -> Translated:
    from assistant.compiler import translate
    from assistant.compiler.arms import robot_of
    from assistant.compiler.program_files import load, load_task
    from assistant.report.translation import Translated

    task, options = given
    name = task.name
    if name != STANDARD:
        options = with_project_defaults(name if len(task.files) != 1 else task.files[0], options)
    arm = robot_of(options.from_robot)
    if name == STANDARD:
        source = _load_standard_input(options)
    elif len(task.files) > 1 or task.findings:
        source = load_task(task, process=options.process, robot=arm)
    else:
        language = options.from_language
        source = load(name, process=options.process, robot=arm, language=language)
    options = replace(options, cell=options.cell or _found_cell_file(name, source, options))
    translation = translate(
        source if source.language is not None else name,
        to=options.to,
        robot=options.robot,
        from_robot=options.from_robot,
        process=options.process,
        cell=options.cell,
        frames=options.frames.value,
        grammar=options.grammar.value,
        language=options.from_language,
        draft=options.draft,
        entry=options.entry,
        proving=options.proof.proving,
        seeing=options.sight.seeing,
    )
    return Translated(_STANDARD_INPUT if name == STANDARD else name, translation, options.cell)


def _found_cell_file(name: str, source: Loaded, options: Translate) -> Path | None:
    """Return the cell file of a program that no option names; it need not be there yet.

    A program in another dialect of its own language keeps names as they are, and needs none.
    """
    from assistant.compiler.loader import language_of
    from assistant.sources.cell_values import CELL_FILE, cell_file_beside

    if source.language is None:
        return None
    if language_of(source.language).family == language_of(options.to).family:
        return None
    found = None if name == STANDARD else cell_file_beside(name)
    return found or Path(options.output) / CELL_FILE


_MOST_NEXT_COMMANDS: Final = 3


def _next_commands(done: Sequence[Translated], options: Translate) -> list[str]:
    """Return the command that goes on once the cell file is filled in, none if nothing is.

    Without open values, the commands for the programs that have no procedure to begin with.
    """
    cells = list(dict.fromkeys(one.cell for one in done if one.translation.wanting and one.cell))
    stated = options.cell is not None or len(cells) != 1
    more = {} if stated else {"cell": str(cells[0])}
    lone = [one for one in done if one.translation.beginnings]
    again = _fed if STANDARD in options.programs else str
    if len(done) == 1 and lone:
        return [again(command_line(**more, entry=lone[0].translation.beginnings[0]))]
    if cells:
        return [again(command_line(**more))]
    return [
        _fed(command_line(STANDARD, entry=one.translation.beginnings[0]))
        if one.source == _STANDARD_INPUT
        else command_line(one.source, entry=one.translation.beginnings[0])
        for one in lone[:_MOST_NEXT_COMMANDS]
    ]


def _fed(command: str) -> str:
    """Return a command that reads a program from standard input, with the file to feed it from.

    Without one, the command would wait for the program at the keyboard.
    """
    return f"{command} < FILE" if command else ""


def _load_standard_input(options: Translate) -> Loaded:
    from assistant.compiler.arms import robot_of
    from assistant.compiler.loader import load_text

    text, spoken = standard_input(options.from_language)
    arm = robot_of(options.from_robot)
    return load_text(text, process=options.process, robot=arm, language=spoken)


def _write_report_file(path: Path, data: bytes) -> list[str]:
    from assistant.base.file_sets import write_files

    return list(map(str, write_files({path.name: data}, path.parent)))


def _translate_all(
    tasks: Sequence[Task], options: Translate, answers: Outcomes
) -> list[Translated]:
    given = [(task.name, (task, options)) for task in tasks]
    with options.sharing.used() as jobs:
        jobs = 1 if STANDARD in options.programs else jobs
        done = answers.of_each(_translate_task, given, jobs, "translating")
    return [translated for _, translated in done]


def _without_draft(one: Translated) -> Translated:
    """Return a translation whose files are not written unless it is complete."""
    done = one.translation
    return one if done.ok else replace(one, translation=replace(done, files={}))


def _by_cell_file(done: Sequence[Translated]) -> dict[Path, list[Wanted]]:
    """Return the values that programs lack by the cell file that has to state them."""
    found: dict[Path, list[Wanted]] = {}
    for one in done:
        if one.cell is not None and one.translation.wanting:
            found.setdefault(one.cell, []).extend(one.translation.wanting)
    return found


def _ask_missing_values(done: Sequence[Translated]) -> bool:
    """Ask for the values that programs lack and write the answers; return True if there was any."""
    answered = [_ask_values_of(path, wanting) for path, wanting in _by_cell_file(done).items()]
    return any(answered)


def _ask_values_of(path: Path, missing: Sequence[Wanted]) -> bool:
    """Ask for the values that a cell file lacks.

    An empty answer leaves a value open, the end of input all that follow. The question is repeated
    after an invalid answer.
    """
    from assistant.base.file_sets import write_all
    from assistant.base.source_text import SourceText
    from assistant.compiler.cell_defaults import cell_text
    from assistant.sources.cell_values import (
        open_keys,
        parse_cell,
        read_cell,
        wanted_in_words,
        with_answer,
    )

    wanting = {(one.kind, one.name.lower()): one for one in missing}
    text = before = cell_text(read_cell(path), wanting.values())
    for one in wanting.values():
        for key, remark in open_keys(one):
            while True:
                used = f", used in {', '.join(one.uses[:3])}" if one.uses else ""
                sys.stderr.write(
                    f"{wanted_in_words(one)}{used}\n  {key}{f' ({remark})' if remark else ''}: "
                )
                sys.stderr.flush()
                line = sys.stdin.readline()
                if not line.strip():
                    break
                filled = with_answer(text, one, key, line.strip())
                try:
                    parse_cell(SourceText(filled, str(path)))
                except Refused as refused:
                    print_findings(refused.findings)
                    continue
                text = filled
                break
            if not line:
                break
    if text != before:
        write_all({path: text.encode("utf-8")})
    return text != before


def _cell_files_with_blanks(done: Sequence[Translated]) -> list[str]:
    """Write the cell files, with a place for each value that programs lack; return those that
    changed.
    """
    from assistant.base.file_sets import write_all
    from assistant.compiler.cell_defaults import cell_text
    from assistant.sources.cell_values import read_cell

    files = dict[Path, bytes]()
    for path, wanting in _by_cell_file(done).items():
        cell = read_cell(path)
        text = cell_text(cell, wanting)
        if text != cell.text:
            files[path] = text.encode("utf-8")
    return list(map(str, write_all(files))) if files else []


def _print_translation(
    one: Translated, every: bool, before: set[tuple[str, str, str | None]]
) -> None:
    """Print how much is translated, or every statement; findings on the complete program come
    first.

    before: findings of programs before it, by code, message and file; of a file that programs
    share, such as system parameters, they are printed once.
    """
    from assistant.compiler.cell_defaults import UNFILLED
    from assistant.report.translation import reason_lines, report_lines, summary

    translation = one.translation
    # The table at the beginning lists what is to be filled in.
    found = (finding for finding in translation.whole if finding.code != UNFILLED.code)
    whole = [finding.within(one.source) for finding in found]
    whole = [f for f in whole if (f.code, f.message, f.path) not in before]
    before |= {(f.code, f.message, f.path) for f in whole if f.path != one.source}
    print_findings(whole if every else _first_of_each_code(whole))
    if every and sys.stdout.isatty():
        _print_statements(one)
        for line in reason_lines(one):
            say(line)
    else:
        for line in report_lines(one) if every else summary(one):
            say(line)
    for line in translation.written.proof_lines():
        say(f"{one.source}: {line}")


_MOST_OF_ONE_CODE: Final = 3
"""Most findings of one code on a complete program that are shown, unless each is requested."""


def _first_of_each_code(findings: Sequence[Diagnostic]) -> list[Diagnostic]:
    """The first few of each code, the last of them with how many there are besides."""
    alike: dict[str, list[Diagnostic]] = {}
    for finding in findings:
        alike.setdefault(finding.code, []).append(finding)
    shown = list[Diagnostic]()
    for found in alike.values():
        some, rest = found[:_MOST_OF_ONE_CODE], len(found) - _MOST_OF_ONE_CODE
        if rest > 0:
            some[-1] = replace(some[-1], message=f"{some[-1].message} (and {rest:,} more like it)")
        shown += some
    return shown


def _print_statements(one: Translated) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table("line", "level", "statement", "why", box=None, pad_edge=False)
    table.columns[0].justify = "right"
    for row in one.translation.rows:
        why = "\n".join(visible(f"{f.code} {f.message}") for f in row.reasons)
        count = f" ({row.count} rows)" if row.count > 1 else ""
        table.add_row(
            str(row.place.line),
            Text(row.level, style=_LEVEL_STYLES[row.level]),
            Text("\n".join(map(visible, (row.text + count).split("\n")))),
            Text(why),
        )
    Console(highlight=False, emoji=False).print(table)


_LANGUAGE_UNCLEAR = error(
    "CL006", "the text does not show which robot language it is in", "name it with --from"
)
_COVERAGE_HEADINGS: Final = ("Construct", "Supported", "Partial", "Kept verbatim")


@command
class Coverage:
    """Tell, construct by construct, what of a program can be translated and what cannot."""

    programs: tuple[str, ...] = argument("Robot programs, or folders with them; - for input.")
    from_language: FromLanguage
    format: FormatOption

    def run(self) -> int:
        """0 if every program could be read, 1 if one has syntax errors, 2 if one is unreadable."""
        from assistant.languages.coverage import coverage, total

        if self.programs.count(STANDARD) > 1:
            raise Refused(TWICE(), exit_status=2)
        status, found = 0, []
        wrong: list[Diagnostic] = []
        for path in dict.fromkeys(self.programs):
            try:
                for name, spoken, source in _programs_to_count(path, self.from_language):
                    with working(f"reading {name}"):
                        tree = spoken.parse(source)
                        told = [f.within(name) for f in tree.findings]
                        print_findings(told)
                        if has_errors(tree.findings):
                            status = max(status, 1)
                            wrong += told
                            continue
                        found.append(coverage(spoken, [tree]))
            except Refused as refused:
                told = [f.within(str(path)) for f in refused.findings]
                print_findings(told)
                wrong += told
                status = max(status, refused.exit_status)
        _print_coverage(total(found), wrong, self.format)
        return status


def _programs_to_count(
    path: str, language: str | None
) -> Iterator[tuple[str, Language[Any], SourceText]]:
    """Name, language and text of each program that a path stands for."""
    from assistant.compiler.formatter import read_program
    from assistant.compiler.loader import language_of
    from assistant.compiler.program_files import programs_in

    if path != STANDARD:
        for name in programs_in(path, language):
            yield name, *read_program(name, language)
        return
    text, spoken = standard_input(language)
    if spoken is None:
        raise Refused(_LANGUAGE_UNCLEAR(path=_STANDARD_INPUT), exit_status=2)
    yield _STANDARD_INPUT, language_of(spoken), text


def _print_coverage(rows: Sequence[Construct], wrong: Sequence[Diagnostic], format: Format) -> None:
    """wrong: why programs are not counted, which a list of constructs alone would not tell."""
    if format is Format.JSON:
        from assistant.findings.formats import records_of

        constructs = [asdict(row) for row in rows]
        findings = records_of(wrong)
        print_json(
            {"ok": False, "constructs": constructs, "findings": findings} if wrong else constructs
        )
        return
    counts = [(row.name, row.supported, row.partial, row.verbatim) for row in rows]
    sums = [sum(column) for column in zip(*(c[1:] for c in counts), strict=True)]
    lines = [_COVERAGE_HEADINGS, *counts, ("total", *(sums or (0, 0, 0)))]
    width = max(len(str(line[0])) for line in lines)
    for first, *rest in lines:
        said = f"{first:{width}}" + "".join(f"{value:>15}" for value in rest)
        say(said.rstrip())
