"""Corners that the source leaves to its controller, where the target wants a size."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from assistant.compiler import translate

POINTS = """P1=(+350.00,+20.00,+250.00,+180.00,+0.00,+180.00)(7,0)
P2=(+330.00,-60.00,+220.00,+180.00,+0.00,+165.00)(7,0)
P3=(+300.00,+60.00,+200.00,+180.00,+5.00,+170.00)(7,0)
"""
SIZES = {"z0": 0.3}
"""Radius in mm of zones that are not called by it."""


def zones(folder: Path, head: str, between: str = "") -> list[float]:
    """Radii in mm of the corners at P1 and P2, 0 for a stop."""
    text = f"Tool P_NTool\nBase P_NBase\n{head}\nMvs P1\n{between}Mvs P2\nCnt 0\nMvs P3\nEnd\n"
    file = folder / "CORNER.mb6"
    file.write_text(text + POINTS, encoding="ascii")
    found = translate(file, to="rapid", language="melfa-basic-6")
    assert found.ok, found.findings
    (data,) = found.files.values()
    moves = re.findall(r"MoveL P_?\d,\w+,(\w+)", data.decode())
    assert len(moves) == 3
    assert moves[2] == "fine"
    told = {f.message for row in found.rows for f in row.reasons if f.code == "RA306"}
    assert bool(told) == head.endswith("Cnt 1")
    return [
        0.0 if z == "fine" else SIZES.get(z) or float(re.sub(r"\D*", "", z, count=1))
        for z in moves[:2]
    ]


@pytest.mark.parametrize("between", ["", "M_Out(9)=1\n"])
@pytest.mark.parametrize("speed", [20, 100, 200, 250, 400, 2000])
def test_never_wider_than_where_braking_begins(speed: int, between: str, tmp_path: Path) -> None:
    """v² / 2a with 5 m/s², and 10 mm at most; in a path and in single moves."""
    braking = max(0.3, speed**2 / (2 * 5000.0))
    for radius in zones(tmp_path, f"Spd {speed}\nCnt 1", between):
        assert 0.0 < radius <= min(10.0, braking)


def test_of_two_sizes_the_smaller(tmp_path: Path) -> None:
    assert zones(tmp_path, "Spd 100\nCnt 1,5,5") == [5.0, 5.0]
    assert zones(tmp_path, "Spd 100\nCnt 0") == [0.0, 0.0]
