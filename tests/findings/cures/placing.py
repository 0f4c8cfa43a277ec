"""Cures of drawings that are placed, and of what a command line may leave to a project."""

from __future__ import annotations

from typing import Final

from tests.findings.cures.case import Case, dxf
from tests.findings.cures.drawings import HERE, line, square

DRAWN: Final = {"a.dxf": dxf(line)}
MARKS: Final = "--mark 0,0=0,0,0 --mark 90,0=90,0,0"
FITTING: Final = (
    "drawing = [[0, 0], [90, 0], [0, 50]]\ncell = [[0, 0, 0], [90, 0, 0], [0, 50, 0]]\n"
)
WIDE: Final = "drawing = [[0, 0], [90, 0], [0, 50]]\ncell = [[0, 0, 0], [92, 0, 0], [0, 50, 0]]\n"
OVER: Final = "drawing = [[0, 0], [90, 0], [0, 50]]\ncell = [[0, 0, 0], [90, 0, 0], [0, -50, 0]]\n"
ALONE: Final = "drawing = [[0, 0], [90, 0], [0, 50]]\n"


def _process(text: str) -> dict[str, str]:
    return {"a.process.toml": f"[placement]\n{text}"}


POSED: Final = "position = [0, 0, 0]\neuler_zyx = [0, 0, 180]\n"
TURNED: Final = "position = [0, 0, 0]\nquaternion = [1, 0, 0, 0]\n"
ROWS: Final = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n400,0,300,0,1,0,0\n420,0,300,0,1,0,0\n"
METRES: Final = ROWS.replace("400,0,300", "0.4,0,0.3").replace("420,0,300", "0.42,0,0.3")
IN_METRES: Final = METRES.replace("x_mm,y_mm,z_mm", "x_m,y_m,z_m")
TABLE: Final = {"a.csv": ROWS, **_process("position = [0, 9, 0]\n")}

SMALL, LARGE = "-r irb1200-7-0.7", "-r irb4600-20-2.50"
AT_BASE: Final = {"a.dxf": dxf(square)}
PLACED: Final = '[motion]\nframe = "table"\n[frames.table]\nposition = [1200, -40, 500]\n'

PROJECT: Final = """\
[controllers]
left = "virtual:irc5"
right = "virtual:cr"
[programs.a]
source = "a.dxf"
[programs.b]
source = "a.dxf"
language = "melfa-basic-5"
[targets.left]
programs = ["a"]
[targets.right]
programs = ["b"]
"""

APART: Final = PROJECT.replace('[programs.b]\nsource = "a.dxf"', '[programs.b]\nsource = "b.dxf"')

FAR: Final = {"a.process.toml": PLACED}
"""In the robot's reach."""

CASES: Final = (
    Case("CO340", f"check a.dxf {LARGE}", AT_BASE, (f"check a.dxf {LARGE} --place 1200,0,500",)),
    Case("CO340", f"check a.dxf {LARGE}", AT_BASE, change=FAR),
    Case(
        "CO340",
        f"check a.dxf {LARGE}",
        AT_BASE,
        change=_process("position = [1200, 0, 500]\n"),
    ),
    Case("CO340", f"check a.dxf {SMALL}", AT_BASE, change={"a.process.toml": HERE}),
    Case(
        "CO340",
        f"check a.dxf {SMALL}",
        AT_BASE,
        change=_process("position = [450, -40, 300]\n"),
    ),
    Case("CO340", f"check a.dxf {SMALL}", AT_BASE, (f"check a.dxf {SMALL} --place 450,-40,300",)),
    Case("CO340", f"check a.csv {SMALL}", {"a.csv": METRES}, change={"a.csv": IN_METRES}),
    Case("TB208", "check a.csv", {"a.csv": METRES}, change={"a.csv": IN_METRES}),
    Case("CL050", "info a.csv", {"a.csv": ROWS}, ("show a.csv",)),
    Case("CT360", "check a.dxf", DRAWN | _process(WIDE), change=_process(WIDE + "misfit = 2\n")),
    Case("CT362", "check a.dxf", DRAWN | _process(OVER), change=_process(FITTING)),
    Case("CT362", "check a.dxf", DRAWN | _process(OVER), change=_process(POSED)),
    Case("CT363", "check a.dxf", DRAWN | _process(ALONE), change=_process(FITTING)),
    Case("CT363", "check a.dxf", DRAWN | _process(ALONE), change=_process(POSED)),
    Case("CT363", "check a.dxf", DRAWN | _process(ALONE), change=_process(TURNED)),
    Case(
        "CT365",
        "check a.dxf --place 0,0,5",
        DRAWN | _process("position = [0, 9, 0]\n"),
        ("check a.dxf",),
    ),
    Case(
        "CT365",
        f"check a.dxf {MARKS} --mark 0,50=0,50,0",
        DRAWN | _process("position = [0, 9, 0]\n"),
        ("check a.dxf",),
    ),
    Case("CT367", f"check a.dxf {MARKS}", DRAWN, (f"check a.dxf {MARKS} --mark 0,50=0,50,0",)),
    Case("CT368", "check a.csv", TABLE, change={"a.process.toml": 'robot = "irb1200-7-0.7"\n'}),
    Case("CT368", "check a.csv --place 0,9,0", {"a.csv": ROWS}, ("check a.csv",)),
    Case(
        "CT368",
        f"check a.csv {MARKS} --mark 0,50=0,50,0",
        {"a.csv": ROWS},
        ("check a.csv",),
    ),
    Case("CL052", "init --unit in", then=("init a.dxf --unit in",), files=DRAWN),
    Case("CL052", "init --unit in", then=("init",)),
    Case("CL053", "compile a.dxf", DRAWN, ("compile a.dxf --language rapid",)),
    Case(
        "PR304",
        "compile a.dxf",
        DRAWN | {"assistant.toml": PROJECT},
        ("compile a.dxf --language rapid",),
    ),
    Case("PR304", "compile a.dxf", DRAWN | {"assistant.toml": PROJECT}, ("build",)),
    Case(
        "CL054",
        "compile a.dxf b.dxf",
        DRAWN | {"b.dxf": DRAWN["a.dxf"], "assistant.toml": APART},
        ("compile a.dxf",),
    ),
    Case(
        "CL054",
        "compile a.dxf b.dxf",
        DRAWN | {"b.dxf": DRAWN["a.dxf"], "assistant.toml": APART},
        ("build",),
    ),
)
