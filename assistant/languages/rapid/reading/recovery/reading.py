"""Reading on behind syntax errors: each is mended with the least change, and said once.

The grammar stays the authority. Every word is tried on the parser's stack before it is shifted;
where none fits, `repairs` proposes changes, and the one that lets the parser read on furthest is
made. What can be mended in no way becomes a placeholder, as the pendant writes them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.files import with_line_feeds
from assistant.languages.rapid.reading.grammar import grammar, tables
from assistant.languages.rapid.reading.recovery import wording
from assistant.languages.rapid.reading.recovery.broken import CLAUSES, Broken, Kept, Repair
from assistant.languages.rapid.reading.recovery.lexemes import END, lexemes
from assistant.languages.rapid.reading.recovery.repairs import best
from assistant.languages.rapid.reading.shortened import RunInTheWay, Shortened
from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.text import SourceText

if TYPE_CHECKING:
    from lark import Token

MOST_FINDINGS: Final = 50
FURTHER: Final = 24
"""Words behind an error that a repair is tried on."""
MOST_MENDS: Final = 2000
"""Repairs, the unsaid ones included, after which a file counts as damaged all over."""
ROUTINES: Final = frozenset({"_PROC", "_FUNC", "_TRAP"})


def read_damaged(
    source: SourceText, short: Shortened, start: str
) -> tuple[Any, tuple[Diagnostic, ...]] | RunInTheWay:
    """Lark's tree of a damaged file and what is wrong with it."""
    reading = _Reading(source, short, start)
    try:
        return reading.tree(), tuple(reading.findings)
    except _Way as way:
        return RunInTheWay(way.number)


class _Way(Exception):
    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number: Final = number


