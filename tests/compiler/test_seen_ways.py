"""Which ways of a program are looked at for collisions, and what is said of the others."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import check_files

pytest.importorskip("coal")

CELL = Path("samples/cell/clamped.toml").resolve()
"""Its clamp stands between `one` and `two`."""
MOTION = "speed 500 mm/s blend fine tool grip frame plate"
HEAD = f"""program seen for irb1200-7-0.7
tool grip tip [0, 0, 58]
frame plate object [272, 0, 260]
frame low object [272, 0, 220]
target one [-10, -60, 15] [0, 0, 1, 0]
target two [-10, 40, 15] [0, 0, 1, 0]
target up [-10, -60, 150] [0, 0, 1, 0]
target over [-10, 40, 150] [0, 0, 1, 0]
signal part digital input 1
signal count group input 2
variable unset position
procedure main
move joint up {MOTION}
"""
ROUND = [f"move linear {name} {MOTION}" for name in ("one", "up", "over", "two")]
"""Clear, but not from its end to its start."""


def codes(folder: Path, lines: list[str]) -> set[str]:
    file = folder / "seen.pseudo"
    file.write_text("\n".join([HEAD + lines[0], *lines[1:], "end", ""]), encoding="utf-8")
    found = check_files([file], cell=CELL).findings
    return {one.code for one in found} & {"CK421", "CK424"}


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        (ROUND, set()),
        (["while part = 1", *ROUND, "end"], {"CK421"}),
        (["while 1 = 1", *ROUND, "end"], {"CK421"}),
        (["for i from 1 to count", *ROUND, "end"], {"CK421"}),
        (["while part = 1", *ROUND, *ROUND[2:0:-1], "end"], set()),
        # Left out: from `one`, where no round is gone.
        ([ROUND[0], "while part = 1", *ROUND[1:3], "end", ROUND[3]], {"CK421"}),
        (["while part = 1", ROUND[2], "return", "end", *ROUND], set()),
        (["while part = 1", "return", "end", ROUND[0], ROUND[3]], {"CK421"}),
        # What is not looked at is told of.
        (["label again", *ROUND, "goto again"], {"CK424"}),
        ([*ROUND[:1], f"move linear unset {MOTION}"], {"CK424"}),
        ([ROUND[0], f"{ROUND[1]} until part = 1", ROUND[2]], {"CK424"}),
        (["plate = low", ROUND[1]], {"CK424"}),
    ],
)
def test_ways_are_looked_at_or_told_of(tmp_path: Path, lines: list[str], found: set[str]) -> None:
    assert codes(tmp_path, lines) == found
