"""Cures of programs in files: the command line, translating, running, tables."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from assistant import robots
from tests.findings.cures.case import Case, dxf, sample
from tests.findings.cures.following import outline_first
from tests.findings.cures.tables import CROWD
from tests.robots.test_urdf import WRISTED

PLACED: Final = (
    "home = [0, 0, 0, 0, 60, 0]\n[placement]\nposition = [600, -50, 300]\neuler_zyx = [0, 0, 0]\n"
    "[layers.CUT]\n"
)
ARM: Final = "--robot irb1200-7-0.7"
POSE: Final = "[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
JOINTS: Final = "[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


def rapid(*lines: str, data: str = "", main: str = "main") -> str:
    body = "\n".join(f"    {one}" for one in lines)
    return f"MODULE part\n{data}  PROC {main}()\n{body}\n  ENDPROC\nENDMODULE\n"


MOVING: Final = rapid(f"MoveL {POSE},v100,fine,tool0;")
WAITING: Final = rapid("WaitDI ready,1;", f"MoveL {POSE},v100,fine,tool0;")
TAUGHT: Final = rapid(f"MoveAbsJ {JOINTS},v100,fine,tool0;")
NAMELESS: Final = MOVING.replace("main", "Glue")
STEPS: Final = "10 Spd 50\n20 Dly 1\n30 End\n"
UNNAMED: Final = sample("taught.toml").decode().replace('robot = "irb1200-7-0.7"', "")
IDLE: Final = rapid(
    f"MoveL {POSE},v100,fine,tool0;", data=f"  CONST jointtarget jIdle:={JOINTS};\n"
)
LONG: Final = rapid("FOR i FROM 1 TO 40 DO", "WaitTime 60;", "ENDFOR")

BRANCHED: Final = rapid(
    "FOR i FROM 1 TO 3 DO",
    "WaitTime 1;",
    "IF DInput(ready)=1 THEN",
    "WaitTime 1;",
    "ELSE",
    "WaitTime 2;",
    "ENDIF",
    "ENDFOR",
)
UNNUMBERED: Final = (
    sample("plate.process.toml").decode().replace("number = 8\n", "").replace("number = 9\n", "")
)
TURNING: Final = """\
program seam
tool gun tip [0, 0, 100] mass 1 kg centre [0, 0, 50] free turn
target a [400, 0, 400] [0, 0, 1, 0]
procedure main
  move linear a speed 100 mm/s blend fine tool gun frame base
