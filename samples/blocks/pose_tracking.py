"""A model of bdsim: an arm keeps its tool on a pose that moves, as on a part on a conveyor.

The speed of the tool that is wanted, and what is left between the two poses, become speeds of the
joints by the Jacobian. The joints lag by 30 ms, and the speed is told as much earlier:

    python pose_tracking.py [-o columns.csv]
"""

import argparse
import itertools

import numpy as np

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.blocks.bdsim_adapter import run_paced

ROBOT = robots.get("irb1200-7-0.7")
STEP, SECONDS = 0.01, 6.0
LAG = 0.03  # seconds by which the joints follow
GAIN = 8.0  # of what is left, a second
HOME = np.array([0.0, 20.0, 10.0, 0.0, 60.0, 0.0])
DRAWN = {
    "target[0]": "target: pose that is wanted, mm and a quaternion",
    "left[0]": "left: from the tool to it, mm and degrees",
    "control[0]": "control: speeds of the joints, degrees/s",
}
"""Signals of the picture, and what is said of them."""


def target() -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) and poses (n, 7): along the conveyor and to and fro, turning about its own z."""
    t = np.arange(0.0, SECONDS + STEP, STEP)
    (position,), (turn,) = ROBOT.fk(HOME)
    part = np.sin(np.clip(t, 0.0, 1.0) * np.pi / 2.0) ** 2  # begins softly
    way = part[:, None] * np.column_stack(
        [40.0 * np.sin(1.5 * t), 60.0 * np.sin(0.9 * t), 30.0 * np.sin(2.1 * t)]
    )
    half = np.radians(15.0 * part * np.sin(1.2 * t)) / 2.0
    about_z = np.column_stack([np.cos(half), 0 * t, 0 * t, np.sin(half)])
    return t, np.hstack([position + way, rotations.multiply(turn[None], about_z)])


def left(wanted: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """(6,) mm and degrees from a pose to another one."""
    turn = rotations.multiply(wanted[None, 3:], rotations.conjugate(pose[None, 3:]))[0]
    turn = turn if turn[0] >= 0.0 else -turn
    return np.concatenate([wanted[:3] - pose[:3], np.degrees(2.0 * turn[1:])])


def control(off: np.ndarray, ahead: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
    """(6,) speeds of the joints: what leads to the target, and what it moves by itself."""
    return np.linalg.lstsq(jacobian.reshape(6, 6), GAIN * off + ahead, rcond=1e-6)[0]


def model(sim):
    """The diagram."""
    t, poses = target()
    speeds = np.gradient(poses[:, :3], STEP, axis=0)
    turning = [left(b, a) / STEP for a, b in itertools.pairwise(poses)]
    speeds = np.hstack([speeds, np.array([*turning, turning[-1]])[:, 3:]])
    bd = sim.blockdiagram()
    clock = bd.clock(STEP)
    wanted = bd.MOTIONTABLE(t, poses, name="target")
    ahead = bd.MOTIONTABLE(t - LAG - STEP, speeds, name="its speed")
    off = bd.FUNCTION(left, nin=2, name="left")
    law = bd.FUNCTION(control, nin=3, name="control")
    joints = bd.INTEGRATOR_S(clock, x0=HOME, name="joints")
    arm = bd.SIMARM(clock, ROBOT, start=HOME, lag=LAG, name="arm")
    slopes = bd.ARMJACOBIAN(ROBOT, name="jacobian")
    bd.connect(wanted[0], off[0])
    bd.connect(arm[1], off[1])
    bd.connect(off, law[0])
    bd.connect(ahead[0], law[1])
    bd.connect(arm[0], slopes)
    bd.connect(slopes, law[2])
    bd.connect(law, joints)
    bd.connect(joints, arm)
    return bd


def simulated():
    """The diagram, and the columns of its run."""
    from bdsim import BDSim

    quiet = {"graphics": False, "progress": False, "quiet": True, "hold": False}
    sim = BDSim(packages="assistant", toolboxes=False, sysargs=False, **quiet)
    bd = model(sim)
    return bd, run_paced(sim, bd, SECONDS, STEP)


def main() -> None:
    """Runs the model and says how near the tool stays."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("-o", "--output", help=".csv or .npz for the columns")
    given = arguments.parse_args()
    _, ran = simulated()
    off = np.linalg.norm(ran["left[0]"][:, :3], axis=1)[ran.seconds > 1.0]
    way = np.linalg.norm(np.diff(ran["target[0]"][:, :3], axis=0), axis=1).sum()
    print(f"{way:.0f} mm of way, at most {off.max():.2f} mm beside it")
    if given.output:
        from assistant.controllers.recording import save_columns

        save_columns(given.output, ran.flat())


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        raise SystemExit(str(refused)) from None
