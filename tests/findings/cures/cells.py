"""Cures of cells, of what programs touch in them, of space that nobody has explored."""

from __future__ import annotations

from typing import Final

from tests.cell.test_urdf_bodies import CHAIN, shape, urdf
from tests.findings.cures.case import Case, sample

ACROSS: Final = """\
program across{arm}
target a [400, -100, 400] [0, 0, 1, 0]
target b [400, 100, 400] [0, 0, 1, 0]
procedure main
  move joint a speed 200 mm/s blend fine
  move {kind} b speed 100 mm/s blend fine
end
"""
LINE: Final = ACROSS.format(arm="", kind="linear")
FOR_ARM: Final = ACROSS.format(arm=" for irb1200-7-0.7", kind="linear")
ROBOT: Final = '[robots.arm]\nrobot = "irb1200-7-0.7"\n'
POST: Final = "[bodies.post]\nbox = [60, 60, 500]\nposition = [400, 0, 250]\n"
HELD: Final = '[robots.arm]\nrobot = "irb1200-7-0.7"\ntool = "gripper"\n'
TWO: Final = (
    ROBOT
    + ROBOT.replace("arm", "left")
    + "position = [0, 1500, 0]\n"
    + POST.replace("400, 0", "400, 3000")
)
OPEN: Final = "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 0 0 90\nf 1 3 2\nf 1 2 4\nf 1 4 3\n"
FAR: Final = '\nallowed = [["post", "arm"]]\n'
HIDDEN: Final = {"c.toml": sample("cell/stand.toml")}
NEEDLE: Final = '[robots.arm]\nrobot = "irb1200-7-0.7"\ntool = "needle"\n'
SEEN: Final = "[bodies.wall.locations.top]\nposition = [0, 0, 5]\n"
BODY: Final = "[bodies.needle]\ncylinder = [1, 200]\nposition = [0, 0, 100]\n"
BESIDE: Final = (
    NEEDLE
    + BODY.replace("200", "80").replace("100]", "40]")
    + "[bodies.plate]\nbox = [30, 0.2, 30]\nposition = [400, 0, 330]\n"
)
GUN: Final = FOR_ARM.replace(
    "target a", "tool gun tip [0, 0, 200] mass 1 kg centre [0, 0, 50]\ntarget a", 1
).replace("fine", "fine tool gun")
WALL: Final = "[bodies.wall]\nbox = [10, 10, 10]\nposition = [0, 3000, 0]\n"
PLATE: Final = {"a.dxf": sample("plate.dxf"), "a.process.toml": sample("plate.process.toml")}
CLAMPED: Final = sample("cell/clamped.toml").decode()

OTHER: Final = (
    ROBOT.replace("arm", "second").replace("irb1200-7-0.7", "rv-4frl") + "position = [0, 3000, 0]\n"
)
BARE: Final = '[robots.arm]\nrobot = "rv-2aj"\n'
CELL: Final = '[controllers.cell1]\naddress = "virtual:cr"\nrobot = "rv-2aj"\n'
WANDER: Final = "explore wander w.toml --runs 1 --seed 1 --size 40"
AJ: Final = """\
program across for rv-2aj
target a [250, -50, 300] [0, 0, 1, 0]
procedure main
  move joint a speed 50 mm/s blend fine
end
"""
WAY: Final = FOR_ARM.replace("move linear b", "travel to b").replace("400, 100, 400", "400, 0, 400")
MOVED: Final = (
    ROBOT
    + """\
[bodies.cube]
box = [40, 40, 40]
position = [300, 0, 20]
[bodies.cube.locations.top]
position = [0, 0, 120]
quaternion = [0, 0, 1, 0]
[bodies.wall]
box = [100, 100, 100]
position = [500, 0, 50]
"""
)
URDF: Final = '[robots.arm]\nrobot = "arm.urdf"\n'
DRAWN: Final = urdf(CHAIN, {"base": shape('<sphere radius="0.05"/>')})
MESHED: Final = urdf(CHAIN, {"base": shape('<mesh filename="link.stl"/>')})

