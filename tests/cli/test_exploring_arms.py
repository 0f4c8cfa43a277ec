"""`explore` with a virtual arm that really moves, among obstacles that only contacts reveal."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.cell.exploration.occupancy import CellState, load_map
from assistant.cli import exploration
from assistant.cli.exploration import NO_CONTACT
from assistant.compiler.exploration import contact_test
from assistant.controllers import connect
from assistant.controllers.mitsubishi.cr import Cr
from assistant.virtual.cr import Contact, VirtualCr
from assistant.vision.exploration import AnyContacts
from tests.cli.test_commands import run
from tests.cli.test_leaving_no_trace import NETWORK

CELL = """[robots.arm]
robot = "rv-2aj"
tool = "gripper"
[bodies.gripper]
cylinder = [25, 58]
position = [0, 0, 29]
"""
POST = "[bodies.post]\ncylinder = [40, 900]\nposition = [260, 160, 450]\n"
WHERE = ("--cell", "cell.toml", "--chart", "arm.npz")
BOUNDS = ("--range", "J1=-60:60", "--range", "J2=0:60", "--range", "J3=30:110")
WANDER = ("explore", "wander", "cell1", *WHERE, "--contact", "10", *BOUNDS)
CAMERA = """[cameras.side]
size = [64, 48]
focal = [60, 60]
centre = [31.5, 23.5]
position = [300, -900, 400]
quaternion = [0.70710678, -0.70710678, 0, 0]
source = "cell.toml"
"""


@pytest.fixture
def pace() -> float:
    """Seconds of the controller in a second; those that watch a line take one."""
    return 200.0


@pytest.fixture
def cell(tmp_path, monkeypatch, pace):
    """A controller with its motors on and a post beside its arm; input 10 is on in contact."""
    monkeypatch.chdir(tmp_path)
    files = {"cell.toml": CELL, "real.toml": CELL + POST, "cameras.toml": CAMERA}
    for name, text in files.items():
        Path(name).write_text(text, encoding="utf-8")
    felt = Contact("10", contact_test(Path("real.toml"), "rv-2aj"))
    virtual = VirtualCr(servo_time=0.02, pace=pace, contact=felt)
    virtual.state.parameters.write("COMDEV", NETWORK, all_levels=True)
    with virtual:
        table = f'address = "{virtual.address}"\nrobot = "rv-2aj"\ntimeout = 10\n'
        Path("assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        virtual.state.machinery.switch_servo(True)
        yield virtual


def rows_of(name: str) -> list[dict[str, str]]:
    with Path(name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def inside(chart: str, size: float) -> int:
    """Number of free cells that are completely in the post."""
    cells = load_map(chart).cells(CellState.FREE)
    corners = size * (cells[:, None, :2] + np.array([[0, 0], [0, 1], [1, 0], [1, 1]]))
    away = np.linalg.norm(corners - np.array([260.0, 160.0]), axis=2).max(axis=1)
    return int((away < 40.0).sum())


NARROW = ("J1=-10:12", "J2=0:12", "J3=80:95", "J5=75:90", "J6=-15:15")


def wandered(capsys, runs: str, size: str, *more: str):
    words = (*WANDER, "--runs", runs, "--seed", "3", "--size", size, "--log", "log.csv", "--yes")
    status, out, err = run(capsys, *words, *more, "--format", "json")
    assert status == 0, out + err
    return json.loads(out)


def test_an_arm_that_moves_finds_free_space_and_its_log_tells_the_same(capsys, cell) -> None:
    before = cell.state.joints
    told = wandered(capsys, "1", "50", *(word for one in NARROW for word in ("--range", one)))
    assert cell.state.joints != before
    assert told["chart"]["free"] > 0 and inside("arm.npz", 50.0) == 0
    assert told["written"] == ["arm.npz", "log.csv"]
    rows = rows_of("log.csv")
    assert {"seconds", "j1_deg", "j6_deg", "x_mm", "q_w", "contact"} <= rows[0].keys()
    words = ("explore", "recorded", "log.csv", "--contact", "contact", "--cell", "cell.toml")
    assert run(capsys, *words, "--chart", "again.npz", "--size", "50")[0] == 0
    one, other = load_map("arm.npz"), load_map("again.npz")
    assert np.array_equal(one.cells(CellState.FREE), other.cells(CellState.FREE))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("by", "pace"),
    [("jog", 200.0), ("mxt", 200.0), ("data-link", 1.0)],
    ids=["jog", "mxt", "data-link"],
)
def test_contacts_stop_it_and_no_cell_of_the_obstacle_is_free(capsys, cell, by) -> None:
    pairs = [f"{host}:{port}" for host, port in cell.data_ports.values()][:2]
    lines = [word for pair in pairs for word in ("--line", pair)]
    ways = {"mxt": ["--port", str(cell.mxt_port)], "data-link": lines}
    told = wandered(capsys, "6", "20", "--by", by, *ways.get(by, []), "--speed", "250")
    assert told["contacts"] > 0 and told["chart"]["litres"] > 5.0
    assert inside("arm.npz", 20.0) == 0
    with connect("cell1") as controller:
        assert controller.inputs(["10"]) == {"10": 0.0}, "it has gone back"


def test_lines_that_lead_nowhere_are_refused_before_anything_starts(capsys, cell) -> None:
    left = ", ".join(f"OPT{i}" for i in range(13, 19))
    before = cell.state.joints
    for devices in ("RS232, OPT12", "OPT12, "):
        cell.state.parameters.write("COMDEV", f"{devices}, {left}", all_levels=True)
        status, _, said = run(capsys, *WANDER, "--by", "data-link", "--yes")
        assert status == 2 and "CN209" in said and "COMDEV = OPT12, OPT13" in said, said
    assert cell.state.joints == before and not [*cell.state.store] and not Path("arm.npz").exists()


OUTSIDE = ("wander", "cell1", *WHERE, "--range", "J1=20:60", "--contact", "10", "--yes")
REFUSED = [
    (WANDER[1:], "CL203"),
    (("wander", "cell1", "--chart", "arm.npz", "--line", "COM1"), "CL288"),
    (("wander", "cell1", *WHERE, "--contact", "10"), "CL282"),
    (("wander", "cell1", *WHERE, *BOUNDS), "CL283"),
    (("wander", "cell1", *WHERE, *BOUNDS, "--contact", "10", "--speed", "900"), "CL287"),
    (("wander", "cell1", *WHERE, *BOUNDS, "--contact", "10", "--log", "log.txt"), "CL285"),
    (("wander", "cell1", *WHERE, *BOUNDS, "--contact", "10", "--by", "magic"), "CL530"),
    (("wander", "cell1", *WHERE, "--range", "J9=0:10", "--contact", "10"), "LN016"),
    (("wander", "cell1", *WHERE, *BOUNDS, "--contact", "10", "--hidden", "real.toml"), "CL289"),
    (("wander", "cell1", *WHERE, *BOUNDS, "--camera", "cameras.toml", "--region", "a"), "CL286"),
    (
        ("wander", "cell1", *WHERE, *BOUNDS, "--camera", "cameras.toml", "--region", "9,9,9,99"),
        "VS224",
    ),
    (("wander", "cell1", "--chart", "arm.npz"), "CL288"),
    (("wander", "cell.toml", "--chart", "arm.npz", "--contact", "10"), "CL288"),
    (OUTSIDE, "VS221"),
    (("wander", "cell1", *WHERE, "--range", "J1=0:999", "--contact", "10"), "CL290"),
    (("running", "cell1", *WHERE), "CL283"),
    (("running", "cell1", *WHERE, "--contact", "10", "--override", "0"), "CL242"),
    (("running", "cell1", *WHERE, "--contact", "10"), "CL203"),
]


def test_what_is_refused_moves_nothing_and_writes_no_chart(capsys, cell) -> None:
    before = cell.state.joints
    for words, code in REFUSED:
        status, _, said = run(capsys, "explore", *words)
        assert (status, code in said) == (2, True), (words, said)
    for more in (("--contact", "10"), ("--cell", "real.toml"), ("--contact", "x", "--cell", "c")):
        status, _, said = run(capsys, "virtual", "cr", *more)
        assert status == 2 and "CL105" in said, said
    text = Path("assistant.toml").read_text(encoding="utf-8")
    Path("assistant.toml").write_text(text.replace("rv-2aj", "rv-2a"), encoding="utf-8")
    status, _, said = run(capsys, *WANDER, "--yes")
    assert status == 2 and "CL284" in said, said
    assert cell.state.joints == before and not Path("arm.npz").exists()


@pytest.mark.slow
def test_a_camera_that_sees_the_arm_come_tells_of_contacts(capsys, cell) -> None:
    """Nothing moves once the picture has changed: here the region is where the arm stands."""
    words = ("explore", "wander", "cell1", *WHERE, *BOUNDS, "--camera", "cameras.toml")
    status, _, said = run(capsys, *words, "--runs", "1", "--size", "50", "--yes", "--log", "l.csv")
    assert status in {0, 1}, said
    touched = [row["contact"] for row in rows_of("l.csv")]
    assert float(touched[0]) == 0.0
    assert any(float(value) for value in touched), "the arm moves in the picture"


def test_an_arm_that_is_moved_by_hand_is_recorded(capsys, cell) -> None:
    words = ("explore", "manual", "cell1", *WHERE, "--contact", "10", "--seconds", "0.8")
    status, out, said = run(capsys, *words, "--log", "log.csv", "--format", "json")
    assert status == 0, said
    assert json.loads(out)["chart"]["free"] > 0 and rows_of("log.csv")


def started(capsys, *more: str) -> tuple[int, str, str]:
    """Explore while a program moves the arm to and fro, past the post."""
    lines = ["10 SPD 100", "20 JA=(31,20,80,0,40,0)", "30 MOV JA", "40 JB=(0,0,90,0,90,0)"]
    text = "\n".join([*lines, "50 MOV JB", "60 GOTO 30"])
    Path("MOVES.MB4").write_text(text + "\n", encoding="utf-8")
    assert run(capsys, "put", "cell1", "MOVES.MB4")[0] == 0
    words = ("explore", "running", "cell1", *WHERE, "--program", "MOVES", "--contact", "10")
    return run(capsys, *words, "--override", "1", "--yes", *more)


@pytest.mark.parametrize(
    "error", [KeyboardInterrupt, pytest.param(Refused, marks=pytest.mark.slow)]
)
def test_what_ends_a_program_stops_it_before_anything_is_learnt(capsys, cell, monkeypatch, error):
    """And before it would get its old speed again."""
    save, states, looks = exploration._saved, [], iter([False] * 4)

    def saved(*arguments):
        with connect("cell1") as controller:
            states.append(controller.state())
        return save(*arguments)

    def touching(_):
        for look in looks:
            return look
        raise error() if error is KeyboardInterrupt else Refused(NO_CONTACT())

    set_override = Cr.set_override

    def set_back(controller, percent):
        states.append(controller.state())
        set_override(controller, percent)

    monkeypatch.setattr(exploration, "_saved", saved)
    monkeypatch.setattr(AnyContacts, "touching", touching)
    monkeypatch.setattr(Cr, "set_override", set_back)
    status, _, said = started(capsys, "--size", "50")
    assert status in (1, 130) and "CL240" in said, said
    assert [(one.running, one.override) for one in states] == [
        *((False, 100), (False, 1), (False, 100))
    ]


@pytest.mark.slow
def test_a_program_runs_and_a_contact_stops_it(capsys, cell) -> None:
    more = ("--seconds", "20", "--log", "log.csv", "--format", "json")
    status, out, said = started(capsys, *more)
    assert status == 1, said
    assert json.loads(out)["contacts"] == 1
    assert float(rows_of("log.csv")[-1]["contact"]) == 1.0
    with connect("cell1") as controller:
        state = controller.state()
    assert not state.running and state.override == 100
