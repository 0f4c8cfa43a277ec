"""ABB RAPID for RobotWare 5 to 7."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path as FilePath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, has_errors
from assistant.base.source_text import SourceText
from assistant.languages.language import Language
from assistant.languages.language_types import ARITHMETIC, Adapted, Part, Precision
from assistant.languages.rapid.reading.files import LOADING, surroundings, task_folder
from assistant.lazy import offered
from assistant.program.expressions import Effect, VendorTextKind
from assistant.program.motion import Blend, Speed
from assistant.program.program import Program

if TYPE_CHECKING:
    from lark import Lark

    from assistant.base.arrays import Rows
    from assistant.languages.language_types import Outline
    from assistant.languages.rapid.reading.editing import EditableRapid
    from assistant.languages.rapid.tree import syntax
    from assistant.languages.rapid.tree.syntax import File
    from assistant.program.undeclared_names import Supplied, Wanted
    from assistant.robots import Robot

__all__ = ["Rapid", "language", "syntax"]


def language(name: str) -> Rapid:
    """The language of that name; KeyError for any but `rapid`."""
    if name != Rapid.name:
        raise KeyError(name)
    return Rapid()


__getattr__ = offered(__name__, {"syntax": ("assistant.languages.rapid.tree.syntax", None)})


class Rapid(Language["File"]):
    """RAPID: modules of data and routines."""

    name = "rapid"
    title = "ABB RAPID"
    suffixes = (".mod", ".modx", ".sys", ".sysx", ".prg", ".pgf")
    # Tried in order: Latin-1 comes last, as it takes any bytes.
    encodings = ("utf-8-sig", "utf-8", "cp1252", "latin-1")
    precision = Precision(position=6e-5, angle=1e-6)
    comment_mark = "!"
    joint_words = re.compile(r"(?i)joint|absj")
    family = "RA"
    family_title = "RAPID"
    fixed = ("RA1", "RA3")
    restated = MappingProxyType(
        {"CK101": "RA459", "CK102": "RA460", "CK103": "RA460", "CK104": "RA461", "CK331": "RA469"}
    )
    table = "rapid"
    settings = ARITHMETIC
    loading = LOADING
    surroundings = staticmethod(surroundings)

    def recognises(self, data: bytes, suffix: str = "") -> bool:  # noqa: ARG002
        from assistant.languages.rapid.reading.files import recognises

        return recognises(data)

    def decode(self, data: bytes, path: str | None = None) -> SourceText:
        from assistant.languages.rapid.reading.files import read_text

        return read_text(data, path, self.encodings)

    def parse(self, source: SourceText | str) -> File:
        from assistant.languages.rapid.reading.parser import parse

        return parse(source)

    def by_lark(self) -> Lark:
        from assistant.languages.rapid.reading.scanner import by_lark

        return by_lark()

    def runs(self, tree: File) -> Iterator[Rows]:
        from assistant.languages.rapid.tree.syntax import RunNode
        from assistant.languages.rapid.tree.walk import nodes

        for node in nodes(tree.parts):
            if isinstance(node, RunNode) and node.lines is not None:
                yield node.lines

    def shell(self, tree: File, *, data: bool) -> File:
        from assistant.languages.rapid.tree.walk import shell

        return shell(tree, data=data)

    def render(self, tree: File) -> str:
        if tree.origin is None:
            from assistant.languages.rapid.text.printer import print_file

            return print_file(tree)
        from assistant.languages.rapid.text.changes import render

        return render(tree, tree.origin)

    def format(self, tree: File) -> str:
        """The tree's text in the one layout; the text of a broken file as it is."""
        text = self.render(tree)
        # A printed tree has the layout already; laying out a broken text could move what nobody
        # understood.
        if tree.origin is None or has_errors(tree.findings) or not tree.parts:
            return text
        from assistant.languages.rapid.text.layout import lay_out

        return lay_out(text)

    def outline(self) -> Outline:
        from assistant.languages.rapid.text.header import OUTLINE

        return OUTLINE

    def editable(self) -> EditableRapid:
        from assistant.languages.rapid.reading.editing import EditableRapid

        return EditableRapid()

    def parts(self, tree: File) -> Iterator[Part]:
        from assistant.languages.rapid.tree.walk import source_parts

        return source_parts(tree)

    def wanted(self, trees: Sequence[File]) -> tuple[Wanted, ...]:
        from assistant.languages.rapid.checks.missing_names import wanted
        from assistant.languages.rapid.text.header import with_controller_data

        return wanted(with_controller_data(trees))

    def hand_output(self, hand: int) -> str:
        from assistant.languages.rapid.tables.signals import hand_signal

        return hand_signal(hand)

    def supplied(self, given: Supplied, trees: Sequence[File]) -> str:
        from assistant.languages.rapid.lower.cell_module import cell_module_text

        return cell_module_text(given, [one.name.lower() for tree in trees for one in tree.modules])

    def with_supplied(self, trees: Sequence[File], given: Supplied, path: str) -> list[File]:
        from assistant.languages.rapid.lower.cell_module import with_cell_values

        changed, left = with_cell_values(trees, given)
        return super().with_supplied(changed, left, path) if left else changed

    def kept_secret(self, tree: File) -> str:
        return next((_NOT_SHOWN for one in tree.modules if _NOT_SHOWN in one.attributes), "")

    def shared_names(self, tree: File) -> Iterator[tuple[str, str]]:
        from assistant.languages.rapid.tree.walk import shared_names

        return shared_names(tree)

    def mentions(self, tree: File) -> frozenset[str]:
        from assistant.languages.language_types import words_of
        from assistant.languages.rapid.tree.walk import own_names

        text = "" if tree.origin is None else tree.origin.source.text
        return words_of(text, self.comment_mark) - frozenset(own_names(tree))

    def effect(self, text: str, kind: VendorTextKind) -> Effect:
        from assistant.languages.rapid.text.verbatim import effect_of_text

        return effect_of_text(text, kind)

    def said(self, text: str) -> Iterator[tuple[str, str]]:
        from assistant.languages.rapid.text.changes import module_pieces

        return module_pieces(text)

    def declares(self, text: str) -> str:
        from assistant.languages.rapid.text.verbatim import declares

        return declares(text)

    def lift_trees(self, trees: Sequence[File], robot: Robot | None) -> Program:  # noqa: ARG002
        from assistant.languages.rapid.checks.single_rows import with_single_rows
        from assistant.languages.rapid.lift.program import lift
        from assistant.languages.rapid.text.header import with_controller_data

        return lift(with_single_rows(with_controller_data(trees), unknown=False))

    def told(self, program: Program, to: Language[Any]) -> Program:
        from assistant.languages.rapid.lift.for_other_vendor import with_flat_data

        return program if to.family == self.family else with_flat_data(program).program

    def exported(self, program: Program, to: Language[Any], arm: Robot | None) -> Adapted:
        from assistant.languages.rapid.lift.for_other_vendor import for_other_vendor

        return Adapted(program) if to.family == self.family else for_other_vendor(program, arm)

    def merge(
        self,
        tree: File,
        before: File,
        after: File,
        program: Program,
        robot: Robot | None,  # noqa: ARG002
    ) -> File:
        """Merge a changed program into the tree of its source text. Data that sets up trigger moves
        can be anywhere, so a program with triggers is lifted again and compared.
        """
        from assistant.languages.rapid.text.changes import merge
        from assistant.program.analysis.io_use import sets_on_way
        from assistant.program.comparison import compare

        merged, origin = merge(tree, before, after), program.origin
        if not sets_on_way(program) and (origin is None or not sets_on_way(origin.lifted)):
            return merged
        # The merged text counts only if it is the same program as the one that is built anew.
        wanted, made = (self.lift_trees((one,), None) for one in (after, merged))
        return merged if compare(wanted, made).same else after

    def adapt(
        self,
        program: Program,
        robot: Robot | None = None,  # noqa: ARG002
        *,
        most_targets: int | None = None,
    ) -> Adapted:
        from assistant.languages.rapid.lower.legalisation import adapt

        return adapt(program, most_targets)

    def declares_motion(self, value: Speed | Blend) -> bool:
        from assistant.languages.rapid.tables.equivalents import BLENDS, SPEEDS

        if isinstance(value, Speed):
            return SPEEDS.name(value) not in SPEEDS.predefined
        return BLENDS.name(value) not in BLENDS.predefined

    def build(
        self,
        program: Program,
        robot: Robot | None = None,  # noqa: ARG002
        unit: str | None = None,
    ) -> File:
        from assistant.languages.rapid.lower.program import build

        return build(program, unit)

    def file_name(self, program: Program, unit: str | None = None) -> str:
        from assistant.languages.rapid.lower.program import module_name

        return module_name(program, unit) + ".mod"

    def spelled(self, program: Program) -> Callable[[str, str, str], str]:
        from assistant.languages.rapid.lower.expressions import NAMES

        return NAMES.naming(program).spelled

    def called_files(self, tree: File) -> tuple[str, ...]:
        from assistant.languages.rapid.checks import loaded_files
        from assistant.languages.rapid.reading.files import is_list, listed

        text = "" if tree.origin is None else tree.origin.source.text
        return listed(text) if is_list(text) else loaded_files(tree)

    def check(self, trees: Sequence[File]) -> tuple[Diagnostic, ...]:
        from assistant.languages.rapid.checks import check
        from assistant.languages.rapid.text.header import with_controller_data

        return check(with_controller_data(trees))

    def program_of(self, path: FilePath) -> FilePath:
        return task_folder(path)


_NOT_SHOWN: Final = "NOVIEW"
"""Attribute of modules that can only be run."""
