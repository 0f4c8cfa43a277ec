"""From one dialect of MELFA-BASIC to another: the same statements, tree to tree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import Final

from assistant.base.diagnostics import Diagnostic, has_errors
from assistant.base.source_text import SourceText, finding_in, without_ends
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.convert import lines, names, original_names, words
from assistant.languages.melfa_basic.convert.blocks import with_blocks
from assistant.languages.melfa_basic.convert.jumps import Jumps
from assistant.languages.melfa_basic.convert.original_names import OriginalNames
from assistant.languages.melfa_basic.reading.files import recognises
from assistant.languages.melfa_basic.reading.parser import parse
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.text.layout.lines import lay_out
from assistant.languages.melfa_basic.text.rendering import render
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import blocks_of
from assistant.languages.melfa_basic.tree.targets import (
    labels_of,
    labels_written,
    targets_in,
    with_labelled_jumps,
)

DEEPEST_BLOCK: Final = 51
"""Blocks inside one another that are converted; controllers stop at 16."""


@dataclass(frozen=True, slots=True)
class Converted:
    """The files of a program in another dialect.

    trees: in the order of the given ones, parsed from what is written; empty after an error.
    """

    trees: tuple[s.File, ...]
    findings: tuple[Diagnostic, ...] = ()


def convert(trees: Sequence[s.File], to: str) -> Converted:
    """The files of one program, without syntax errors, in another dialect.

    What that dialect cannot say is a finding of severity error.
    """
    dialect = DIALECTS[to]
    files = [_ConvertedFile(tree, dialect) for tree in trees]
    for file in files:
        file.restructure()
    if dialect.level == 4:
        short = names.short_names([file.items for file in files], dialect)
        for file in files:
            file.shorten(short)
    written = tuple(file.written() for file in files)
    findings = tuple(finding for file in files for finding in file.findings)
    return Converted(() if has_errors(findings) else written, findings)


class _ConvertedFile:
    """One file on its way."""

    def __init__(self, tree: s.File, dialect: Dialect) -> None:
        self.tree, self.dialect, self.before = tree, dialect, DIALECTS[tree.dialect]
        self.items: list[s.Item] = list(tree.items)
        self.memory = OriginalNames()
        self.as_steps: set[str] = set()
        self.findings: list[Diagnostic] = []

    def complain(self, item: s.Item, what: str, cure: str) -> None:
        finding = finding_in(
            self.tree.source, rules.NOT_CONVERTED, item.span,
            title=self.dialect.title, what=what, cure=cure,
        )  # fmt: skip
        if finding not in self.findings:
            self.findings.append(finding)

    # --------------------------------------------------------------------------- passes

    @property
    def keeps_numbers(self) -> bool:
        """V and VI take each other's lines as they stand."""
        return 4 not in (self.dialect.level, self.before.level)

    def restructure(self) -> None:
        """Everything but names and numbers."""
        if self.dialect.level == self.before.level:
            return
        if self.keeps_numbers:
            self.sideways()
        elif self.dialect.level == 4:
            self.down()
        else:
            self.up()

    def sideways(self) -> None:
        if self.dialect.level < self.before.level:
            self.items = words.Words(self.dialect, self.memory, self.complain).lines(self.items)

    def down(self) -> None:
        items, self.memory = original_names.take_original_names(self.items)
        items, made = with_labelled_jumps(items)
        self.as_steps = {*made, *self.memory.steps}
        self.memory.steps.clear()
        items = lines.with_lone_labels(lines.without_steps(items))
        for line in words.unreachable_constants(items):
            self.complain(
                line, "a `Const` behind a jump or label", "move it to the head of the program"
            )
        items = lines.with_fitting_comments(items, self.dialect)
        blocks = blocks_of(items)
        if not blocks.sound or any(block.depth > DEEPEST_BLOCK for block in blocks.all):
            self.complain(
                self.items[0],
                "blocks that cross each other or stand too deep",
                "close each in order",
            )
            return
        jumps = Jumps(items, blocks, self.dialect, self.complain)
        items = jumps.lines(range(len(items)))
        self.items = words.Words(self.dialect, self.memory, self.complain).lines(items)

    def up(self) -> None:
        items, self.memory = original_names.take_original_names(self.items)
        items, made = with_labelled_jumps(items)
        self.memory.steps |= dict.fromkeys(made)
        items = with_blocks(lines.without_steps(items), self.dialect)
        items = words.Words(self.dialect, self.memory, self.complain).lines(items)
        items = words.restored(items, self.memory)
        given = {
            "named": {n.upper() for n in names.variables_of(items)},
            "stems": set(),
            "labelled": set(labels_of(items)),
        }
        back = names.Names()
        for kind, there in given.items():
            known = getattr(self.memory, kind)
            free = {k: v for k, v in known.items() if v.upper() not in there}
            setattr(back, kind, free)
            setattr(self.memory, kind, {k: v for k, v in known.items() if k not in free})
        items = names.with_names(items, back, upper=False)
        self.items = original_names.with_heading_names(items, back.named)

    def shorten(self, short: names.Names) -> None:
        """Names that the dialect takes; what they were goes into the heading."""
        if self.before.level == 4:
            return
        # also labels that are nowhere, and only jumps name
        named = (str(target.place) for target in targets_in(self.items))
        for kind, written in (
            ("named", names.variables_of(self.items)),
            ("stems", names.stems_of(self.items)),
            ("labelled", (*named, *labels_written(self.items))),
        ):
            known = {name.upper(): name for name in written}
            made = getattr(short, kind).items()
            getattr(self.memory, kind).update((new, known[n]) for n, new in made if n in known)
        self.items = names.with_names(self.items, short, upper=self.dialect.upper)
        self.items = original_names.with_heading_names(self.items, short.named)

    # -------------------------------------------------------------------------- writing

    def written(self) -> s.File:
        """The tree of the text that is written."""
        source = self.tree.source
        if self.keeps_numbers:
            items = tuple(
                original_names.put_original_names(self.items, self.memory, self.dialect.name)
            )
            changed = replace(self.tree, dialect=self.dialect.name, items=items)
            return _read_back(render(changed), self.dialect, self.tree)
        text = self.numbered_text(marked=False)
        encoded = text.encode(source.encoding if source else "utf-8", "replace")
        others = (d for d in DIALECTS.values() if d.name != self.dialect.name)
        if any(recognises(encoded, other.level) for other in others):
            text = self.numbered_text(marked=True)
        return _read_back(text, self.dialect, self.tree)

    def numbered_text(self, *, marked: bool) -> str:
        items = original_names.put_original_names(
            self.items, self.memory, self.dialect.name, marked=marked
        )
        numbered = lines.with_steps(items, self.dialect.step, self.as_steps)
        if numbered is None:
            self.complain(self.items[0], "a program of so many lines", "split it into programs")
            return ""
        self.measure(numbered)
        text = render(s.File(self.dialect.name, tuple(numbered)))
        tree = parse(text, self.dialect.name)
        return text if has_errors(tree.findings) else lay_out(tree)

    def measure(self, items: Sequence[s.Item]) -> None:
        """Lines that are too long for the dialect."""
        for line in items:
            if not isinstance(line, s.Line):
                continue
            length = len(printer.line(line, self.dialect.upper).encode("utf-8"))
            if length > self.dialect.line:
                self.complain(
                    line,
                    f"a line of {length} bytes, more than {self.dialect.line}",
                    "split the statement, or write its comment on a line of its own",
                )


def _read_back(text: str, dialect: Dialect, tree: s.File) -> s.File:
    """The tree of a text as the file that it will be. tree: that it was made from."""
    source = tree.source
    plain = without_ends(text)
    if source is None:
        return parse(SourceText(plain), dialect.name)
    plain = plain.replace("\r\n", "\n").replace("\n", source.newline)
    path = None if source.path is None else PurePath(source.path).stem + ".prg"
    return parse(SourceText(plain, path, source.encoding, source.newline), dialect.name)
