"""Data of RAPID in MELFA-BASIC: what small programs show by their moves is worked out here anew.

Each program moves to `Offs(p10,a,b,c)` with the values that it is about. Both sides are run; what
they show has to be what plain arithmetic gives.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath

import numpy as np
import pytest

import assistant
from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from assistant.virtual.events import Moved, Run
from tests.virtual import rapid_words
from tests.virtual.data_cases import angles, arrays, clocks, named, texts, turns, vectors
from tests.virtual.test_translated_rapid import LANGUAGES, run_melfa, run_rapid
from tests.virtual.translating import in_turn

HEAD = f"""MODULE Cell
CONST robtarget p10:=[[354,0,300],[0,0,1,0],[0,0,0,0],{rapid_words.UNUSED}];
"""
CASES = {
    **angles.CASES,
    **arrays.CASES,
    **clocks.CASES,
    **named.CASES,
    **texts.CASES,
    **turns.CASES,
    **vectors.CASES,
}


ALSO = {("a routine's own clock begins anew beside one of the module", "melfa-basic-5")}


def shown(run: Run) -> Iterator[tuple[float, float, float]]:
    """How far from `p10` each move ended."""
    for event in run.events:
        if isinstance(event, Moved):
            assert event.flange is not None
            x, y, z = event.flange.position
            yield x - 354.0, y, z - 300.0


@pytest.mark.parametrize(("name", "language"), in_turn(CASES, [*LANGUAGES], ALSO))
def test_it_shows_what_arithmetic_gives(name: str, language: str, tmp_path: FilePath) -> None:
    body, expected = CASES[name]
    text = f"{HEAD}{body.replace('SHOW', 'MoveL Offs(p10,').replace('DONE', '),v100,fine,tool0;')}"
    text += "\nENDMODULE\n"
    process = tmp_path / "cell.process.toml"
    process.write_text(rapid_words.process_file(), encoding="utf-8")
    loaded = load_text(SourceText(text), process=process, language="rapid")
    translation = assistant.translate(loaded, to=language)
    refused = [finding.message for finding in translation.findings if not translation.ok]
    assert translation.ok, refused
    (data,) = translation.files.values()
    written = languages.get(language).decode(data).text
    runs = run_rapid(text, {}, 20_000), run_melfa(language, written, {}, 100_000)
    for run in runs:
        assert run.ended == "end", run.message
        np.testing.assert_allclose(list(shown(run)), expected, atol=0.006)


def test_a_quaternion_of_angles_is_told_of_where_it_is_read() -> None:
    body = "VAR robtarget pt;\nVAR num n;\nPROC main()\npt:=p10;\nn:=pt.rot.q2;\n"
    text = f"{HEAD}{body}MoveL Offs(pt,n,0,0),v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    translation = assistant.translate(
        load_text(SourceText(text), language="rapid"), to="melfa-basic-6"
    )
    told = [row.text for row in translation.rows if any(f.code == "RA351" for f in row.reasons)]
    assert told == ["n:=pt.rot.q2"]


ANGLES = """1 P2=P1
2 P2.C=P1.C+Rad(10)
3 P3=(0,0,0,0,0,0)(7,0)
4 P3.X=Deg(P2.A)
5 P3.Y=Deg(P2.B)
6 P3.Z=Deg(P2.C)
7 Mvs P3
8 P2.A=Rad(-20)
9 P2.B=P2.A+Rad(50)
10 P2.C=P2.B
11 P3.X=Deg(P2.A)
12 P3.Y=Deg(P2.B)
13 P3.Z=Deg(P2.C)
14 Mvs P3
15 End
P1=(400,10,300,20,30,40)(7,0)
P2=(400,10,300,180,0,180)(7,0)
P3=(400,10,300,180,0,180)(7,0)
"""


def test_angles_that_are_set_one_by_one_are_one_orientation_in_rapid() -> None:
    loaded = load_text(SourceText(ANGLES), language="melfa-basic-6")
    translation = assistant.translate(loaded, to="rapid")
    assert translation.ok
    (data,) = translation.files.values()
    written = languages.get("rapid").decode(data).text
    assert written.count("OrientZYX") == 2
    for run in (run_melfa("melfa-basic-6", ANGLES, {}, 1000), run_rapid(written, {}, 1000)):
        places = [event.flange for event in run.events if isinstance(event, Moved)]
        found = [place.position for place in places if place is not None]
        np.testing.assert_allclose(found, [(20, 30, 50), (-20, 30, 30)], atol=0.01)
