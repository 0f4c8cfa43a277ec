"""Cures of tables and files of waypoints."""

from __future__ import annotations

import io
from typing import Final

import numpy as np

from tests.findings.cures.case import Case

CROWD: Final = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n500,0,500,0,0,1,0\n510,0,500,0,0,1,0\n"
TARGET: Final = """\
[[targets]]
name = "a"
position = [400, 0, 400]
quaternion = [0, 0, 1, 0]
"""
FOLDED: Final = """\
robot = "irb1200-7-0.7"
[[targets]]
name = "a"
kind = "{}"
joints = [0, 0, 0, 0, 30, 0]
"""
BRANCH: Final = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,back,down,flip,quadrant1,quadrant4,quadrant6\n"
MIXED: Final = """\
x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,j1_deg,j2_deg,j3_deg,j4_deg,j5_deg,j6_deg
500,0,500,0,0,1,0,,,,,,
,,,,,,,0,0,0,0,30,0
"""
STEPS: Final = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n" + "".join(
    f"{500 + k / 100},0,500,0,0,1,0\n" for k in range(20)
)
METRES: Final = (
    '{"poses": [[[1,0,0,0.4],[0,-1,0,0],[0,0,-1,0.4],[0,0,0,1]],'
    "[[1,0,0,0.5],[0,-1,0,0],[0,0,-1,0.4],[0,0,0,1]]]}"
)
TURNS: Final = (
    ",".join(f"j{n}_rad" for n in range(1, 7))
    + "\n"
    + "".join(f"{k},0,0,0,{40 + k},0\n" for k in range(8))
)
NAMED_TURNS: Final = "name," + "".join(
    line if not k else f"p{k},{line}" for k, line in enumerate(TURNS.splitlines(keepends=True))
)
NAMED: Final = "name," + MIXED.replace("\n500", "\na,500").replace("\n,", "\nb,,")


def npz(**arrays: object) -> bytes:
    """An archive of numpy."""
    file = io.BytesIO()
    np.savez(file, **{name: np.array(rows, float) for name, rows in arrays.items()})  # type: ignore[arg-type]
    return file.getvalue()


