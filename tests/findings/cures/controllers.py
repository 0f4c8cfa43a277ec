"""Cures of commands to controllers, of projects and of deployments; controllers are virtual."""

from __future__ import annotations

from typing import Final

from tests.findings.cures.case import Case

CR: Final = '[controllers.cell1]\naddress = "virtual:cr"\nrobot = "rv-2aj"\n'
IRC5: Final = '[controllers.cell1]\naddress = "virtual:irc5"\nrobot = "irb1200-7-0.7"\n'
BOTH: Final = CR + IRC5.replace("cell1", "cell2")
PICK: Final = "10 OVRD 50\n20 DLY 1\n30 END\n"
OTHER: Final = PICK.replace("DLY 1", "DLY 2")
MODULE: Final = """\
MODULE seam
  CONST robtarget p1:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ p1,v100,fine,tool0;
  ENDPROC
ENDMODULE
"""
TOUCHED: Final = MODULE.replace("400", "405")
WAY: Final = "j1_deg,j2_deg,j3_deg,j5_deg,j6_deg\n0,0,90,90,0\n0,0,90,90,0.01\n"
TAUGHT: Final = 'robot = "rv-2aj"\n'
SEAM: Final = (
    IRC5
    + '[programs.seam]\nsource = "seam.mod"\n[targets.cell1]\nprograms = ["seam"]\nload = true\n'
)
PLATE: Final = (
    IRC5 + '[programs.plate]\nsource = "plate.csv"\n{}[targets.cell1]\nprograms = ["plate"]\n'
)
TABLE: Final = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n500,0,500,0,0,1,0\n510,0,500,0,0,1,0\n"

FIRST: Final = """\
[targets.cell1]
programs = ["PICK.prg"]
[targets.cell2]
programs = ["seam.mod"]
load = true
"""

