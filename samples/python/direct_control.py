"""Direct control of a Mitsubishi arm over Ethernet, with feedback in each cycle.

A program with `Mxt 1,1` is installed, started and taken away again; the PC works out every
position, a small swing of the first joint from where the arm stands:

    python direct_control.py melfa://192.168.0.20
    python direct_control.py melfa://192.168.0.20 --robot rv-4frl --cycle CR750
"""

import argparse

import numpy as np

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.cyclic import Limits, Settings, Trajectory
from assistant.controllers.mitsubishi.external_control import CYCLES, Mxt
from assistant.controllers.trajectory_execution import (
    FIRST_PACKET_TIMEOUT,
    MXT_PROGRAM,
    LinkOptions,
    mxt_installed,
    on_network,
)


def main():
    """Swings J1 and prints the feedback."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("address", help="of the controller")
    arguments.add_argument("--port", type=int, default=10000, help="UDP port of Mxt")
    arguments.add_argument("--robot", default="rv-2aj", help="arm, for the limits of its joints")
    arguments.add_argument("--cycle", default="CR750", choices=sorted(CYCLES), help="controller")
    arguments.add_argument("--degrees", type=float, default=5.0, help="that J1 swings")
    arguments.add_argument("--record", default="direct_control.csv", help="where the feedback goes")
    arguments.add_argument("--yes", action="store_true", help="do not ask before it moves")
    given = arguments.parse_args()

    arm = robots.get(given.robot)
    speeds, lowest, highest = np.ones(6), -np.ones(6), np.ones(6)  # an axis it lacks stays at 0
    speeds[list(arm.places)] = 0.3 * arm.speeds
    lowest[list(arm.places)], highest[list(arm.places)] = arm.limits.T
    limits = Limits(tuple(speeds), lowest=tuple(lowest), highest=tuple(highest))
    times = np.linspace(0.0, 2.0, 101)
    swing = given.degrees * np.sin(np.pi * times / 2.0) ** 2
    wishes = LinkOptions(port=given.port)

    with connect(given.address) as controller:
        on_network(controller, wishes)
        here = np.array([angle or 0.0 for angle in controller.position().joints[:6]])
        print("stands at", here.round(2).tolist())
        if not given.yes and input(f"swings J1 by {given.degrees:g} degrees, type yes: ") != "yes":
            raise SystemExit(1)
        mxt = Mxt(
            controller.address.host,
            port=given.port,
            cycle=CYCLES[given.cycle],
            limits=limits,
            settings=Settings(
                opening=FIRST_PACKET_TIMEOUT
            ),  # the program may not wait for packets yet
        )
        controller.motors(True)
        try:
            with mxt_installed(controller, wishes):
                controller.load(MXT_PROGRAM)
                controller.start()
                try:
                    with mxt:
                        report = mxt.follow(
                            Trajectory.of_joints(
                                here + np.outer(swing, np.eye(6)[0]), times, unit="deg"
                            ),
                            end=True,
                            watch=lambda now: print(
                                f"{now.seconds:.1f} s, J1 at {now.values[0]:.2f}"
                            ),
                        )
                except Refused:
                    controller.stop()
                    controller.reset()  # the error of this motion: nothing is left behind
                    raise
        finally:
            controller.stop()
            controller.motors(False)
    print(report)
    report.save(given.record)


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        raise SystemExit(str(refused)) from None