end
"""


TWO_PLACES: Final = """\
1 Mov P1
2 Mov P2
3 End
P1=(400,0,300,180,0,180)(7,0)
P2=(400,100,300,180,0,180)(7,0)
"""
SETTING: Final = rapid("SetDO ready,1;")
SETTING_TWO: Final = rapid("SetDO fetched,1;", "SetDO placed,1;")
READY: Final = '[signals.ready]\nkind = "digital"\ndirection = "input"\nnumber = 3\n'
JOINED: Final = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,motion,{}\n300,0,400,0,0,1,0,joint,{}\n"
STATED_ARM: Final = (
    'MOC:CFG_1.0:6:1::\n#\nROBOT:\n\n      -name "ROB_1" -use_robot_type "ROB1_{}"\n'
)
OWN_ARM: Final = (
    Path(robots.__file__)
    .with_name("catalogue")
    .joinpath("irb1200-7-0.7.toml")
    .read_text("utf-8")
    .replace("irb1200-7-0.7", "own-arm")
)
AT_ONCE: Final = '[[set]]\ninput = "ready"\nat = 0\n'
KNOWN: Final = """\
title = "ABB IRB 1200-7/0.7"
maker = "ABB"
languages = ["rapid"]
payload_kg = 7
"""
MANY: Final = CROWD + "".join(f"{510 + i},0,500,0,0,1,0\n" for i in range(30))

CASES: Final = (
    Case(
        "CL002",
        "compile a.csv --language rapid --most-targets 10 -o -",
        {"a.csv": MANY},
        ("compile a.csv --language rapid --most-targets 10 --output out",),
    ),
    Case(
        "CL005",
        "fmt a.prg --from melfa-basic-5 --renumber ten",
        {"a.prg": STEPS},
        ("fmt a.prg --from melfa-basic-5 --renumber 10,10",),
    ),
    Case("CL006", "coverage -", then=("coverage - --from melfa-basic-5",), given="P1=P2\n"),
    Case("CL010", "simulate a.mod", {"a.mod": MOVING}, ("robots", f"simulate a.mod {ARM}")),
    Case(
        "CL013",
        "show a.mod --after sayable",
        {"a.mod": MOVING},
        ("show a.mod --to melfa-basic-5 --after sayable",),
    ),
    Case(
        "CO017",
        "translate a.mod --to melfa-basic-6 --output out",
        {"a.mod": MOVING},
        then=("translate a.mod --to melfa-basic-6 --output out --robot rv-4frl",),
    ),
    Case(
        "CL014",
        "translate a.mod --to melfa-basic-5 -o -",
        {"a.mod": MOVING},
        ("translate a.mod --to melfa-basic-5 --output out",),
    ),
    Case(
        "CL020",
        "translate a.mod --to melfa-basic-5 --output out --signals s.toml",
        {"a.mod": MOVING, "s.toml": AT_ONCE},
        ("translate a.mod --to melfa-basic-5 --output out --signals s.toml --prove",),
    ),
    Case("CL025", "run a.mod", {"a.mod": MOVING}, ("robots", f"run a.mod {ARM}")),
    Case("CL028", "run a.mod --step --format json", {"a.mod": MOVING}, ("run a.mod --step",)),
    Case(
        "CL028", "run a.mod --step --format json", {"a.mod": MOVING}, ("run a.mod --format json",)
    ),
    Case(
        "CL028",
        "run a.mod --break 3 --format json",
        {"a.mod": MOVING},
        ("run a.mod --format json",),
    ),
    Case("CL029", "run a.mod --plot a.png", {"a.mod": MOVING}, (f"run a.mod --plot a.png {ARM}",)),
    Case("CL032", "run - --from rapid --ask", {}, ("run - --from rapid",), given=MOVING),
    Case(
        "CL036",
        "reach map --x 300 --y 0 --z 500",
        {},
        ("robots", f"reach map --x 300 --y 0 --z 500 {ARM}"),
    ),
    Case(
        "CO005",
        "translate a.dxf --to rapid",
        {"a.dxf": sample("plate.dxf"), "a.process.toml": sample("plate.process.toml")},
        (f"compile a.dxf --language rapid {ARM} -o out",),
    ),
    Case(
        "SR001",
        "translate a.txt --to rapid",
        {"a.txt": "P1=P2\n"},
        ("translate a.txt --to rapid --from melfa-basic-5",),
    ),
    Case(
        "CO009",
        "translate a.mod --to melfa-basic-5 -p p.toml",
        {"a.mod": MOVING, "p.toml": 'robot = "irb1200-7-0.7"\n'},
        (
            "translate a.mod --to melfa-basic-5 -p p.toml "
            "--robot rv-4frl --from-robot irb1200-7-0.7",
        ),
        change={"p.toml": "joint_speed = 100\n"},
    ),
    Case(
        "CO512",
        "translate a.prg --to rapid -r irb1200-5-0.9 --from-robot rv-6sl -p p.toml",
        {"a.prg": TWO_PLACES, "p.toml": "joint_speed = 50\n"},
        change={"p.toml": "joint_speed = 5000\n"},
    ),
    Case(
        "RB108",
        "translate a.prg --to rapid -r irb1200-5-0.9",
        {"a.prg": TWO_PLACES.replace("400,0,", "400,-180,")},
        ("translate a.prg --to rapid -r irb1200-5-0.9 --from-robot rv-6sl",),
    ),
    Case(
        "CO302",
        "check .",
        {"a.mod": MOVING, "b.prg": "P1=P2\n"},
        ("check b.prg --from melfa-basic-5",),
    ),
    Case("CO402", "fmt a.txt", {"a.txt": "P1=P2\n"}, ("fmt a.txt --from melfa-basic-5",)),
    Case("CO403", "fmt here", {"here/a.txt": STEPS}, ("fmt here/a.txt --from melfa-basic-5",)),
    Case("CO404", "fmt a.mod --renumber 10,10", {"a.mod": MOVING}, ("fmt a.mod",)),
    Case(
        "CO503",
        "compile a.mod --language melfa-basic-5 --robot rv-4frl -o out",
        {"a.mod": TAUGHT},
        ("compile a.mod -l melfa-basic-5 --from-robot irb1200-7-0.7 -r rv-4frl -o out",),
    ),
    Case(
        "CO503",
        f"compile a.toml --language rapid {ARM} -o out",
        {"a.toml": UNNAMED},
        change={"a.toml": 'robot = "irb1200-7-0.7"\n' + UNNAMED},
    ),
    Case(
        "CO503",
        f"compile a.dxf --language rapid {ARM} -o out",
        {"a.dxf": dxf(outline_first), "a.process.toml": PLACED},
        change={"a.process.toml": 'robot = "irb1200-7-0.7"\n' + PLACED},
    ),
    Case(
        "CO504",
        "compile a.toml --language melfa-basic-5 -o out",
        {"a.toml": sample("taught.toml")},
        ("compile a.toml --language melfa-basic-5 --robot rv-4frl -o out",),
    ),
    Case(
        "CO510",
        "compile a.mod -l melfa-basic-5 -o out",
        {"a.mod": IDLE},
        ("compile a.mod -l melfa-basic-5 --from-robot irb1200-7-0.7 --robot rv-4frl -o out",),
    ),
    Case(
        "CO034",
        "run a.mod --signals s.toml",
        {"a.mod": MOVING, "s.toml": '[[set]]\ninput = "ready"\nat = 1\nfor = 5\nevery = 3\n'},
        change={"s.toml": '[[set]]\ninput = "ready"\nat = 1\nfor = 2\nevery = 3\n'},
    ),
    Case(
        "MB245",
        "translate a.mod --to melfa-basic-5",
        {"a.mod": NAMELESS},
        ("translate a.mod --to melfa-basic-5 --entry Glue",),
    ),
    Case(
        "VC206",
        "run a.prg --from melfa-basic-5 --entry top",
        {"a.prg": STEPS},
        ("run a.prg --from melfa-basic-5",),
    ),
    Case(
        "VC210",
        "run a.mod --signals s.toml",
        {"a.mod": MOVING, "s.toml": "[options]\nhold = 1\n" + AT_ONCE},
        change={"s.toml": AT_ONCE},
    ),
    Case(
        "VC211",
        "run a.prg --from melfa-basic-5",
        {"a.prg": 'Open "COM1:" As #1\nPrint #1,"HI"\nClose #1\nEnd\n'},
        ("run a.prg --from melfa-basic-5 --line COM1=10047",),
    ),
    Case(
        "VC212",
        "run a.mod",
        {"a.mod": rapid("WaitTime 1;", "Else_where;")},
        ("run a.mod --until 0.5",),
    ),
    Case("CL035", f"view a.mod {ARM}", {"a.mod": MOVING}, (f"view a.mod {ARM} --html page.html",)),
    Case(
        "MB106",
        "check a.prg --from melfa-basic-5",
        {"a.prg": f"M{'1' * 40}=1\nEnd\n"},
        change={"assistant.toml": "[melfa-basic]\nname-length = 60\n"},
    ),
    Case(
        "MB107",
        "check a.prg --from melfa-basic-5",
        {"a.prg": f"M1=1 '{'x' * 235}\nEnd\n"},
        change={"assistant.toml": "[melfa-basic]\nstep-length = 250\n"},
    ),
    Case(
        "CO112",
        "translate a.mod --to melfa-basic-5 -o out -p p.toml --prove --signals s.toml",
        {
            "a.mod": BRANCHED,
            "p.toml": READY,
            "s.toml": '[[set]]\ninput = "ready"\nvalue = 0\nat = 0\n',
        },
        change={"s.toml": '[[set]]\ninput = "ready"\nat = 1.5\n'},
    ),
    Case(
        "CO010",
        "translate a.mod --to melfa-basic-5 -o out -p p.toml",
        {"a.mod": WAITING, "p.toml": READY.replace("input", "output")},
        change={"p.toml": READY},
    ),
    Case(
        "CO128",
        "translate a.mod --to melfa-basic-5 -r rv-4frl -o out --cell c.toml --prove "
        "--signals s.toml",
        {
            "a.mod": rapid(
                "IF DInput(ready)=1 THEN",
                "n:=900;",
                "ENDIF",
                "MoveL Offs(p,n,0,0),v100,fine,tool0;",
                data=f"  CONST robtarget p:={POSE};\n  VAR num n:=0;\n",
            ),
            "c.toml": READY,
            "s.toml": AT_ONCE,
        },
        change={"s.toml": '[[set]]\ninput = "ready"\nvalue = 0\n'},
    ),
    Case(
        "CO085",
        "translate a.mod --to melfa-basic-6 -r rv-4frl --from-robot irb120-3-0.58 -o out",
        {"a.mod": MOVING, "SYSPAR/MOC.cfg": STATED_ARM.format("1200_0.7_7")},
        then=("translate a.mod --to melfa-basic-6 -r rv-4frl --from-robot irb1200-7-0.7 -o out",),
    ),
    Case(
        "CO086",
        "translate a.mod --to melfa-basic-6 -r rv-4frl -o out",
        {"a.mod": MOVING, "SYSPAR/MOC.cfg": STATED_ARM.format("9900_0.7_7"), "own.toml": OWN_ARM},
        then=("translate a.mod --to melfa-basic-6 -r rv-4frl --from-robot own.toml -o out",),
    ),
    Case(
        "CO114",
        "translate a.mod --to melfa-basic-5 -o out -p p.toml --prove --signals s.toml",
        {
            "a.mod": rapid(f"MoveL {POSE},v100,fine,tool0;", "WaitDI ready,1;"),
            "p.toml": READY,
            "s.toml": '[[set]]\ninput = "ready"\nvalue = 0\n',
        },
        change={"s.toml": AT_ONCE},
    ),
    Case(
        "CO119",
        "compare a.mb5 b.mb5",
        dict.fromkeys(("a.mb5", "b.mb5"), "M1=M_Run(2)\nM_Out(1)=1\nEnd\n"),
        ("compare a.mb5 b.mb5 --text",),
    ),
    Case(
        "CO120",
        "compare one.mod two.mod",
        {"one.mod": SETTING, "two.mod": SETTING_TWO},
        change={"names.toml": '[names]\nready = "fetched"\n'},
        then=("compare one.mod two.mod --names names.toml",),
        others=("CO118",),
    ),
    Case(
        "CO121",
        "compare one.mod two.mod",
        {"one.mod": SETTING, "two.mod": SETTING.replace("ready", "fetched")},
        change={"names.toml": '[names]\nready = "fetched"\n'},
        then=("compare one.mod two.mod --names names.toml",),
    ),
    Case(
        "CO111",
        "translate a.prg --from melfa-basic-5 --to melfa-basic-6 -o out --prove",
        {"a.prg": "1 M3=M_Mode\n2 Dly M3\n3 End\n"},
        ("translate a.prg --from melfa-basic-5 --to melfa-basic-6 -o out",),
    ),
    Case(
        "CO115",
        "translate a.mod --to melfa-basic-5 -o out --prove",
        {
            "a.mod": rapid(
                f"MoveL {POSE},v200,fine,tool0;",
                "j:=CJointT();",
                "MoveAbsJ j,v200,fine,tool0;",
                data="  VAR jointtarget j;\n",
            )
        },
        (
            "translate a.mod --to melfa-basic-5 -o out --prove "
            "--robot rv-4frl --from-robot irb1200-7-0.7",
        ),
    ),
    Case(
        "MB201",
        "compile a.dxf --language melfa-basic-5 --robot rv-4frl -o out",
        {"a.dxf": sample("plate.dxf"), "a.process.toml": UNNUMBERED},
        change={"a.process.toml": sample("plate.process.toml").decode()},
    ),
    Case(
        "MB201",
        "compile a.dxf --language melfa-basic-6 --robot rv-4frl -o out",
        {"a.dxf": sample("plate.dxf"), "a.process.toml": UNNUMBERED},
        change={"a.process.toml": sample("plate.process.toml").decode()},
    ),
    Case(
        "MB204",
        "compile a.csv --language melfa-basic-5 --robot rv-4frl -o out",
        {"a.csv": JOINED.format("speed_mm_s", 100)},
        change={"a.process.toml": "joint_percent = 20\n"},
    ),
    Case(
        "MB204",
        "translate a.mod --to melfa-basic-5 -p p.toml -o out",
        {"a.mod": MOVING.replace("MoveL", "MoveJ"), "p.toml": "# how it moves\n"},
        change={"p.toml": "joint_percent = 20\n"},
    ),
    Case(
        "CO073",
        "translate a.mod --to melfa-basic-5 --cell c.toml -o out",
        {
            "a.mod": rapid("a:=b;", data="  VAR num a;\n"),
            "c.toml": '[data.b]\ntype = "num"\nvalue = "x"\n',
        },
        change={"c.toml": '[data.b]\ntype = "num"\nvalue = 1\n'},
    ),
    Case(
        "CO082",
        "translate a.mod --to melfa-basic-5 --cell c.toml -o out",
        {
            "a.mod": rapid("a:=given();", data="  VAR num a;\n"),
            "c.toml": '[routines.given]\nroutine = "empty"\n',
        },
        change={"c.toml": '[routines.given]\nroutine = "stop"\n'},
    ),
    Case(
        "CO081",
        "translate a.mod --to melfa-basic-5 --cell c.toml -o out",
        {
            "a.mod": rapid("SetDO valve,1;"),
            "c.toml": '[signals.valve]\nkind = "digital"\ndirection = "output"\nnumber = 1\n',
        },
        change={"c.toml": '[signals.valve]\nkind = "digital"\ndirection = "output"\nnumber = 16\n'},
    ),
    Case(
        "CO084",
        "translate a.prg --to rapid --cell c.toml -o out",
        {
            "a.prg": "M_Out(12)=1\nDly 1\nEnd\n",
            "c.toml": "[signals.valve]\nnumber = 12\n",
        },
        change={"c.toml": '[signals.valve]\nnumber = 12\ndirection = "output"\n'},
    ),
    Case(
        "RB008",
        "check a.mod --robot own.urdf",
        {"a.mod": MOVING, "own.urdf": WRISTED},
        ("check a.mod --robot own.toml",),
        {"own.toml": 'urdf = "own.urdf"\n' + KNOWN},
    ),
    Case(
        "VC213",
        "run a.mod",
        {"a.mod": WAITING},
        ("run a.mod --signals s.toml",),
        {"s.toml": '[[set]]\ninput = "ready"\nat = 1\n'},
    ),
    Case(
        "VC214",
        "run a.mod --max-steps 50",
        {"a.mod": rapid(*["WaitTime 0.1;"] * 60)},
        ("run a.mod --max-steps 500",),
    ),
    Case("VC215", "run a.mod --max-time 60", {"a.mod": LONG}, ("run a.mod --max-time 6000",)),
    Case("VC215", "run a.mod --max-time 60", {"a.mod": LONG}, ("run a.mod --until 30",)),
    Case("SR003", "check a.toml --unit mm", {"a.toml": sample("taught.toml")}, ("check a.toml",)),
    Case(
        "RB124",
        "compile a.pseudo --language rapid -o out",
        {"a.pseudo": TURNING},
        (f"compile a.pseudo --language rapid {ARM} -o out",),
    ),
    Case(
        "IN010",
        "--budget 0.001 check a.mod",
        {"a.mod": MOVING + "! long\n" * 45000},
        ("--budget 10 check a.mod",),
        slow=True,
    ),
)
