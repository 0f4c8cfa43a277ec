"""Names that are words of a language, and comments in any script: neither stops a program."""

from __future__ import annotations

from pathlib import Path as FilePath

import ezdxf
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import assistant
from assistant import languages
from assistant.program import statements as p
from assistant.program.program import Procedure, Program


@pytest.mark.parametrize("layer", ["Default", "default", "error", "End", "Außenkontur ü", "Ü"])
@pytest.mark.parametrize("language", ["rapid", "melfa-basic-5"])
def test_a_drawing_with_such_a_layer(tmp_path: FilePath, layer: str, language: str) -> None:
    drawing = ezdxf.new(units=4)
    for x in (300, 360, 420):
        points = [(x, 0), (x + 40, 0), (x + 40, 40)]
        drawing.modelspace().add_lwpolyline(points, close=True, dxfattribs={"layer": layer})
    file = tmp_path / f"{layer}.dxf"
    drawing.saveas(file)
    compiled = assistant.compile(file, language=language)
    assert compiled.proof.holds, compiled.findings


LETTERS = st.characters(codec="utf-8", categories=("L", "N", "P", "S"))
COMMENTS = st.one_of(
    st.text(LETTERS, max_size=20),
    st.text("aeÄÖüéñøÃ¼¶Å½", max_size=20),
    st.text("aｱ日本語ソ表", max_size=20),
    st.text(LETTERS, max_size=9).map(lambda t: t.encode("utf-8").decode("latin-1")),
)


@pytest.mark.parametrize("language", languages.names())
@given(text=COMMENTS)
@settings(max_examples=25, deadline=None)
def test_a_comment_in_any_script_is_proven(language: str, text: str) -> None:
    program = Program("job", (Procedure("main", (p.Comment(text),)),), comments=(text,))
    compiled = assistant.compile(program, language=language)
    assert compiled.proof.holds, compiled.proof.findings
