"""`teach --point --go`: an arm led to places that are shown; where it comes to rest is stored.

It goes by its own arithmetic, and with `--servo` the last of the way by what the cameras see of its
tool: then it is where they saw the place, whatever the arm says of its lengths.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.cli.cells import joints_line, pose_line, record, robot_of_cell
from assistant.cli.confirming import confirm
from assistant.cli.moving import Moving, moving
from assistant.cli.presentation import Format, print_findings, print_json, say
from assistant.cli.shown import ShownPlaces, certainty, next_place, place_line, pointing_record

if TYPE_CHECKING:
    from assistant.compiler.taught_targets import ShownTarget
    from assistant.controllers.setpoint_streams import Mode as ByPictures
    from assistant.controllers.trajectory_execution import LinkOptions, Mode
    from assistant.robots import Robot
    from assistant.vision.pointing.holding import Held
    from assistant.vision.servoing.setting_up import SetUp
    from assistant.vision.servoing.task_file import ServoFile

NO_ROBOT: Final = error(
    "CL511",
    "no project says which robot `{name}` moves, so it is led nowhere",
    "write robot = NAME into its table in assistant.toml",
)
NO_POINTING_MODE: Final = error(
    "CL517", "no arm is led to a place by `{by}`", "choose one of {known}"
)


@dataclass(frozen=True, slots=True)
class _ArmLeader:
    """mode: by which the arm is led. pictures: and file, by which from `above` on, None for not."""

    motion: Moving
    robot: Robot
    shown: ShownPlaces
    mode: Mode
    wishes: LinkOptions
    pictures: tuple[ByPictures, ServoFile] | None

    def led(self, place: ShownTarget, held: Held) -> dict[str, float]:
        """Asks, and leads the arm to a place; how far it is from there. Raises Refused."""
        from assistant.compiler.commanded_motion import trajectory_of_program
        from assistant.compiler.taught_targets import (
            check_reached,
            own_joints,
            program_to_target,
            tip_at,
        )

        options, controller = self.shown.options, self.motion.cell.controller
        position = controller.position()
        way = program_to_target(place, options.above, to_its_end=self.pictures is None)
        into = str(options.into)
        led = trajectory_of_program(
            way, self.robot, position, self.mode.period, options.speed, into
        )
        print_findings(led.findings)
        seen = self._set_up(place)
        how = self.mode.title if seen is None else f"{self.mode.title}, then {seen.title}"
        what = f"leads the arm to `{place.name}` at {place_line(place)}, {certainty(held)}, {how}"
        confirm(self.motion.cell.one, what, options.yes)
        self.motion.began = True
        self.mode.run(controller, led, self.wishes, lambda _: None)
        if seen is None:
            joints = own_joints(controller.position(), self.robot)
            off, turned = check_reached(place, tip_at(place, joints, self.robot))
        else:
            off, turned = self._by_pictures(seen)
        self.motion.began = False
        return {"off_mm": off, "off_degrees": turned}

    def _set_up(self, place: ShownTarget) -> SetUp | None:
        from assistant.compiler.taught_targets import tip_of
        from assistant.program.geometry import IDENTITY
        from assistant.vision.servoing.setting_up import set_up

        if self.pictures is None:
            return None
        file = replace(self.pictures[1], target=None, place=place.tip, goal=IDENTITY)
        return set_up(replace(file, tip=tip_of(place)), self.shown.rig, self.robot)

    def _by_pictures(self, seen: SetUp) -> tuple[float, float]:
        """Mm and degrees that are left as the cameras see it."""
        import numpy as np

        from assistant.compiler.taught_targets import own_joints
        from assistant.vision.servoing.loop import servo
        from assistant.vision.servoing.setting_up import eyes_of

        assert self.pictures is not None
        mode, cell = self.pictures[0], self.motion.cell
        near = np.array(own_joints(cell.controller.position(), self.robot))
        session = cell.controller if mode.operates else cell.session
        carrier = mode.make(session, seen.guard.arm(), self.wishes, near)
        with eyes_of(seen, carrier.joints) as eyes, carrier:
            done = servo(eyes, seen.law, carrier, seen.guard, seen.file.settings)
        return done.distance, done.turn


def run_pointed_arm(cell: str, names: Sequence[str], shown: ShownPlaces) -> int:
    """The arm is led to each place, and where it comes to rest is stored."""
    from assistant.cli.teaching import free_names
    from assistant.compiler.taught_targets import check_names
    from assistant.controllers.trajectory_execution import MODES, LinkOptions

    options = shown.options
    if options.by not in MODES:
        known = ", ".join(MODES)
        raise Refused(NO_POINTING_MODE(by=options.by, known=known), exit_status=2)
    mode, wishes = MODES[options.by], options.wishes or LinkOptions()
    pictures = _servo_pictures(options.servo, options.by)
    stored: list[dict[str, object]] = []
    with moving(cell, "teach --go") as motion:
        there = motion.cell
        controller, robot = there.controller, robot_of_cell(there.one)
        if robot is None:
            raise Refused(NO_ROBOT(name=there.one.name), exit_status=2)
        mode.check(controller, wishes)
        check_names(options.into, names, robot, options.wanted)
        leader = _ArmLeader(motion, robot, shown, mode, wishes, pictures)
        with ExitStack() as looking:
            # Cameras by which the arm is led are let go of in between.
            holds = None if pictures else looking.enter_context(shown.holds())
            for name in names or free_names(options.into):
                done = _store_next(name, holds, leader)
                if done is None:
                    if names or not stored:
                        raise shown.ended(name)
                    break
                stored.append(done)
    if options.format is Format.JSON:
        answer = {"address": str(there.one.address), "file": str(options.into), "stored": stored}
        print_json(record(answer))
    return 0


def _servo_pictures(file: Path | None, by: str) -> tuple[ByPictures, ServoFile] | None:
    if file is None:
        return None
    from assistant.controllers.setpoint_streams import MODES
    from assistant.vision.servoing.task_file import read_servo

    return MODES[by], read_servo(file, led_elsewhere=True)


def _store_next(
    name: str, holds: Iterator[Held] | None, leader: _ArmLeader
) -> dict[str, object] | None:
    """Leads the arm to the next place and stores where it is then; None without a place."""
    from assistant.compiler.taught_targets import own_joints, teach_target

    shown, robot = leader.shown, leader.robot
    options, controller = shown.options, leader.motion.cell.controller
    near = own_joints(controller.position(), robot)
    with ExitStack() as looking:
        looked = looking.enter_context(shown.holds()) if holds is None else holds
        found = next_place(name, looked, shown, robot, near)
    if found is None:
        return None
    held, place = found
    off = leader.led(place, held)
    position = controller.position()
    print_findings(teach_target(options.into, name, position, robot, options.wanted).findings)
    if options.format is Format.TEXT:
        shown_line = joints_line if options.wanted.joints else pose_line
        say(
            f"{name}: {shown_line(position)}, {off['off_mm']:.2f} mm and "
            f"{off['off_degrees']:.2f} degrees from what was shown, stored in {options.into}"
        )
        sys.stdout.flush()
    return {**pointing_record(held, place), "reached": position, **off}
