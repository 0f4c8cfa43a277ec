"""Accelerations of arms that have a published picking cycle, and of the others."""

from dataclasses import replace

import numpy as np
import pytest

from assistant import robots
from assistant.program.expressions import TargetValue
from assistant.program.geometry import Load, Pose, Target, Tool
from assistant.program.motion import FINE, MAXIMUM_SPEED
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, Move
from assistant.robots.timing import TIME_TO_SPEED, drive_of, simulate
from benchmarks.picking import PUBLISHED, ratios


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_published_cycle_is_met(name):
    found = ratios(name, 25.0)
    assert len(found) >= 4
    robot = robots.get(name)
    fitted = robot.accelerations is None  # else they are those of the maker's planner
    assert np.median(found) == pytest.approx(1.0, abs=0.02 if fitted else 0.1)
    assert min(found) > 0.85
    assert max(found) < (1.15 if fitted else 1.25)
    assert ("time_to_speed_s" in robot.unconfirmed) is (robot.accelerations is None)


@pytest.mark.parametrize(
    ("name", "load", "seconds"),
    [
        ("irb1200-7-0.7", 0.0, 0.032),
        ("irb1200-7-0.7", 1.0, 0.032),
        ("irb1200-7-0.7", 1.5, TIME_TO_SPEED),
        ("irb1200-7-0.7", None, TIME_TO_SPEED),
        ("irb140-6-0.81", 5.0, 0.15),
        ("irb140-6-0.81", 6.0, 0.15),  # no quicker with more
        ("irb2600-12-1.65", 0.0, TIME_TO_SPEED),
    ],
)
def test_it_holds_up_to_its_load(name, load, seconds):
    robot = robots.get(name)
    drive = drive_of(robot, load=load)
    assert robot.speeds / drive.accelerations == pytest.approx(seconds)


def test_accelerations_of_a_planner_come_first():
    robot = replace(robots.get("rv-4frl"), time_to_speed=0.01, light=9.0)
    assert (drive_of(robot, load=0.0).accelerations == robot.accelerations).all()


def seconds(*tools):
    robot = robots.get("irb1200-7-0.7")
    motion = Motion(MAXIMUM_SPEED, FINE, "hand" if tools else "tool0")
    ends = (Pose((400.0, y, 300.0), (0.0, 0.0, 1.0, 0.0)) for y in (-150.0, 150.0))
    body = tuple(Move("joint", TargetValue(Target(pose)), motion) for pose in ends)
    named = dict(zip(("hand", "other"), tools, strict=False))
    program = Program("p", (Procedure("main", body),), entry="main", tools=named)
    return simulate(robots.solve_program(program, robot)).seconds


def test_the_heaviest_tool_of_a_program_counts():
    light, heavy, unknown = Tool(load=Load(0.5)), Tool(load=Load(3.0)), Tool()
    assert seconds() == seconds(light) < seconds(heavy) == seconds(light, heavy)
    assert seconds(unknown) == seconds(light, unknown) == seconds(heavy)
