"""Commands that write, each with what it is given and what was there before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

NAMES: Final = ("one", "two", "three")
MODULE: Final = """\
MODULE {0}
PERS num done:=0;
PROC main()
MoveL [[500,0,{1}],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
done:=done+1;
Save "{0}"\\FilePath:="HOME:/kept.mod";
ENDPROC
ENDMODULE
"""
LISTING: Final = "10 SPD 50\r\n20 DLY 1\r\n30 END\r\n"
TABLE: Final = """\
x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z
500,0,500,0,0,1,0
510,{0},500,0,0,1,0
520,{0},510,0,0,1,0
"""
CORNER: Final = """\
v 0 0 0
v 90 0 0
v 0 90 0
v 0 0 90
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""
PROJECT: Final = """\
[controllers.cell1]
address = "virtual:irc5"
robot = "irb1200-7-0.7"

[programs.one]
source = "one.csv"
[programs.two]
source = "two.csv"
[programs.three]
source = "three.csv"

[targets.cell1]
programs = ["one", "two", "three"]
"""
CELL: Final = '[controllers.cell1]\naddress = "virtual:cr"\nrobot = "rv-2aj"\n'
ROBOT_CELL: Final = '[robots.arm]\nrobot = "rv-2aj"\n'
WANDER: Final = (
    *("explore", "wander", "one.toml", "--runs", "1", "--seed", "1"),
    *("--size", "40", "--chart", "one.npz"),
)
STORE: Final = ".robot-assistant/virtual/cell1/programs"


@dataclass(frozen=True, slots=True)
class Command:
    """words: of the command line. given: files by name, for three programs.

    before: what is run to have something there; then: what is given anew behind that. over: every
    other file that it writes holds something else before. together: all that it writes is there, or
    nothing of it. again: it can be run once more when all is there. books: files that tell what was
    done, which are whole but of neither old nor new after a part of it.
    """

    words: tuple[str, ...]
    given: Mapping[str, str]
    before: tuple[tuple[str, ...], ...] = ()
    then: Mapping[str, str] = field(default_factory=dict)
    over: bool = True
    together: bool = True
    again: bool = True
    books: frozenset[str] = frozenset()


TABLES: Final = {f"{name}.csv": TABLE.format(y) for y, name in enumerate(NAMES)}
OTHERS: Final = {f"{name}.csv": TABLE.format(y + 5) for y, name in enumerate(NAMES)}
MODULES: Final = {f"{name}.mod": MODULE.format(name, 500) for name in NAMES}
LISTINGS: Final = {f"{STORE}/{name.upper()}.prg": LISTING for name in NAMES}
BUILD: Final = ("build", "--jobs", "1")
TEACH: Final = ("teach", "cell1", "--now", "--into", "points.toml")
GET: Final = ("get", "cell1", "ONE", "TWO", "THREE", "-o", "out", "--replace")
MEASURED: Final = (
    Path(__file__).parents[2].joinpath("samples/calibration/rv-2aj.csv").read_text("utf-8")
)
SIMULATED: Final = ("out/one.csv", "out/one.npz", "out/one.moves.csv")

COMMANDS: Final[Mapping[str, Command]] = {
    "compile": Command(
        ("compile", *TABLES, "--language", "rapid", "-o", "out", "--overwrite"),
        TABLES,
    ),
    "fmt": Command(("fmt", *MODULES), MODULES, over=False, together=False),
    "translate": Command(
        ("translate", *MODULES, "--to", "melfa-basic-5", "-o", "out", "--report", "out.json"),
        {name: text.replace("Save", "! Save") for name, text in MODULES.items()},
        together=False,
    ),
    "show": Command(("show", "one.csv", "-o", "one.pseudo"), TABLES),
    "simulate": Command(
        (*("simulate", "one.mod", "--robot", "irb1200-7-0.7"), *(f"-o{one}" for one in SIMULATED)),
        {name: text.replace("Save", "! Save") for name, text in MODULES.items()},
    ),
    "report": Command(
        ("simulate", "one.mod", "--robot", "irb1200-7-0.7", "--report", "out/one.html"),
        {name: text.replace("Save", "! Save") for name, text in MODULES.items()},
    ),
    "scene": Command(
        ("scene", "one.toml", "-o", "out/cell.toml"),
        {"one.toml": "[bodies.a]\nmesh = 'a.obj'\nunit = 'mm'\n", "a.obj": CORNER},
    ),
    "view": Command(
        ("view", "one.mod", "--robot", "irb1200-7-0.7", "--html", "out/one.html"),
        {name: text.replace("Save", "! Save") for name, text in MODULES.items()},
    ),
    "run": Command(
        ("run", "one.mod", "--trace", "one.npz", "--disk", "disk"),
        {**MODULES, "disk/kept.mod": MODULE.format("kept", 1)},
        together=False,
        books=frozenset({"one.npz"}),
    ),
    "calibrate": Command(
        ("robots", "calibrate", "rv-2aj", "one.csv", "--estimate", "chain", "-o", "out/one.toml"),
        {"one.csv": MEASURED},
    ),
    "learn": Command(
        (
            *("learn", "rv-2aj", "--steps", "16", "--hold", "J5=0", "--hold", "J6=0"),
            *("--lattice", "3x3x3", "--curve", "out/one.csv", "-o", "out/one.npz"),
        ),
        {},
    ),
    "lsp": Command(("lsp", "--extension", "out/one.vsix"), {}),
    "poses": Command(("robots", "poses", "rv-2aj", "--count", "6", "-o", "out/one.csv"), {}),
    "pose": Command(
        ("pose", "one.csv", "--from", "rapid", "--to", "kuka", "-o", "out/one.csv"),
        {"one.csv": TABLE.format(9)},
    ),
    "kinematics": Command(("kinematics", "rv-2aj", "-o", "out"), {}),
    "exchange": Command(("exchange", "module", "-o", "exchange.mod"), {}),
    "explore": Command(
        ("explore", "merge", "one.npz", "-o", "all.npz"), {"one.toml": ROBOT_CELL}, (WANDER,)
    ),
    "reach": Command(
        (
            *(
                "reach",
                "map",
                "--robot",
                "irb1200-7-0.7",
                "--x",
                "400",
                "--y",
                "0",
                "--z",
                "300:400:50",
            ),
            *(f"-o{one}" for one in ("out/one.csv", "out/one.npz")),
        ),
        {},
    ),
    "init": Command(("init", "."), {}, over=False),
    "build": Command(
        BUILD,
        {"assistant.toml": PROJECT, **TABLES},
        (BUILD,),
        OTHERS,
        over=False,
        together=False,
        books=frozenset({".robot-assistant/build.json"}),
    ),
    "teach": Command(
        (*TEACH, "two"), {"assistant.toml": CELL}, ((*TEACH, "one"),), over=False, again=False
    ),
    "get": Command(GET, {"assistant.toml": CELL, "out/keep": "", **LISTINGS}),
    "backup": Command(
        ("backup", "cell1", "kept"), {"assistant.toml": CELL, **LISTINGS}, over=False, again=False
    ),
}
