"""Languages behind an editor: one interface for the neutral program and every vendor language.

Syntax errors, findings, layout, declarations and translation of a text that is being typed. The
pseudo text of the neutral program is laid out with two blanks a block level and no blanks at line
ends.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path as FilePath
from typing import Any, Final

from assistant import checks, languages
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.source_text import SourceText, lines_of
from assistant.compiler.arms import InCell
from assistant.compiler.checker import Checked, check_text
from assistant.compiler.compilation import compile
from assistant.compiler.formatter import NOT_THE_SAME, format_text
from assistant.compiler.loader import (
    Loaded,
    lift_trees,
    parse_pseudo,
    read_trees,
    with_project_settings,
)
from assistant.compiler.source_map import Places, Trace, at_its_line
from assistant.compiler.translation import translate
from assistant.editing.text_lines import LINE_END
from assistant.languages import Language
from assistant.program import pseudo
from assistant.program.editor_support import CachedLineFacts, Editable
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, Speed
from assistant.program.program import Program, walk
from assistant.program.pseudo.editor_support import EditablePseudo
from assistant.program.undeclared_names import SuppliedValue, Wanted
from assistant.robots import Robot

_PSEUDO_INDENT: Final = "  "
_DIVIDING: Final = ("else", "elseif", "case")


def _laid_out_pseudo(source: SourceText, folder: FilePath | None) -> str:
    """Return the text in the standard layout, proven to have the same meaning; raises Refused if it
    cannot be read.

    folder: folder of tables in separate files.
    """
    before = parse_pseudo(source, folder)
    text = _indented(source.text)
    if text != source.text:
        after = parse_pseudo(SourceText(text, source.path, source.encoding), folder)
        if before != after or before.comments != after.comments:
            raise Refused(NOT_THE_SAME(path=source.path))
    return text


def _indented(text: str) -> str:
    language, depth, made, at = EditablePseudo(), 0, "", 0
    ends = [match.span() for match in LINE_END.finditer(text)]
    for stop, behind in [*ends, (len(text), len(text))]:
        line, end = text[at:stop], text[stop:behind]
        at = behind
        bare = line.strip(" \t\f")
        if bare.startswith("|"):  # what stands behind it is as it is
            made += _PSEUDO_INDENT * depth + line.lstrip(" \t\f") + end
            continue
        facts = language.facts(line)
        first = facts.words[0].text if facts.words else ""
        less = facts.opens < 0 or first in _DIVIDING
        depth = max(depth + min(facts.opens, 0), 0)
        inner = depth - (less and facts.opens >= 0)
        made += (_PSEUDO_INDENT * max(inner, 0) + bare if bare else "") + end
        depth += max(facts.opens, 0) + facts.begins
    return made


PSEUDO: Final = "pseudo"


class LanguageAdapter(abc.ABC):
    """name: of the language, `pseudo` for the pseudo-program. editable: None where it tells
    nothing but findings.
    """

    name: str
    title: str
    mark: str
    suffixes: tuple[str, ...]
    editable: Editable | None
    remembered: CachedLineFacts | None

    @abc.abstractmethod
    def syntax(self, text: SourceText) -> tuple[Diagnostic, ...]:
        """Errors of what cannot be read."""

    @abc.abstractmethod
    def quick(
        self, text: SourceText, others: Sequence[SourceText]
    ) -> tuple[tuple[Diagnostic, ...], tuple[Diagnostic, ...]]:
        """Errors of what cannot be read, and all that rules of the language find in a text.

        others: of the same program.
        """

    @abc.abstractmethod
    def whole(self, text: SourceText, others: Sequence[SourceText], **given: Any) -> Checked:
        """All that is found, also for the robot and cell that are given, see `check_text`."""

    @abc.abstractmethod
    def laid_out(self, text: SourceText) -> str:
        """The text in its layout; raises Refused if it cannot be laid out."""

    @abc.abstractmethod
    def program(
        self, text: SourceText, others: Sequence[SourceText], robot: Robot | None = None
    ) -> Program:
        """Return the program of a text; raises Refused if it cannot be read.

        robot: the robot whose configurations and orientations the program states.
        """

    def warm(self, text: str) -> None:
        """Loads what the first damaged line would have to wait for. text: any program."""
        begin = "\n".join(LINE_END.split(text, 20)[:20])
        self.quick(SourceText(f"{begin} (\n", None, "utf-8", "\n"), ())

    def program_of(self, path: FilePath) -> FilePath:
        return path

    @abc.abstractmethod
    def declarations(
        self, text: SourceText, others: Sequence[SourceText], name: str
    ) -> Sequence[str]:
        """Lines that declare a name which nothing declares, the likeliest first."""

    @abc.abstractmethod
    def translated(
        self, text: SourceText, others: Sequence[SourceText], to: str, stands: InCell
    ) -> Translated:
        """It in another language; raises Refused for what cannot be read."""


@dataclass(frozen=True, slots=True)
class Translated:
    """files: by name, empty if something forbids them. rows: first line and last line of each
    statement of the source from 1, what became of it in words, and the lines it went to.
    """

    files: Mapping[str, bytes]
    rows: Sequence[tuple[int, int, str, tuple[int, ...]]]
    findings: Sequence[Diagnostic]
    draft: bool = False


@cache
def adapter_of(name: str) -> LanguageAdapter | None:
    """Return the adapter of the language with that name, None for an unknown name."""
    if name == PSEUDO:
        return _PseudoAdapter()
    return _VendorAdapter(languages.get(name)) if name in languages.names() else None


def language_name(path: str, text: str) -> str:
    """The name of the language that a text is in, empty for none."""
    if FilePath(path).suffix.lower() == pseudo.SUFFIX:
        return PSEUDO
    found = languages.of_file(path, text.encode("utf-8", "replace"))
    return "" if found is None else found.name


class _PseudoAdapter(LanguageAdapter):
    name, title, mark, suffixes = PSEUDO, "pseudo-program", "#", (pseudo.SUFFIX,)
    editable: EditablePseudo

    def __init__(self) -> None:
        self.editable = EditablePseudo()
        self.remembered = CachedLineFacts(self.editable)

    def syntax(self, text: SourceText) -> tuple[Diagnostic, ...]:
        try:
            parse_pseudo(text, _folder_of(text))
        except Refused as refused:
            return refused.findings
        return ()

    def quick(
        self,
        text: SourceText,
        others: Sequence[SourceText],  # noqa: ARG002
    ) -> tuple[tuple[Diagnostic, ...], tuple[Diagnostic, ...]]:
        try:
            program = parse_pseudo(text, _folder_of(text))
        except Refused as refused:
            return refused.findings, refused.findings
        places = Places(program, text)
        found = (at_its_line(places.finding(one), text) for one in checks.check(program))
        return (), tuple(found)

    def whole(
        self,
        text: SourceText,
        others: Sequence[SourceText],  # noqa: ARG002
        **given: Any,
    ) -> Checked:
        return check_text(text, **given)

    def laid_out(self, text: SourceText) -> str:
        return _laid_out_pseudo(text, _folder_of(text))

    def program(
        self,
        text: SourceText,
        others: Sequence[SourceText],  # noqa: ARG002
        robot: Robot | None = None,  # noqa: ARG002
    ) -> Program:
        return parse_pseudo(text, _folder_of(text))

    def declarations(
        self,
        text: SourceText,  # noqa: ARG002
        others: Sequence[SourceText],  # noqa: ARG002
        name: str,
    ) -> Sequence[str]:
        return self.editable.declarations(name)

    def translated(
        self,
        text: SourceText,
        others: Sequence[SourceText],  # noqa: ARG002
        to: str,
        stands: InCell,
    ) -> Translated:
        program = parse_pseudo(text, _folder_of(text))
        compiled = compile(Loaded(program, text=text), language=to, cell=stands)
        trace = Trace(compiled.program, compiled.proof.lifted)
        rows = []
        for statement in program.statements():
            if statement.span is not None:
                span = statement.span
                first, last = (
                    text.line_column(at)[0] for at in (span.start, max(span.end - 1, span.start))
                )
                went = tuple(place.line for place in trace.written(span))
                rows.append((first, last, "supported" if went else "", went))
        return Translated(compiled.files, rows, compiled.findings)


class _VendorAdapter(LanguageAdapter):
    def __init__(self, language: Language[Any]) -> None:
        self._language = language
        self.name, self.title = language.name, language.title
        self.mark, self.suffixes = language.comment_mark, language.suffixes
        self.editable = language.editable()
        self.remembered = None if self.editable is None else CachedLineFacts(self.editable)

    def syntax(self, text: SourceText) -> tuple[Diagnostic, ...]:
        found = self._language.parse(text).findings
        return tuple(one for one in found if has_errors([one]))

    def quick(
        self, text: SourceText, others: Sequence[SourceText]
    ) -> tuple[tuple[Diagnostic, ...], tuple[Diagnostic, ...]]:
        folder = _folder_of(text)
        language = (
            self._language if folder is None else with_project_settings(self._language, folder)
        )
        tree = language.parse(text)
        trees = [tree, *map(language.parse, others)]
        found = [one for one in language.check(trees) if one.path in (text.path, None)]
        syntax = tuple(one for one in tree.findings if has_errors([one]))
        return syntax, tuple(dict.fromkeys((*tree.findings, *found)))

    def whole(self, text: SourceText, others: Sequence[SourceText], **given: Any) -> Checked:
        folder = _folder_of(text)
        return check_text(text, language=self.name, others=others, beside=folder, **given)

    def laid_out(self, text: SourceText) -> str:
        done = format_text(text, self._language)
        if has_errors(done.findings):
            raise Refused(*done.findings)
        return done.text

    def program(
        self, text: SourceText, others: Sequence[SourceText], robot: Robot | None = None
    ) -> Program:
        trees = [self._language.parse(one) for one in (text, *others)]
        wrong = [one for tree in trees for one in tree.findings if has_errors([one])]
        if wrong:
            raise Refused(*wrong)
        return self._language.lift(trees, robot)

    def program_of(self, path: FilePath) -> FilePath:
        return self._language.program_of(path)

    def declarations(
        self, text: SourceText, others: Sequence[SourceText], name: str
    ) -> Sequence[str]:
        """Return the declaration that a cell file would supply, followed by one of each kind."""
        kinds = () if self.editable is None else self.editable.declarations(name)
        language = self._language
        try:
            trees = [language.parse(one) for one in (text, *others)]
            asked = [one for one in language.wanted(trees) if one.name.lower() == name.lower()]
            supplied = language.supplied([(one, _least(one)) for one in asked], trees)
        except (Refused, NotImplementedError):
            return kinds
        if self.editable is None or not asked:
            return kinds
        said = [line.strip() for line in lines_of(supplied)]
        kept = [line for line in said if line and not self.editable.facts(line).stays]
        return ("\n".join(kept), *kinds) if kept else kinds

    def translated(
        self, text: SourceText, others: Sequence[SourceText], to: str, stands: InCell
    ) -> Translated:
        trees = read_trees(self._language, (text, *others), beside=_folder_of(text))
        robot = None if stands.robot is None else stands.robot.name
        loaded = lift_trees(self._language, trees, stands.robot)
        if to == PSEUDO:
            return _as_pseudo(loaded.program, text)
        done = translate(loaded, to=to, robot=robot, draft=True)
        rows = [
            (
                row.place.line,
                row.place.line + row.place.text.strip().count("\n"),
                row.level,
                tuple(place.line for place in row.went),
            )
            for row in done.rows
            if row.place.path == text.path
        ]
        told = (*done.whole, *(one for row in done.rows.noted for one in row.reasons))
        return Translated(done.files, rows, told, done.draft)


def _as_pseudo(program: Program, text: SourceText) -> Translated:
    """The pseudo-program itself, each statement at the line that it is printed in."""
    printed = pseudo.print_program(program).text
    again = parse_pseudo(SourceText(printed, None, "utf-8", "\n"))
    places, rows = Places(program), []
    written = SourceText(printed, None, "utf-8", "\n")
    there = {
        id(mine): its
        for one, other in zip(program.procedures, again.procedures, strict=False)
        for mine, its in zip(walk(one.body), walk(other.body), strict=False)
    }
    for statement in program.statements():
        its, span = there.get(id(statement)), statement.span
        place = None if span is None else places.of(span)
        if place is None or place.path != text.path or its is None or its.span is None:
            continue
        line = written.line_column(its.span.start)[0]
        rows.append((place.line, place.line + place.text.strip().count("\n"), "supported", (line,)))
    return Translated({f"{program.name}{pseudo.SUFFIX}": printed.encode()}, rows, ())


def _least(wanted: Wanted) -> SuppliedValue | None:
    """Return the plainest value for a wanted name."""
    made = _LEAST.get(wanted.kind)
    return wanted.nothing if made is None else made


_LEAST: Final[Mapping[str, SuppliedValue]] = {
    "tool": Tool(),
    "frame": Frame(),
    "speed": Speed(100.0),
    "blend": FINE,
    "position": Target(Pose()),
    "joints": JointTarget((0.0,) * 6),
    "routine": "stop",
}


def _folder_of(text: SourceText) -> FilePath | None:
    """The folder of a file that there is."""
    folder = FilePath(text.path or "").absolute().parent
    return folder if text.path and folder.is_dir() else None