CASES: Final = (
    Case(
        "TB108",
        "check a.csv",
        {"a.csv": "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,wait_s\n500,0,500,0,0,1,0,1\n"},
        change={"a.csv": "name,x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,wait_s\na,500,0,500,0,0,1,0,1\n"},
    ),
    Case(
        "TB315",
        "check a.csv",
        {"a.csv": STEPS},
        change={"a.process.toml": "tolerance = 0.01\n"},
    ),
    Case(
        "TB315",
        "check a.csv",
        {"a.csv": STEPS},
        change={"a.process.toml": "[motion]\nblend = 0.01\n"},
    ),
    Case("TB133", "check a.csv", {"a.csv": MIXED}, change={"a.csv": NAMED}),
    Case(
        "TB134",
        "check a.csv",
        {"a.csv": BRANCH + "500,0,500,0,0,1,0,1,,,,,\n"},
        change={"a.csv": BRANCH + "500,0,500,0,0,1,0,0,0,1,0,0,0\n"},
    ),
    Case(
        "TB502",
        "check a.toml",
        {"a.toml": "targets = 1\n"},
        change={"a.toml": TARGET},
    ),
    Case(
        "TB501",
        "check a.toml",
        {"a.toml": "\n"},
        change={"a.toml": TARGET},
    ),
    Case(
        "TB503",
        "check a.toml",
        {"a.toml": '[[targets]]\nname = "a"\n'},
        change={"a.toml": TARGET},
    ),
    Case(
        "TB503",
        "check a.toml",
        {"a.toml": '[[targets]]\nname = "a"\n'},
        change={"a.toml": FOLDED.replace('kind = "{}"\n', "")},
    ),
    Case(
        "TB504",
        "check a.toml",
        {"a.toml": '[[targets]]\nname = "a"\nposition = [400, 0, 400]\n'},
        change={"a.toml": TARGET},
    ),
    Case(
        "TB504",
        "check a.toml",
        {"a.toml": '[[targets]]\nname = "a"\nposition = [400, 0, 400]\n'},
        change={
            "a.toml": '[[targets]]\nname = "a"\nposition = [400, 0, 400]\neuler_zyx = [0, 180, 0]\n'
        },
    ),
    Case(
        "TB514",
        "check a.toml",
        {"a.toml": "moves = 1\n" + TARGET},
        change={"a.toml": '[[moves]]\nto = "a"\n' + TARGET},
    ),
    Case(
        "TB515",
        "check a.toml",
        {"a.toml": 'moves = ["none"]\n' + TARGET},
        change={"a.toml": 'moves = ["a"]\n' + TARGET},
    ),
    Case(
        "TB516",
        "check a.toml",
        {"a.toml": 'moves = ["a"]\n' + TARGET + TARGET.replace('"a"', '"b"')},
        change={"a.toml": 'moves = ["a", "b"]\n' + TARGET + TARGET.replace('"a"', '"b"')},
    ),
    Case(
        "TB505",
        "check a.toml",
        {"a.toml": FOLDED.format("linear")},
        change={"a.toml": FOLDED.format("joint")},
    ),
    Case(
        "TB313",
        "check a.csv",
        {"a.csv": CROWD, "a.process.toml": '[motion]\nkind = "travel"\n'},
        change={"a.process.toml": '[motion]\nkind = "joint"\n'},
    ),
    Case(
        "TB208",
        "check a.json",
        {"a.json": METRES},
        change={"a.json": METRES.replace("}", ', "unit": "m"}')},
    ),
    Case(
        "RB129",
        "check a.csv -r irb1200-7-0.7",
        {"a.csv": TURNS},
        change={"a.csv": TURNS.replace("_rad", "_deg")},
    ),
    Case(
        "RB129",
        "check a.csv -r irb1200-7-0.7",
        {"a.csv": NAMED_TURNS},
        change={"a.csv": NAMED_TURNS.replace("_rad", "_deg")},
    ),
    Case("TB208", "check a.json", {"a.json": METRES}, change={"a.process.toml": 'unit = "m"\n'}),
    Case(
        "TB415",
        "check a.npz",
        {"a.npz": npz(positions=[[400, 0, 400]])},
        change={"a.npz": npz(positions=[[400, 0, 400]], quaternions=[[0, 0, 1, 0]])},
    ),
    Case(
        "TB454",
        "pose a.csv --from kuka --to rapid",
        {"a.csv": "px,py,pz,rz,ry,rx\n1,2,3,4,5,6\n"},
        then=("pose a.csv --from kuka --to rapid --columns px,py,pz,rz,ry,rx",),
    ),
    Case(
        "CL076",
        "pose 1 2 3 0 0 0 1 --from xyzw --to rapid",
        then=("pose 1 2 3 0 0 0 1 --from xyzw --to rapid --unit m",),
    ),
    Case(
        "CL077",
        "pose 1 2 3 0 0 0 --from kuka --to rapid --columns X,Y,Z,A,B,C",
        {"a.csv": "X,Y,Z,A,B,C\n1,2,3,4,5,6\n"},
        then=("pose a.csv --from kuka --to rapid --columns X,Y,Z,A,B,C",),
    ),
    Case(
        "CL077",
        "pose 1 2 3 0 0 0 --from kuka --to rapid --columns X,Y,Z,A,B,C",
        then=("pose 1 2 3 0 0 0 --from kuka --to rapid",),
    ),
    Case(
        "TB422",
        "check a.json",
        {"a.json": "5"},
        change={"a.json": '{"poses": [[[1,0,0,400],[0,-1,0,0],[0,0,-1,400],[0,0,0,1]]]}'},
    ),
    Case(
        "TB422",
        "check a.json",
        {"a.json": "5"},
        change={"a.json": '{"paths": {"seam": [[[1,0,0,400],[0,-1,0,0],[0,0,-1,400],[0,0,0,1]]]}}'},
    ),
)
