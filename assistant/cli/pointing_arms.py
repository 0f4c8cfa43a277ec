"""`teach --point --go`: an arm led to places that are shown; where it comes to rest is stored."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

from assistant.cli.cells import joints_line, pose_line, record, robot_of_cell
from assistant.cli.confirming import confirmed
from assistant.cli.moving import Moving, moving
from assistant.cli.presentation import Format, print_findings, print_json, say
from assistant.cli.shown import Shown, next_place, place_line, recorded, sureness
from assistant.program.diagnostics import Refused, error

if TYPE_CHECKING:
    from assistant.controllers.following import Mode, Wishes
    from assistant.robots import Robot
    from assistant.vision.pointing.holding import Held

NO_ROBOT: Final = error(
    "CL511",
    "no project says which robot `{name}` moves, so it is led nowhere",
    "write robot = NAME into its table in assistant.toml",
)
NO_MODE: Final = error("CL517", "no arm is led to a place by `{by}`", "choose one of {known}")


def run_led(cell: str, names: Sequence[str], shown: Shown) -> int:
    """The arm is led to each place, and where it comes to rest is stored."""
    from assistant.cli.teaching import free_names
    from assistant.compiler.shown_places import check_names
    from assistant.controllers.following import MODES, Wishes

    options = shown.options
    if options.by not in MODES:
        known = ", ".join(MODES)
        raise Refused(NO_MODE(by=options.by, known=known), exit_status=2)
    mode, wishes = MODES[options.by], options.wishes or Wishes()
    stored: list[dict[str, object]] = []
    with moving(cell, "teach --go") as motion:
        there = motion.cell
        controller, robot = there.controller, robot_of_cell(there.one)
        if robot is None:
            raise Refused(NO_ROBOT(name=there.one.name), exit_status=2)
        mode.check(controller, wishes)
        check_names(options.into, names, robot, options.wanted)
        with shown.holds() as holds:
            for name in names or free_names(options.into):
                done = _one_led(name, holds, shown, motion, robot, mode, wishes)
                if done is None:
                    if names or not stored:
                        raise shown.ended(name)
                    break
                stored.append(done)
    if options.format is Format.JSON:
        answer = {"address": str(there.one.address), "file": str(options.into), "stored": stored}
        print_json(record(answer))
    return 0


def _one_led(
    name: str,
    holds: Iterator[Held],
    shown: Shown,
    motion: Moving,
    robot: Robot,
    mode: Mode,
    wishes: Wishes,
) -> dict[str, object] | None:
    """Leads the arm to the next place and stores where it is then; None without a place."""
    from assistant.compiler.following import led_by
    from assistant.compiler.shown_places import check_reached, tip_at, way_to
    from assistant.compiler.teaching import own_joints, teach

    options, one = shown.options, motion.cell.one
    controller = motion.cell.controller
    found = next_place(name, holds, shown, robot, own_joints(controller.position(), robot))
    if found is None:
        return None
    held, place = found
    position = controller.position()
    way = way_to(place, options.above)
    led = led_by(way, robot, position, mode.period, options.speed, str(options.into))
    print_findings(led.findings)
    what = f"leads the arm to `{name}` at {place_line(place)}, {sureness(held)}, {mode.title}"
    confirmed(one, what, options.yes)
    motion.began = True
    mode.run(controller, led, wishes, lambda _: None)
    position = controller.position()
    motion.began = False
    joints = own_joints(position, robot)
    off, turned = check_reached(place, tip_at(place, joints, robot))
    print_findings(teach(options.into, name, position, robot, options.wanted).findings)
    if options.format is Format.TEXT:
        shown_line = joints_line if options.wanted.joints else pose_line
        say(
            f"{name}: {shown_line(position)}, {off:.2f} mm and {turned:.2f} degrees from what was "
            f"shown, stored in {options.into}"
        )
        sys.stdout.flush()
    return {**recorded(held, place), "reached": position, "off_mm": off, "off_degrees": turned}
