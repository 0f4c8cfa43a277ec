"""A model of bdsim: a tool stays on its path, with no force and no contact to lead it.

The arm is slow and lags behind. A program's motion is played at the speed at which the arm comes
after: the nearer it is to being too far behind, the slower the path goes on, so that the tool cuts
no corner. Beside it the same arm is sent along by the time of the program, whatever it does:

    python path_following.py [-o columns.csv]
"""

import argparse
from pathlib import Path

import numpy as np

import assistant
from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.bdsim_adapter import run_paced

PROGRAM = Path(__file__).parent.parent / "rapid" / "gluing.mod"
ROBOT = robots.get("irb1200-7-0.7")
STEP = 0.02
LAG, PERCENT = 0.08, 40.0  # seconds by which its joints follow; of the speeds of its axes
ALLOWED = 1.5  # degrees behind at which the path stands still
SOON = 0.05  # seconds in which the arm may become that far behind
DRAWN = {
    "rate[0]": "rate: how fast the path goes on, of the speed of the program",
    "how far[0]": "how far: seconds of the program",
    "arm[0]": "arm: joints, degrees",
}
"""Signals of the picture, and what is said of them."""


def motion():
    """Times (n,), joints (n, 6) and places of the tool (n, 3) mm of the program."""
    samples = assistant.simulate(PROGRAM, robot=ROBOT.name, period=0.02).simulation.samples
    return samples.t, samples.joints


def model(sim, seconds, joints):
    """The diagram: a path that waits for its arm, and one that does not."""

    def at(time):
        return np.array([np.interp(time, seconds, column) for column in joints.T])

    fastest = np.abs(np.gradient(joints, seconds, axis=0)).max(axis=1)

    def rate(time, wanted, reached):
        behind = float(np.abs(wanted - reached).max())
        speed = float(np.interp(time, seconds, fastest))
        return float(np.clip((ALLOWED - behind) / max(SOON * speed, 1e-9), 0.0, 1.0))

    bd = sim.blockdiagram()
    clock = bd.clock(STEP)
    how_far = bd.INTEGRATOR_S(clock, x0=0.0, name="how far")
    along = bd.FUNCTION(at, name="path")
    goes_on = bd.FUNCTION(rate, nin=3, name="rate")
    arm = bd.SIMARM(clock, ROBOT, start=joints[0], lag=LAG, percent=PERCENT, name="arm")
    bd.connect(how_far, along, goes_on[0])
    bd.connect(along, goes_on[1], arm)
    bd.connect(arm[0], goes_on[2])
    bd.connect(goes_on, how_far)
    by_time = bd.MOTIONTABLE(seconds, joints, name="by time")
    other = bd.SIMARM(clock, ROBOT, start=joints[0], lag=LAG, percent=PERCENT, name="other arm")
    bd.connect(by_time[0], other)
    return bd


def simulated():
    """The diagram, and the columns of its run."""
    from bdsim import BDSim

    quiet = {"graphics": False, "progress": False, "quiet": True, "hold": False}
    sim = BDSim(packages="assistant", toolboxes=False, sysargs=False, **quiet)
    seconds, joints = motion()
    bd = model(sim, seconds, joints)
    return bd, run_paced(sim, bd, 2.2 * seconds[-1], STEP)


def beside(points, path):
    """(n,) mm of points from a way of many points (m, 3), by its nearest stretch."""
    start, way = path[:-1], np.diff(path, axis=0)
    square = np.maximum((way**2).sum(axis=1), 1e-12)
    off = np.empty(len(points))
    for i, point in enumerate(points):
        part = np.clip(((point - start) * way).sum(axis=1) / square, 0.0, 1.0)
        off[i] = np.linalg.norm(start + part[:, None] * way - point, axis=1).min()
    return off


def main() -> None:
    """Runs the model and says how far the tools are beside the path."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("-o", "--output", help=".csv or .npz for the columns")
    given = arguments.parse_args()
    _, ran = simulated()
    seconds, joints = motion()
    path = ROBOT.fk(joints)[0]
    ours, other = (beside(ran[f"{name}[1]"][::2, :3], path) for name in ("arm", "other arm"))
    took = ran.seconds[np.flatnonzero(ran["how far[0]"] >= seconds[-1] - 0.01)[0]]
    print(f"waiting: at most {ours.max():.2f} mm beside the path, {took:.1f} s")
    print(f"by time: at most {other.max():.2f} mm beside the path, {seconds[-1]:.1f} s")
    if given.output:
        from assistant.controllers.recording import save_columns

        save_columns(given.output, ran.flat())


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        raise SystemExit(str(refused)) from None
