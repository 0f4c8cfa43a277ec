"""Commands that use an IRC5 for a while leave it as it was, by what is inside of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.controllers import connect
from assistant.controllers.setpoint_streams import MODES
from assistant.controllers.trajectory_execution import LinkOptions
from assistant.virtual.irc5 import VirtualIrc5
from assistant.virtual.irc5.cabinet import Signal
from assistant.virtual.irc5.egm import Guidance, VirtualEgm
from assistant.vision.servoing.bounds import Bounds, Guard
from tests.cli.test_commands import run
from tests.cli.test_follow import DOWN, GRIPPER, SIX, free_port
from tests.controllers.abb.exchanging import RunningRobot

MODULE = """MODULE cell
  PERS num made:=3;
  PROC main()
    SetDO doGrip,1;
    WaitDI diPart,1;
  ENDPROC
ENDMODULE
"""
ARM = robots.get("irb1200-7-0.7")


def files(controller: VirtualIrc5) -> dict[str, bytes]:
    home = controller.folder
    return {
        str(path.relative_to(home)): path.read_bytes() if path.is_file() else b"folder"
        for path in home.rglob("*")
    }


def snapshot(controller: VirtualIrc5) -> dict[str, object]:
    """All that a controller keeps, but for where the arm is."""
    cabinet, panel = controller.cabinet, controller.cabinet.panel
    signals = cabinet.signals()
    return {
        "files": files(controller),
        "programs": cabinet.do(
            lambda programs: {name: programs.text(one) for name, one in programs.modules.items()}
        ),
        "run": cabinet.do(
            lambda programs: (programs.running, programs.cycle, programs.pointer(), programs.ready)
        ),
        "panel": (panel.mode, panel.state, panel.speed),
        "signals": {name: cabinet.read(one) for name, one in signals.items()},
        "mastership": dict(cabinet.mastership.holders),
        "sessions": len(controller.sessions),
        "events": [event.code for event in cabinet.log.of(0)],
    }


Words = Callable[[int], list[object]]
COMMANDS: dict[str, Words] = {
    "info": lambda _: ["monitor", "cell1", "--seconds", "0.2", "--interval", "0.05"],
    "watched signals": lambda _: [
        *("monitor", "cell1", "--seconds", "0.2", "--signals", "doGrip", "--log", "run.csv")
    ],
    "ls": lambda _: ["ls", "cell1"],
    "get": lambda _: ["get", "cell1", "cell.mod", "-o", "-"],
    "log": lambda _: ["log", "cell1"],
    "inputs": lambda _: ["inputs", "cell1", "diPart"],
    "outputs": lambda _: ["outputs", "cell1", "doGrip"],
    "variables": lambda _: ["variables", "cell1", "made", "--program", "cell"],
    "teach": lambda _: ["teach", "cell1", "first", "--now", "--into", "points.toml"],
    "backup": lambda _: ["backup", "cell1", "kept"],
    "plan": lambda _: ["plan", "cell.mod", "--to", "cell1"],
    "verify": lambda _: ["verify", "--to", "cell1"],
    "deploy again": lambda _: ["deploy", "cell.mod", "--to", "cell1"],
    "stop": lambda _: ["stop", "cell1"],
    "follow by egm": lambda port: [
        *("follow", "cell1", "way.csv", "--by", "egm", "--port", port, "--yes")
    ],
    "explore by hand": lambda _: [
        *("explore", "manual", "cell1", "--cell", "cell.toml", "--chart", "arm.npz"),
        *("--contact", "diPart", "--seconds", "0.3", "--size", "100"),
    ],
}
REFUSED: dict[str, Words] = {
    "jog": lambda _: ["jog", "cell1", "J1", 1, "--yes"],
    "hand": lambda _: ["hand", "cell1", "open", "--yes"],
    "wander by jog": lambda _: [
        *("explore", "wander", "cell1", "--cell", "cell.toml", "--chart", "arm.npz", "--yes"),
        *("--contact", "diPart", "--range", "J1=-10:10"),
    ],
    "packets of another maker": lambda _: ["follow", "cell1", "way.csv", "--by", "mxt", "--yes"],
    "lines of another maker": lambda _: [
        *("follow", "cell1", "way.csv", "--by", "data-link", "--yes")
    ],
}
"""What this controller cannot do is refused, and leaves nothing either."""
QUICK = ("backup", "verify")
WHILE_WAITING = ("info", "variables", "teach", "inputs")


@pytest.fixture
def ready(capsys, here, tmp_path, monkeypatch) -> Iterator[VirtualIrc5]:
    """With a program that a deployment left there."""
    signals = (Signal("doGrip", "DO"), Signal("diPart", "DI"))
    home = tmp_path / "home"
    with VirtualIrc5(home, password="secret", rate=10.0, rwss=None, signals=signals) as irc5:
        monkeypatch.setenv("ROBOT_ASSISTANT_CELL1_PASSWORD", "secret")
        table = f'address = "{irc5.rws_address}"\nrobot = "irb1200-7-0.7"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        made_ready(capsys, here)
        yield irc5


def made_ready(capsys, here: Path) -> None:
    cell = '[robots.arm]\nrobot = "irb1200-7-0.7"\n'
    texts = {"cell.mod": MODULE, "way.csv": SIX, "cell.toml": cell}
    for name, text in texts.items():
        (here / name).write_text(text, encoding="utf-8")
    for words in (
        ("motors", "cell1", "on", "--yes"),
        ("deploy", "cell.mod", "--to", "cell1"),
        ("start", "cell1", "cell.mod", "--yes", "--no-wait"),
        ("stop", "cell1"),
        # The start has loaded the module: what is there is known from here on.
        ("deploy", "cell.mod", "--to", "cell1"),
    ):
        status, _, said = run(capsys, *words)
        assert status == 0, said


def check_each(capsys, controller: VirtualIrc5, names: Iterable[str]) -> None:
    """Runs one after the other, and names all that leave something."""
    port, left = free_port(), {}
    for name in names:
        before = snapshot(controller)
        words = (COMMANDS.get(name) or REFUSED[name])(port)
        with ExitStack() as open_:
            if name == "follow by egm":
                open_.enter_context(VirtualEgm(guided(), ("127.0.0.1", port)))
            status, _, said = run(capsys, *words)
        now = snapshot(controller)
        changed = {what: (before[what], now[what]) for what in now if now[what] != before[what]}
        if changed or (status == 0) != (name in COMMANDS):
            left[name] = (status, said, changed)
    assert left == {}


def guided() -> Guidance:
    patient = {"comm_timeout": 60.0, "cond_time": 60.0, "waiting": None}
    return Guidance("joints", ARM.home, (200.0,) * 6, **patient)


def test_quick_commands_leave_the_controller_as_it_was(capsys, ready):
    """And a program that waits goes on waiting."""
    check_each(capsys, ready, QUICK)
    assert run(capsys, "start", "cell1", "--yes", "--no-wait")[0] == 0
    check_each(capsys, ready, WHILE_WAITING)


@pytest.mark.slow
def test_each_command_leaves_the_controller_as_it_was(capsys, ready):
    check_each(capsys, ready, [*COMMANDS, *REFUSED])


@pytest.mark.slow
def test_an_exchange_leaves_the_files_as_they_were(capsys, monkeypatch, tmp_path, here):
    """`exchange`, `follow --by exchange`, and what leads an arm by poses for `servo` and others."""
    (here / "way.csv").write_text(DOWN, encoding="utf-8")
    (here / "way.process.toml").write_text(GRIPPER, encoding="utf-8")
    with RunningRobot(tmp_path / "home") as robot:
        monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", robot.controller.password)
        address = robot.controller.address
        table = f'address = "{address}"\nrobot = "irb1200-7-0.7"\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        before = set(files(robot.controller))
        for words in (
            ("exchange", "pose", "cell1"),
            ("exchange", "follow", "cell1", "way.csv", "--yes"),
            ("follow", "cell1", "way.csv", "--by", "exchange", "--yes"),
        ):
            status, _, said = run(capsys, *words)
            assert status == 0, (words, said)
            assert set(files(robot.controller)) == before, words
        guard = Guard(ARM, Bounds())
        with connect("cell1") as session:
            mode = MODES["exchange"]
            with mode.make(session, guard.arm(), LinkOptions(), np.array(ARM.home)) as carrier:
                carrier.move(carrier.joints(), 0.5)
        assert set(files(robot.controller)) == before
