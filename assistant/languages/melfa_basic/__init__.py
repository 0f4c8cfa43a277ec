"""MELFA-BASIC IV, V and VI: the language of Mitsubishi Electric's industrial robots."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from pathlib import PurePath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from assistant.base import source_text
from assistant.base.diagnostics import Diagnostic, Severity, Unreadable, has_errors
from assistant.base.source_text import SourceText
from assistant.languages.language import Language
from assistant.languages.language_types import (
    ARITHMETIC,
    Adapted,
    Conversion,
    Frames,
    Part,
    Precision,
    Setting,
)
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.reading.files import TOKENISED
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tables.variables import (
    DEDICATED_SIGNALS,
    REGISTER_NUMBERS,
    SIGNAL_NUMBERS,
)
from assistant.lazy import offered
from assistant.program.expressions import Effect, VendorTextKind
from assistant.program.program import Program

if TYPE_CHECKING:
    from pathlib import Path as FilePath

    from lark import Lark

    from assistant.base.arrays import Rows
    from assistant.languages.language_types import ControllerConfiguration, Outline, Texts
    from assistant.languages.melfa_basic.reading.editing import EditableMelfaBasic
    from assistant.languages.melfa_basic.tree import syntax
    from assistant.languages.melfa_basic.tree.syntax import File
    from assistant.program.undeclared_names import Supplied, Wanted, WantedKind
    from assistant.robots import Robot

__all__ = ["MelfaBasic", "language", "syntax"]


def language(name: str) -> MelfaBasic:
    """Return the dialect of that name; raises KeyError if the name is unknown."""
    return MelfaBasic(name)


_SETTINGS: Final = {
    "name-length": Setting(
        8, 255, "say how many characters of a variable's name or a label the controller takes"
    ),
    "step-length": Setting(
        40, 1000, "say how many bytes of a line, without its line end, the controller takes"
    ),
}
_SETTINGS_OF: Final = {"name-length": "longest", "step-length": "line"}
"""Setting of a project → what it is in the table of dialects."""

__getattr__ = offered(__name__, {"syntax": ("assistant.languages.melfa_basic.tree.syntax", None)})


def _surroundings(program: FilePath, read: Texts) -> ControllerConfiguration:
    from assistant.languages.melfa_basic.reading.parameters import surroundings

    return surroundings(program, read)


class MelfaBasic(Language["File"]):
    """One dialect of MELFA-BASIC."""

    suffixes = (".prg", ".mb4", ".mb5", ".mb6", ".pos")
    encodings = source_text.CODE_PAGES_READ
    begins = TOKENISED
    # half a unit of the second decimal; the angle is that of three Euler angles together
    precision = Precision(position=0.00501, angle=0.0151)
    comment_mark = "'"
    joint_words = re.compile(r"(?i)\bj")  # which the names of joint variables begin with
    family = "MB"
    family_title = "MELFA-BASIC"
    fixed = ("MB0", "MB107", "MB2", "MB5")
    restated = MappingProxyType({"CK101": "MB703", "CK102": "MB703"})
    steps = True
    surroundings = staticmethod(_surroundings)
    called_by_file = True
    joint_percent = True
    tool_loads = False
    dedicated_signals = DEDICATED_SIGNALS
    signal_numbers = SIGNAL_NUMBERS
    register_numbers = REGISTER_NUMBERS
    frames: Frames = "base"
    table = "melfa-basic"
    settings = MappingProxyType({**_SETTINGS, **ARITHMETIC})

    def __init__(self, name: str) -> None:
        self.dialect = DIALECTS[name]
        self.name, self.title = name, self.dialect.title
        level = self.dialect.level
        self.older = tuple(key for key, other in DIALECTS.items() if other.level < level)

    def outline(self) -> Outline:
        from assistant.languages.melfa_basic.text.header import OUTLINE

        return OUTLINE

    def with_frames(self, frames: Frames) -> MelfaBasic:
        made = copy(self)
        made.frames = frames
        return made

    def configured(self, settings: Mapping[str, int | str]) -> MelfaBasic:
        made = super().configured(settings)
        limits: dict[str, Any] = {
            _SETTINGS_OF[key]: value for key, value in settings.items() if key in _SETTINGS_OF
        }
        made.dialect = replace(self.dialect, **limits)
        return made

    @property
    def _products(self) -> bool:
        return self.frames == "product"

    def recognises(self, data: bytes, suffix: str = "") -> bool:
        """True if the data looks like this dialect; a written file states its dialect."""
        from assistant.languages.melfa_basic.reading.files import recognises

        return recognises(data, self.dialect.level, suffix)

    def decode(self, data: bytes, path: str | None = None) -> SourceText:
        if data.startswith(TOKENISED):
            raise Unreadable(rules.TOKENISED(path=path))
        return source_text.decode_code_page(data, path)

    def encode(self, tree: File) -> bytes:
        """The rendered text in the encoding that it was read in, new text as controllers take it.

        Raises Refused where a character is not in that encoding.
        """
        return source_text.encode_code_page(self.render(tree), tree.source)

    def parse(self, source: SourceText | str) -> File:
        from assistant.languages.melfa_basic.reading.parser import parse

        return parse(source, self.name)

    def by_lark(self) -> Lark:
        from assistant.languages.melfa_basic.reading.line import by_lark

        return by_lark()

    def runs(self, tree: File) -> Iterator[Rows]:
        from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows

        for item in tree.items:
            if not isinstance(item, MoveRows | PositionRows):
                continue
            if item.span is not None and item.places is not None:
                yield item.places + item.span.start

    def mended(self, tree: File) -> File | None:
        from assistant.languages.melfa_basic.reading.parser import mended

        return mended(tree, self.name)

    def render(self, tree: File) -> str:
        from assistant.languages.melfa_basic.text.layout import render

        return render(tree)

    def format(self, tree: File) -> str:
        """The tree's text in the one layout; the text of a broken file as it is."""
        from assistant.languages.melfa_basic.text.layout import lay_out

        if tree.items is not tree.parsed:
            # A changed tree is read again, so that its lines have places in its new text.
            tree = self.parse(replace(tree.source or SourceText(""), text=self.render(tree)))
        return self.render(tree) if has_errors(tree.findings) else lay_out(tree)

    def renumber(self, tree: File, first: int, step: int) -> File:
        from assistant.languages.melfa_basic.text.merging import renumbered

        return renumbered(tree, first, step)

    def same(self, tree: File, other: File) -> bool:
        """True if two trees are equal; a line in a table equals the same line outside it."""
        from assistant.languages.melfa_basic.tree.line_tables import gathered

        # Tables may be cut in other places, so both trees are gathered anew.
        return tree == other or (
            tree.dialect == other.dialect
            and tuple(gathered(tree.items)) == tuple(gathered(other.items))
        )

    def editable(self) -> EditableMelfaBasic:
        from assistant.languages.melfa_basic.reading.editing import EditableMelfaBasic

        return EditableMelfaBasic(self.dialect)

    def parts(self, tree: File) -> Iterator[Part]:
        from assistant.languages.melfa_basic.tree.walk import report_parts

        return report_parts(tree)

    def effect(self, text: str, kind: VendorTextKind) -> Effect:
        from assistant.languages.melfa_basic.text.effects import of_text

        return of_text(text, kind)

    def not_there(self, program: Program) -> Iterator[str]:
        from assistant.languages.melfa_basic.lower.names import counted

        there = () if program.interface is None else program.interface.there
        named = {name for *_, name in counted(program, self.dialect, self._products)}
        given = (*program.tools, *program.frames)
        return (name for name in given if name.lower() in there and name not in named)

    def wanted(self, trees: Sequence[File]) -> tuple[Wanted, ...]:
        from assistant.languages.melfa_basic.checks.wanted import wanted
        from assistant.languages.melfa_basic.text.header import with_stated_parameters

        return wanted([with_stated_parameters(tree) for tree in trees])

    def wanted_of(
        self, trees: Sequence[File], values: Container[tuple[WantedKind, str]]
    ) -> Iterator[Wanted]:
        """Also the tool and the base that are kept for a program which sets none."""
        from assistant.languages.melfa_basic.checks.wanted import kept

        yield from super().wanted_of(trees, values)
        yield from (one for one in kept(trees) if (one.kind, one.name.lower()) in values)

    def with_supplied(self, trees: Sequence[File], given: Supplied, path: str) -> list[File]:
        from assistant.languages.melfa_basic.lower.supplied_values import with_supplied

        return with_supplied(trees, given, self.name, path)

    def lift_trees(self, trees: Sequence[File], robot: Robot | None) -> Program:
        from assistant.languages.melfa_basic.lift.program import lift
        from assistant.languages.melfa_basic.text.header import with_stated_parameters

        return lift([with_stated_parameters(tree) for tree in trees], robot)

    def exported(
        self,
        program: Program,
        to: Language[Any],
        arm: Robot | None,  # noqa: ARG002
    ) -> Adapted:
        from assistant.languages.melfa_basic.lift.for_other_vendor import exported

        return Adapted(program) if to.family == self.family else exported(program)

    def convert(self, program: Program, robot: Robot | None = None) -> Conversion[File] | None:
        """Between the dialects, on the trees: see `convert`."""
        from assistant.languages.melfa_basic.convert.conversion import conversion
        from assistant.languages.melfa_basic.lower.supplied_values import without_kept

        if program.origin is not None and program.origin.language in DIALECTS:
            program = without_kept(program, MelfaBasic(program.origin.language).lift)
        names = [self.file_name(program)] * (1 if program.origin else 0)
        return conversion(program, self.name, names, robot)

    def assumed(self, program: Program, to: str) -> Iterator[Diagnostic]:
        from assistant.languages.melfa_basic.lower.controller_defaults import assumed

        return assumed(program, to)

    def merge(
        self, tree: File, before: File, after: File, program: Program, robot: Robot | None
    ) -> File:
        """The tree changed where the built ones differ, if that says what the program does.

        Also if it says what the program is once adapted, or what `after` is read as.
        """
        from assistant.languages.melfa_basic.text.merging import merge
        from assistant.program.comparison import Tolerance, compare, with_labels_in_order

        asked = (self.lift_trees((after,), robot), program, self.adapt(program, robot).program)
        wanted = [with_labels_in_order(one) for one in asked]
        precision = self.precision
        tolerance = Tolerance(precision.position, precision.angle, precision.number)
        errors = _errors(tree)

        def says(merged: File) -> bool:
            source = merged.source or SourceText("")
            again = self.parse(replace(source, text=self.render(merged)))
            if _errors(again) > errors:
                return False
            lifted = with_labels_in_order(self.lift_trees((again,), robot))
            return any(compare(one, lifted, tolerance).same for one in wanted)

        return merge(tree, before, after, says)

    def adapt(
        self, program: Program, robot: Robot | None = None, *, most_targets: int | None = None
    ) -> Adapted:
        from assistant.languages.melfa_basic.lower.adaptation import adapt

        return adapt(program, robot, self.name, most_targets, self._products)

    def build(self, program: Program, robot: Robot | None = None, unit: str | None = None) -> File:
        from assistant.languages.melfa_basic.lower.program import build

        return build(program, robot, unit, self.name, self._products)

    def file_name(self, program: Program, unit: str | None = None) -> str:
        from assistant.languages.melfa_basic.lower.names import unit_names

        return unit_names(program)[unit] + ".prg"

    def spelled(self, program: Program) -> Callable[[str, str, str], str]:
        from assistant.languages.melfa_basic.lower.names import spelled

        return spelled(program, self.dialect)

    def is_copy(self, path: FilePath) -> bool:
        from assistant.languages.melfa_basic.reading.parameters import is_copy

        return is_copy(path)

    def called_files(self, tree: File) -> tuple[str, ...]:
        """A call that works out the program's name is left aside."""
        from assistant.languages.melfa_basic.tree.walk import awaited_programs

        return tuple(dict.fromkeys(f"{name}.prg" for _, name in awaited_programs(tree)))

    def file_called(self, name: str, tree: File, there: Container[str]) -> str | None:
        """Any suffix of a program will do, that of the calling file before the others."""
        from assistant.languages.melfa_basic.tree.walk import SUFFIXES, program_key

        path = PurePath((tree.source and tree.source.path) or "")
        stem = program_key(name.removesuffix(".prg")).lower()
        # A program may call `SUB` where the folder has `SUB.MB5`.
        suffixes = dict.fromkeys((path.suffix.lower(), *(one.lower() for one in SUFFIXES)))
        return next((stem + one for one in suffixes if stem + one in there), None)

    def check(self, trees: Sequence[File]) -> tuple[Diagnostic, ...]:
        from assistant.languages.melfa_basic.checks import check

        return check(trees, self.dialect)

    def missing(self, trees: Sequence[File]) -> Iterator[Diagnostic]:
        from assistant.languages.melfa_basic.checks import missing

        return missing(trees, self.dialect)

    def companions(self, tree: File) -> tuple[str, ...]:
        """Programs that a file runs or loads in other slots, and those that it includes."""
        from assistant.languages.melfa_basic.tree.walk import named_programs

        return tuple(dict.fromkeys(f"{name}.prg" for _, name, _ in named_programs(tree)))


def _errors(tree: File) -> int:
    return sum(finding.severity is Severity.ERROR for finding in tree.findings)
