"""The FMU of a program's motion beside its simulation, in fmpy and in a C program."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import assistant
from assistant.base.diagnostics import Refused
from assistant.blocks.fmu import Model, program_model
from assistant.blocks.fmu.robot_models import Motion, Playback
from assistant.program.program import Program
from assistant.robots import solve_program
from assistant.robots.timing import Simulation, simulate
from tests.blocks.fmu.hosting import Hosted

SAMPLES = Path(__file__).parents[3] / "samples"
SAME = 1e-9
INPUTS = ("speed_factor", "play", "restart")


def simulated(period: float = 0.01) -> Simulation:
    done = assistant.simulate(
        SAMPLES / "rapid" / "gluing.mod", robot="irb1200-7-0.7", period=period
    )
    return done.simulation


def model_of(simulation: Simulation) -> tuple[Model, Motion]:
    motion = Motion.of(simulation)
    return program_model(motion, simulation.robot, "gluing"), motion


def test_its_joints_and_poses_are_those_of_the_simulation(
    tmp_path: Path, tell: Callable[[str], None]
) -> None:
    simulation = simulated()
    model, _ = model_of(simulation)
    hosted, samples = Hosted(model, tmp_path), simulation.samples
    rows = np.tile([1.0, 1.0, 0.0], (len(samples) + 3, 1))
    found, _ = hosted.run(INPUTS, rows, 0.01)
    _, speed = hosted.run(INPUTS, rows[:100], 0.01, {"repeat": 1.0}, repeats=200_000)
    assert speed is not None
    wanted = np.column_stack(
        [samples.joints, samples.position, samples.quaternion, samples.tcp_speed, samples.t]
    )
    off = np.abs(found[: len(samples), : wanted.shape[1]] - wanted)
    assert off.max() < SAME
    names = hosted.outputs()
    end = dict(zip(names, found[-1], strict=True))
    assert (end["done"], end["running"], end["ends"], end["progress"]) == (1, 0, 1, 1)
    assert end["program_time"] == simulation.seconds
    assert found[0, names.index("running")] == 1
    tell(
        f"FMU program of {simulation.seconds:.1f} s: {speed.steps:,.0f} steps/s in C, "
        f"{speed.nanoseconds:,.0f} ns a step, {speed.bytes} bytes an instance, {speed.peak} KiB "
        f"the process at most, the file {hosted.size // 1024} KiB"
    )


def controlled(count: int, seed: int = 8) -> np.ndarray:
    """Played, held, sped up, restarted, some of the factors no use."""
    random = np.random.default_rng(seed)
    factor = random.choice([1.0, 0.5, 3.0, -1.0, np.nan], count // 20 + 1).repeat(20)[:count]
    play = (random.random(count // 10 + 1) < 0.8).repeat(10)[:count]
    restart = random.random(count) < 0.001
    return np.column_stack([factor, play, restart]).astype(np.float64)


@pytest.mark.parametrize("repeat", [False, True])
def test_what_is_held_and_restarted_is_as_the_library_plays_it(
    repeat: bool, tmp_path: Path
) -> None:
    model, motion = model_of(simulated())
    rows, step = controlled(4000), 0.0371
    playback = Playback(motion, repeat=repeat)
    wanted = [motion.at(0.0)]
    for factor, play, restart in rows:
        wanted.append(playback.step(step, play=bool(play), restart=bool(restart), factor=factor))
    hosted = Hosted(model, tmp_path)
    found, _ = hosted.run(INPUTS, rows, step, {"repeat": float(repeat)})
    width = motion.table.shape[1]
    assert np.abs(found[:, :width] - np.array(wanted)).max() < SAME
    assert found[-1, hosted.outputs().index("ends")] == playback.ends >= 2


def test_fmpy_gives_the_same(tmp_path: Path, tell: Callable[[str], None]) -> None:
    model, motion = model_of(simulated())
    hosted = Hosted(model, tmp_path)
    rows = np.tile([1.0, 1.0, 0.0], (300, 1))
    begin = time.perf_counter()
    found = hosted.in_fmpy(INPUTS, rows, 0.01)
    seconds = time.perf_counter() - begin
    assert np.abs(found[:, : motion.table.shape[1]] - motion.table[:301]).max() < SAME
    tell(f"FMU program: {len(rows) / seconds:,.0f} steps/s in fmpy, unpacking included")


@pytest.mark.slow
def test_between_its_rows_it_is_near_a_finer_simulation(tell: Callable[[str], None]) -> None:
    coarse, fine = Motion.of(simulated(0.002)), simulated(0.0005)
    samples = fine.samples
    found = np.array([coarse.at(t) for t in samples.t])
    a = samples.joints.shape[1]
    degrees = np.abs(found[:, :a] - samples.joints).max()
    mm = np.linalg.norm(found[:, a : a + 3] - samples.position, axis=1).max()
    tell(f"FMU program: between rows of 2 ms off by {degrees:.3f} degrees and {mm:.3f} mm at most")
    assert degrees < 0.01 and mm < 0.1


def test_the_last_row_is_where_the_program_ends() -> None:
    simulation = simulated(0.07)
    motion = Motion.of(simulation)
    fine = Motion.of(simulated(0.001))
    assert motion.seconds == simulation.seconds
    assert np.abs(motion.table[-1] - fine.table[-1]).max() < 1e-6
    assert motion.table[-1, -1] == pytest.approx(0.0, abs=1e-6)


def test_a_program_that_takes_no_time_is_refused() -> None:
    robot = assistant.robots.get("rv-2aj")
    motion = Motion.of(simulate(solve_program(Program("none", ()), robot)))
    with pytest.raises(Refused) as refused:
        program_model(motion, robot, "none")
    assert [one.code for one in refused.value.findings] == ["BL405"]


def test_a_table_of_too_many_rows_is_refused() -> None:
    simulation = simulated(0.0002)
    with pytest.raises(Refused) as refused:
        program_model(Motion.of(simulation), simulation.robot, "gluing")
    (finding,) = refused.value.findings
    assert finding.code == "BL404"
    least = float(finding.cure.split(" of ")[1].split(" s ")[0])
    again = Motion.of(simulated(least))
    assert len(again.table) <= 50_000
