"""The files of a program, taken apart: heading, code and positions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from assistant.languages.melfa_basic.lift.settings.held import ALL_SETTINGS, setting_number
from assistant.languages.melfa_basic.lift.settings.interrupts import calls_on_interrupt
from assistant.languages.melfa_basic.lift.statements.waits import comment_text
from assistant.languages.melfa_basic.lift.structure.answers import Answers, without_trampolines
from assistant.languages.melfa_basic.lift.structure.order import in_order, separated
from assistant.languages.melfa_basic.lift.structure.regions import called_labels, target_name
from assistant.languages.melfa_basic.text import header as headers
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of
from assistant.languages.melfa_basic.tree.positions import Positions
from assistant.languages.melfa_basic.tree.targets import exits_of, with_labelled_jumps
from assistant.languages.melfa_basic.tree.walk import nodes, program_stem, statements_in
from assistant.program.program import identifier


class SourceFile:
    """A tree, taken apart. own: it was written here, and its heading says what it means.

    answers: what its interrupts call; the lines that do so are not among its code.
    """

    def __init__(self, tree: s.File) -> None:
        self.tree = tree
        self.header, self.comments, code = _split_file(tree)
        self.own = self.header.program is not None
        self.answers: Answers = {}
        if self.own:
            self.code, self.answers = without_trampolines(code)
        else:
            self.code = separated(in_order(_with_lone_labels(with_labelled_jumps(code)[0])))
        self.positions = Positions(tree)

    def touched(self) -> frozenset[int]:
        """Settings that the file makes itself."""
        made = map(setting_number, self._nodes())
        return frozenset(number for number in made if number is not None)

    def interrupts(self) -> bool:
        """Whether it has interrupts that call."""
        return any(
            calls_on_interrupt(statement)
            for item in self.code
            for statement in statements_in(item.statement)
        )

    def called(self) -> frozenset[str | None]:
        """Programs that it calls, in upper case; None for one whose name is worked out."""
        named = (node.program for node in self._nodes() if isinstance(node, s.CallP))
        return frozenset(
            identifier(program_stem(one.value)).upper() if isinstance(one, s.String) else None
            for one in named
        )

    def _nodes(self) -> Iterator[Any]:
        for item in self.code:
            yield from nodes(item.statement)


def changed_settings(files: Mapping[str, SourceFile]) -> dict[str, frozenset[int]]:
    """Settings that each program changes, by name in upper case, with what it calls."""
    found = {name: file.touched() for name, file in files.items()}
    while True:
        before = dict(found)
        for name, file in files.items():
            for other in file.called():
                found[name] |= found.get(other or "", ALL_SETTINGS)
        if found == before:
            return found


def settings_of_interrupts(
    files: Mapping[str, SourceFile], touched: Mapping[str, frozenset[int]]
) -> dict[str, frozenset[int]]:
    """Settings that interrupts of its callers may change while a program runs, by name.

    touched: what each program changes.
    """
    found = dict.fromkeys(files, frozenset[int]())
    running = {name: touched[name] for name, file in files.items() if file.interrupts()}
    before = None
    while running and found != before:
        before = dict(found)
        for name, file in files.items():
            called = file.called()
            for other in files if None in called else found.keys() & called:
                found[other] |= found[name] | running.get(name, frozenset())
    return found


def _with_lone_labels(code: list[s.Entry]) -> list[s.Entry]:
    """The code with the labels of subroutines in lines of their own: `*OPEN:HOpen 1` is both."""
    wanted = called_labels(code) | {
        target_name(to) for item in code for to, _ in exits_of(statement_of(item)).handlers
    }
    made: list[s.Entry] = []
    for item in code:
        if isinstance(item, s.Line) and item.statement and (item.label or "").upper() in wanted:
            made.append(s.Line(label=item.label, number=item.number, span=item.span))
            item = replace(item, label=None)
        made.append(item)
    return made


def _split_file(tree: s.File) -> tuple[Header, tuple[str, ...], list[s.Entry]]:
    """The heading, the comments above it, and the code."""
    code = tree.code
    texts: list[str] = []
    for item in code:
        if not isinstance(item, s.Line) or item.statement or item.label or not item.comment:
            break
        texts.append(comment_text(item.comment))
    if (bounds := headers.bounds(texts)) is not None:
        start, end = bounds
        head = headers.read(texts[start + 1 : end])
        return head, tuple(texts[:start]), code[end + 1 :]
    return Header(), tuple(texts), code[len(texts) :]
