"""Commands that use a controller for a while leave it as it was, by its own state."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from assistant.virtual.cr import VirtualCr
from assistant.virtual.cr.real_time import Enet, mxt_commands
from tests.cli.test_commands import run
from tests.cli.test_follow import FIVE, free_port
from tests.cli.test_pointing import PLACES, POINT, filmed

PROGRAM = "10 M1=3\r\n20 M_05=7\r\n30 P1=P_CURR\r\n40 END\r\nP1=(160,0,478,0,180)(6,0)\r\n"
NETWORK = ", ".join(f"OPT{i}" for i in range(12, 19)) + ", "


def snapshot(controller: VirtualCr) -> dict[str, object]:
    """All that a controller keeps, but for where the arm is and its servos."""
    state = controller.state
    now = {name: state.program_now(name) for name in state.store}
    return {
        "programs": {name: (one.text(), sorted(one.protected)) for name, one in now.items()},
        "variables": {name: sorted(one.values.values()) for name, one in now.items()},
        # One without a value is 0 to whoever reads it.
        "shared": {
            line for line in state.machinery.shared_now().values.values() if line[-3:] != "=+0"
        },
        "slots": dict(state.selected),
        "parameters": {name: state.parameters[name] for name in state.parameters.changed},
        "override": state.override,
        "tool": state.tool,
        "alarm": state.alarm,
        "right": state.right,
        "open": dict(state.edited),
    }


@pytest.fixture
def port() -> int:
    return free_port()


@contextmanager
def cell(tmp_path: Path, port: int) -> Iterator[VirtualCr]:
    """A controller with a program in slot 1 that a deployment left there."""
    controller = VirtualCr(lines={"ENET:": Enet()}, commands=mxt_commands(port=port))
    controller.state.parameters.write("COMDEV", NETWORK, all_levels=True)
    with controller:
        table = f'address = "{controller.address}"\nrobot = "rv-2aj"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        yield controller


def made_ready(capsys, here: Path) -> None:
    (here / "JOB.prg").write_bytes(PROGRAM.encode("ascii"))
    (here / "way.csv").write_text(FIVE, encoding="utf-8")
    for words in (
        ("motors", "cell1", "on", "--yes"),
        ("deploy", "JOB.prg", "--to", "cell1"),
    ):
        status, _, said = run(capsys, *words)
        assert status == 0, said


def lines_of(controller: VirtualCr) -> list[str]:
    pairs = [f"{host}:{port}" for host, port in controller.data_ports.values()][:2]
    return [word for pair in pairs for word in ("--line", pair)]


Words = Callable[[VirtualCr, int], list[object]]
FOLLOW = ["follow", "cell1", "way.csv", "--yes"]
COMMANDS: dict[str, Words] = {
    "jog a joint": lambda c, p: ["jog", "cell1", "J1", 1, "--speed", 100, "--yes"],
    "jog an axis": lambda c, p: ["jog", "cell1", "Z", -2, "--speed", 100, "--yes"],
    "follow by mxt": lambda c, p: [*FOLLOW, "--by", "mxt", "--port", p],
    "follow by data link": lambda c, p: [
        *(*FOLLOW, "--by", "data-link", "--interval", "1"),
        *lines_of(c),
    ],
    "hand": lambda c, p: ["hand", "cell1", "open", "--yes"],
    "teach": lambda c, p: ["teach", "cell1", "first", "--now", "--into", "points.toml"],
    "backup": lambda c, p: ["backup", "cell1", "kept"],
    "monitor": lambda c, p: ["monitor", "cell1", "--seconds", "0.2"],
    "variables": lambda c, p: ["variables", "cell1", "P1", "--program", "JOB"],
    "parameters": lambda c, p: ["parameters", "cell1", "MEJAR"],
    "ls": lambda c, p: ["ls", "cell1"],
    "get": lambda c, p: ["get", "cell1", "JOB", "-o", "-"],
    "log": lambda c, p: ["log", "cell1"],
    "inputs": lambda c, p: ["inputs", "cell1", "5"],
    "outputs": lambda c, p: ["outputs", "cell1", "5"],
    "plan": lambda c, p: ["plan", "JOB.prg", "--to", "cell1"],
    "verify": lambda c, p: ["verify", "--to", "cell1"],
    "deploy again": lambda c, p: ["deploy", "JOB.prg", "--to", "cell1"],
    "stop": lambda c, p: ["stop", "cell1"],
}


QUICK = ("jog a joint", "verify")


def check_each(capsys, controller: VirtualCr, port: int, names: Iterable[str]) -> None:
    """One after the other: what one left would be seen by the next one, too."""
    before = snapshot(controller)
    for name in names:
        status, _, said = run(capsys, *COMMANDS[name](controller, port))
        assert status == 0, (name, said)
        assert snapshot(controller) == before, name


def test_quick_commands_leave_the_controller_as_it_was(capsys, tmp_path, here, port):
    with cell(tmp_path, port) as controller:
        made_ready(capsys, here)
        controller.state.machinery.select(1, "JOB")
        check_each(capsys, controller, port, QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("loaded", [True, False], ids=["slot 1 has a program", "slot 1 is empty"])
def test_each_command_leaves_the_controller_as_it_was(capsys, tmp_path, here, port, loaded):
    with cell(tmp_path, port) as controller:
        made_ready(capsys, here)
        if loaded:
            controller.state.machinery.select(1, "JOB")
        check_each(capsys, controller, port, COMMANDS)


def test_a_goal_that_is_out_of_reach_leaves_no_error(capsys, tmp_path, here, port):
    """Without a robot in the project only the controller sees that it is."""
    with cell(tmp_path, port) as controller:
        made_ready(capsys, here)
        table = f'[controllers.cell1]\naddress = "{controller.address}"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(table, encoding="utf-8")
        before = snapshot(controller)
        status, _, said = run(capsys, "jog", "cell1", "Z", 90, "--speed", 100, "--yes")
        assert status == 1 and "CN301" in said
        assert snapshot(controller) == before


LONG_JOG = ["jog", "cell1", "J1", 60, "--speed", 2, "--yes"]
WAY = FIVE.rsplit("\n", 2)[0] + "\n200,0,430,0,0,1,0,5\n"
SLOW: dict[str, Words] = {
    "jog": lambda c, p: LONG_JOG,
    "follow by mxt": COMMANDS["follow by mxt"],
    "follow by data link": COMMANDS["follow by data link"],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SLOW)
def test_an_interrupted_command_leaves_the_controller_as_it_was(capsys, tmp_path, here, port, name):
    with cell(tmp_path, port) as controller:
        made_ready(capsys, here)
        (here / "way.csv").write_text(WAY, encoding="utf-8")
        controller.state.machinery.select(1, "JOB")
        before, began = snapshot(controller), controller.state.joints
        command = [sys.executable, "-m", "assistant", *map(str, SLOW[name](controller, port))]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as child:
            end = time.monotonic() + 30.0
            while child.poll() is None and time.monotonic() < end:
                now = controller.state.joints
                if max(abs(a - b) for a, b in zip(now, began, strict=True)) > 0.3:
                    break
                time.sleep(0.02)
            child.send_signal(signal.SIGINT)
            _, said = child.communicate(timeout=60)
        assert child.returncode == 130 and "CL240" in said and "Traceback" not in said, said
        assert snapshot(controller) == before


@pytest.mark.slow
def test_what_leads_the_arm_works_after_a_jog(capsys, tmp_path, here, port):
    filmed(here, PLACES[:1])
    with cell(tmp_path, port) as controller:
        made_ready(capsys, here)
        go = ["teach", "cell1", "above", *POINT[1:], "--go", "--speed", 100, "--yes"]
        by = ["--by", "mxt", "--port", port]
        for words in (
            ("start", "cell1", "JOB", "--yes"),
            ("jog", "cell1", "J1", 1, "--speed", 100, "--yes"),
            (*FOLLOW, *by),
            (*go, *by),
        ):
            status, _, said = run(capsys, *words)
            assert status == 0, (words, said)
        (here / "JOB.prg").write_bytes(PROGRAM.replace("M1=3", "M1=4").encode("ascii"))
        status, _, said = run(capsys, "deploy", "JOB.prg", "--to", "cell1")
        assert "JCOSIROP" not in said and "JGOAL" not in said, said
        assert sorted(controller.state.store) == ["JOB"]
