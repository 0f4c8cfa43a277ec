"""Files that were written, and edited since: what is to stand in them when they are written anew.

What was compiled is kept beside what is in the file: `.robot-assistant/written/` of the folder that
is written into, or of the project. So each run knows what was edited since.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, Severity, has_errors
from assistant.compiler.keeping import rules, texts
from assistant.compiler.keeping.made import ContourOrigins
from assistant.compiler.keeping.merging import Merge
from assistant.compiler.keeping.remembered import WRITTEN_SUFFIX, bytes_of
from assistant.compiler.keeping.sides import MergeChoices
from assistant.compiler.loading import language_of, lift_texts, load_text
from assistant.compiler.proof import prove_read_back
from assistant.deploy.site import difference
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.compiler.scenes import InCell
    from assistant.languages import Language
    from assistant.robots import Robot

NOT_EXPRESSIBLE: Final = "the new program changes what programs of its kind do not say"


@dataclass(frozen=True, slots=True)
class Kept:
    """What is to be written.

    files: of the programs. compiled: what is to be remembered, by the file that remembers it.
    diffs: of the files with edits, from what was compiled to what stands there. findings: what is
    kept or left out of edits. ok: whether all of it may be written.
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
        """What is to be written of one program, by its files. memory: see `written_in`."""
        memories = {path: memory / f"{path.name}{WRITTEN_SUFFIX}" for path in files}
        remembered = {memories[path]: data for path, data in files.items()}
        there = {path: bytes_of(path) for path in files}
        before = {path: bytes_of(memories[path]) for path in files}
        edited = [
            path for path, data in files.items() if there[path] not in (None, data, before[path])
        ]
        if not edited:
            return Kept(files, remembered)
        if self.wishes.overwrite:
            found = [
                rules.LEFT_OUT(path=str(path), file=path, edits="whatever it was")
                for path in edited
            ]
            return Kept(files, remembered, findings=tuple(found))
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
        """A file with its edits, and what is told of them; raises Refused."""
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
        why = rules.NOT_READ(path=str(path), file=path, reason=NOT_EXPRESSIBLE)
        for data in texts.merged_text(language, program, sides, arm):
            proof = prove_read_back(language, program, {path.name: data}, arm)
            lost = texts.lost_comments(language, (*comments, data)) if comments else []
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
        """What is wrong with the program that was not before the edits."""
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
        from assistant.compiler.compiling import compile

        text = language.decode(data, str(path))
        loaded = load_text(text, robot=self._arm(), language=language.name)
        done = compile(loaded, language=language.name, robot=self._arm(), cell=self.cell)
        return done.findings


def _words_text(words: list[str]) -> str:
    return ", ".join(dict.fromkeys(words))
