"""A program for a Mitsubishi arm: installed, started and watched by controller link.

The arm goes round a small square below where it stands. Feedback comes over the same line, or over
a data link of its own that a second program sends on, Ethernet (COM2:) or serial (COM1:):

    python run_program.py melfa://192.168.0.20
    python run_program.py melfa://192.168.0.20 --status /dev/ttyUSB0
    python run_program.py melfa-serial:///dev/ttyUSB0 --status 192.168.0.20:10002
"""

import argparse

from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.mitsubishi.data_link import DataLink, Form, Rate

SQUARE = b"""10 ' Round a square of 20 mm, 20 mm lower, and back
20 OVRD 50
30 SPD 40
40 PSTART=P_CURR
50 PNEXT=PSTART
60 PNEXT.Z=PNEXT.Z-20
70 MVS PNEXT
80 PNEXT.X=PNEXT.X+20
90 MVS PNEXT
100 PNEXT.Y=PNEXT.Y+20
110 MVS PNEXT
120 PNEXT.X=PNEXT.X-20
130 MVS PNEXT
140 PNEXT.Y=PNEXT.Y-20
150 MVS PNEXT
160 MVS PSTART
170 END
"""
TELL = """10 ' Where the arm is, until the other program has ended, by an error too
20 WAIT M_RUN(1)=1
30 OPEN "{line}:" AS #1
40 *NEXT1
50 PRINT #1,P_CURR,"|",J_CURR
60 DLY 0.05
70 IF M_RUN(1)=1 THEN *NEXT1
80 PRINT #1,"END"
90 CLOSE #1
100 END
"""
FORM = Form.parse("P_CURR | J_CURR")


def heard(link):
    """Prints what the second program tells, until it ends."""
    while (line := link.receive()) != "END":
        position, joints = FORM.read(line)
        print(
            "at", *(f"{value:.2f}" for value in position.values[:3]), f"J1 {joints.values[0]:.2f}"
        )


def ended(controller):
    """Acknowledges the error that the program ended with, if any, and raises it."""
    for fault in controller.state().faults:
        controller.reset()
        raise SystemExit(f"the program ended with error {fault.number}: {fault.text}") from None


def main():
    """Installs the program, starts it and prints where the arm is."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("address", help="of the controller")
    arguments.add_argument("--status", help="what COM2, or COM1 if it is serial, leads to")
    arguments.add_argument("--baud", type=int, default=9600, help="of a serial status line")
    arguments.add_argument("--yes", action="store_true", help="do not ask before it moves")
    given = arguments.parse_args()

    with connect(given.address) as controller:
        if (
            not given.yes
            and input("goes round a square of 20 mm, 20 mm lower, type yes: ") != "yes"
        ):
            raise SystemExit(1)
        controller.write("SQUARE", SQUARE)
        controller.load("SQUARE")
        if given.status:
            line = "COM2" if ":" in given.status else "COM1"
            controller.write("TELL", TELL.format(line=line).encode())
            controller.load("TELL", task="2")
        controller.motors(True)
        try:
            if given.status:
                controller.start("2")
                with DataLink(given.status, rate=Rate(given.baud)) as link:
                    controller.start("1")
                    heard(link)
            else:
                controller.start("1")
            for sample in controller.watch(0.2):
                x, y, z = sample.position.position
                print(f"{sample.seconds:.1f} s at {x:.2f} {y:.2f} {z:.2f}")
                if not sample.state.running:
                    break
            ended(controller)
        except Refused:
            ended(controller)  # which says more than that no answer comes
            raise
        finally:
            controller.stop()
            controller.motors(False)


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        raise SystemExit(str(refused)) from None
