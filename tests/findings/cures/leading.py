"""Cures of what leads an arm by what cameras see."""

from __future__ import annotations

from typing import Final

from tests.findings.cures.case import Case

SERVO: Final = "servo cell1 s.toml --cameras c.toml --by jog --yes"
NAMED: Final = '[controllers.cell1]\naddress = "virtual:cr"\n'
CAMERA: Final = "[cameras.hand]\nsize = [64, 48]\nfocal = [80, 80]\ncentre = [31.5, 23.5]\n"
TASK: Final = """
[target]
marker = 7
size = 50
[goal]
position = [0, 0, 160]
"""
FILES: Final = {
    "s.toml": TASK,
    "c.toml": f'{CAMERA}parent = "flange"\n',
    "assistant.toml": f'{NAMED}robot = "rv-2aj"\n',
}

WANDER: Final = "explore wander cell1 --chart c.npz"
ARM: Final = {**FILES, "cell.toml": '[robots.arm]\nrobot = "rv-2aj"\n'}
MOVED: Final = f"{WANDER} --cell cell.toml"

CASES: Final = (
    Case("CL288", WANDER, ARM, (MOVED,), others=("CL282",)),
    Case("CL282", MOVED, ARM, (f"{MOVED} --range J1=-40:40",), others=("CL283",)),
    Case(
        "CL283",
        f"{MOVED} --range J1=-40:40",
        ARM,
        (f"{MOVED} --range J1=-40:40 --contact 10",),
        others=("CL203",),
    ),
    Case(
        "CL531",
        SERVO,
        {**FILES, "assistant.toml": NAMED},
        change={"assistant.toml": FILES["assistant.toml"]},
        others=("VS211",),
    ),
    Case(
        "VS211",
        SERVO,
        FILES,
        change={"c.toml": FILES["c.toml"] + 'source = "pictures"\n'},
        others=("CN113",),
    ),
)