CASES: Final = (
    Case(
        "CK406",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": FOR_ARM, "c.toml": HELD},
        change={"c.toml": HELD + "[bodies.gripper]\nbox = [9, 9, 9]\nposition = [0, 0, 9]\n"},
    ),
    Case(
        "CK408",
        "check a.pseudo --cell c.toml",
        {
            "a.pseudo": FOR_ARM,
            "m.obj": OPEN,
            "c.toml": ROBOT + '[bodies.m]\nmesh = "m.obj"\nunit = "mm"\n',
        },
        change={"c.toml": ROBOT + '[bodies.m]\nconvex = "m.obj"\nunit = "mm"\n'},
    ),
    Case(
        "CK412",
        "check a.pseudo --cell c.toml",
        {
            "a.pseudo": FOR_ARM,
            "m.obj": OPEN,
            "c.toml": ROBOT + '[bodies.m]\nconvex = "m.obj"\nposition = [0, 3000, 0]\n',
        },
        change={
            "c.toml": ROBOT + '[bodies.m]\nconvex = "m.obj"\nunit = "mm"\nposition = [0, 3000, 0]\n'
        },
    ),
    Case(
        "CK421",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": LINE, "c.toml": BESIDE},
        change={"c.toml": '[world]\nallowed = [["needle", "plate"]]\n' + BESIDE},
    ),
    Case(
        "CK423",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": FOR_ARM, "c.toml": ROBOT.replace("irb1200-7-0.7", "rv-4frl") + WALL},
        ("check a.pseudo --cell c.toml --robot rv-4frl",),
    ),
    Case(
        "CK423",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": FOR_ARM, "c.toml": WALL + OTHER},
        change={"c.toml": ROBOT + WALL + OTHER},
    ),
    Case(
        "CK425",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": FOR_ARM, "c.toml": TWO},
        ("check a.pseudo --cell c.toml --robot arm",),
    ),
    Case(
        "CO075",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": LINE, "c.toml": TWO},
        ("check a.pseudo --cell c.toml --robot arm",),
    ),
    Case(
        "CO076",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": FOR_ARM, "c.toml": "[world]\nmargin = 5\n"},
        change={"c.toml": ROBOT + WALL},
    ),
    Case(
        "CK427",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": GUN, "c.toml": ROBOT + WALL},
        change={"c.toml": NEEDLE + BODY + WALL},
    ),
    Case(
        "CK470",
        "check a.pseudo --robot irb1200-7-0.7",
        {"a.pseudo": FOR_ARM.replace("move linear b", "travel to b"), "c.toml": ROBOT + WALL},
        ("check a.pseudo --robot irb1200-7-0.7 --cell c.toml",),
        slow=True,
    ),
    Case(
        "CK490",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": FOR_ARM, "c.toml": ROBOT + 'unknown = "free"\n' + WALL},
        change={"c.toml": ROBOT + WALL},
    ),
    Case(
        "CK490",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": AJ, "w.toml": BARE, "c.toml": BARE + 'unknown = "free"\n'},
        change={"c.toml": BARE + 'unknown = "free"\nexplored = "arm.npz"\n'},
        before=(f"{WANDER} --chart arm.npz",),
        slow=True,
    ),
    Case(
        "CK459",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": AJ, "w.toml": BARE, "c.toml": BARE + 'explored = "arm.npz"\n'},
        change={"c.toml": BARE + 'explored = "arm.npz"\nunknown = "free"\n'},
        before=(f"{WANDER} --chart arm.npz",),
        slow=True,
    ),
    Case(
        "CK444",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": WAY, "c.toml": BESIDE},
        change={"c.toml": '[world]\nallowed = [["needle", "plate"]]\n' + BESIDE},
        slow=True,
    ),
    Case(
        "CK467",
        "reach place cube --cell c.toml --x 0:400:50",
        {"c.toml": MOVED},
        change={"c.toml": '[world]\nallowed = [["cube", "wall"]]\n' + MOVED},
        others=("CK466",),
        slow=True,
    ),
    Case(
        "CK480",
        "explore recorded a.csv --cell c.toml --chart arm.npz",
        {"a.csv": "a,b\n1,2\n", "assistant.toml": CELL, "c.toml": BARE},
        (
            "monitor cell1 --log b.csv --seconds 1",
            "explore recorded b.csv --cell c.toml --chart arm.npz",
        ),
        slow=True,
    ),
    Case(
        "CK481",
        "explore recorded a.csv --cell c.toml --chart arm.npz --contact in:3",
        {"assistant.toml": CELL, "c.toml": BARE},
        (
            "monitor cell1 --signals in:3 --log b.csv --seconds 1",
            "explore recorded b.csv --cell c.toml --chart arm.npz --contact _in:3",
        ),
        before=("monitor cell1 --log a.csv --seconds 1",),
        slow=True,
    ),
    Case(
        "CK437",
        "check a.pseudo --cell c.toml",
        {
            "a.pseudo": LINE,
            "arm.urdf": MESHED.replace("link.stl", "http://maker/link.stl"),
            "c.toml": URDF,
        },
        change={"c.toml": URDF + 'links = "capsules"\n'},
    ),
    Case(
        "CK436",
        "check a.pseudo --cell c.toml",
        {
            "a.pseudo": LINE,
            "arm.urdf": MESHED.replace("link.stl", "package://far/link.stl"),
            "c.toml": URDF,
        },
        change={"c.toml": URDF + 'links = "capsules"\n'},
    ),
    Case(
        "CK436",
        "check a.pseudo --cell c.toml",
        {
            "a.pseudo": LINE,
            "arm.urdf": MESHED.replace("link.stl", "package://far/link.stl"),
            "here/link.obj": OPEN,
            "c.toml": URDF,
        },
        change={
            "c.toml": URDF + 'packages = {far = "here"}\n',
            "arm.urdf": MESHED.replace("link.stl", "package://far/link.obj"),
        },
    ),
    Case(
        "CK419",
        "check a.pseudo --cell c.toml",
        {"a.pseudo": LINE, "arm.urdf": DRAWN, "c.toml": URDF},
        change={"c.toml": URDF + 'links = "capsules"\n'},
    ),
    Case(
        "CL040",
        "reach place wall --robot irb1200-7-0.7 --x 0 --y 3000 --z 0",
        {"c.toml": ROBOT + WALL + SEEN},
        ("reach place wall --robot irb1200-7-0.7 --x 0 --y 3000 --z 0 --cell c.toml",),
        others=("CK466",),
    ),
    Case(
        "CL041",
        "reach base a.pseudo --robot irb1200-7-0.7 --tip 0,0,10",
        {"a.pseudo": LINE},
        ("reach base a.pseudo --robot irb1200-7-0.7",),
    ),
)
