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
from assistant.compiler.loading import load_text
from assistant.program.text import SourceText
from assistant.virtual.events import Moved, Run
from tests.virtual import rapid_words
from tests.virtual.data_cases import angles, clocks, texts, turns, vectors
from tests.virtual.test_translated_rapid import LANGUAGES, run_melfa, run_rapid

HEAD = f"""MODULE Cell
CONST robtarget p10:=[[354,0,300],[0,0,1,0],[0,0,0,0],{rapid_words.UNUSED}];
"""
CASES = {
    **angles.CASES,
    **clocks.CASES,
    **texts.CASES,
    **turns.CASES,
    **vectors.CASES,
}


def shown(run: Run) -> Iterator[tuple[float, float, float]]:
    """How far from `p10` each move ended."""
    for event in run.events:
        if isinstance(event, Moved):
            assert event.flange is not None
            x, y, z = event.flange.position
            yield x - 354.0, y, z - 300.0


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", CASES)
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
