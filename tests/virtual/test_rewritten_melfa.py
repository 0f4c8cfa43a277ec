"""Random MELFA-BASIC programs written anew in their own dialect do what they did."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterable

import pytest

from tests.virtual.random_melfa import program
from tests.virtual.test_translated_melfa import SCENARIOS, run_melfa
from tests.virtual.translating import Tally, judge

LEVELS = (4, 5, 6)
SIGNALS = {str(number): [number] for number in range(9100)}
MOST_UNPROVEN = 0.03
"""The part of the programs that may be refused because the proof does not hold."""
LAST = re.compile(r"(\d+) End\b", re.IGNORECASE)
SUBROUTINE = re.compile(r"\*(S[ABC])\b")


def odd(level: int, seed: int) -> str:
    """A program with a jump from its main part into a subroutine, which is never taken.

    With it nobody knows from the text what holds where that subroutine begins.
    """
    text = program(level, seed)
    subroutines = sorted(set(SUBROUTINE.findall(text)))
    end = LAST.search(text)
    if not subroutines or end is None:
        return text
    into = random.Random(seed).choice(subroutines)
    step = int(end[1]) - (5 if level == 4 else 0)
    tail = text[end.start() :]
    if level != 4:  # its steps have no room between them
        tail = re.sub(r"(?m)^(\d+) ", lambda found: f"{int(found[1]) + 1} ", tail)
    return f"{text[: end.start()]}{step} If M_In(39)=1 Then GoTo *{into}\n{tail}"


def tally_of(level: int, texts: Iterable[tuple[str, str]]) -> Tally:
    """Programs, by name, written anew and compared."""
    language = f"melfa-basic-{level}"
    running = language, lambda *given: run_melfa(level, None, *given)
    tally = Tally()
    for name, text in texts:
        judge(tally, name, text, SCENARIOS, source=running, target=running, signals=SIGNALS)
    print(f"{language} to itself: {tally}")  # noqa: T201
    return tally


@pytest.mark.parametrize(
    ("level", "seeds"),
    [(4, (10, 1)), (5, (27, 1)), (6, (5, 15))],  # with texts that depend on settings
)
def test_random_programs_do_the_same(level: int, seeds: tuple[int, ...]) -> None:
    tally = tally_of(level, ((f"seed {seed}", program(level, seed)) for seed in seeds))
    assert tally.kept == []
    assert tally.counts["equal"] == len(seeds)


@pytest.mark.parametrize(("level", "seed"), [(4, 6), (5, 5), (6, 5)])
def test_programs_with_odd_jumps_do_the_same(level: int, seed: int) -> None:
    tally = tally_of(level, [(f"seed {seed}", odd(level, seed))])
    assert tally.kept == []
    assert tally.counts["equal"] == 1


POSES = """\
P1=(400,0,450,180,0,180)(7,0)
P2=(380,60,430,180,0,180)(7,0)
P3=(400,120,450,180,0,180)(7,0)
"""
AROUND_LOOPS = {
    "a jump from behind a loop to lines above the subroutine": """\
GoSub *TWO
GoSub *ONE
End
*ONE
Mvs P1
M1=M1+1
If M1<3 Then GoSub *TWO
Return
*TWO
M2=0
While M2<2
M2=M2+1
Mvs P2,-10
WEnd
Mvs P3
If M_In(39)=1 Then GoTo *ONE
Return
""",
    "the same with a loop over numbers": """\
GoSub *TWO
GoSub *ONE
End
*ONE
Mvs P1
Return
*TWO
For M2=1 To 2
Mvs P2,-10
Next M2
Mvs P3
M1=M1+1
If M1<3 Then GoTo *ONE
Return
""",
    "a loop that runs into the subroutine that jumps back to it": """\
GoSub *TWO
GoSub *TWO
End
*BACK
M2=0
While M2<2
M2=M2+1
Mvs P2,-10
WEnd
' then again
*TWO
Mvs P3
M1=M1+1
If M1=2 Then GoTo *BACK
Return
""",
}
"""Subroutines whose lines are parted or shared, about loops that control leaves at their head."""


@pytest.mark.parametrize("name", AROUND_LOOPS)
def test_subroutines_in_parts_keep_what_follows_their_loops(name: str) -> None:
    lines = f"M1=0\n{AROUND_LOOPS[name]}".splitlines()
    text = "".join(f"{k} {line}\n" for k, line in enumerate(lines, start=1)) + POSES
    tally = tally_of(5, [(name, text)])
    assert tally.kept == []
    assert tally.counts["equal"] == 1, tally.reasons


@pytest.mark.slow
@pytest.mark.parametrize("kind", [program, odd])
@pytest.mark.parametrize("level", LEVELS)
def test_many_random_programs_do_the_same(level: int, kind: Callable[[int, int], str]) -> None:
    tally = tally_of(level, ((f"seed {seed}", kind(level, seed)) for seed in range(60)))
    unproven = [line for line in tally.kept if ": crashed: CO10" in line]
    assert tally.kept == unproven
    assert len(unproven) <= MOST_UNPROVEN * tally.counts["tried"]
    assert tally.counts["equal"] >= 0.95 * tally.counts["tried"], tally.reasons
