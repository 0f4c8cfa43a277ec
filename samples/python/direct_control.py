"""Direct control of a Mitsubishi arm over Ethernet, with feedback in each cycle.

A program with `Mxt 1,1` waits on the controller; the PC works out every position, a small swing of
the first joint from where the arm stands:

    python direct_control.py 192.168.0.20 --robot rv-4frl --cycle CR750
"""

import argparse

import numpy as np

from assistant import robots
from assistant.controllers.cyclic import Limits, Trajectory
from assistant.controllers.mitsubishi.mxt import CYCLES, Mxt
from assistant.program.diagnostics import Refused


def main():
    """Swings J1 and prints the feedback."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("host", help="address of the controller")
    arguments.add_argument("--port", type=int, default=10000, help="UDP port of Mxt")
    arguments.add_argument("--robot", default="rv-4frl", help="arm, for the limits of its joints")
    arguments.add_argument("--cycle", default="CR750", choices=sorted(CYCLES), help="controller")
    arguments.add_argument("--degrees", type=float, default=5.0, help="that J1 swings")
    arguments.add_argument("--record", default="direct_control.csv", help="where the feedback goes")
    arguments.add_argument("--yes", action="store_true", help="do not ask before it moves")
    given = arguments.parse_args()

    arm = robots.get(given.robot)
    limits = Limits(
        speeds=tuple(0.3 * arm.speeds),
        accelerations=tuple(0.2 * arm.accelerations),
        lowest=tuple(arm.limits[:, 0]),
        highest=tuple(arm.limits[:, 1]),
    )
    times = np.linspace(0.0, 2.0, 101)
    swing = np.sin(np.pi * times / 2.0) ** 2

    if not given.yes and input(f"swings J1 by {given.degrees:g} degrees, type yes: ") != "yes":
        raise SystemExit(1)
    cell = Mxt(given.host, port=given.port, cycle=CYCLES[given.cycle], limits=limits)
    with cell as mxt:
        here = np.array(mxt.position())
        print("stands at", here.round(2).tolist())
        way = here + np.outer(swing, [given.degrees] + [0.0] * (len(here) - 1))
        report = mxt.follow(
            Trajectory.of_joints(way, times),
            watch=lambda now: print(f"{now.seconds:.1f} s, J1 at {now.values[0]:.2f}"),
        )
    print(report)
    report.save(given.record)


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        raise SystemExit(str(refused)) from None
