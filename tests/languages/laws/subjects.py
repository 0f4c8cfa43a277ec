"""What the laws are tried on: every language, texts of each, and programs that each can say."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Severity
from assistant.languages import Language
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Procedure, Program, Signal
from tests.examples import drawn

LANGUAGES: Final = (*(name for name in languages.names() if name != "toy"), "toy")
every_language = pytest.mark.parametrize("name", LANGUAGES)
assert settings.default is not None
few = settings(
    max_examples=5 if settings.default.derandomize else 8,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
)
many = settings(few, max_examples=drawn(100))
TESTS: Final = Path(__file__).parents[2]


def texts() -> Iterator[tuple[str, Path]]:
    """Files of small programs, each with the name of the language that it is written in."""
    folders = (TESTS.parent / "samples", TESTS / "languages")
    for file in sorted(file for folder in folders for file in folder.rglob("*.*")):
        if file.suffix == ".toy":
            yield "toy", file
        elif file.parent.name == "data" or folders[0] in file.parents:
            told = languages.of_file(file, file.read_bytes())
            if told is not None and file.suffix in told.suffixes:
                yield told.name, file


TEXTS: Final = tuple(texts())


def read(name: str, file: Path) -> Any:
    """The tree of a file."""
    language = languages.get(name)
    return language.parse(language.read(file))


def written(language: Language[Any], program: Program) -> dict[str, bytes]:
    """The files of an adapted program."""
    units = dict.fromkeys([None, *(q.unit for q in program.procedures)])
    return {
        language.file_name(program, unit): language.encode(language.build(program, unit=unit))
        for unit in units
    }


def errors(found: Any) -> list[Diagnostic]:
    return [finding for finding in found if finding.severity is Severity.ERROR]


# ---------------------------------------------------------------------- what all can say

TURNED: Final = (0.0, 0.0, 1.0, 0.0)
TARGETS: Final = {
    "home": Target(Pose((400.0, 0.0, 600.0), TURNED)),
    "seat": Target(Pose((10.25, -20.5, 5.0), TURNED)),
}
PARTS: Final[dict[str, Any]] = {
    "comments": ("what every language can say",),
    "tools": {"hand": Tool(Pose((0.0, 0.0, 120.5)))},
    "frames": {"tray": Frame(Pose((500.0, 100.0, 0.0)))},
    "signals": {"grip": Signal("digital", "output", 5), "ready": Signal("digital", "input", 7)},
    "targets": TARGETS,
    "joint_targets": {"parked": JointTarget((0.0, -30.0, 30.0, 0.0, 60.0, 0.0))},
}
"""Parts of a program whose statements are `statements`."""

_bits = st.sampled_from([e.Number(0), e.Number(1)])
_conditions = st.builds(e.Binary, st.just("="), st.just(e.Name("ready")), _bits)
_speeds = st.sampled_from([5.0, 12.5, 150.0, 2000.0]).map(Speed)
_blends = st.sampled_from([FINE, Blend(1.0), Blend(12.5)])
_frames = st.sampled_from(["base", "tray"])
_motions = st.builds(p.Motion, _speeds, _blends, st.sampled_from(["tool0", "hand"]), _frames)
_in_base = st.builds(p.Motion, _speeds, _blends, st.sampled_from(["tool0", "hand"]))
_points = st.sampled_from([e.Name("home"), e.Name("seat"), e.TargetValue(TARGETS["seat"])])
_simple = st.one_of(
    st.builds(p.Move, st.sampled_from(["joint", "linear"]), _points, _motions),
    st.builds(p.MoveJoints, st.just(e.Name("parked")), _in_base),
    st.sampled_from([0.25, 1, 12.5]).map(lambda seconds: p.Wait(e.Number(seconds))),
    st.builds(p.SetSignal, st.just("grip"), _bits),
    st.builds(p.WaitSignal, st.just("ready"), _bits),
    st.builds(p.Comment, st.text(max_size=30)),
    st.sampled_from([p.Call("part"), p.Stop()]),
)


def _blocks(inner: st.SearchStrategy[p.Statement]) -> st.SearchStrategy[p.Statement]:
    bodies = st.lists(inner, max_size=3).map(tuple)
    branches = st.builds(p.Branch, _conditions, bodies).map(lambda branch: (branch,))
    return st.builds(p.If, branches, bodies) | st.builds(p.While, _conditions, bodies)


statements = st.recursive(_simple, _blocks, max_leaves=5)
bodies = st.lists(statements, max_size=6).map(tuple)
programs = st.builds(
    lambda main, part: Program("job", (Procedure("main", main), Procedure("part", part)), **PARTS),
    bodies,
    bodies.map(lambda body: tuple(s for s in body if "Call" not in repr(s))),
)
"""Programs that every language says without an error."""

WAITS: Final = tuple(p.Wait(e.Number(seconds)) for seconds in range(1, 8))
_MOTION: Final = p.Motion(Speed(250.0), Blend(10.0), "hand", "tray")
_READY: Final = e.Binary("=", e.Name("ready"), e.Number(1))
WAITING: Final = Program(
    "job",
    (
        Procedure(
            "main",
            (
                p.Move("joint", e.Name("home"), _MOTION),
                WAITS[0],
                p.If((p.Branch(_READY, (WAITS[1], p.Call("part"))),), (WAITS[2],)),
                p.While(_READY, (p.SetSignal("grip", e.Number(1)), WAITS[3])),
                WAITS[4],
            ),
        ),
        Procedure("part", (p.WaitSignal("ready", e.Number(1)), WAITS[5], p.Stop(), WAITS[6])),
    ),
    **PARTS,
)
"""A program of every kind of block, whose waits tell which of its lines are read."""


def damaged(text: str, comment_mark: str) -> Iterator[tuple[int, float, str]]:
    """The text with one line of code spoilt; the line, the share of it that is lost, the text."""
    lines = text.splitlines(keepends=True)
    for row, line in enumerate(lines):
        bare = line.rstrip()
        if not bare.strip() or comment_mark in bare:
            continue
        end = line[len(bare) :]
        first = re.match(r"\s*\S+", bare)[0]
        for lost, spoilt in (
            (0.0, f"{bare} )("),
            (0.5, f"{first} )({bare[len(first) :]}"),
            (1.0, ")("),
        ):
            yield row + 1, lost, "".join((*lines[:row], spoilt, end, *lines[row + 1 :]))
