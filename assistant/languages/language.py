"""The interface of a vendor language.

`Language` is the base class of every language and dialect: text, tree and neutral program, both
ways. Its methods that are stages of a command run within the time budget of that stage, which a
subclass gets without asking for it.
"""

from __future__ import annotations

import abc
import re
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import wraps
from pathlib import Path as FilePath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Generic, Self

from assistant.base.arrays import Rows
from assistant.base.budgets import (
    ADAPTING,
    BUILDING,
    CHECKING,
    LAYING_OUT,
    LIFTING,
    READING,
    Stage,
    within,
)
from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.base.source_text import SourceText, decode, encode, lines_of, read_bytes
from assistant.languages.language_types import (
    ARITHMETIC,
    Adapted,
    Choice,
    Conversion,
    Frames,
    Part,
    Precision,
    Sampling,
    Setting,
    Surroundings,
    T,
    TaskLoading,
)
from assistant.program.expressions import Effect, VendorTextKind, unknown_effect
from assistant.program.program import Origin, Program

if TYPE_CHECKING:
    from lark import Lark

    from assistant.languages.language_types import Outline
    from assistant.program.editor_support import Editable
    from assistant.program.motion import Blend, Speed
    from assistant.program.undeclared_names import Supplied, Wanted, WantedKind
    from assistant.robots import Robot


_SizeMeasure = Callable[[Any], tuple[str | None, int]]
"""The place and the size of an input: of a text, a tree, some trees, or a program."""


def text_size(text: SourceText | str) -> tuple[str | None, int]:
    return (None, len(text)) if isinstance(text, str) else (text.path, len(text.text))


def trees_size(trees: Any) -> tuple[str | None, int]:
    """Return path and size of the texts that trees were read from; a built tree has no text."""
    listed = trees if isinstance(trees, Sequence) else (trees,)
    texts = [tree.source for tree in listed if tree.source is not None]
    return texts[0].path if texts else None, sum(len(text.text) for text in texts)


def program_size(program: Program) -> tuple[str | None, int]:
    return None, program.size()


_BUDGETED: Final[dict[str, tuple[Stage, _SizeMeasure]]] = {
    "parse": (READING, text_size),
    "check": (CHECKING, trees_size),
    "lift_trees": (LIFTING, trees_size),
    "format": (LAYING_OUT, trees_size),
    "renumber": (LAYING_OUT, trees_size),
    "convert": (ADAPTING, program_size),
    "exported": (ADAPTING, program_size),
    "adapt": (ADAPTING, program_size),
    "build": (BUILDING, program_size),
}
"""Methods of a language → the stage that they are, and how their first argument is measured."""


def budgeted(methods: dict[str, Any]) -> dict[str, Callable[..., Any]]:
    """Those of the methods that are stages, within their budgets."""
    return {
        name: _with_budget(methods[name], stage, measure)
        for name, (stage, measure) in _BUDGETED.items()
        # An abstract method has no work to bound; its implementations are wrapped themselves.
        if name in methods and not getattr(methods[name], "__isabstractmethod__", False)
    }


def _with_budget(
    method: Callable[..., Any], stage: Stage, measure: _SizeMeasure
) -> Callable[..., Any]:
    @wraps(method)
    def run(self: Any, first: Any, *rest: Any, **named: Any) -> Any:
        place, size = measure(first)
        with within(stage, place, size):
            return method(self, first, *rest, **named)

    return run


