"""Programs for the virtual IRC5, loaded and started over RWS."""

from __future__ import annotations

from tests.virtual.irc5.web import wait_for


def module(*body, data=(), name="Work"):
    lines = [f"MODULE {name}", *data, "PROC main()", *body, "ENDPROC", "ENDMODULE", ""]
    return "\n".join(lines)


def ready(robot, *body, data=()):
    """A program that could be started."""
    robot.take()
    assert robot.load("work.mod", module(*body, data=data), "true").status == 204
    assert robot.motors().status == 204
    assert robot.execution("resetpp").status == 204


def start(robot, cycle="once"):
    form = {"regain": "continue", "execmode": "continue", "condition": "none"}
    return robot.execution("start", cycle=cycle, stopatbp="disabled", **form)


def ended(robot):
    wait_for(lambda: robot.state() == "stopped")
