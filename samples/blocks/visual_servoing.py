"""A model of bdsim: a camera in the hand sees a marker, and leads the tool above it.

The marker is projected into the camera where the arm is, with noise, 30 times a second; a law of
`assistant.vision.servoing` says how the flange is to move, and the arm goes there:

    python visual_servoing.py [--law image|pose] [-o columns.csv]
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.bdsim_adapter import add, run_paced
from assistant.blocks.diagrams import Block, Port
from assistant.blocks.library.ports import joints_port
from assistant.vision.cameras.camera_file import read_cameras
from assistant.vision.servoing.control_laws import ServoMoment
from assistant.vision.servoing.interaction import flange_of, jacobian
from assistant.vision.servoing.servo_task import read_servo, set_up_servo
from assistant.vision.servoing.simulation import ProjectedEyes, ServoWorld, SteppedClock

SAMPLES = Path(__file__).parent.parent / "servoing"
ROBOT = robots.get("rv-2aj")
START = np.array([-2.0, 1.0, 78.0, 87.0, -60.0])
STEP, PERIOD, SECONDS = 0.01, 0.03, 5.0
GAIN = 2.0  # of what is left, a second
DRAWN = {
    "law[1]": "law: pixels that are left, as they are seen",
    "law[2]": "law: mm that are left, as they are seen",
    "law[0]": "law: speeds of the joints, degrees/s",
    "arm[0]": "arm: joints, degrees",
}
"""Signals of the picture, and what is said of them."""


class SeeAndTell(Block):
    """joints where the arm is → speeds of the joints, pixels and mm that are left.

    A picture a step. What cannot be seen leaves the arm at rest. It is not direct: what it says
    comes with the step behind the picture.
    """

    direct = False

    def __init__(self, name: str, law: str) -> None:
        speeds = Port("speeds", len(ROBOT.axes), "deg/s")
        super().__init__(name, [joints_port(ROBOT)], [speeds, Port("pixels"), Port("left")])
        file, rig = read_servo(SAMPLES / "marker.toml"), read_cameras(SAMPLES / "cameras.toml")
        self.setting = set_up_servo(replace(file, law=law), rig, ROBOT)
        self.world = ServoWorld(ROBOT, lambda: self.joints, (file.target, file.drawn))
        self.joints = START

    def begin(self) -> None:
        self.clock = SteppedClock()
        self.eyes = ProjectedEyes(self.setting.cameras, self.world, self.clock, noise=0.1)
        self.setting.law.forget()
        self.says = [np.zeros(len(ROBOT.axes)), [0.0], [0.0]]

    def give(self, now, given):
        del now, given
        return self.says

    def take(self, now, given) -> None:
        self.joints = given[0]
        self.clock.now = now
        sight = self.eyes.look(-np.inf, 1.0)
        flange = flange_of(ROBOT, self.joints)
        cameras = [camera.carried(flange) for camera in self.eyes.cameras]
        task = self.setting.law.task(ServoMoment(cameras, sight, flange))
        if isinstance(task, str):  # why it does not know
            self.says = [np.zeros(len(ROBOT.axes)), [np.nan], [np.nan]]
            return
        slopes = task.slopes @ jacobian(ROBOT, self.joints)
        speeds = -GAIN * np.linalg.lstsq(slopes, task.error, rcond=1e-3)[0]
        part = min(1.0, float((0.3 * ROBOT.speeds / np.maximum(np.abs(speeds), 1e-9)).min()))
        self.says = [part * speeds, [task.pixels], [task.distance]]


def model(sim, law: str = "image"):
    """The diagram."""
    bd = sim.blockdiagram()
    ticks = bd.clock(STEP)
    sees = add(bd, SeeAndTell("law", law), bd.clock(PERIOD))
    joints = bd.INTEGRATOR_S(ticks, x0=START, name="joints")
    arm = bd.SIMARM(ticks, ROBOT, start=START, lag=0.03, name="arm")
    bd.connect(sees[0], joints)
    bd.connect(joints, arm)
    bd.connect(arm[0], sees)
    return bd


def simulated(law: str = "image"):
    """The diagram, and the columns of its run."""
    from bdsim import BDSim

    quiet = {"graphics": False, "progress": False, "quiet": True, "hold": False}
    sim = BDSim(packages="assistant", toolboxes=False, sysargs=False, **quiet)
    bd = model(sim, law)
    return bd, run_paced(sim, bd, SECONDS, STEP)


def missed(joints: np.ndarray) -> float:
    """How many mm the tip is beside its goal, where the marker truly lies."""
    file = read_servo(SAMPLES / "marker.toml")
    tip = flange_of(ROBOT, joints) @ file.tip
    goal = file.drawn @ file.goal
    return float(np.linalg.norm(np.subtract(tip.position, goal.position)))


def main() -> None:
    """Runs the model and says how near the tool comes."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--law", choices=("image", "pose"), default="image")
    arguments.add_argument("-o", "--output", help=".csv or .npz for the columns")
    given = arguments.parse_args()
    _, ran = simulated(given.law)
    before, after = missed(ran["arm[0]"][0]), missed(ran["arm[0]"][-1])
    print(f"the tip is {before:.1f} mm beside its goal, then {after:.2f} mm")
    print(f"as it is seen: {ran['law[2]'][-1]:.2f} mm")
    if given.output:
        from assistant.controllers.recording import save_columns

        save_columns(given.output, ran.flat())


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        raise SystemExit(str(refused)) from None
