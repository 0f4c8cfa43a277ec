"""MELFA-BASIC IV, V and VI: the language of Mitsubishi Electric's industrial robots."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from assistant.languages.language import Adapted, Language, Part, Precision
from assistant.languages.melfa_basic.dialects import DIALECTS
from assistant.languages.melfa_basic.syntax import CallP, File, Line, String
from assistant.program import japanese
from assistant.program.comparison import Tolerance, compare
from assistant.program.diagnostics import Diagnostic, Severity, has_errors
from assistant.program.program import Program
from assistant.program.text import SourceText

if TYPE_CHECKING:
    from assistant.robots import Robot

__all__ = ["MelfaBasic", "language"]


def language(name: str) -> MelfaBasic:
    """The dialect of that name; raises KeyError if there is none."""
    return MelfaBasic(name)


_CODE: Final = re.compile(
    rb"^[ \t]*[0-9]+[ \t]*(\*|'|[A-Za-z])|^[ \t]*(?:DEF[ \t]+POS[ \t]+)?[A-Za-z_][A-Za-z0-9_]*"
    rb"(?:\([0-9, ]+\))?=\([^)]*\)(?:\([^)]*\))?[ \t]*\r?$"
    rb"|^[ \t]*(\*[A-Za-z]|MOV |MVS |OVRD |SPD |DEF |DLY |IF |FUNCTION |OPEN |SERVO )",
    re.IGNORECASE | re.MULTILINE,
)
_RAPID: Final = re.compile(
    rb"^[ \t]*(%%%|MODULE[ \t]+[A-Za-z]|ENDMODULE|(LOCAL[ \t]+)?PROC[ \t]+[A-Za-z])",
    re.IGNORECASE | re.MULTILINE,
)
_MARK: Final = re.compile(rb"' robot-assistant: (melfa-basic-[456])")


class MelfaBasic(Language[File]):
    """One dialect of MELFA-BASIC."""

    suffixes = (".prg", ".mb4", ".mb5", ".mb6", ".pos")
    encodings = ("ascii", "utf-8-sig", "utf-8", "cp932", japanese.CODEC, "cp1252")
    # half a unit of the second decimal; the angle is that of three Euler angles together
    precision = Precision(position=0.00501, angle=0.0151)
    comment_mark = "'"
    family = "MB"
    fixed = ("MB0", "MB2", "MB5")
    steps = True

    def __init__(self, name: str) -> None:
        self.dialect = DIALECTS[name]
        self.name, self.title = name, self.dialect.title

    def recognises(self, data: bytes) -> bool:
        """Whether it looks like this dialect; a written file says which one it is in."""
        if data.startswith(b"ROBPRG"):
            return True
        head = data[:200_000]
        marked = _MARK.search(head)
        if marked:
            return marked.group(1).decode() == self.name
        if _RAPID.search(head) or not _CODE.search(head):
            return False
        return self.dialect.level == _level(head)

    def encode(self, tree: File) -> bytes:
        """The rendered text in the encoding that it was read in; new text in UTF-8."""
        text = self.render(tree)
        return text.encode(tree.source.encoding if tree.source else "utf-8")

    def parse(self, source: SourceText | str) -> File:
        from assistant.languages.melfa_basic.parser import parse

        return parse(source, self.name)

    def render(self, tree: File) -> str:
        from assistant.languages.melfa_basic.layout.rendering import render

        return render(tree)

    def format(self, tree: File) -> str:
        """The tree's text in the one layout; the text of a broken file as it is."""
        from assistant.languages.melfa_basic.layout.lines import lay_out

        if tree.items is not tree.parsed:
            tree = self.parse(replace(tree.source or SourceText(""), text=self.render(tree)))
        return self.render(tree) if has_errors(tree.findings) else lay_out(tree)

    def renumber(self, tree: File, first: int, step: int) -> File:
        from assistant.languages.melfa_basic.layout.renumbering import renumbered

        return renumbered(tree, first, step)

    def same(self, tree: File, other: File) -> bool:
        """Whether two trees are one; lines are the same in a table and on their own."""
        from assistant.languages.melfa_basic.lift.gathering import gathered

        return tree == other or (
            tree.dialect == other.dialect
            and tuple(gathered(tree.items)) == tuple(gathered(other.items))
        )

    def parts(self, tree: File) -> Iterator[Part]:
        from assistant.languages.melfa_basic.parts import parts

        return parts(tree)

    def lift_trees(self, trees: Sequence[File], robot: Robot | None) -> Program:
        from assistant.languages.melfa_basic.lift.program import lift

        return lift(trees, robot)

    def convert(self, program: Program, robot: Robot | None = None) -> Conversion[File] | None:
        """Between the dialects, on the trees: see `convert`."""
        from assistant.languages.melfa_basic.convert.program import conversion

        names = [self.file_name(program)] * (1 if program.origin else 0)
        return conversion(program, self.name, names, robot)

    def merge(self, tree: File, before: File, after: File) -> File:
        """The tree changed where the built ones differ, if that says what `after` does."""
        from assistant.languages.melfa_basic.layout.merging import merge

        wanted = self.lift_trees((after,), None)
        precision = self.precision
        tolerance = Tolerance(precision.position, precision.angle, precision.number)
        errors = _errors(tree)

        def says(merged: File) -> bool:
            source = merged.source or SourceText("")
            again = self.parse(replace(source, text=self.render(merged)))
            if _errors(again) > errors:
                return False
            return compare(wanted, self.lift_trees((again,), None), tolerance).same

        return merge(tree, before, after, says)

    def adapt(
        self, program: Program, robot: Robot | None = None, *, most_targets: int | None = None
    ) -> Adapted:
        from assistant.languages.melfa_basic.adapt.program import adapt

        return adapt(program, robot, self.name, most_targets)

    def build(self, program: Program, robot: Robot | None = None, unit: str | None = None) -> File:
        from assistant.languages.melfa_basic.lower.program import build

        return build(program, robot, unit, self.name)

    def file_name(self, program: Program, unit: str | None = None) -> str:
        from assistant.languages.melfa_basic.names import naming

        return naming(program, self.dialect).units[unit] + ".prg"

    def called_files(self, tree: File) -> tuple[str, ...]:
        """A call that works out the program's name is left aside."""
        statements = [item.statement for item in tree.items if isinstance(item, Line)]
        named = [s.program for s in statements if isinstance(s, CallP)]
        called = [program.value for program in named if isinstance(program, String)]
        return tuple(f"{name}.prg" for name in dict.fromkeys(called))

    def check(self, trees: Sequence[File]) -> tuple[Diagnostic, ...]:
        from assistant.languages.melfa_basic.checking import check

        return check(trees)


_SIX: Final = re.compile(rb"^[ \t]*[0-9]*[ \t]*(FUNCTION|#INCLUDE|STATIC)\b", re.I | re.M)
_NUMBERED: Final = re.compile(rb"^[ \t]*[0-9]+[ \t]+([A-Za-z]+)", re.MULTILINE)


def _level(head: bytes) -> int:
    """The oldest version that a text may be: IV is numbered and in upper case throughout."""
    if _SIX.search(head):
        return 6
    words = [m.group(1) for m in _NUMBERED.finditer(head)]
    if words and all(word.isupper() for word in words):
        return 4
    positions_only = not words and b"=(" in head and not re.search(rb"(?i)\b(mov|mvs|if)\b", head)
    return 4 if positions_only else 5


def _errors(tree: File) -> int:
    return sum(finding.severity is Severity.ERROR for finding in tree.findings)