class Language(abc.ABC, Generic[T]):
    """One vendor language (or one dialect of it) between text, tree and pseudo-program.

    `parse(render(tree)) == tree` and `render(parse(text)) == text` hold for every text.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    encodings: tuple[str, ...]
    begins: bytes = b""
    """First bytes of its files that are not text, empty without such files."""
    precision: Precision
    comment_mark: str
    """Begins a comment to the end of the line, outside of a string in double quotes."""
    joint_words: re.Pattern[str]
    """Is found in every text of the language that speaks of joint angles, and in few others."""
    family: str
    """The two letters that the codes of its findings begin with."""
    family_title: str = ""
    """Common name of the language, for any version or maker; empty if that is its title."""
    fixed: tuple[str, ...]
    """First letters of codes whose errors no project may turn down: unreadable, inexpressible."""
    restated: Mapping[str, str] = MappingProxyType({})
    """Code of a check of any program → that of the rule which tells the same of this language."""
    table: str = ""
    """The table of a project's file that holds its settings."""
    settings: Mapping[str, Setting | Choice] = MappingProxyType({})
    """Settings that a project may state about its controllers, by key."""
    stated: Mapping[str, str] = MappingProxyType({})
    """Choices of ARITHMETIC that the project states."""
    joint_percent: bool = False
    """True if joint moves state percents of the axes' speeds; else mm/s and degrees/s."""
    tool_loads: bool = True
    """True if programs state the loads of tools; else the controller's parameters have them."""
    dedicated_signals: Mapping[str, Mapping[int, str]] = MappingProxyType({})
    """By `input` and `output`: numbers that its controllers use themselves when they are new."""
    signal_numbers: str = ""
    """The numbers that its controllers have for signals that are not analog, for a cell file."""
    register_numbers: str = ""
    """Those that they have for analog signals."""
    called_by_file: bool = False
    """True if other programs call this one by its file name, and see nothing else of it."""
    steps: bool = False
    """True if its lines have step numbers."""
    sampling: Sampling = "samples"
    """Part of a long text that lark parses in a proof."""
    older: tuple[str, ...] = ()
    """Names of the languages whose programs a controller of this one takes as well."""

    loading: TaskLoading | None = None
    surroundings: Surroundings | None = None
    """Reader of the files of one task, None if each file is a separate program."""

    def __init_subclass__(cls) -> None:
        """Run each method that takes time or memory within a budget, in every language."""
        super().__init_subclass__()
        # Each class wraps only what it defines itself, so an inherited stage is not wrapped twice.
        for name, method in budgeted({**vars(cls)}).items():
            setattr(cls, name, method)

    def read(self, path: str | FilePath) -> SourceText:
        """A file decoded as this vendor's are; raises Unreadable."""
        return self.decode(read_bytes(path), str(path))

    def decode(self, data: bytes, path: str | None = None) -> SourceText:
        return decode(data, path, self.encodings)

    def recognises(self, data: bytes, suffix: str = "") -> bool:  # noqa: ARG002
        """True if a file's bytes look like this language.

        suffix: of its name in lower case with the dot, which may distinguish dialects.
        """
        return suffix in self.suffixes

    def encode(self, tree: T) -> bytes:
        """The rendered tree as the controller wants its bytes.

        In the encoding that it was read in, ASCII for a new one. Raises Refused where a character
        is not in that encoding.
        """
        return encode(replace(tree.source or SourceText(""), text=self.render(tree)))

    @abc.abstractmethod
    def parse(self, source: SourceText | str) -> T:
        """The typed tree; never raises on bad text, the tree's `findings` say what is wrong.

        Raises Refused for what reaches the budget of reading, as other stages do with theirs.
        """

    def by_lark(self) -> Lark | None:
        """Lark's own parser for complete texts (`start`); None if no grammar describes them."""
        return None

    def with_sampling(self, sampling: Sampling) -> Self:
        """Return the language with proofs that parse samples of a long text with lark, or all."""
        # Languages are shared by name, so a setting goes into a copy.
        made = copy(self)
        made.sampling = sampling
        return made

    def runs(self, tree: T) -> Iterator[Rows]:  # noqa: ARG002
        """Offsets (n, 2) at which each row starts and ends, for each run of like rows of a tree.

        A text stays a text of the language if some rows of a run are removed, but not all.
        """
        yield from ()

    def shell(self, tree: T, *, data: bool) -> T | None:  # noqa: ARG002
        """Return a tree with procedures that do nothing, to stand for it beside another unit.

        data: with its declarations of data as well. None if units of this language are proven
        together only.
        """
        return None

    def mended(self, tree: T) -> T | None:  # noqa: ARG002
        """The tree of what a broken text certainly means, its findings as warnings; None else."""
        return None

    @abc.abstractmethod
    def render(self, tree: T) -> str:
        """Text; for an unchanged tree the very text that was parsed."""

    @abc.abstractmethod
    def format(self, tree: T) -> str:
        """Canonical layout of the same tree."""

    def renumber(self, tree: T, first: int, step: int) -> T:
        """The tree with steps numbered first, first + step …, and every jump to them.

        Only of a language with `steps`. Raises Refused, with a finding, where that cannot be done.
        """
        raise NotImplementedError(f"{self.name} has no step numbers")

    def same(self, tree: T, other: T) -> bool:
        """True if two trees are the same program, in whatever form they hold it."""
        return tree == other

    def lift(self, trees: T | Sequence[T], robot: Robot | None = None) -> Program:
        """The pseudo-program that the trees of one program say.

        robot: reads vendor configurations and orientations for that arm; without it the one
        that the program's own header names, else a plain six-axis arm.
        """
        listed = tuple(trees) if isinstance(trees, Sequence) else (trees,)
        program = self.lift_trees(listed, robot)
        return replace(program, origin=Origin(self.name, listed, program, robot))

    def effect(self, text: str, kind: VendorTextKind) -> Effect:  # noqa: ARG002
        """Return the effect of vendor text in a program; any effect if it cannot be read."""
        return unknown_effect(text)

    def declares(self, text: str) -> str:  # noqa: ARG002
        """Return the construct that vendor text declares, as a table names it; "" without one."""
        return ""

    def said(self, text: str) -> Iterator[tuple[str, str]]:
        """Yield the content of a text piece by piece, each with its written form.

        The content is the form in which two states of a program in a controller's memory are
        compared: layout, comments and the printed form of a number do not count. Here these are its
        lines.
        """
        for line in lines_of(text):
            if line.strip():
                yield line.strip(), line.rstrip()

    @abc.abstractmethod
    def lift_trees(self, trees: Sequence[T], robot: Robot | None) -> Program:
        """Return the program that `lift` returns, without its origin.

        Spans count on from the text of one tree to that of the next, see `starts_of`.
        """

    def convert(
        self,
        program: Program,  # noqa: ARG002
        robot: Robot | None = None,  # noqa: ARG002
    ) -> Conversion[T] | None:
        """A program that was read in another dialect of this language, and is meant for its robot.

        None if it comes from elsewhere, or is not as it was read any more.
        """
        return None

    def assumed(self, program: Program, to: str) -> Iterator[Diagnostic]:  # noqa: ARG002
        """Report assumptions of a program of this language, with their form in the language `to`.

        program: as it was lifted.
        """
        yield from ()

    def told(self, program: Program, to: Language[Any]) -> Program:  # noqa: ARG002
        """Return a program of this language with the data that is lowered for another language.

        A report on the program lists these data next to the source itself. Idempotent.
        """
        return program

    def exported(
        self,
        program: Program,
        to: Language[Any],  # noqa: ARG002
        arm: Robot | None,  # noqa: ARG002
    ) -> Adapted:
        """Return a program of this language without the parts that another language does not need.

        Idempotent. A finding reports each effect that is lost. arm: the robot that will run it.
        """
        return Adapted(program)

    def outline(self) -> Outline | None:
        """Sections of its new programs for templates; None for a language without templates."""
        return None

    def with_frames(self, frames: Frames) -> Self:  # noqa: ARG002
        """The language with frames written in a way; itself where it has work objects.

        `base`: the robot's base is set to the frame, so that every position is the one that is
        taught and shown in it; what runs meanwhile sees that base as well. `product`: the base
        stays, and each target is multiplied by its frame, which is also where the arm branch
        comes from; positions cannot be taught in the frame.
        """
        return self

    @abc.abstractmethod
    def adapt(
        self, program: Program, robot: Robot | None = None, *, most_targets: int | None = None
    ) -> Adapted:
        """Return the program with names, speeds, blends and units that this language can express.

        Idempotent. A part that cannot be expressed at all is a finding of severity error.
        most_targets: of one unit, None for the language's own limit.
        """

    def declares_motion(self, value: Speed | Blend) -> bool:  # noqa: ARG002
        """True if a program declares such a speed or blend to name it; False for numbers and for
        standard names.
        """
        return False

    def wanted(self, trees: Sequence[T]) -> tuple[Wanted, ...]:  # noqa: ARG002
        """Return the items that the trees of one program use and none declares, in order of use."""
        return ()

    def hand_output(self, hand: int) -> str:  # noqa: ARG002
        """The output that opens a hand; empty if the language has a statement for that."""
        return ""

    def wanted_of(
        self, trees: Sequence[T], values: Container[tuple[WantedKind, str]]
    ) -> Iterator[Wanted]:
        """Those that a controller holds values of, by their kind and lower-case name."""
        for one in self.wanted(trees):
            if (one.kind, one.name.lower()) in values:
                yield one

    def supplied(self, given: Supplied, trees: Sequence[T]) -> str:  # noqa: ARG002
        """The text of a file that declares names beside these trees; None: without a value.

        Raises Refused for what the language cannot write.
        """
        return ""

    def with_supplied(self, trees: Sequence[T], given: Supplied, path: str) -> list[T]:
        """The trees and a file beside them that declares names, as `supplied` writes it.

        Or the trees with the names in them, where each file has its own. path: of that file.
        """
        text = self.supplied(given, trees)
        return [*trees, self.parse(SourceText(text, path, newline="\n"))]

    def parts(self, tree: T) -> Iterator[Part]:  # noqa: ARG002
        """Yield the parts of a parsed tree that a report on it names besides the lifted statements.

        These are its data, and statements that lifting combines (settings of the moves that
        follow); not comments, labels and ends of blocks.
        """
        yield from ()

    @abc.abstractmethod
    def build(self, program: Program, robot: Robot | None = None, unit: str | None = None) -> T:
        """The tree of one unit of an adapted program."""

    def file_name(self, program: Program, unit: str | None = None) -> str:
        """Name of the file that holds a unit of an adapted program."""
        return (unit or program.name) + self.suffixes[0]

    def spelled(self, program: Program) -> Callable[[str, str, str], str]:  # noqa: ARG002
        """Return a function from an item of an adapted program to its name in the text, if any.

        Its arguments are the item's kind (`TABLE_NOUNS`, `parameter`, `label`), its procedure and
        its name. It returns an empty text for an item without a name.
        """
        return lambda kind, owner, name: name  # noqa: ARG005

    def not_there(self, program: Program) -> Iterator[str]:
        """Yield tools and frames that a controller has under names that this language lacks."""
        stands, called = program.interface, self.spelled(program)
        for kind, table in (("tool", program.tools), ("frame", program.frames)):
            for name in table if stands is not None else ():
                there = stands is not None and name.lower() in stands.there
                if there and called(kind, "", name).lower() != name.lower():
                    yield name

    def editable(self) -> Editable | None:
        """Return the language's services for editors besides findings, None without any."""
        return None

    def kept_secret(self, tree: T) -> str:  # noqa: ARG002
        """The word of a file which keeps controllers from showing its text, "" without one."""
        return ""

    def shared_names(self, tree: T) -> Iterator[tuple[str, str]]:  # noqa: ARG002
        """Names that no other file of the same program can declare as well, each with its kind."""
        yield from ()

    def mentions(self, tree: T) -> frozenset[str]:  # noqa: ARG002
        """Return lower-case names that a file uses without declaring, and a few of its keywords."""
        return frozenset()

    def called_files(self, tree: T) -> tuple[str, ...]:  # noqa: ARG002
        """Names of the files that a tree loads or calls, each once."""
        return ()

    def file_called(self, name: str, tree: T, there: Container[str]) -> str | None:  # noqa: ARG002
        """Return the file that a tree means by a name of `called_files` or `companions`.

        there: names of the files in its folder, in lower case, of which it is one; None without.
        """
        return name.lower() if name.lower() in there else None

    @abc.abstractmethod
    def check(self, trees: Sequence[T]) -> tuple[Diagnostic, ...]:
        """Findings of the language's own rules over the trees of one program."""

    def missing(self, trees: Sequence[T]) -> Iterator[Diagnostic]:  # noqa: ARG002
        """Findings on what the trees of one program call and none of them is."""
        yield from ()

    def companions(self, tree: T) -> tuple[str, ...]:  # noqa: ARG002
        """Names of files that run beside a program: checked with it, but no part of it."""
        return ()

    def configured(self, settings: Mapping[str, int | str]) -> Self:
        """The same language with what a project states about its controllers."""
        made = copy(self)
        made.stated = {key: str(settings[key]) for key in ARITHMETIC if key in settings}
        return made

    def is_copy(self, path: FilePath) -> bool:  # noqa: ARG002
        """True if a project keeps a file as a copy of a program that it has elsewhere as well."""
        return False

    def program_of(self, path: FilePath) -> FilePath:
        """Return the program of a file: files with the same result are checked as one program.

        A file is a separate program unless the language loads several into one.
        """
        return path

    def lower(self, program: Program, robot: Robot | None = None) -> T:
        """Return the main unit's tree of any program, ready to render; raises Refused.

        For a program that was lifted from one tree of this language, the parts that have not
        changed since are in the tree as they were: declarations and routines in their order, with
        their layout.
        """
        origin = program.origin
        # Only a program of one tree has a text to merge changes into.
        if origin is None or origin.language != self.name or len(origin.trees) != 1:
            return self._built(program, robot)
        (tree,) = origin.trees
        # Another robot reads the same text as other targets, so the comparison needs its own
        # lifting.
        known = robot is origin.robot
        lifted = origin.lifted if known else self.lift_trees((tree,), robot)
        # Nothing changed: the tree, with its layout, is the answer.
        if program == lifted:
            unchanged: T = tree
            return unchanged
        lifted = replace(lifted, origin=origin)
        # Both are built the same way, so that their differences are those of the programs alone.
        before, after = self._built(lifted, robot), self._built(program, robot)
        return self.merge(tree, before, after, program, robot)

    def _built(self, program: Program, robot: Robot | None) -> T:
        adapted = self.adapt(program, robot)
        errors = [f for f in adapted.findings if f.severity is Severity.ERROR]
        if errors:
            raise Refused(*errors)
        return self.built(adapted, robot)

    def built(self, adapted: Adapted, robot: Robot | None = None, unit: str | None = None) -> T:
        """The tree of a unit of an adapted program, which may have been built already."""
        known: T | None = adapted.trees.get(unit)
        return self.build(adapted.program, robot, unit) if known is None else known

    def merge(
        self,
        tree: T,  # noqa: ARG002
        before: T,  # noqa: ARG002
        after: T,
        program: Program,  # noqa: ARG002
        robot: Robot | None,  # noqa: ARG002
    ) -> T:
        """A tree with the changes made to it that lead from one built tree to another.

        A language that cannot do that gives the built tree. program, robot: that it was built from.
        """
        return after
