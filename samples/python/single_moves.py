"""Single moves of a Mitsubishi arm by controller link: along z by some mm, and back.

The controller works out the path; where the arm is can be asked once it stands. Over Ethernet and
over a serial line alike:

    python single_moves.py melfa://192.168.0.20
    python single_moves.py melfa-serial:///dev/ttyUSB0
"""

import argparse
import re

from assistant.base.diagnostics import Refused
from assistant.controllers import connect

NUMBER = re.compile(r"[-+]?\d+\.?\d*")


def raised(text, by):
    """A position as the controller writes it, some mm higher or lower."""
    z = list(NUMBER.finditer(text))[2]
    return f"{text[: z.start()]}{float(z[0]) + by:.2f}{text[z.end() :]}"


def main():
    """Moves the arm along z and back."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("address", help="of the controller")
    arguments.add_argument("--by", type=float, default=-20.0, help="mm upwards, less than 0: down")
    arguments.add_argument("--override", type=int, default=10, help="percent of the speed")
    arguments.add_argument("--yes", action="store_true", help="do not ask before it moves")
    given = arguments.parse_args()

    with connect(given.address) as controller:
        here = controller.position()
        print("stands at", here.text)
        if (
            not given.yes
            and input(f"moves along z by {given.by:g} mm and back, type yes: ") != "yes"
        ):
            raise SystemExit(1)
        override = controller.state().override
        controller.motors(True)
        try:
            controller.set_override(given.override)
            for target in (raised(here.text, given.by), here.text):
                controller.execute(f"P99={target}")
                controller.execute("MVS P99", wait=True)
                print("stands at", controller.position().text)
        except Refused:
            controller.reset()  # the error of this move: nothing is left behind
            raise
        finally:
            controller.set_override(override)
            controller.motors(False)


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        raise SystemExit(str(refused)) from None
