"""Cures of programs that were edited since they were written."""

from __future__ import annotations

from typing import Final

from tests.findings.cures.case import Case

AXES: Final = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]"


def module(
    named: str = "[400,0,300]",
    start: str = "[400,50,300]",
    end: str = "[450,50,300]",
    speed: str = "v50",
    comment: str = "",
) -> str:
    """A point that somebody named, and a contour that has a number."""
    return f"""\
MODULE p
    CONST robtarget pick:=[{named},[0,1,0,0],{AXES}];
    CONST robtarget bead_1_start:=[{start},[0,1,0,0],{AXES}];
    CONST robtarget bead_1_end:=[{end},[0,1,0,0],{AXES}];{comment}

    PROC main()
        MoveJ pick,v100,fine,tool0;
        MoveL bead_1_start,{speed},fine,tool0;
        MoveL bead_1_end,v50,fine,tool0;
    ENDPROC
ENDMODULE
"""


WITHOUT: Final = "\n".join(line for line in module().split("\n") if "bead_1_end" not in line)
COMPILE: Final = "compile p.mod -l rapid -o out"


def case(code: str, edited: str, source: str, option: str) -> Case:
    """A program that was written, its file edited, and its source changed."""
    return Case(
        code,
        COMPILE,
        {"p.mod": module()},
        (f"{COMPILE} {option}",),
        before=(COMPILE,),
        between={"out/p.mod": edited, "p.mod": source},
    )


NEAR: Final = module(named="[400,0,299]")
CASES: Final = (
    case("CO330", NEAR, module(), "--overwrite"),
    Case("CO331", COMPILE, {"p.mod": module(), "out/p.mod": NEAR}, (f"{COMPILE} --overwrite",)),
    case("CO332", NEAR, module(named="[405,0,300]"), "--keep-edit pick"),
    case("CO332", NEAR, module(named="[405,0,300]"), "--drop-edit pick"),
    case(
        "CO333",
        module(start="[400,51,300]"),
        module(start="[400,80,300]", end="[450,80,300]"),
        "--drop-edit bead_1_start",
    ),
    case("CO334", module(speed="v30"), module(end="[460,50,300]"), "--drop-edit bead_1"),
    case("CO336", "MODULE p\n", module(named="[405,0,300]"), "--overwrite"),
    case("CO337", module(comment=" ! measured"), WITHOUT, "--overwrite"),
)
