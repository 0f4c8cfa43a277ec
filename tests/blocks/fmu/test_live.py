"""The FMU of a live controller against the virtual one, over UDP: who moves, how far, how ended."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.fmu import live_model
from assistant.blocks.fmu.robot_models import USUAL_RISE_SHARE, USUAL_SPEED_SHARE
from assistant.blocks.library.arms import ArmMotion
from assistant.robots import Robot
from assistant.virtual.cr.mxt import Fault
from assistant.virtual.cr.mxt_process import MxtProcess
from tests.blocks.fmu.hosting import Hosted

NAME = "rv-2aj"
CYCLE = 0.004
SAME = 1e-9
CONFIRMED = {"controller": "127.0.0.1", "confirm": "127.0.0.1"}


def robot() -> Robot:
    return robots.get(NAME)


def inputs() -> list[str]:
    return [*(f"{axis}_wanted" for axis in robot().axes), "enable"]


def told(count: int = 120) -> np.ndarray:
    """Joints that swing about home, and whether the arm goes to them; at first and last not."""
    t = np.arange(count) * CYCLE
    swing = np.outer(np.sin(4.0 * t), [9.0, -5.0, 6.0, -8.0, 20.0])
    enable = (np.arange(count) >= 10) & (np.arange(count) < 2 * count // 3)
    return np.column_stack([robot().home + swing, enable])


@pytest.fixture(scope="module")
def hosted(tmp_path_factory: pytest.TempPathFactory) -> Hosted:
    return Hosted(live_model(robot(), cycle=CYCLE), tmp_path_factory.mktemp("live"))


def led(hosted: Hosted, found: np.ndarray, name: str) -> np.ndarray:
    names = hosted.outputs()
    if name in names:
        return found[:, names.index(name)]
    return found[:, [names.index(name.format(axis)) for axis in robot().axes]]


Run = Callable[[dict[str, object]], np.ndarray]


def undisturbed(
    hosted: Hosted, run: Run, faults: Mapping[int, Fault] | None = None
) -> tuple[np.ndarray, MxtProcess]:
    """What comes of a run; of another one where this computer kept the controller waiting so long
    that the arm was taken to stand.

    run: is told the parameters.
    """
    for _ in range(40):
        with MxtProcess(NAME, cycle=CYCLE, faults=faults) as virtual:
            found = run({**CONFIRMED, "port": virtual.port})
        late = led(hosted, found, "longest_delay")[-1] > 3.0 * CYCLE
        if not late and not led(hosted, found, "lost")[-1]:
            break
    return found, virtual


def ours(start: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """What the library commands from the same place, to the same goals."""
    arm = ArmMotion.of(robot())
    # In single precision the place may be beyond a limit, which an arm that begins there may not.
    arm.at, arm.goal, arm.joints, drive = start.copy(), start.copy(), start.copy(), arm.drive
    arm.drive = replace(
        drive,
        speeds=USUAL_SPEED_SHARE * drive.speeds,
        accelerations=USUAL_RISE_SHARE * drive.accelerations,
    )
    found, before = [start], 0.0
    for row in rows:
        if row[-1]:
            arm.towards(row[:-1])
        elif before:
            arm.towards(arm.at + arm.speed * np.abs(arm.speed) / (2.0 * arm.drive.accelerations))
        before = row[-1]
        arm.step(CYCLE)
        found.append(arm.at)
    return np.array(found)


def test_what_it_commands_is_what_the_library_does(
    hosted: Hosted, tell: Callable[[str], None]
) -> None:
    rows, speeds = told(), []

    def run(given: dict[str, object]) -> np.ndarray:
        found, speed = hosted.run(inputs(), rows, CYCLE, given, repeats=1)
        speeds.append(speed)
        return found

    found, virtual = undisturbed(hosted, run)
    speed = speeds[-1]
    commands = led(hosted, found, "{}_command")
    assert commands[0] == pytest.approx(robot().home, abs=1e-4)
    assert np.abs(commands - ours(commands[0], rows)).max() < SAME
    track, lost = np.array(virtual.result["track"]), int(led(hosted, found, "lost")[-1])
    assert virtual.result["reason"] == "end"
    assert len(track) >= len(rows)
    assert np.abs(track[:20] - commands[1:21]).max() < 1e-4  # single precision
    assert np.abs(track[-1] - commands[-1]).max() < 1e-4
    assert np.ptp(track, axis=0).max() > 5.0
    moved = np.abs(np.diff(commands, axis=0)) / CYCLE
    assert (moved <= USUAL_SPEED_SHARE * robot().speeds * (1.0 + 1e-9)).all()
    measured = led(hosted, found, "{}")
    assert np.abs(measured[-1] - commands[-1]).max() < 0.1
    assert led(hosted, found, "virtual").all() and led(hosted, found, "confirmed")[-1]
    assert led(hosted, found, "enabled")[11:-45].all()
    assert not led(hosted, found, "enabled")[-38:].any()
    assert speed is not None
    late, delay = (led(hosted, found, name)[-1] for name in ("late_steps", "longest_delay"))
    tell(
        f"FMU live: {len(rows)} steps of {CYCLE * 1e3:g} ms, {late:.0f} late, {lost} lost, "
        f"{delay * 1e6:.0f} µs the longest delay, {speed.bytes} bytes an instance"
    )


@pytest.mark.slow
def test_it_goes_at_the_pace_of_the_controller(hosted: Hosted) -> None:
    """Steps of several cycles are as many packets; nothing is faster than the controller."""
    rows = told(30)
    with MxtProcess(NAME, cycle=CYCLE) as virtual:
        given = {**CONFIRMED, "port": virtual.port}
        found, _ = hosted.run(inputs(), rows, 3 * CYCLE, given)
    assert led(hosted, found, "cycles")[-1] == 90
    assert len(virtual.result["track"]) >= 90
    assert virtual.result["cycles"] >= 90


def test_what_nobody_confirmed_does_not_move(hosted: Hosted) -> None:
    with MxtProcess(NAME, cycle=CYCLE) as virtual:
        found, _ = hosted.run(inputs(), told(40), CYCLE, {"port": virtual.port})
    assert "motion is not confirmed" in hosted.said
    assert virtual.result["track"] == [] and virtual.result["reason"] == "stopped"
    assert led(hosted, found, "{}")[-1] == pytest.approx(robot().home, abs=1e-3)
    assert not led(hosted, found, "confirmed").any() and not led(hosted, found, "enabled").any()


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"controller": "192.0.2.7", "confirm": "yes"}, "nothing was sent"),
        ({"confirm": "192.0.2.7"}, "nothing was sent"),
        ({"controller": "no.such.host.invalid"}, "no address"),
        ({"port": 0}, "port"),
        ({"J1_speed_limit": 1e4}, "no more than the arm has"),
        ({"J1_upper_limit": 1e3}, "inside those of the arm"),
        ({"port": 9, "timeout": 0.05}, "does not answer"),
    ],
)
def test_what_cannot_be_is_refused_at_the_start(
    hosted: Hosted, wrong: dict[str, float | str], words: str
) -> None:
    with pytest.raises(AssertionError, match=words):
        hosted.run(inputs(), told(3), CYCLE, wrong)


@pytest.mark.slow
def test_a_step_is_a_cycle_of_the_controller(hosted: Hosted) -> None:
    with (
        MxtProcess(NAME, cycle=CYCLE) as virtual,
        pytest.raises(AssertionError, match="whole ones"),
    ):
        hosted.run(inputs(), told(3), CYCLE * 1.5, {**CONFIRMED, "port": virtual.port})
    assert virtual.result["track"] == []


def test_a_goal_far_away_is_not_gone_to(hosted: Hosted) -> None:
    rows = told(60)
    rows[:, 0] += 30.0
    with MxtProcess(NAME, cycle=CYCLE) as virtual:
        found, _ = hosted.run(inputs(), rows, CYCLE, {**CONFIRMED, "port": virtual.port})
    assert "too far" in hosted.said
    refused = led(hosted, found, "refused")
    assert refused[12:40].all() and not refused[:10].any()
    assert np.ptp(np.array(virtual.result["track"]), axis=0).max() == 0.0


@pytest.mark.parametrize(
    "fault",
    ["lost", *(pytest.param(f, marks=pytest.mark.slow) for f in ("garbled", "late"))],
)
def test_it_goes_on_behind_a_fault(hosted: Hosted, fault: str) -> None:
    rows = told(60)
    with MxtProcess(NAME, cycle=CYCLE, faults={35: fault}) as virtual:  # type: ignore[dict-item]
        found, _ = hosted.run(inputs(), rows, CYCLE, {**CONFIRMED, "port": virtual.port})
    assert virtual.result["reason"] == "end" and virtual.result["number"] == 0
    assert fault == "late" or led(hosted, found, fault)[-1] >= 1


@pytest.mark.slow
def test_an_answer_that_comes_twice_is_no_jerk(hosted: Hosted) -> None:
    found, virtual = undisturbed(
        hosted, lambda given: hosted.run(inputs(), told(60), CYCLE, given)[0], {35: "twice"}
    )
    assert virtual.result["reason"] == "end"
    rises = np.abs(np.diff(led(hosted, found, "{}_command"), 2, axis=0)) / CYCLE**2
    assert (rises <= 2.0 * USUAL_RISE_SHARE * ArmMotion.of(robot()).drive.accelerations).all()


@pytest.mark.slow
def test_a_controller_that_falls_silent_ends_it(hosted: Hosted) -> None:
    with MxtProcess(NAME, cycle=CYCLE, faults={25: "silent"}) as virtual:
        given = {**CONFIRMED, "port": virtual.port, "timeout": 0.1}
        with pytest.raises(AssertionError, match="does not answer"):
            hosted.run(inputs(), told(60), CYCLE, given)


def test_fmpy_gives_the_same(hosted: Hosted) -> None:
    rows = told(50)
    found, virtual = undisturbed(hosted, lambda given: hosted.in_fmpy(inputs(), rows, CYCLE, given))
    commands = led(hosted, found, "{}_command")
    assert np.abs(commands - ours(commands[0], rows)).max() < SAME
    assert virtual.result["reason"] == "end"


def test_the_cycle_is_that_of_its_controller() -> None:
    assert live_model(robots.get("rv-2aj")).step == pytest.approx(0.00711, abs=1e-5)
    assert live_model(robots.get("rv-4frl")).step == 0.0035
    with pytest.raises(Refused) as refused:
        live_model(robot(), cycle=2.0)
    assert [one.code for one in refused.value.findings] == ["BL407"]


def test_an_arm_of_another_controller_is_refused() -> None:
    with pytest.raises(Refused) as refused:
        live_model(robots.get("irb1200-7-0.7"))
    assert [one.code for one in refused.value.findings] == ["BL406"]
