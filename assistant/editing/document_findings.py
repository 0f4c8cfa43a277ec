"""Findings of a document at their positions, and quick fixes, each tried before it is offered.

A cure is a sentence for people. A word in it between backquotes, or after `did you mean`, may be
what is to be written: it is put in place of the finding, before it and after it, and an edit that
removes the finding without a new error is offered.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Span, has_errors
from assistant.base.near_names import near_names
from assistant.editing.answers import Change, Fix, Found
from assistant.editing.symbols import editable, named
from assistant.editing.text_lines import Place, Range
from assistant.editing.workspace import Document
from assistant.findings.rulebook import is_adjustable


def findings(document: Document, *, whole: bool) -> tuple[Found, ...]:
    """In the order of the lines."""
    found, settled = document.workspace.found(document, whole=whole)
    placed = [found_at(document, one, settled=settled) for one in found]
    return tuple(sorted(placed, key=_text_order))


def _text_order(one: Found) -> tuple[int, int, str]:
    return one.range.start.line, one.range.start.column, one.diagnostic.code


def found_at(document: Document, finding: Diagnostic, *, settled: bool) -> Found:
    return Found(finding, _finding_range(document, finding), settled)


def _finding_range(document: Document, finding: Diagnostic) -> Range:
    """Line and column where they are known: offsets of a program of several texts count on."""
    lines = document.lines
    if finding.line is None:
        return _line_range(document, 0)
    line = min(max(finding.line - 1, 0), len(lines) - 1)
    if finding.column is None:
        return _line_range(document, line)
    if lines.narrow and finding.end_column is not None and finding.end_line == finding.line:
        most = lines.length(line)
        start_column = min(finding.column - 1, most)
        end_column = max(min(finding.end_column - 1, most), start_column)
        return Range(Place(line, start_column), Place(line, end_column))
    start = lines.starts[line] + min(finding.column - 1, len(lines.line(line)))
    last = min(max((finding.end_line or finding.line) - 1, line), len(lines) - 1)
    end = start + 1
    if finding.end_column is not None:
        end = lines.starts[last] + min(finding.end_column - 1, len(lines.line(last)))
    return lines.range(Span(start, max(end, start)))


def _line_range(document: Document, line: int) -> Range:
    lines = document.lines
    text = lines.line(line)
    start = lines.starts[line]
    begin = len(text) - len(text.lstrip())
    return lines.range(Span(start + begin, start + max(len(text.rstrip()), begin)))


_MOST_TRIED: Final = 24
"""Edits of one finding that are tried."""
_MOST_OFFERED: Final = 5
_QUOTED: Final = re.compile(r"`([^`]+)`")
_MEANT: Final = re.compile(r"did you mean ([^?]+)\?")
_DELETE: Final = re.compile(r"\b(?:delete|remove|take)\b", re.IGNORECASE)
_IGNORE: Final = re.compile(r"assistant:[ \t]*ignore\b(?![-])", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class _Edit:
    title: str
    span: Span
    text: str


def fixes(document: Document, found: Found) -> tuple[Fix, ...]:
    """See `service.fixes`."""
    finding, speaks = found.diagnostic, document.spoken
    if speaks is None:
        return ()
    code = finding.code
    made: list[Fix] = []
    tried: set[tuple[Span, str]] = set()
    for edit in _candidate_edits(document, found):
        if (edit.span, edit.text) in tried or len(made) >= _MOST_OFFERED:
            continue
        tried.add((edit.span, edit.text))
        if len(tried) > _MOST_TRIED:
            break
        if _cures(document, finding, edit):
            made.append(_fix(document, edit, code, preferred=not made))
    ignoring = _ignoring(document, found)
    if ignoring is not None:
        made.append(_fix(document, ignoring, code, preferred=False))
    return tuple(made)


def _fix(document: Document, edit: _Edit, code: str, *, preferred: bool) -> Fix:
    change = Change(document.lines.range(edit.span), edit.text)
    return Fix(edit.title, code, {document.path: (change,)}, preferred)


def _candidate_edits(document: Document, found: Found) -> Iterator[_Edit]:
    """Yield possible corrections, the likeliest first."""
    finding, lines = found.diagnostic, document.lines
    span = lines.span(found.range)
    there = document.text[span.start : span.end]
    cure = finding.cure
    if meant := _MEANT.search(cure):
        for name in re.split(r", | or ", meant[1]):
            plain = name.strip().strip("`")
            yield _Edit(f"Change `{there}` to `{plain}`", span, plain)
            yield from _word_for(document, finding, plain)
    missing = finding.missing or _undeclared(document, found)
    if missing:
        yield from _similar_names(document, found, missing)
        yield from _declaring(document, missing)
    words = _quoted(finding)
    near = near_names(there, [word for word in words if word != there])
    for word in sorted(words, key=lambda one: one not in near):
        yield from _with_word(document, span, there, word)
    if _DELETE.search(cure):
        if there.strip():
            yield _Edit(f"Delete `{there.strip()}`", _with_blank(document.text, span), "")
        line = found.range.start.line
        end = lines.starts[line + 1] if line + 1 < len(lines) else len(document.text)
        yield _Edit(f"Delete line {line + 1}", Span(lines.starts[line], end), "")


def _undeclared(document: Document, found: Found) -> str | None:
    """The name at the place of a finding, if nothing declares it."""
    speaks, here = editable(document), named(document, found.range.start)
    if speaks is None or here is None or here.declared is not None:
        return None
    return None if speaks.folded(here.word.text) in speaks.known() else here.word.text


def _similar_names(document: Document, found: Found, missing: str) -> Iterator[_Edit]:
    """Declared names that are spelled like one that is not."""
    speaks = editable(document)
    assert speaks is not None
    key = speaks.folded(missing)
    declared = {
        one.name
        for other in document.workspace.task(document)
        for facts in other.facts
        for one in facts.declares
        if speaks.folded(one.name) != key
    }
    words = document.facts[found.range.start.line].words
    begin = document.lines.starts[found.range.start.line]
    at = next((one for one in words if speaks.folded(one.text) == key), None)
    for name in near_names(missing, sorted(declared)) if at is not None else ():
        assert at is not None
        span = Span(begin + at.start, begin + at.end)
        yield _Edit(f"Change `{missing}` to `{name}`", span, name)


def _quoted(finding: Diagnostic) -> list[str]:
    """Return the quoted words of the cure, then of the message: a message may name the missing
    word.
    """
    words = [*_QUOTED.findall(finding.cure), *_QUOTED.findall(finding.message)]
    return [word for word in dict.fromkeys(words) if "…" not in word and len(word) <= 60]


def _with_word(document: Document, span: Span, there: str, word: str) -> Iterator[_Edit]:
    text = document.text
    if word != there:
        if there.strip():
            yield _Edit(f"Change `{there}` to `{word}`", span, word)
        line = document.lines.place(span.start).line
        end = document.lines.starts[line] + len(_code_of(document, line))
        for at in dict.fromkeys((span.start, span.end, end)):
            before = " " if at and text[at - 1].isalnum() and word[0].isalnum() else ""
            behind = " " if text[at : at + 1].isalnum() and word[-1].isalnum() else ""
            yield _Edit(f"Write `{word}`", Span(at, at), before + word + behind)


def _word_for(document: Document, finding: Diagnostic, name: str) -> Iterator[_Edit]:
    """A name for the one in the message, where the place is larger than that."""
    line = (finding.line or 1) - 1
    for word in _QUOTED.findall(finding.message)[:1]:
        for one in document.facts[line].words if line < len(document.facts) else ():
            if one.text.lower() == word.lower():
                begin = document.lines.starts[line]
                span = Span(begin + one.start, begin + one.end)
                yield _Edit(f"Change `{word}` to `{name}`", span, name)


def _code_of(document: Document, line: int) -> str:
    """A line up to its comment."""
    text = document.lines.line(line)
    for word in document.facts[line].words:
        if word.kind == "comment":
            return text[: word.start].rstrip()
    return text.rstrip()


def _with_blank(text: str, span: Span) -> Span:
    """And a blank in front of it, so that none is left over."""
    start = span.start
    if start and text[start - 1] == " " and text[span.end : span.end + 1] in (" ", "", "\n", ";"):
        start -= 1
    return Span(start, span.end)


def _declaring(document: Document, name: str) -> Iterator[_Edit]:
    speaks, words = document.spoken, editable(document)
    if speaks is None or words is None:
        return
    _, *others = document.workspace.task(document)
    texts = [one.source for one in others]
    end = "\r\n" if "\r\n" in document.text else "\n"
    line = _line_for(document, last=words.declared_last)
    at = document.lines.starts[line] if line < len(document.lines) else len(document.text)
    before = "" if not at or document.text[at - 1] in "\r\n" else end
    for said in speaks.declarations(document.source, texts, name):
        inner = said.replace("\n", f"{end}{_indent(document, line)}")
        text = f"{before}{_indent(document, line)}{inner}{end}"
        first, _, _ = said.partition("\n")
        yield _Edit(f"Declare `{first}`", Span(at, at), text)


def _line_for(document: Document, *, last: bool) -> int:
    """The line in front of which a declaration goes: behind others, before the first routine."""
    facts, made_of = document.facts, document.made_of
    if last:
        return len(facts) - (not document.lines.line(len(facts) - 1).strip())
    first = made_of.routines[0].first if made_of.routines else len(facts)
    behind = 0
    for line in range(first):
        stays = facts[line].stays and bool(facts[line].declares)
        if stays or any(not one.implied for one in facts[line].declares):
            behind = line + 1
    return behind


def _indent(document: Document, line: int) -> str:
    """That of the declaration above, else of the next line that has one."""
    lines = document.lines
    for near in (line - 1, line, line + 1):
        if 0 <= near < len(lines) and document.facts[near].declares:
            stays = document.facts[near].stays
            text = lines.line(near)
            if text.strip() and not stays:
                return text[: len(text) - len(text.lstrip())]
    return ""


def _cures(document: Document, finding: Diagnostic, edit: _Edit) -> bool:
    """True if an edit removes the finding and adds no error."""
    text = document.text[: edit.span.start] + edit.text + document.text[edit.span.end :]
    before, after = _looked(document, document.text), _looked(document, text)
    if before is None or after is None or _count(before, finding) == 0:
        return False
    if _count(after, finding) >= _count(before, finding):
        return False
    errors = sum(has_errors([one]) for one in before)
    return sum(has_errors([one]) for one in after) <= errors - has_errors([finding])


def _looked(document: Document, text: str) -> Sequence[Diagnostic] | None:
    return document.workspace.tried(document, text)


def _count(findings: Sequence[Diagnostic], finding: Diagnostic) -> int:
    return sum((one.code, one.message) == (finding.code, finding.message) for one in findings)


def _ignoring(document: Document, found: Found) -> _Edit | None:
    """A comment that ignores the finding at its line."""
    finding, speaks = found.diagnostic, document.spoken
    if speaks is None or finding.line is None or not is_adjustable(finding):
        return None
    line = found.range.start.line
    lines, words = document.lines, document.facts[line].words
    text, start = lines.line(line), lines.starts[line]
    title = f"Ignore {finding.code} here"
    comment = next((word for word in words if word.kind == "comment"), None)
    if comment is None:
        end = start + len(text.rstrip())
        return _Edit(title, Span(end, end), f"  {speaks.mark} assistant: ignore {finding.code}")
    if there := _IGNORE.search(comment.text):
        at = start + comment.start + there.end()
        return _Edit(title, Span(at, at), f" {finding.code},")
    indent = text[: len(text) - len(text.lstrip())]
    if words[0].kind == "number":
        return None  # lines have numbers, so that none can be put between
    ended = "\r\n" if "\r\n" in document.text else "\n"
    said = f"{indent}{speaks.mark} assistant: ignore {finding.code}{ended}"
    return _Edit(title, Span(start, start), said)
