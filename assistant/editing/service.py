"""What editors ask about programs that are being written, without any protocol.

    workspace = Workspace(Path("cell"))
    document = workspace.open("cell/main.mod", text, version=1)
    document = workspace.change(document.path, [Change(range, "x")], version=2)
    for found in findings(document):
        show(found.range, found.diagnostic, fixes(document, found))

A `Document` is one state of a text and never changes; its workspace holds the open ones, which
stand for their files. Every place is a line and a column from 0, columns in units of UTF-16, as
browsers and language servers count. Nothing here writes a file: what is to be changed comes as
`Changes`. All functions may be called from any thread; one workspace works on one call at a time.
No function raises for what a text says: what cannot be answered is empty or None. What cannot be
done for a reason (a name that is taken, a text that cannot be laid out) raises `Refused` with
findings.
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
    """What is wrong with a document now, in the order of its lines; fast, for each key.

    The parts that changed are looked at; findings of all others are those of the last time that
    the whole program was looked at. A damaged line has its own findings, and all others keep
    theirs meanwhile. `settled` looks at the whole program; call it when typing rests.
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
    """The words of a document, each with its sort, in columns.

    first, last: lines from 0 whose words are asked for; None for up to the end.
    """
    return code_assist.tokens(document, max(first, 0), last)


def completions(document: Document, place: Place) -> tuple[Completion, ...]:
    """Words that may stand at a place: declared names, instructions, keywords, values."""
    return code_assist.completions(document, place)


def hover(document: Document, place: Place) -> Hover | None:
    """What the word at a place means: an instruction, a declaration, a target with its pose.

    Of a target also the joints of the project's robot, where there is one.
    """
    return code_assist.hover(document, place)


def definition(document: Document, place: Place) -> Location | None:
    """Where the name at a place is declared, in any file of the task."""
    return symbols.definition(document, place)


def references(document: Document, place: Place, declaration: bool = True) -> tuple[Location, ...]:
    """Where the thing named at a place is named, in all files of the task, in their order.

    declaration: whether that counts.
    """
    return symbols.references(document, place, declaration)


def renameable(document: Document, place: Place) -> Range | None:
    """The name at a place that can be changed, None where there is none."""
    return symbols.renameable(document, place)


def rename(document: Document, place: Place, name: str) -> Changes:
    """What gives the thing named at a place another name, in all files of the task.

    Raises Refused for what is no name there, is taken, or is not declared in the task.
    """
    return symbols.rename(document, place, name)


def outline(document: Document) -> tuple[OutlineItem, ...]:
    """Modules, procedures, functions, records, data, labels, in their order and inside another."""
    return symbols.outline(document)


def formatted(document: Document) -> tuple[Change, ...]:
    """What lays a document out as `robot-assistant fmt` does, line by line; empty if nothing does.

    Raises Refused if it cannot be laid out, with the reason.
    """
    return renderings.formatted(document)


def translation(document: Document, language: str) -> Translation:
    """The document's program in another language, its lines beside what they became.

    language: `pseudo` shows the pseudo-program. With the files of its task and its project's robot.
    What cannot be read or said is in the findings. Raises Refused for an unknown language.
    """
    return renderings.translation(document, language)
