"""A case: files and a command that have a finding, and what its cure says to write instead."""

from __future__ import annotations

import io
import re
import shlex
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import ezdxf
import pytest

from assistant.cli import main
from tests.findings.cures.naming import ROOT

_CODE: Final = re.compile(r"\b[A-Z]{2}\d{3}\b")
_ERROR: Final = re.compile(r"\b([A-Z]{2}\d{3})(?= error\b|\",\s+\"severity\": \"error\")")
_TOLD: Final = re.compile(r"^more about them: .*$", re.MULTILINE)
_WORD: Final = re.compile(r"--[a-z-]+|[\w.-]+")
Text = str | bytes


@dataclass(frozen=True, slots=True)
class Case:
    """command: has the finding, in a folder with these files. then: commands that the cure asks
    for, the last of which must not have it; without any the same one. change: files as the cure
    asks for them. given: on standard input. before: commands that lead there, then files as
    somebody else changes them between. becomes: what is said then, where the finding is one that
    tells an amount, and stays. others: errors of other kinds that are seen only then. slow: more
    than a fraction of a second.
    """

    code: str
    command: str
    files: Mapping[str, Text] = field(default_factory=dict)
    then: tuple[str, ...] = ()
    change: Mapping[str, Text] = field(default_factory=dict)
    given: str = ""
    before: tuple[str, ...] = ()
    between: Mapping[str, Text] = field(default_factory=dict)
    becomes: str = ""
    others: tuple[str, ...] = ()
    slow: bool = False

    @property
    def written(self) -> frozenset[str]:
        """The words that following the cure adds or takes away."""
        before, after = _pairs(self.command), _pairs(self.then[-1] if self.then else self.command)
        for command in self.then[:-1]:
            after += _pairs(command)
        for name, text in self.change.items():
            before += _pairs(self.files.get(name, ""))
            after += _pairs(text)
        changed = ((before - after) + (after - before)).keys()
        return frozenset(word for pair in changed for word in pair)


def _pairs(text: Text) -> Counter[tuple[str, ...]]:
    """The words of a text, each with the one in front of it."""
    words = _WORD.findall(text if isinstance(text, str) else "")
    return Counter(zip(("", *words), words, strict=False))


@dataclass(slots=True)
class Bench:
    """Runs commands in a folder, in this process."""

    folder: Path
    capsys: pytest.CaptureFixture[str]
    patch: pytest.MonkeyPatch

    def write(self, files: Mapping[str, Text]) -> None:
        for name, text in files.items():
            file = self.folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(text if isinstance(text, bytes) else text.encode())

    def run(self, command: str, given: str = "") -> tuple[int, set[str], str]:
        """Exit status, codes of findings, and all that was said."""
        self.patch.chdir(self.folder)
        self.patch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(given.encode())))
        with pytest.raises(SystemExit) as ended:
            main(shlex.split(command))
        said = self.capsys.readouterr()
        text = said.out + said.err
        assert "Traceback" not in text
        return int(ended.value.code or 0), set(_CODE.findall(_TOLD.sub("", text))), text


def follow(case: Case, bench: Bench) -> None:
    """Has the finding, does what its cure says, and sees that it is gone."""
    bench.write(case.files)
    for command in case.before:
        status, _, said = bench.run(command)
        assert status in (0, 1), said
    bench.write(case.between)
    _, codes, before = bench.run(case.command, case.given)
    assert case.code in codes, before
    said = before
    bench.write(case.change)
    for command in case.then or (case.command,):
        status, codes, said = bench.run(command, case.given)
        assert status in (0, 1) or case.others, said
        assert set(_ERROR.findall(said)) <= {*_ERROR.findall(before), *case.others}, said
    if case.becomes:
        assert case.becomes not in before and case.becomes in said, said
    else:
        assert case.code not in codes, said


def sample(name: str) -> bytes:
    return (ROOT / "samples" / name).read_bytes()


def dxf(draw: Callable[[Any], object], unit: int = 4) -> str:
    """A drawing in this unit of `$INSUNITS`; 4 is millimetres."""
    document = ezdxf.new()  # type: ignore[attr-defined]
    document.header["$INSUNITS"] = unit
    draw(document.modelspace())
    text = io.StringIO()
    document.write(text)
    return text.getvalue()
