"""`coverage`: what of a vendor program the pseudo-program says, construct by construct."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict

from assistant.cli.compiling import working
from assistant.cli.presentation import Format, print_findings, say
from assistant.program.diagnostics import Refused, has_errors

HEADINGS = ("Construct", "Supported", "Partial", "Kept verbatim")


def run_coverage(paths: Sequence[str], language: str | None, format: Format) -> int:
    """0 if every program could be read, 1 if one has syntax errors, 2 if one is unreadable."""
    from assistant.compiler.formatting import programs_in, read_program
    from assistant.languages.coverage import coverage, total

    status, found = 0, []
    for path in dict.fromkeys(paths):
        try:
            for name in programs_in(path, language):
                with working(f"reading {name}"):
                    spoken, source = read_program(name, language)
                    tree = spoken.parse(source)
                    print_findings(f.within(name) for f in tree.findings)
                    if has_errors(tree.findings):
                        status = max(status, 1)
                        continue
                    found.append(coverage(spoken, [tree]))
        except Refused as refused:
            print_findings(f.within(str(path)) for f in refused.findings)
            status = max(status, refused.exit_status)
    rows = total(found)
    if format is Format.JSON:
        json.dump([asdict(row) for row in rows], sys.stdout, indent=2)
        sys.stdout.write("\n")
        return status
    counts = [(row.name, row.supported, row.partial, row.verbatim) for row in rows]
    sums = [sum(column) for column in zip(*(c[1:] for c in counts), strict=True)]
    lines = [HEADINGS, *counts, ("total", *(sums or (0, 0, 0)))]
    width = max(len(str(line[0])) for line in lines)
    for first, *rest in lines:
        said = f"{first:{width}}" + "".join(f"{value:>15}" for value in rest)
        say(said.rstrip())
    return status
