"""Programs of several files become modules that one task holds, and such modules one program."""

from __future__ import annotations

from pathlib import Path

import ezdxf
import pytest

import assistant
from assistant.compiler import load, translate
from assistant.compiler.motion_proof import Proving
from assistant.languages.rapid.text import header

PLACE = "P1=(+400.00,{y:+.2f},+300.00,+180.00,+0.00,+180.00)(7,0)\n"
FILES = {
    "MAIN.prg": 'Spd 50\nMvs P1\nCallP "SUB",1\nCallP "OTHER"\nEnd\n' + PLACE.format(y=0),
    "SUB.prg": 'FPrm M1\nSpd 50\nM2=M1+1\nMvs P1\nIf M2>2 Then\nHlt\nEndIf\nCallP "OTHER"\nEnd\n'
    + PLACE.format(y=20),
    "OTHER.prg": "Spd 50\nMvs P1\nMvs P1\nEnd\n" + PLACE.format(y=40),
}


def modules(folder: Path) -> dict[str, str]:
    for name, text in FILES.items():
        (folder / name).write_text(text)
    found = translate(folder / "MAIN.prg", to="rapid", proving=Proving())
    assert found.ok, [(f.code, f.message) for f in found.findings]
    assert found.motion is not None and found.motion.holds
    return {name: data.decode() for name, data in found.files.items()}


def test_each_file_is_a_module_with_its_own_places(tmp_path: Path) -> None:
    texts = modules(tmp_path)
    assert list(texts) == ["MAIN_2.mod", "SUB_2.mod", "OTHER_2.mod"]
    main, sub, other = texts.values()
    assert "SUB 1;" in main and "OTHER;" in main and "OTHER;" in sub
    assert not any("Load" in text for text in texts.values())
    assert [text.count("robtarget") for text in (main, sub, other)] == [1, 1, 1]
    assert "[400,20,300]" in sub and "[400,40,300]" in other


def test_such_modules_are_read_back_as_units_and_cross_as_one_program(tmp_path: Path) -> None:
    out = tmp_path / "rapid"
    out.mkdir()
    for name, text in modules(tmp_path).items():
        (out / name).write_text(text)
    assert {q.unit for q in load(out).program.procedures} == {None, "SUB", "OTHER"}
    back = translate(out, to="melfa-basic-6", proving=Proving())
    assert back.ok, [(f.code, f.message) for f in back.findings]
    assert back.motion is not None and back.motion.holds
    assert len(back.files) == 1


def test_headers_that_are_read_grow_with_the_units(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = [0]
    plain = header.read_header

    def counting(comments: list[str]) -> header.Header:
        read[0] += 1
        return plain(comments)

    monkeypatch.setattr(header, "read_header", counting)
    counts = []
    for contours in (6, 12):
        drawing = tmp_path / f"waves_{contours}.dxf"
        document = ezdxf.new(units=4)
        for k in range(contours):
            points = [(20 * k + 2 * j, j % 2) for j in range(10)]
            document.modelspace().add_lwpolyline(points, dxfattribs={"layer": "CUT"})
        document.saveas(drawing)
        drawing.with_suffix(".process.toml").write_text("[layers.CUT]\nspeed = 30\n")
        read[0] = 0
        made = assistant.compile(drawing, language="rapid", most_targets=12)
        assert made.ok and len(made.files) > contours
        counts.append(read[0])
    assert counts[1] <= 2.2 * counts[0]
