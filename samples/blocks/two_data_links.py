"""A model of bdsim: an arm on two data links, joints out on one and the status in on the other.

Use case 6 of Kohrt et al., A Robot Manipulator Communications and Control Framework: points go to
the controller over a serial line, which works out the way and does not stop between them, while it
tells where the arm is over Ethernet. J1 turns as fast as it is allowed to, and never stands.
Without an address the controller is a virtual one:

    python two_data_links.py [-o columns.csv]
    python two_data_links.py melfa://192.168.0.20 /dev/ttyUSB0 192.168.0.20:10002
"""

import argparse
from contextlib import contextmanager

import numpy as np

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.bdsim_adapter import run_paced
from assistant.blocks.diagrams import RealTime
from assistant.blocks.setpoint_connections import led
from assistant.controllers.trajectory_execution import LinkOptions
from assistant.virtual.cr import VirtualCr

ROBOT = robots.get("rv-2aj")
STEP, MOST_SECONDS = 0.1, 30.0
PERCENT = 10.0  # of the speeds of its axes
MOST = STEP * PERCENT / 100.0 * ROBOT.speeds  # degrees in a step
FIRST, STEPS = 5, 24  # the first step, and how many there are
TURN = STEPS * MOST[0]  # degrees that J1 goes, while J3 goes up and down
NAME = "arm"
DRAWN = {
    "by[0]": "by: steps of the joints, degrees",
    "status[1]": "status: joints as they are told on the other line, degrees",
    "behind[0]": "behind: of the step that went out last, degrees",
    "status[3]": "status: speed of the tool, mm/s",
}
"""Signals of the picture, and what is said of them."""


@contextmanager
def virtual(pace: float = 1.0):
    """A controller of one's own: its address, its serial line and its line of Ethernet."""
    quick = {"pace": pace, "servo_time": 0.02}
    with VirtualCr("rv-2aj", serial=True, framing="data link", **quick) as cell:
        ports = [f"{host}:{port}" for host, port in cell.data_ports.values()]
        yield cell, (cell.address, cell.serial_path, ports[0])


def model(sim, address: str, *lines: str):
    """The diagram, and the connection that its blocks share."""
    arm = led(NAME, address, ROBOT, percent=PERCENT, wishes=LinkOptions(lines=lines))

    rows = np.zeros((FIRST + STEPS + 1, len(MOST)))
    rows[FIRST : FIRST + STEPS, 0] = MOST[0]
    rows[FIRST : FIRST + STEPS, 2] = np.repeat([0.5, -0.5], STEPS // 2) * MOST[2]
    bd = sim.blockdiagram()
    clock = bd.clock(STEP)
    by = bd.MOTIONTABLE(STEP * np.arange(len(rows)), rows, name="by")
    go = bd.CONSTANT(1.0, name="go")
    steps = bd.RELJOINT(clock, arm, ROBOT, "steps", most=5.0)
    status = bd.STATUS(clock, arm, ROBOT, "status")
    behind = bd.SUM("+-", name="behind")
    bd.connect(by[0], steps[0])
    bd.connect(go, steps[1])
    bd.connect(steps[0], behind[0])
    bd.connect(status[1], behind[1])
    return bd, arm


def run(lines, pace: float = 1.0):
    """The diagram, and the columns of its run: it moves the arm. pace: of the model's time."""
    from bdsim import BDSim

    quiet = {"graphics": False, "progress": False, "quiet": True, "hold": False}
    sim = BDSim(packages="assistant", toolboxes=False, sysargs=False, **quiet)
    bd, arm = model(sim, *lines)

    stands = 0

    def on_its_way(now):
        """Until the arm has stood for two steps where the last one leads."""
        nonlocal stands
        off = np.abs(arm.value.measured().joints - arm.value.told).max()
        stands = stands + 1 if now > STEP * (FIRST + STEPS) and off < 0.02 else 0
        return stands < 3

    clock = RealTime(pace)
    ran = run_paced(sim, bd, MOST_SECONDS, STEP, clock=clock, watch=on_its_way, moving=[NAME])
    return bd, ran


def simulated():
    """The same with a virtual controller."""
    with virtual() as (_, lines):
        return run(lines)


def main() -> None:
    """Runs the model and says how well the arm came after."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("lines", nargs="*", help="address, line of the joints, of the status")
    arguments.add_argument("-o", "--output", help=".csv or .npz for the columns")
    given = arguments.parse_args()
    if given.lines and input(f"turns J1 by {TURN:.1f} degrees, type yes: ") != "yes":
        raise SystemExit(1)
    _, ran = run(given.lines) if given.lines else simulated()
    joints = ran["status[1]"]
    moving = np.flatnonzero(ran["status[3]"] > 0.0)
    halts = int((ran["status[3]"][moving[0] : moving[-1] + 1] == 0.0).sum())
    print(f"{ran['steps[1]'][-1]:.0f} steps, {halts} halts on the way, {ran.late} steps late")
    print(f"J1 went {joints[-1, 0] - joints[0, 0]:.2f} of {TURN:.2f} degrees")
    behind = np.abs(ran["behind[0]"]).max(axis=1)
    print(f"{behind.max():.2f} degrees behind at most, {behind[-1]:.2f} degrees at the end")
    if given.output:
        from assistant.controllers.recording import save_columns

        save_columns(given.output, ran.flat())


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        raise SystemExit(str(refused)) from None
