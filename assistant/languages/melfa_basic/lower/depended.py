"""Settings that kept texts depend on, which they find as the lines above them leave them."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.languages.melfa_basic.lift.settings.along_lines import needed_settings
from assistant.languages.melfa_basic.lift.settings.held import FRAME, TOOL
from assistant.languages.melfa_basic.reading.parser import statement as read_statement
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.rewriting import head, records


def settings_for_vendor_text(program: Program) -> frozenset[int]:
    """The settings, by number, under which texts of a program in one unit do what they do.

    None of one in several units, where it is not known what the others change. Tool and base only
    of one that was read in MELFA-BASIC: without a line for them they stay as the controller has
    them there, elsewhere there are none.
    """
    found: frozenset[int] = frozenset()
    if any(procedure.unit is not None for procedure in program.procedures):
        return found
    for node in program.statements():
        texts = list(_vendor_texts(node))
        for text in texts:
            line = read_statement(text)
            if line is not None and line.statement is not None:
                found |= needed_settings(line.statement)
        if texts and any(isinstance(part, e.Here) for part in records(head(node))):
            found |= {TOOL, FRAME}  # the statement is one line with the text
    read = program.origin is not None and program.origin.language in DIALECTS
    return found if read else found - {TOOL, FRAME}


def _vendor_texts(node: p.Statement) -> Iterator[str]:
    """The texts that a statement keeps, as statements."""
    for part in records(head(node)):
        if isinstance(part, p.Opaque) and part.language in DIALECTS:
            yield part.text
        elif isinstance(part, e.Verbatim) and part.language in DIALECTS:
            yield f"M1={part.text}"
