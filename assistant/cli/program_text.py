"""Print programs: `show` as a pseudo-program, `fmt` in the layout of their language.

`show --after PASS` prints the program as it is after one pass on its way into a language. `fmt`
writes in place, prints a diff, or only checks.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from difflib import unified_diff
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error, fold, has_errors
from assistant.base.source_text import ended_lines, read_input, visible
from assistant.cli.command import argument, command, option
from assistant.cli.options import (
    DrawingOptions,
    EntryOption,
    FromLanguage,
    JobsOption,
    RobotOption,
    Source,
    complete_language,
    with_project_defaults,
)
from assistant.cli.output_files import results_of
from assistant.cli.presentation import print_findings, say
from assistant.cli.source_input import NO_FILE_NAME, SIDE_TABLES_ABOVE, STANDARD, TWICE, load_given

if TYPE_CHECKING:
    from assistant.compiler import Loaded
    from assistant.compiler.formatter import Formatted, StepNumbering
    from assistant.program.program import Program
    from assistant.program.pseudo.printer import Printed


_NO_PASS: Final = error(
    "CL012", "the program goes through no pass `{name}`", "name one of {passes}"
)
_NO_LANGUAGE: Final = error(
    "CL013", "a pass is on the way into a language", "name it: `--to LANGUAGE`"
)


@command
class Show:
    """Print the pseudo-program of any source or robot program."""

    source: Source
    robot: RobotOption
    reader: DrawingOptions
    from_language: FromLanguage
    entry: EntryOption
    output: Path | None = option(
        "Write a .pseudo file, long paths in tables beside.", "--output", "-o"
    )
    to: str | None = option("As this language will say it.", completions=complete_language)
    after: str | None = option("On the way into that language, after this pass.")

    def run(self) -> int:
        from assistant.program import pseudo

        wanted = with_project_defaults(self.source, self)
        loaded = load_given(
            self.source, wanted.robot, wanted.reader, wanted.from_language, wanted.entry
        )
        print_findings(fold(f.within(self.source) for f in loaded.findings))
        program = _lowered(loaded, wanted)
        if self.output is None:
            sys.stdout.write(_pseudo_text(program, self.source, None).text)
            return 0
        from assistant.base.file_sets import write_files

        printed = _pseudo_text(program, self.source, SIDE_TABLES_ABOVE)
        if not self.output.name or self.output.name in (".", ".."):
            raise Refused(NO_FILE_NAME(path=str(self.output), name=self.output), exit_status=2)
        name = self.output.with_suffix(pseudo.SUFFIX).name
        for path in write_files(
            {name: printed.text.encode(), **printed.tables}, self.output.parent
        ):
            say(f"wrote {path}")
        return 0


def _pseudo_text(program: Program, source: str, side_tables_above: int | None) -> Printed:
    """Return the text of the program; report parts it cannot express at their lines of the
    source.
    """
    from assistant.compiler.source_map import Places
    from assistant.program import pseudo

    try:
        return pseudo.print_program(program, side_tables_above=side_tables_above)
    except Refused as refused:
        places = Places(program)
        raise Refused(*(places.finding(f).within(source) for f in refused.findings)) from None


def _lowered(loaded: Loaded, wanted: Show) -> Program:
    """The program that was loaded, or what a pass on its way into a language makes of it."""
    if wanted.to is None:
        if wanted.after is not None:
            raise Refused(_NO_LANGUAGE(), exit_status=2)
        return loaded.program
    from assistant.compiler import compile
    from assistant.program.passes.legalisation import pass_trace

    seen: dict[str, Program] = {}
    with pass_trace(seen.__setitem__):
        compiled = compile(loaded, language=wanted.to, robot=wanted.robot)
    if wanted.after is None:
        return compiled.program
    if wanted.after not in seen:
        passes = ", ".join(f"`{name}`" for name in seen)
        raise Refused(_NO_PASS(name=wanted.after, passes=passes), exit_status=2)
    return seen[wanted.after]


_BAD_NUMBERING: Final = error(
    "CL005",
    "`{text}` does not say how steps are numbered",
    "write the first number and the step, both from 1 on, as in --renumber 10,10",
)
_NUMBERING: Final = re.compile(r"[ ]*([0-9]{1,5})[ ]*(?:,[ ]*([0-9]{1,5})[ ]*)?")


@command
class Fmt:
    """Lay robot programs out: indentation, blanks, case of keywords. Their meaning stays the
    same.
    """

    files: tuple[str, ...] = argument("Robot programs, or folders with them; - for input.")
    check: bool = option("Write nothing; exit 1 if a file would change.")
    diff: bool = option("Write nothing; print what would change.")
    renumber: str | None = option("Number the steps anew, jumps to them too.", metavar="FIRST,STEP")
    from_language: FromLanguage
    jobs: JobsOption

    def run(self) -> int:
        """0 if all is well, 1 if a file is broken or, with check, would change, 2 if unreadable."""
        if self.files.count(STANDARD) > 1:
            raise Refused(TWICE(), exit_status=2)
        numbering = None if self.renumber is None else _numbering(self.renumber)
        status = files = changed = 0
        wanted = [
            (str(name) if isinstance(name, str) else path, (name, self.from_language, numbering))
            for path in dict.fromkeys(self.files)
            for name in _files_to_format(path, self.from_language)
        ]
        jobs = 1 if STANDARD in self.files else self.jobs
        for name, results, answers in results_of(_formatted, wanted, jobs, "formatting"):
            for done in results:
                with answers.of(name):
                    self._write(done, name)
            print_findings(answers.refusals)
            status = max(status, answers.status)
            for done in results if not answers.refusals else ():
                files, changed = files + 1, changed + done.changed
                print_findings(f.within(name) for f in done.findings)
                if has_errors(done.findings) or (self.check and done.changed):
                    status = max(status, 1)
                if self.diff:
                    sys.stdout.writelines(_unified_diff(done, name))
                elif done.changed and name != STANDARD:
                    say(f"would format {name}" if self.check else f"formatted {name}")
        if not self.diff and STANDARD not in self.files:
            does = "would change" if self.check else "changed"
            say(f"{files} file{'s' * (files != 1)}, {changed} {does}")
        return status

    def _write(self, done: Formatted, name: str) -> None:
        from assistant.compiler.formatter import rewrite_file

        if self.check or self.diff:
            return
        if name == STANDARD:
            sys.stdout.buffer.write(done.encoded())
        elif done.changed:
            rewrite_file(done)


def _formatted(given: tuple[str | Refused, str | None, StepNumbering | None]) -> Formatted:
    """Return a file in the layout of its language; raise the refusal that is given for one."""
    from assistant.compiler.formatter import format_bytes, format_file

    name, language, numbering = given
    if isinstance(name, Refused):
        raise name
    if name == STANDARD:
        return format_bytes(read_input(sys.stdin.buffer), "standard input", language, numbering)
    return format_file(name, language, numbering)


def _numbering(text: str) -> tuple[int, int]:
    """First number and step; one number is both. Raises Refused for anything else."""
    found = _NUMBERING.fullmatch(text)
    first, step = (int(found[1]), int(found[2] or found[1])) if found else (0, 0)
    if not (first and step):
        raise Refused(_BAD_NUMBERING(text=text), exit_status=2)
    return first, step


def _files_to_format(path: str, language: str | None) -> Iterator[str | Refused]:
    """Yield the files of a path, and the reason if it has no file or no more."""
    from assistant.compiler.program_files import programs_in

    if path == STANDARD:
        yield path
        return
    try:
        yield from programs_in(path, language)
    except Refused as refused:
        yield refused


def _unified_diff(done: Formatted, name: str) -> Iterator[str]:
    """A unified difference; the ends of its lines are as they are, so that it can be applied."""
    before, after = (ended_lines(text) for text in (done.source.text, done.text))
    for line in unified_diff(before, after, name, f"{name} (formatted)"):
        said = line.rstrip("\r\n")
        end = line[len(said) :]
        if end:
            yield visible(said) + (end if "\n" in end else "\n")
        else:
            yield f"{visible(said)}\n\\ No newline at end of file\n"