class _Reading:
    def __init__(self, source: SourceText, short: Shortened, start: str) -> None:
        parser = grammar().parse_interactive(short.text, start=start)
        self.source, self.short = source, short
        self.text = with_line_feeds(source.text)
        self.findings: list[Diagnostic] = []
        self._state: Any = parser.parser_state
        self._lexer: Any = parser.lexer_thread
        self._tables = tables(start)
        self._quiet_until = -1
        self._kept: list[Kept] = []
        self._mends = 0

    def tree(self) -> Any:
        while True:
            error = None
            for token in self._tokens():
                if self._after([token.type]) is None:
                    error = token
                    break
                self._note(token)
                if token.type == END:
                    return self._state.feed_token(token, True)
                self._state.feed_token(token)
            self._mends += 1
            if self._mends > MOST_MENDS:
                return self._nothing()
            self._mend(self._at if error is None else int(error.start_pos or 0), error)

    def _nothing(self) -> Any:
        """A tree without parts, for what is damaged all over."""
        from lark import Tree

        return Tree("start", [None])

    @property
    def _at(self) -> int:
        at: int = self._lexer.state.line_ctr.char_pos
        return at

    def _tokens(self) -> Iterator[Token]:
        """The rest of the text; ends early where no word is found."""
        from lark import Token
        from lark.exceptions import UnexpectedCharacters, UnexpectedToken

        try:
            yield from self._lexer.lex(self._state)
        except UnexpectedToken as error:  # a word of the language, but not one for here
            yield error.token
            return
        except UnexpectedCharacters as error:
            self._lexer.state.line_ctr.char_pos = error.pos_in_stream
            return
        at = len(self.short.text)
        yield Token(END, "", at, 1, 1, 1, 1, at)

    def _after(self, terminals: Sequence[str]) -> list[int] | None:
        return self._tables.after(self._state.state_stack, terminals)

    def _note(self, token: Token) -> None:
        """Remembers where an IF without THEN began: its ENDIF tells what it was meant to be."""
        if token.type in ROUTINES:
            self._kept.clear()
        elif token.type == "_IF" and token.start_pos is not None:
            text, at = self.short.text, token.start_pos
            stop = text.find(";", at)
            line = text.find("\n", at)
            code = re.sub(r"![^\n]*", "", text[at:stop])
            if 0 <= line < stop and "then" not in code.lower():
                self._kept.append(
                    Kept(
                        self.short.offset(at),
                        self.short.offset(line),
                        tuple(self._state.state_stack),
                        tuple(map(_marked, self._state.value_stack)),
                    )
                )

    def _mend(self, short_at: int, token: Token | None) -> None:
        if token is not None and token.type in ("TARGETS", "MOVES"):
            first = ("NAME",) if token.type == "MOVES" else ("CONST", "LOCAL")
            if any(self._after([t]) is not None for t in first):
                raise _Way(int(token[1:-1]))
        at = len(self.text) if token is not None and token.type == END else None
        at = self.short.offset(short_at) if at is None else at
        base, begin = self._statement(at)
        words = lexemes(self.text, begin, at, FURTHER)
        error = next((i for i, word in enumerate(words) if word.end > at), len(words) - 1)
        states = self._state.state_stack
        broken = Broken(
            self.text,
            words,
            error,
            self._tables,
            states,
            tuple(getattr(v, "type", "") for v in self._state.value_stack),
            tuple(map(self._begins, self._state.value_stack)),
            base,
            tuple(self._kept),
        )
        full = len(self.findings) >= MOST_FINDINGS
        repair = broken.rest_left_out() if full else best(broken)
        self._say(broken, repair, full=full)
        self._make(broken, repair)

    def _statement(self, at: int) -> tuple[int, int]:
        """How much of the stack stands before the damaged statement, and where that begins."""
        states, values = self._state.state_stack, self._state.value_stack
        base = len(values)
        while base and not STARTS & self._tables.rows[states[base]].keys():
            base -= 1
            if getattr(values[base], "type", "") in CLAUSES:
                break
        for value in values[base:]:
            if (begin := self._begins(value)) >= 0:
                return base, begin
        return base, at

    def _begins(self, value: Any) -> int:
        """Offset of a value of the stack; -1 for one that stands for no text."""
        at = getattr(value, "start_pos", None)
        if at is None and not getattr(getattr(value, "meta", None), "empty", True):
            at = value.meta.start_pos
        return -1 if at is None or getattr(value, "end_pos", None) == at else self.short.offset(at)

    def _say(self, broken: Broken, repair: Repair, *, full: bool) -> None:
        word = broken.words[broken.error]
        if repair.silent or (word.start <= self._quiet_until and not full):
            return
        if full:
            if len(self.findings) == MOST_FINDINGS:
                span = Span(word.start, max(word.end, word.start + 1))
                self.findings.append(self.source.finding(rules.MANY, span, most=MOST_FINDINGS))
            return
        self.findings.append(wording.finding(self.source, broken, repair))

    def _make(self, broken: Broken, repair: Repair) -> None:
        """Changes the stack and goes on behind the damaged place."""
        from lark import Token

        state = self._state
        if repair.kept is not None:
            state.state_stack[:] = repair.kept.states
            state.value_stack[:] = [_as_marked(*value) for value in repair.kept.values]
            self._kept.remove(repair.kept)
        else:
            del state.state_stack[repair.keep + 1 :]
            del state.value_stack[repair.keep :]
        for word in repair.put:
            at = self.short.back(word.start)
            end = at + word.end - word.start
            state.feed_token(Token(word.type, word.text, at, 1, 1, 1, 1, end))
        ended = broken.word.type == END and repair.resume >= broken.word.start
        go_on = len(self.text) if ended else repair.resume
        inside = self.short.run_around(self.text, go_on)
        if inside is not None:
            raise _Way(inside)
        self._lexer.state.line_ctr.char_pos = self.short.back(go_on)
        place = broken.words[broken.error].start
        if broken.error and go_on <= place:
            before = broken.words[broken.error - 1].end
            if "\n" in self.text[before:place]:  # what was missing stands on an earlier line
                place = before
        line = self.text.find("\n", place)
        ends = len(self.text) if line < 0 else line
        self._quiet_until = max(ends, go_on)


STARTS: Final = frozenset({"_FOR", "_RECORD", "_MODULE"})
"""Words that only a whole statement, item or module may begin with."""


def _marked(value: Any) -> tuple[Any, int]:
    """A value of the stack, and how far the list goes that lark may still extend in place."""
    from lark import Tree

    return value, len(value.children) if isinstance(value, Tree) else 0


def _as_marked(value: Any, length: int) -> Any:
    from lark import Tree

    if not isinstance(value, Tree):
        return value
    return Tree(value.data, value.children[:length], value.meta)
