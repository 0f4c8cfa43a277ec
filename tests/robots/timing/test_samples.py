"""The motion over time fits together."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.program.pseudo import parse
from assistant.robots.timing import Simulation, simulate

ARM = robots.get("irb1200-7-0.7")
TEXT = """program p

tool pen tip [20, 0, 80]

target a [400, -150, 400] [0, 0, 1, 0]
target b [400, 150, 400] [0, 0.3826834323650898, 0.9238795325112867, 0]
target c [450, 0, 300] [0, 0, 1, 0]
target d [400, -150, 350] [0, 0, 1, 0]

procedure main
  move joint a speed 300 mm/s blend fine tool pen
  wait 0.5 s
  move linear b speed 250 mm/s blend 20 mm tool pen
  move circular via c to d speed 200 mm/s blend fine tool pen
end
"""


def done(**options: float) -> Simulation:
    return simulate(robots.solve_program(parse(TEXT), ARM), **options)


def test_the_samples_reach_from_the_start_to_the_end() -> None:
    result = done()
    samples = result.samples
    assert samples.t[0] == 0.0 and np.allclose(np.diff(samples.t), 0.01)
    assert result.seconds - 0.01 < samples.t[-1] <= result.seconds
    assert np.allclose(samples.joints[0], ARM.home)
    assert np.allclose(samples.position[-1], [400, -150, 350], atol=1.0)
    counts = {len(getattr(samples, name)) for name in samples.__slots__}
    assert counts == {len(samples)}


def test_the_wait_stands_still() -> None:
    samples = done().samples
    still = (samples.tcp_speed == 0) & (np.abs(samples.joint_velocity).max(axis=1) == 0)
    assert 49 <= np.count_nonzero(still[1:]) <= 53
    assert np.allclose(samples.position[1:][still[1:]], [400, -150, 400])


def test_speed_is_the_change_of_position() -> None:
    samples = done(period=0.002).samples
    way = np.linalg.norm(np.diff(samples.position, axis=0), axis=1) / 0.002
    mean = (samples.tcp_speed[1:] + samples.tcp_speed[:-1]) / 2
    known = samples.t[1:] > 1.0  # before, the flange becomes the tool's tip
    assert np.quantile(np.abs(way - mean)[known], 0.98) < 1.0


def test_velocity_is_the_change_of_joints_and_acceleration_of_velocity() -> None:
    samples = done(period=0.002).samples
    change = np.diff(samples.joints, axis=0) / 0.002
    mean = (samples.joint_velocity[1:] + samples.joint_velocity[:-1]) / 2
    assert np.quantile(np.abs(change - mean), 0.98) < 1.0
    assert (np.abs(samples.joint_velocity) <= ARM.speeds).all()
    inner = (samples.joint_velocity[2:] - samples.joint_velocity[:-2]) / 0.004
    assert np.allclose(samples.joint_acceleration[1:-1], inner)


def test_joints_and_positions_are_those_of_one_arm() -> None:
    samples = done().samples
    flange, turn = ARM.fk(samples.joints)
    tip = flange + rotations.rotate(turn, [20.0, 0.0, 80.0])
    assert np.abs(tip - samples.position)[1:].max() < 0.05
    assert rotations.angle_between(turn, samples.quaternion)[1:].max() < 0.05


def test_a_period_that_gives_too_many_samples_is_refused() -> None:
    with pytest.raises(Refused) as refused:
        _ = done(period=1e-6).samples
    assert refused.value.findings[0].code == "RB301"
    with pytest.raises(Refused, match="period"):
        done(period=0.0)
    with pytest.raises(Refused, match="acceleration"):
        done(acceleration=-1.0)


@pytest.mark.slow
def test_a_long_program_gets_a_period_that_fits() -> None:
    result = simulate(robots.solve_program(parse(TEXT.replace("wait 0.5 s", "wait 30000 s")), ARM))
    assert result.period == pytest.approx(0.05)
    assert len(result.samples) <= 1_000_000


ROUND = """    wait 0.2 s
    move linear d speed 200 mm/s blend fine tool pen
    move linear a speed 100 mm/s blend fine tool pen
"""
INNER = f"    for j from 1 to 2\n{ROUND}    end\n    wait 0.3 s\n"


def looping(body: str) -> Simulation:
    start = TEXT[: TEXT.index("  wait 0.5 s")]
    return simulate(robots.solve_program(parse(f"{start}{body}end\n"), ARM), period=0.007)


def test_the_samples_of_a_loop_are_those_of_its_rounds_one_after_the_other() -> None:
    looped = looping(f"  for i from 1 to 3\n{INNER}  end\n  wait 1 s\n").samples
    written = looping((ROUND * 2 + "    wait 0.3 s\n") * 3 + "  wait 1 s\n").samples
    assert len(looped) == len(written)
    for name in looped.__slots__:
        assert np.allclose(getattr(looped, name), getattr(written, name), atol=1e-6)


def test_a_loop_without_end_has_samples_of_its_rounds() -> None:
    start = TEXT[: TEXT.index("  wait 0.5 s")]
    loop = f"  for i from 1 to 1000000000\n{INNER}  end\n"
    samples = simulate(robots.solve_program(parse(f"{start}{loop}end\n"), ARM)).samples
    assert 100_000 < len(samples) <= 1_000_000
    x, y, z = samples.position[1:].T
    assert np.allclose(x, 400) and np.allclose(y, -150, atol=0.1)
    assert np.quantile(z, 0.01) < 352 and np.quantile(z, 0.99) > 398