CASES: Final = (
    Case(
        "CL267",
        "exchange module --files p.txt,q.txt,c.txt -o px.mod",
        then=("exchange module --files p.txt,q.txt,c.txt -o px.mod --plain",),
    ),
    Case(
        "CL203",
        "start cell1 PICK",
        {"assistant.toml": CR, "PICK.prg": PICK},
        ("start cell1 PICK --yes",),
        before=("put cell1 PICK.prg",),
    ),
    Case(
        "CL210",
        "get cell1 NONE",
        {"assistant.toml": CR, "PICK.prg": PICK},
        ("ls cell1", "get cell1 PICK -o b.prg"),
        before=("put cell1 PICK.prg",),
    ),
    Case(
        "CL211",
        "get cell1 PICK -o PICK.prg",
        {"assistant.toml": CR, "PICK.prg": PICK},
        ("get cell1 PICK -o PICK.prg --replace",),
        before=("put cell1 PICK.prg",),
        between={"PICK.prg": OTHER},
    ),
    Case(
        "CL212",
        "put cell1 PICK.prg",
        {"assistant.toml": CR, "PICK.prg": PICK},
        ("put cell1 PICK.prg --replace",),
        before=("put cell1 PICK.prg",),
        between={"PICK.prg": OTHER},
    ),
    Case(
        "CL212",
        "put cell1 PICK.prg",
        {"assistant.toml": CR, "PICK.prg": PICK},
        ("deploy PICK.prg --to cell1 --replace PICK",),
        before=("put cell1 PICK.prg",),
        between={"PICK.prg": OTHER},
    ),
    Case(
        "CL215",
        "restore cell1 kept",
        {"assistant.toml": CR, "PICK.prg": PICK},
        ("backup cell1 kept", "restore cell1 kept --yes"),
        before=("put cell1 PICK.prg",),
    ),
    Case(
        "CN403",
        "restore cell1 kept",
        {"assistant.toml": CR, "PICK.prg": PICK, "kept/a.txt": "x"},
        ("backup cell1 again", "restore cell1 again --yes"),
        before=("put cell1 PICK.prg",),
    ),
    Case(
        "CL230",
        "teach cell1 a --into t.toml --now --on 3",
        {"assistant.toml": CR, "t.toml": TAUGHT},
        ("teach cell1 a --into t.toml --now",),
    ),
    Case("CL270", "plan a.prg", {"assistant.toml": CR, "a.prg": PICK}, ("plan a.prg --to cell1",)),
    Case(
        "CL270",
        "plan a.prg",
        {"assistant.toml": CR + '[targets.cell1]\nprograms = ["a.prg"]\n', "a.prg": PICK},
        ("build", "plan --target cell1"),
    ),
    Case(
        "CN104",
        "ls cell7",
        {"assistant.toml": CR},
        change={"assistant.toml": CR + '[controllers.cell7]\naddress = "virtual:cr"\n'},
    ),
    Case(
        "CN108",
        "ls cell1",
        {"assistant.toml": '[controllers.cell1]\nrobot = "rv-2aj"\n'},
        change={"assistant.toml": CR},
    ),
    Case(
        "CO714",
        "jog cell1 J1 1 --yes",
        {"assistant.toml": CR.replace("robot =", "#")},
        change={"assistant.toml": CR},
    ),
    Case("PR101", "build", {}, ("init", "build")),
    Case("PR101", "build", {}, change={"assistant.toml": PLATE.format(""), "plate.csv": TABLE}),
    Case(
        "PR108",
        "build",
        {"assistant.toml": IRC5 + "[targets.cell1]\nprograms = []\n", "plate.csv": TABLE},
        change={"assistant.toml": PLATE.format("")},
    ),
    Case(
        "PR110",
        "build",
        {"assistant.toml": PLATE.format('language = "melfa-basic-4"\n'), "plate.csv": TABLE},
        change={"assistant.toml": PLATE.format("")},
    ),
    Case(
        "PR111",
        "build",
        {
            "assistant.toml": PLATE.format("")
            .replace("robot =", "#")
            .replace("virtual:irc5", "melfa://10.0.0.1"),
            "plate.csv": TABLE,
        },
        change={
            "assistant.toml": PLATE.format('language = "melfa-basic-4"\n')
            .replace("robot =", "#")
            .replace("virtual:irc5", "melfa://10.0.0.1")
        },
    ),
    Case(
        "PR202",
        "deploy",
        {"assistant.toml": PLATE.format(""), "plate.csv": TABLE},
        ("build", "deploy"),
    ),
    Case(
        "DP204",
        "deploy seam.mod --to cell1",
        {"assistant.toml": IRC5, "seam.mod": MODULE},
        ("deploy seam.mod --to cell1 --replace seam.mod --files-only",),
        before=("deploy seam.mod --to cell1 --files-only",),
        between={".robot-assistant/virtual/cell1/home/seam.mod": TOUCHED},
    ),
    Case(
        "DP212", "deploy --resume --to cell1", {"assistant.toml": IRC5}, ("deployments --to cell1",)
    ),
    Case("DP213", "rollback 7 --to cell1", {"assistant.toml": IRC5}, ("deployments --to cell1",)),
    Case(
        "PR111",
        "build",
        {
            "assistant.toml": PLATE.format("")
            .replace("robot =", "#")
            .replace("virtual:irc5", "melfa://10.0.0.1"),
            "plate.csv": TABLE,
        },
        change={
            "assistant.toml": PLATE.format("")
            .replace("irb1200-7-0.7", "rv-2aj")
            .replace("virtual:irc5", "melfa://10.0.0.1")
        },
        others=("RB102", "RB104"),
    ),
    Case(
        "DP222",
        "plan seam.mod --to cell1",
        {"assistant.toml": IRC5, "seam.mod": MODULE},
        ("deploy seam.mod --to cell1 --replace seam.mod --files-only",),
        before=("deploy seam.mod --to cell1 --files-only",),
        between={".robot-assistant/virtual/cell1/home/seam.mod": TOUCHED},
        slow=True,
    ),
    Case(
        "DP203",
        "deploy seam.mod --to cell1",
        {"assistant.toml": IRC5, "seam.mod": MODULE, ".robot-assistant/deployments": "x"},
        ("deploy seam.mod --to cell1 --history kept",),
        slow=True,
    ),
    Case(
        "CL273",
        "rollback",
        {"assistant.toml": BOTH + FIRST, "PICK.prg": PICK, "seam.mod": MODULE},
        ("rollback --target cell1",),
        before=("build", "deploy"),
        slow=True,
    ),
    Case(
        "CL046",
        "view a.mod -r irb1200-7-0.7 --live cell1 --html page.html",
        {"assistant.toml": IRC5, "a.mod": MODULE},
        ("view a.mod -r irb1200-7-0.7 --html page.html",),
    ),
    Case(
        "TB508",
        "teach cell1 a --into t.toml --now",
        {
            "assistant.toml": CR,
            "t.toml": TAUGHT + 'targets = [{name = "b", joints = [0, 0, 90, 90, 0]}]\n',
        },
        change={"t.toml": TAUGHT + '[[targets]]\nname = "b"\njoints = [0, 0, 90, 90, 0]\n'},
    ),
    Case(
        "TB511",
        "teach cell1 a --into t.toml --now --replace",
        {
            "assistant.toml": CR,
            "t.toml": TAUGHT
            + '[[targets]]\nname = "a"\njoints = [0, 0, 90, 90, 0]\nexternal = [5]\n',
        },
        change={"t.toml": TAUGHT + '[[targets]]\nname = "a"\njoints = [0, 0, 90, 90, 0]\n'},
    ),
    Case(
        "TB512",
        "teach cell1 a --into t.toml --now --joints",
        {"assistant.toml": CR, "t.toml": "# taught\n"},
        change={"t.toml": TAUGHT},
    ),
    Case(
        "SR003",
        "build",
        {"assistant.toml": PLATE.format('unit = "mm"\n'), "plate.csv": TABLE},
        change={"assistant.toml": PLATE.format("")},
        slow=True,
    ),
)
