"""The samples do in every other language what they do in their own, as interpreters tell it."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages
from assistant.compiler import translate
from assistant.compiler.motion_proof import Proving

SAMPLES = Path(__file__).parents[2] / "samples"
ARMS = {"rapid": "irb1200-7-0.7", "melfa": "rv-4frl"}
RAPID = ("drilling.mod", "gluing.mod", "palletising.mod", "pick_and_place.mod")
PROGRAMS = [f"rapid/{name}" for name in (*RAPID, "station/station.pgf")]
PROGRAMS += [f"melfa/{name}.prg" for name in ("LOADER", "PALLET")]
NOT_RUN = {
    "CONTROLLINK": "slots of a program that runs without a controller",
    "DATALINK": "the flags of a position that is printed",
    "MEASURE": "the flags of a position that is printed",
    "MULTITASK": "slots of a program that runs without a controller",
}
"""What works together with programs in other slots, and why none of them runs by itself."""


def proven(sample: str, to: str, proving: Proving) -> list[str]:
    """Why a sample in another language is not proven by motion; nothing if it is."""
    maker = sample.split("/")[0]
    other = "rapid" if to == "rapid" else "melfa"
    found = translate(
        SAMPLES / sample,
        to=to,
        robot=ARMS[other],
        from_robot=ARMS[maker],
        process=SAMPLES / maker / "cell.process.toml",
        proving=proving,
    )
    assert found.motion is not None, found.findings
    return [] if found.motion.holds else [f.message for f in found.motion.findings]


@pytest.mark.parametrize("sample", ["rapid/gluing.mod", "rapid/drilling.mod", "melfa/LOADER.prg"])
def test_a_sample_moves_as_its_translation(sample: str) -> None:
    to = "melfa-basic-5" if sample.startswith("rapid") else "rapid"
    assert proven(sample, to, Proving(runs=2)) == []


@pytest.mark.slow
@pytest.mark.parametrize("to", languages.names())
@pytest.mark.parametrize("sample", PROGRAMS)
def test_every_sample_moves_as_its_translation(sample: str, to: str) -> None:
    assert proven(sample, to, Proving(seconds=60.0)) == []


@pytest.mark.parametrize("name", NOT_RUN)
def test_a_sample_that_cannot_be_run_by_itself_is_said(name: str) -> None:
    first = min(SAMPLES.rglob(f"{name}.prg")).relative_to(SAMPLES)
    (why, *_) = proven(first.as_posix(), "melfa-basic-6", Proving(runs=2))
    assert NOT_RUN[name] in why


UNSAID = {"rapid/pose_exchange.mod", "rapid/plain_exchange.mod", "rapid/guided.mod"}
"""MELFA-BASIC has no such files, and no EGM."""


def test_every_sample_is_tried() -> None:
    alone = [p for p in SAMPLES.rglob("*.prg") if p.stem not in NOT_RUN]
    there = {p.relative_to(SAMPLES).as_posix() for p in alone}
    there |= {p.relative_to(SAMPLES).as_posix() for p in (SAMPLES / "rapid").glob("*.mod")}
    assert there - {*PROGRAMS} == UNSAID
