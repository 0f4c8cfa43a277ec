"""`show`: the pseudo-program of a source, also on its way into a language."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error, fold
from assistant.cli.compiling import NO_FILE_NAME, SIDE_TABLES_ABOVE, load_given
from assistant.cli.presentation import print_findings, say
from assistant.cli.stating import with_project_defaults

if TYPE_CHECKING:
    from assistant.compiler import Loaded
    from assistant.program.program import Program
    from assistant.program.pseudo.printer import Printed
    from assistant.sources.process.placement import DrawingPlacement

NO_PASS: Final = error("CL012", "the program goes through no pass `{name}`", "name one of {passes}")
NO_LANGUAGE: Final = error(
    "CL013", "a pass is on the way into a language", "name it: `--to LANGUAGE`"
)


@dataclass(frozen=True, slots=True)
class ShowOptions:
    """What of a source is shown. to, after: as a language says it, after one of its passes."""

    robot: str | None
    process: Path | None
    unit: str | None
    from_language: str | None
    entry: str | None
    to: str | None
    after: str | None
    placement: DrawingPlacement | None = None


def run_show(source: str, wanted: ShowOptions, output: Path | None) -> int:
    from assistant.program import pseudo

    wanted = with_project_defaults(source, wanted)
    loaded = load_given(
        source,
        wanted.robot,
        wanted.process,
        wanted.unit,
        wanted.from_language,
        wanted.entry,
        placement=wanted.placement,
    )
    print_findings(fold(f.within(source) for f in loaded.findings))
    program = _lowered(loaded, wanted)
    if output is None:
        sys.stdout.write(_pseudo_text(program, source, None).text)
        return 0
    from assistant.base.file_sets import write_files

    printed = _pseudo_text(program, source, SIDE_TABLES_ABOVE)
    if not output.name or output.name in (".", ".."):
        raise Refused(NO_FILE_NAME(path=str(output), name=output), exit_status=2)
    name = output.with_suffix(pseudo.SUFFIX).name
    for path in write_files({name: printed.text.encode(), **printed.tables}, output.parent):
        say(f"wrote {path}")
    return 0


def _pseudo_text(program: Program, source: str, side_tables_above: int | None) -> Printed:
    """The text of the program; what it cannot say is told at its line of the source."""
    from assistant.compiler.source_map import Places
    from assistant.program import pseudo

    try:
        return pseudo.print_program(program, side_tables_above=side_tables_above)
    except Refused as refused:
        places = Places(program)
        raise Refused(*(places.finding(f).within(source) for f in refused.findings)) from None


def _lowered(loaded: Loaded, wanted: ShowOptions) -> Program:
    """The program that was loaded, or what a pass on its way into a language makes of it."""
    if wanted.to is None:
        if wanted.after is not None:
            raise Refused(NO_LANGUAGE(), exit_status=2)
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
        raise Refused(NO_PASS(name=wanted.after, passes=passes), exit_status=2)
    return seen[wanted.after]
