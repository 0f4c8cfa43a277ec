"""What tests of a CR controller that is operated share."""

import threading

COUNTING = b"10 M1=0\r\n20 *AGAIN\r\n30 M1=M1+1\r\n40 DLY 0.05\r\n50 GOTO *AGAIN\r\n"


def codes(refused):
    return [finding.code for finding in refused.value.findings]


def number(refused):
    """The error number in a finding of the controller."""
    return int(refused.value.findings[0].message.split(" error ")[1][:4])


def until(done, seconds=5.0):
    """Waits for something that the controller does in its own time."""
    pause = threading.Event()
    for _ in range(int(seconds / 0.02)):
        if done():
            return
        pause.wait(0.02)
    raise AssertionError("it did not happen")
