"""Formatter: robot programs in the one layout of their language, proven to be the same.

The text is laid out, read back and compared: the same tree, with the same comments.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, Final

from assistant import languages
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors
from assistant.base.file_sets import write_all
from assistant.base.source_text import SourceText, comments, encode, read_bytes
from assistant.compiler.loader import language_of
from assistant.languages import Language

NOT_THE_SAME: Final = error(
    "CO401",
    "laid out anew, the program would not be the same; it stays as it was",
    "report it with the file: the formatter is wrong, not the file",
)
_NO_LANGUAGE: Final = error(
    "CO402", "`{name}` does not look like a robot program", "name its language with --from"
)
_NO_STEPS: Final = error(
    "CO404",
    "`{name}` is {language}, which has no step numbers",
    "leave --renumber out, or name programs in {others} only",
)

StepNumbering = tuple[int, int]
"""First step number, and what the next ones are more."""


@dataclass(frozen=True, slots=True)
class Formatted:
    """A source, and its text in the layout of its language.

    text: that of the source if it cannot be laid out; an error among the findings gives the reason.
    """

    source: SourceText
    text: str
    findings: tuple[Diagnostic, ...] = ()

    @property
    def changed(self) -> bool:
        return self.text != self.source.text

    def encoded(self) -> bytes:
        """The text's bytes, in the encoding that was read."""
        return encode(replace(self.source, text=self.text))


def _families_with_steps() -> list[str]:
    spoken = map(languages.get, languages.names())
    return sorted({one.family_title or one.title for one in spoken if one.steps})


def format_text(
    source: SourceText, language: Language[Any], numbering: StepNumbering | None = None
) -> Formatted:
    """A text laid out, read back and compared: the same tree, with the same comments.

    numbering: of the steps, which are kept without it; the trees are the same but for that.
    Raises Refused (exit status 2) for a numbering in a language without steps.
    """
    if numbering and not language.steps:
        name = source.path or "input"
        others = ", ".join(_families_with_steps())
        refused = _NO_STEPS(path=source.path, name=name, language=language.title, others=others)
        raise Refused(refused, exit_status=2)
    tree = language.parse(source)
    if has_errors(tree.findings):
        return Formatted(source, source.text, tree.findings)
    try:
        text = language.format(language.renumber(tree, *numbering) if numbering else tree)
    except Refused as refused:
        return Formatted(source, source.text, refused.findings)
    if text != source.text:
        again = language.parse(replace(source, text=text))
        mark = language.comment_mark
        same = _comments(source.text, mark) == _comments(text, mark)
        if has_errors(again.findings) or not (
            same and _is_same_tree(language, tree, again, numbering)
        ):
            return Formatted(source, source.text, (NOT_THE_SAME(path=source.path),))
    return Formatted(source, text, tree.findings)


def _is_same_tree(
    language: Language[Any], tree: Any, again: Any, numbering: StepNumbering | None
) -> bool:
    """True if two parsed trees are equivalent. numbering: the step numbering expected of the
    second.
    """
    if numbering is None:
        return language.same(tree, again)
    plain, kept = language.renumber(again, 1, 1), language.renumber(again, *numbering)
    return language.same(language.renumber(tree, 1, 1), plain) and language.same(again, kept)


def format_file(
    path: str | FilePath, language: str | None = None, numbering: StepNumbering | None = None
) -> Formatted:
    """A file laid out; nothing is written. language: if neither suffix nor text tell.

    Raises Unreadable, or Refused if the file is in no known language.
    """
    spoken, source = read_program(path, language)
    return format_text(source, spoken, numbering)


def read_program(
    path: str | FilePath, language: str | None = None
) -> tuple[Language[Any], SourceText]:
    """The text of a robot program and the language it is in; raises as `format_file` does."""
    data = read_bytes(path)
    spoken = language_of(language) if language else languages.of_file(path, data)
    if spoken is None:
        raise Refused(_NO_LANGUAGE(path=str(path), name=path), exit_status=2)
    return spoken, spoken.decode(data, str(path))


def format_bytes(
    data: bytes, name: str, language: str | None = None, numbering: StepNumbering | None = None
) -> Formatted:
    """Format bytes that are not a file."""
    named = [language_of(language)] if language else map(languages.get, languages.names())
    spoken = next((one for one in named if language or one.recognises(data)), None)
    if spoken is None:
        raise Refused(_NO_LANGUAGE(path=name, name=name), exit_status=2)
    return format_text(spoken.decode(data, name), spoken, numbering)


def rewrite_file(formatted: Formatted) -> None:
    """Puts the text in place of the file that was read, whole or not at all.

    A link stays one, permissions stay. Raises Refused (exit status 2) if it cannot be written.
    """
    assert formatted.source.path is not None
    write_all({FilePath(formatted.source.path): formatted.encoded()})


def _comments(text: str, mark: str) -> list[str]:
    """The comments of a text that say something, wherever they stand, without outer blanks."""
    found = (text[span.start + len(mark) : span.end].strip() for span in comments(text, mark))
    return [comment for comment in found if comment]
