"""Written files that were edited since: their new contents when they are written again.

The compiled output is stored beside the files: `.robot-assistant/written/` of the output folder, or
of the project. So each run knows the edits since. The text of a merged program keeps the comments
and declarations that people wrote.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Severity, has_errors
from assistant.base.source_text import comments
from assistant.base.text_merge import difference, says_the_same
from assistant.compiler.loader import language_of, lift_texts, load_text
from assistant.compiler.merge_edits import rules
from assistant.compiler.merge_edits.contour_origins import ContourOrigins
from assistant.compiler.merge_edits.last_output import WRITTEN_SUFFIX, bytes_of
from assistant.compiler.merge_edits.three_way_merge import Merge, MergeChoices
from assistant.compiler.read_back_proof import prove_read_back
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.compiler.arms import InCell
    from assistant.languages import Language
    from assistant.robots import Robot


_TEXT_WORD: Final = re.compile(r'"[^"\r\n]*"|[A-Za-z_]\w*|[^\w\s]')


def _merged_text(
    language: Language[Any],
    program: Program,
    sides: tuple[Program, Program, Program],
    arm: Robot | None,
) -> Iterator[bytes]:
    """Yield a merged program in the text compiled now, or in that of the file, or both.

    sides: the programs that were merged: as written, as in the file, as compiled now. The text of
    the file comes first if it contains more than its program, such as the form of declarations and
    comments; it is skipped if the new program has changed that as well.
    """
    base, edited, made = sides
    whole, there = _in_text_of(language, edited, base, arm), _printed_bytes(language, edited)
    if says_the_same(whole, there, bytes):
        yield _in_text_of(language, program, made, arm)
        return
    now = _in_text_of(language, made, base, arm)
    if _words_in(language, now) == _words_in(language, _printed_bytes(language, made)):
        yield _in_text_of(language, program, edited, arm)
    if _words_in(language, whole) == _words_in(language, there):
        yield _in_text_of(language, program, made, arm)


def _lost_comments(language: Language[Any], sides: tuple[bytes, bytes, bytes]) -> list[str]:
    """The comments that somebody wrote and that are not in the merged text.

    sides: as it was written, as it is in the file, as it is merged.
    """
    old, now, new = (Counter(_comments_in(language, data)) for data in sides)
    return [comment for comment in (now - old) - new if comment]


def _in_text_of(
    language: Language[Any], program: Program, text_of: Program, arm: Robot | None
) -> bytes:
    """A program in the text that another one was read from, as far as that says the same."""
    return language.encode(language.lower(replace(program, origin=text_of.origin), arm))


def _printed_bytes(language: Language[Any], program: Program) -> bytes:
    assert program.origin is not None
    return language.encode(program.origin.trees[0])


def _comments_in(language: Language[Any], data: bytes) -> Iterator[str]:
    text, mark = language.decode(data).text, language.comment_mark
    for span in comments(text, mark):
        yield text[span.start + len(mark) : span.end].strip()


def _words_in(language: Language[Any], data: bytes) -> Counter[str]:
    """The words of a text in any order, without its comments and numbers."""
    text, mark = language.decode(data).text, language.comment_mark
    plain, at = [], 0
    for span in comments(text, mark):
        plain.append(text[at : span.start])
        at = span.end
    plain.append(text[at:])
    return Counter(found[0] for found in _TEXT_WORD.finditer("".join(plain)))


_NOT_EXPRESSIBLE: Final = "the new program changes what programs of its kind do not say"


@dataclass(frozen=True, slots=True)
class Kept:
    """Contents to write.

    files: of the programs. compiled: compiled output to store, by the file that stores it. diffs:
    of the files with edits, from the compiled to the present text. findings: edits that are kept or
    left out. ok: True if all of it may be written.
    """

    files: Mapping[FilePath, bytes]
    compiled: Mapping[FilePath, bytes]
    diffs: Mapping[FilePath, str] = field(default_factory=dict)
    findings: tuple[Diagnostic, ...] = ()

    @property
    def ok(self) -> bool:
        return not has_errors(self.findings)

    @property
    def all(self) -> dict[FilePath, bytes]:
        """All that is to be written, the programs before what is remembered of them.

        Who is killed between them leaves an old memory of a new program: the next run takes what
        the source has changed for an edit that it has made as well.
        """
        return {**self.files, **self.compiled}


@dataclass(slots=True)
class Keeper:
    """Keeps the edits of the programs of one command.

    language: of the programs. robot: whose arm runs them, None for the one that they name. cell:
    that they run in. wishes: what is decided about edits.
    """

    language: str
    robot: str | Robot | None = None
    cell: str | InCell | None = None
    wishes: MergeChoices = field(default_factory=MergeChoices)
    known: set[str] = field(default_factory=set)
    """Names of the edits that were met."""

    def kept(self, files: Mapping[FilePath, bytes], memory: FilePath) -> Kept:
        """Return the contents to write of one program, by its files. memory: see `written_in`."""
        memories = {path: memory / f"{path.name}{WRITTEN_SUFFIX}" for path in files}
        remembered = {memories[path]: data for path, data in files.items()}
        # Edited: neither what is compiled now nor what was compiled before. One file after the
        # other, as there may be hundreds.
        edited = [
            path
            for path, data in files.items()
            if bytes_of(path) not in (None, data, bytes_of(memories[path]))
        ]
        there = {path: bytes_of(path) for path in edited}
        before = {path: bytes_of(memories[path]) for path in edited}
        if not edited:
            return Kept(files, remembered)
        if self.wishes.overwrite:
            found = [
                rules.LEFT_OUT(path=str(path), file=path, edits="whatever it was")
                for path in edited
            ]
            return Kept(files, remembered, findings=tuple(found))
        # Without the compiled output of before, edits cannot be told from changes of the source.
        foreign = [path for path in edited if before[path] is None]
        if foreign:
            told = tuple(rules.FOREIGN(path=str(path), file=path) for path in foreign)
            return Kept({}, {}, findings=told)
        result = dict(files)
        findings: list[Diagnostic] = []
        diffs: dict[FilePath, str] = {}
        for path in edited:
            sides = before[path] or b"", there[path] or b"", files[path]
            try:
                result[path], found = self._one(path, *sides, len(files))
                findings += found
            except Refused as refused:
                findings += [finding.within(str(path)) for finding in refused.findings]
            names = f"{path} (as compiled)", f"{path} (as edited)"
            if diff := difference(files[path], result[path], *names):
                diffs[path] = diff
        return Kept(result, remembered, diffs, tuple(findings))

    def unknown_names(self) -> list[Diagnostic]:
        """A finding for each name of the wishes that no edit has, asked when all files are met."""
        named = ", ".join(f"`{one}`" for one in sorted(self.known))
        cure = f"write one of {named}" if named else "leave it out: nothing was edited"
        wrong = sorted((self.wishes.keep | self.wishes.drop) - self.known)
        return [rules.NO_EDIT(name=name, cure=cure) for name in wrong]

    def _one(
        self, path: FilePath, base: bytes, edited: bytes, made: bytes, count: int
    ) -> tuple[bytes, list[Diagnostic]]:
        """Return a file with its edits, and the findings about them; raise Refused."""
        language = language_of(self.language)
        if count > 1 and base != made:
            raise Refused(rules.SEVERAL(path=str(path), file=path, count=count))
        old, now, new = (self._read(path, language, data) for data in (base, edited, made))
        merge = Merge(
            str(path), ContourOrigins(old), ContourOrigins(now), ContourOrigins(new), self.wishes
        )
        program = merge.program()
        self.known |= merge.names
        if merge.conflicts:
            raise Refused(*merge.conflicts)
        told: list[Diagnostic] = []
        if merge.dropped:
            told.append(rules.LEFT_OUT(path=str(path), file=path, edits=_words_text(merge.dropped)))
        text = edited
        if count == 1:
            known = None if merge.dropped else (base, edited)
            text = self._text(path, language, program, (old, now, new), known)
        if text != made:
            edits = merge.edits or ["its comments and layout"]
            told.append(rules.KEPT(path=str(path), file=path, edits=_words_text(edits)))
        return text, [*told, *self._found(path, language, text, made)]

    def _read(self, path: FilePath, language: Language[Any], data: bytes) -> Program:
        try:
            return lift_texts(language, [language.decode(data, str(path))], self._arm()).program
        except Refused as refused:
            reason = refused.findings[0].message
            finding = rules.NOT_READ(path=str(path), file=path, reason=reason)
            raise Refused(finding, *refused.findings) from None

    def _arm(self) -> Robot | None:
        from assistant.compiler.arms import robot_of

        return robot_of(self.robot)

    def _text(
        self,
        path: FilePath,
        language: Language[Any],
        program: Program,
        sides: tuple[Program, Program, Program],
        comments: tuple[bytes, bytes] | None,
    ) -> bytes:
        """The merged program as a text, read back and compared.

        sides: as it was written, as it is in the file, as it is now. comments: the first two, whose
        comments are to be there; None if some may go with the edits that they are of.
        """
        arm = self._arm()
        why = rules.NOT_READ(path=str(path), file=path, reason=_NOT_EXPRESSIBLE)
        for data in _merged_text(language, program, sides, arm):
            proof = prove_read_back(language, program, {path.name: data}, arm)
            lost = _lost_comments(language, (*comments, data)) if comments else []
            if proof.holds and not lost:
                return data
            if lost:
                why = rules.COMMENT(path=str(path), file=path, comment=lost[0])
            else:
                why = rules.NOT_READ(path=str(path), file=path, reason=proof.findings[0].message)
        raise Refused(why)

    def _found(
        self, path: FilePath, language: Language[Any], text: bytes, made: bytes
    ) -> list[Diagnostic]:
        """Return the findings about the program that are new with the edits."""
        before = {(f.code, f.message) for f in self._findings(language, made, path)}
        return [
            finding.within(str(path))
            for finding in self._findings(language, text, path)
            if finding.severity is not Severity.INFO
            and (finding.code, finding.message) not in before
        ]

    def _findings(
        self, language: Language[Any], data: bytes, path: FilePath
    ) -> tuple[Diagnostic, ...]:
        from assistant.compiler.compilation import compile

        text = language.decode(data, str(path))
        loaded = load_text(text, robot=self._arm(), language=language.name)
        done = compile(loaded, language=language.name, robot=self._arm(), cell=self.cell)
        return done.findings


def _words_text(words: list[str]) -> str:
    return ", ".join(dict.fromkeys(words))
