"""Answers for editors about programs during typing, independent of any protocol.

    workspace = Workspace(Path("cell"))
    document = workspace.open("cell/main.mod", text, version=1)
    document = workspace.change(document.path, [Change(range, "x")], version=2)
    for found in findings(document):
        show(found.range, found.diagnostic, fixes(document, found))

A `Document` is one state of a text and never changes; its workspace holds the open documents, which
replace their files. Every place is a line and a column from 0, columns in units of UTF-16, as
browsers and language servers count. These functions write no file: they return edits as `Changes`.
All functions may be called from any thread; one workspace works on one call at a time. No function
raises for the content of a text: an answer that is not available is empty or None. A request that
cannot be carried out for a reason (a name that is taken, a text that cannot be laid out) raises
`Refused` with findings.
"""

from __future__ import annotations

from assistant.editing import code_assist, document_findings, renderings, symbols
from assistant.editing.answers import (
    MARKS,
    SORTS,
    Change,
    Changes,
    Completion,
    Fix,
    Found,
    Hover,
    Location,
    OutlineItem,
    Pair,
    Tokens,
    Translation,
)
from assistant.editing.text_lines import Place, Range
from assistant.editing.workspace import Document, Workspace

__all__ = [
    "MARKS", "SORTS", "Change", "Changes", "Completion", "Document", "Fix", "Found", "Hover",
    "Location", "OutlineItem", "Pair", "Place", "Range", "Tokens", "Translation", "Workspace",
    "completions", "definition", "findings", "fixes", "formatted", "hover", "outline", "references",
    "rename", "renameable", "settled", "tokens", "translation",
]  # fmt: skip


def findings(document: Document) -> tuple[Found, ...]:
    """Return the present findings of a document, in the order of its lines; fast enough for each
    key.

    Only the changed parts are checked; all other findings are from the last check of the complete
    program. A damaged line has separate findings, and all other lines keep theirs meanwhile.
    `settled` checks the complete program; call it when typing rests.
    """
    return document_findings.findings(document, whole=False)


def settled(document: Document) -> tuple[Found, ...]:
    """The same, of the whole program: what `robot-assistant check` finds in this file.

    With the robot, cell and severities of the project, and the other files of its task. Takes a
    second for 5,000 lines. Known afterwards to `findings`.
    """
    return document_findings.findings(document, whole=True)


def fixes(document: Document, found: Found) -> tuple[Fix, ...]:
    """Cures of a finding that are definite edits, the likeliest first; also one that ignores it.

    Each was tried: the finding is gone with it, and no error is there that was not.
    """
    return document_findings.fixes(document, found)


def tokens(document: Document, first: int = 0, last: int | None = None) -> Tokens:
    """Return the words of a document, each with its sort, in columns.

    first, last: lines from 0 whose words are returned; None for all lines to the end.
    """
    return code_assist.tokens(document, max(first, 0), last)


def completions(document: Document, place: Place) -> tuple[Completion, ...]:
    """Words that may stand at a place: declared names, instructions, keywords, values."""
    return code_assist.completions(document, place)


def hover(document: Document, place: Place) -> Hover | None:
    """Return the meaning of the word at a place: an instruction, a declaration, a target with its
    pose.

    For a target it includes the joints of the project's robot, if the project has one.
    """
    return code_assist.hover(document, place)


def definition(document: Document, place: Place) -> Location | None:
    """Return the location of the declaration of the name at a place, in any file of the task."""
    return symbols.definition(document, place)


def references(document: Document, place: Place, declaration: bool = True) -> tuple[Location, ...]:
    """Return the locations of all uses of the thing named at a place, in all files of the task, in
    their order.

    declaration: True to include the declaration.
    """
    return symbols.references(document, place, declaration)


def renameable(document: Document, place: Place) -> Range | None:
    """Return the range of the name at a place if it can be renamed, else None."""
    return symbols.renameable(document, place)


def rename(document: Document, place: Place, name: str) -> Changes:
    """Return the changes that rename the thing named at a place, in all files of the task.

    Raises Refused for a word that is not a name there, for a taken name, and for a name that is not
    declared in the task.
    """
    return symbols.rename(document, place, name)


def outline(document: Document) -> tuple[OutlineItem, ...]:
    """Modules, procedures, functions, records, data, labels, in their order and inside another."""
    return symbols.outline(document)


def formatted(document: Document) -> tuple[Change, ...]:
    """Return the changes that lay a document out as `robot-assistant fmt` does, line by line; empty
    if the layout is correct.

    Raises Refused if it cannot be laid out, with the reason.
    """
    return renderings.formatted(document)


def translation(document: Document, language: str) -> Translation:
    """Return the document's program in another language, with its lines beside their translations.

    language: `pseudo` shows the pseudo-program. The translation uses the files of its task and its
    project's robot. Text that cannot be read or translated is in the findings. Raises Refused for
    an unknown language.
    """
    return renderings.translation(document, language)
