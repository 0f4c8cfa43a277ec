"""A Mitsubishi arm on two data links: joints go out on one line while the status comes on another.

The programs are installed and started by controller link; the arm does not stop between points:

    python two_data_links.py melfa://192.168.0.20 /dev/ttyUSB0 192.168.0.20:10002
"""

import argparse
import math

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.mitsubishi.control_mode import ControlMode
from assistant.controllers.mitsubishi.data_link import DataLink, Rate


def main():
    """Swings J1 by points on a data link."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("address", help="of the controller")
    arguments.add_argument("control", help="what COM1 of the programs leads to")
    arguments.add_argument("status", help="what COM2 leads to")
    arguments.add_argument("--robot", default="rv-2aj", help="arm, for the limits of its joints")
    arguments.add_argument("--parity", default="even", choices=("none", "odd", "even"))
    arguments.add_argument(
        "--degrees", type=float, default=5.0, help="that J1 swings to either side"
    )
    arguments.add_argument("--record", default="two_data_links.csv", help=".csv or .npz")
    arguments.add_argument("--yes", action="store_true", help="do not ask before it moves")
    given = arguments.parse_args()

    robot = robots.get(given.robot)
    limits = [(-1.0, 1.0)] * 6  # an axis that the arm lacks is sent as 0
    for place, (low, high) in zip(robot.places, robot.limits, strict=True):
        limits[place] = (float(low), float(high))

    with connect(given.address) as controller:
        here = [math.nan if angle is None else angle for angle in controller.position().joints[:6]]
        points = [
            [here[0] + given.degrees * math.sin(math.tau * step / 20), *here[1:]]
            for step in range(21)
        ]
        if not given.yes and input(f"swings J1 by {given.degrees:g} degrees, type yes: ") != "yes":
            raise SystemExit(1)
        rate = Rate(9600, given.parity)
        lines = [DataLink(target, rate=rate) for target in (given.control, given.status)]
        try:
            with ControlMode(controller, *lines, limits=limits) as mode:
                mode.follow(points, progress=lambda done, count: print(done, "of", count))
        except Refused:
            controller.reset()  # the error of this motion: nothing is left behind
            raise
        finally:
            controller.motors(False)  # which the programs have switched on
        mode.recording.save(given.record)
        print(len(mode.recording), "records in", given.record)


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        raise SystemExit(str(refused)) from None
