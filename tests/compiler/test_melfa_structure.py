"""Programs of MELFA-BASIC in RAPID have the shape that programmers of RAPID give them."""

from __future__ import annotations

import pytest

from assistant.compiler import Translation

from .proven import crossed

PLACES = """P1=(400,0,400,180,0,180)(7,0)
P2=(400,100,300,180,0,180)(7,0)
P3=(400,-100,300,180,0,180)(7,0)
"""
FIVE = "melfa-basic-5"


def to_rapid(code: str, places: str = PLACES, **options: int) -> Translation:
    done = crossed(f"{code.strip()}\n{places}", FIVE, "rapid", **options)
    assert done.ok, [f"{f.code} {f.message}" for f in done.findings]
    assert done.motion is not None and done.motion.holds
    return done


def lines_of(done: Translation, procedure: str) -> list[str]:
    """The lines of a procedure without its first and last one."""
    (data,) = done.files.values()
    lines = [line.strip() for line in data.decode().splitlines()]
    first = lines.index(f"PROC {procedure}()")
    return lines[first + 1 : lines.index("ENDPROC", first)]


@pytest.mark.parametrize(
    ("above", "written"),
    [
        ("' --- left pad", ["! --- left pad"]),
        ("' left pad\n' of two", ["! left pad", "! of two"]),
        ("'\n' left pad\n'", ["!", "! left pad", "!"]),
        ("\n' left pad\n\n", ["! left pad"]),
    ],
)
def test_comments_above_a_label_are_of_its_procedure(above: str, written: list[str]) -> None:
    done = to_rapid(f"Mvs P1\nGoSub *PAD\nEnd\n{above}\n*PAD\nMvs P2\nReturn\n' the end")
    assert lines_of(done, "main")[-1] == "PAD;"
    lines = lines_of(done, "PAD")
    assert lines[:-2] == written
    assert lines[-2].startswith("MoveL P2")
    assert lines[-1] == "! the end"


def test_comments_above_a_subroutine_that_loops_to_its_label() -> None:
    done = to_rapid(
        "Mvs P1\nM1=0\nGoSub *AGAIN\nEnd\n' --- twice\n*AGAIN\nM1=M1+1\nMvs P2\nMvs P3\n"
        "If M1<2 Then GoTo *AGAIN\nReturn"
    )
    assert lines_of(done, "main")[-1] == "AGAIN;"
    assert lines_of(done, "AGAIN")[0] == "! --- twice"


def test_comments_above_subroutines_that_share_their_end() -> None:
    done = to_rapid(
        "Mvs P1\nGoSub *LEFT\nGoSub *RIGHT\nEnd\n' --- left\n*LEFT\nMvs P2\nGoTo *BOTH\n"
        "' --- right\n*RIGHT\nMvs P3\n*BOTH\nMvs P1\nReturn"
    )
    assert lines_of(done, "LEFT")[0] == "! --- left"
    assert lines_of(done, "RIGHT")[0] == "! --- right"
