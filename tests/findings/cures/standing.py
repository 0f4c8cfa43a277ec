"""Cures of programs that stand among others of their controller."""

from __future__ import annotations

from typing import Any, Final

from tests.findings.cures.case import Case, dxf
from tests.findings.cures.drawings import line

DRAWN: Final = {"a.dxf": dxf(line)}
RAPID: Final = "compile a.dxf -l rapid"
MELFA: Final = "compile a.dxf -l melfa-basic-5"
MOVING: Final = {"b.pseudo": "program b\n\nprocedure main\n  wait 1 s\nend\n"}
KEPT: Final = {
    "c.mod": "MODULE c\nPROC main()\nrun;\nENDPROC\nPROC run()\nActUnit m7;\nENDPROC\nENDMODULE\n"
}
TOOL: Final = '[tools.{name}]\ntip = [0, 0, 60]\n{more}[motion]\ntool = "{name}"\n'


def _long(space: Any) -> None:
    space.add_lwpolyline([(10 * n, 5 * (n % 2)) for n in range(30)])


def _process(text: str) -> dict[str, str]:
    return {"a.process.toml": text}


def _program(text: str) -> dict[str, str]:
    return _process(f"[program]\n{text}")


def _tool(more: str, name: str = "gun") -> dict[str, str]:
    return _process(TOOL.format(name=name, more=more))


def _second(process: str, name: str = "b") -> dict[str, str]:
    """Another drawing, which goes with the first."""
    return {f"{name}.dxf": dxf(line), f"{name}.process.toml": process}


GUN: Final = '[motion]\ntool = "gun"\n[tools.gun]\ntip = [0, 0, 60]\n'
TABLE_TOOL: Final = {"a.process.toml": GUN}
LONG: Final = GUN.replace("60", "61")
BOTH: Final = "compile a.dxf b.dxf -l rapid --together both -o out"
NESTED: Final = "compile a.dxf c/a.dxf -l rapid --together both -o out"
THERE: Final = "on_controller = true\n"
CASES: Final = (
    Case("CO321", f"{RAPID} --as cut", DRAWN, change=_program('prefix = "left_"\n')),
    Case(
        "CO324",
        "compile b.pseudo -l rapid -p a.process.toml",
        MOVING | _program("main = false\n"),
        change=_program('as = "Go"\n'),
    ),
    Case("CO325", MELFA, DRAWN | _program("main = false\n"), change=_program("local = true\n")),
    Case("CO325", f"{MELFA} --no-main", DRAWN, (MELFA,)),
    Case(
        "CO326",
        RAPID,
        DRAWN | _program('as = "Go"\nmain = false\n'),
        change=_program("main = false\n"),
    ),
    Case(
        "CO326",
        RAPID,
        DRAWN | _program('as = "Go"\nmain = false\n'),
        change=_program('as = "Go"\n'),
    ),
    Case(
        "CO327",
        "compile c.mod -l rapid -p a.process.toml -o out",
        KEPT | _program('prefix = "left_"\n'),
        change=_program('as = "Go"\n'),
    ),
    Case("CO328", RAPID, DRAWN | _tool("number = 2\n"), change=_tool(f"number = 2\n{THERE}")),
    Case("CO328", RAPID, DRAWN | _tool("number = 2\n"), change=_tool("")),
    Case("CO329", MELFA, DRAWN | _tool(THERE), change=_tool(f"number = 2\n{THERE}")),
    Case("CO329", RAPID, DRAWN | _tool(THERE, "Default"), change=_tool("", "Default")),
    Case(
        "CK305",
        "check a.csv -r rv-4frl",
        {"a.csv": "x_mm,y_mm,z_mm,qw,qx,qy,qz\n350,0,300,0,1,0,0\n350,20,300,0,1,0,0\n"}
        | TABLE_TOOL,
        change={"a.process.toml": f"{GUN}euler_zyx = [180, 0, 0]\n"},
    ),
    Case(
        "CT369",
        "compile a.dxf -l rapid -o out",
        DRAWN | {"a.process.toml": f'assumed = ["tip of gun"]\n{GUN}'},
        change={"a.process.toml": GUN},
    ),
    Case("CL071", BOTH, DRAWN | _process(GUN) | _second(LONG), change={"b.process.toml": GUN}),
    Case(
        "CL072",
        NESTED,
        DRAWN | _second("tolerance = 0.05\n", "c/a"),
        change={"c/a.process.toml": '[program]\nprefix = "c_"\nas = "c"\n'},
    ),
    Case(
        "CL075",
        "compile a.dxf main.dxf -l rapid --together both -o out",
        DRAWN | _second("tolerance = 0.05\n", "main"),
        change={"main.process.toml": '[program]\nas = "right"\n'},
    ),
    Case(
        "CL073",
        "compile a.dxf b.dxf -l rapid --as Go -o out",
        DRAWN | _second("tolerance = 0.05\n"),
        (BOTH,),
    ),
    Case(
        "CL078",
        "compile a.dxf -l rapid -o out --on cluster",
        DRAWN,
        ("compile a.dxf -l rapid -o out --on dask",),
        slow=True,
    ),
    Case(
        "CL079",
        "compile a.dxf -l rapid -o out --jobs 2 --on dask://127.0.0.1:8786",
        DRAWN,
        ("compile a.dxf -l rapid -o out --jobs 2 --on dask",),
        slow=True,
    ),
    Case(
        "CL074",
        f"{RAPID} --most-targets 10 -o out",
        {"a.dxf": dxf(_long)} | _program("local = true\n"),
        (f"{RAPID} --most-targets 50 -o out",),
    ),
    Case(
        "CL074",
        f"{RAPID} --most-targets 10 -o out",
        {"a.dxf": dxf(_long)} | _program("local = true\n"),
        change=_program('prefix = "left_"\n'),
    ),
)
