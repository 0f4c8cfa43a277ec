"""Run programs together on one virtual controller: its tasks or slots, clock, signals and arm.

`prepared` makes the kernel of a run from programs and `Settings`; each language starts its programs
in tasks of that kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, error
from assistant.program.geometry import Pose
from assistant.virtual.kernel import Board, Kernel, Motion, Signals
from assistant.virtual.kernel.kernel import Instant, Source
from assistant.virtual.tasks import Part, Programs

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.melfa.communication_lines import Line


_NO_ENTRY: Final = error(
    "VC206", "a program begins at its top, not with `{name}`", "leave --entry out"
)
_NO_DISK: Final = error(
    "VC207",
    "programs in {language} use no {what} here",
    "leave --{option} out",
)
_NO_LINE: Final = error(
    "VC217",
    "the line {name} cannot be had: {reason}",
    "name a port that is free, or a serial port that there is",
)
_NO_OPTIONS: Final = error(
    "VC210", "options are for programs whose manuals leave something open", "leave [options] out"
)
BUSY_TIME: Final = 0.001
"""Seconds of each further statement of a loop that lets no time pass."""
_NO_SUCH_ENTRY: Final = error("VC218", "no procedure `{name}` is there to begin with", "{cure}")
_TWO_ENTRIES: Final = error(
    "VC219",
    "each of {files} has a procedure `{name}`",
    "name the modules that one task loads together",
)
_MOST_NAMED: Final = 8
"""Procedures that a cure names."""
MOST_STEPS: Final = 1_000_000
_MOST_TIME: Final = 3600.0
"""Simulated seconds after which a run ends by default."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings of a run.

    robot: the arm, None for an unknown one. motion: how it follows, None for the timed model, or
    without a robot for motions that take no time. entry: the routine that the first task begins
    with, None for the default one. inputs: values of those that nothing has set, by name in lower
    case or number as text. most_steps: statements of all tasks. most_time: simulated seconds. pace:
    simulated seconds for each real one, None for as fast as possible. statement_time: seconds that
    a statement takes if the language states none. disk: the folder whose files are those of the
    controller, which others may change meanwhile; None for an empty one. hosts: real ones by the
    address that programs state; those of this computer need no entry. lines: targets of
    communication lines, by their names (see `melfa.lines`). options: choices that a language leaves
    open, by name (see `melfa.options`).
    """

    robot: Robot | None = None
    motion: Motion | None = None
    entry: str | None = None
    inputs: Source = field(default_factory=dict)
    most_steps: int = MOST_STEPS
    most_time: float = _MOST_TIME
    pace: float | None = None
    statement_time: float = 0.0
    disk: Path | None = None
    hosts: Mapping[str, str] = field(default_factory=dict)
    lines: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, object] = field(default_factory=dict)


def prepared(programs: Programs, settings: Settings | None = None) -> Kernel:
    """A kernel in which the programs begin as soon as it runs; the arm stands at its home."""
    chosen = settings or Settings()
    if chosen.options and (programs.language is None or programs.language.family != OPEN):
        raise Refused(_NO_OPTIONS(), exit_status=2)
    kernel = Kernel(
        Board(Signals(chosen.inputs)),
        motion=chosen.motion or _motion(chosen.robot),
        most_steps=chosen.most_steps,
        most_time=chosen.most_time,
        pace=chosen.pace,
        statement_time=chosen.statement_time,
    )
    if programs.language is None:
        from assistant.virtual.pseudo import start_program

        assert programs.program is not None
        start_program(
            kernel,
            programs.program,
            robot=chosen.robot,
            start=home(chosen.robot),
            text=programs.text,
        )
        return kernel
    STARTS[programs.language.family](kernel, programs.parts, chosen)
    return kernel


def _motion(robot: Robot | None) -> Motion:
    if robot is None:
        return Instant()
    from assistant.virtual.kernel.timed_arm import Timed

    return Timed(robot)


def home(robot: Robot | None) -> Pose | None:
    """The flange in the base where an arm stands before its first motion."""
    if robot is None:
        return None
    position, quaternion = robot.flange_poses(np.array([robot.home], dtype=np.float64))
    return Pose.of(position[0], quaternion[0])


Start = Callable[[Kernel, Sequence[Part], Settings], None]


def _tasks(kernel: Kernel, parts: Sequence[Part], settings: Settings) -> None:
    from assistant.virtual.rapid.controller import Controller, Options
    from assistant.virtual.rapid.disk import Disk
    from assistant.virtual.rapid.interpreter import start_task

    if settings.lines:
        raise Refused(_NO_DISK(language="RAPID", what="lines", option="line"), exit_status=2)
    kernel.busy_time = BUSY_TIME
    disk = Disk(settings.disk, outside=settings.disk is not None)
    controller = Controller(Options(addresses=settings.hosts), disk)
    for number, part in enumerate(parts):
        entry = (settings.entry if number == 0 else None) or "main"
        _check_entry(part, entry)
        start_task(
            kernel,
            part.trees,
            name=part.name,
            robot=settings.robot,
            entry=entry,
            start=home(settings.robot),
            controller=controller,
            kind="normal" if part.essential else "semistatic",
            # Only of the first task it is known that it moves the arm.
            moves=True if number == 0 else None,
        )


def _check_entry(part: Part, entry: str) -> None:
    """Raises Refused if a task has no routine to begin with, or two."""
    from assistant.languages.rapid.tree import syntax as s

    routines = [
        (item, tree.path)
        for tree in part.trees
        for module in tree.modules
        for item in module.items
        if isinstance(item, s.Routine) and item.kind == "PROC" and not item.local
    ]
    found = [path for item, path in routines if item.name.lower() == entry.lower()]
    if len(found) > 1:
        files = ", ".join(f"`{path}`" for path in found)
        raise Refused(_TWO_ENTRIES(place=part.name, name=entry, files=files), exit_status=2)
    if not found:
        names = [item.name for item, _ in routines if not item.parameters]
        some = ", ".join(names[:_MOST_NAMED]) + (" …" if len(names) > _MOST_NAMED else "")
        cure = (
            f"choose one with --entry: {some}" if names else "name the module that has it as well"
        )
        raise Refused(_NO_SUCH_ENTRY(place=part.name, name=entry, cure=cure), exit_status=2)


def _slots(kernel: Kernel, parts: Sequence[Part], settings: Settings) -> None:
    """One cycle of the program of each slot."""
    from assistant.virtual.melfa import Controller, Entry
    from assistant.virtual.melfa.controller import DEFAULT_SLOTS
    from assistant.virtual.melfa.options import choose
    from assistant.virtual.melfa.world import STEP_TIME

    for option, what in (("disk", "files"), ("host", "sockets")):
        if settings.disk if option == "disk" else settings.hosts:
            language = "MELFA-BASIC"
            raise Refused(_NO_DISK(language=language, what=what, option=option), exit_status=2)
    if settings.entry is not None:
        raise Refused(_NO_ENTRY(name=settings.entry), exit_status=2)
    kernel.statement_time = STEP_TIME
    controller = Controller(
        kernel,
        {name: tree for part in parts for name, tree in zip(part.names, part.trees, strict=True)},
        {int(part.name): Entry(part.names[0], mode="CYC") for part in parts},
        robot=settings.robot,
        start=home(settings.robot),
        slots=max(DEFAULT_SLOTS, len(parts)),
        options=choose({"pulses": "timed", **settings.options}),
        lines=_lines(kernel, settings.lines),
    )
    controller.start()


def _lines(kernel: Kernel, given: Mapping[str, str]) -> dict[str, Line]:
    """Lines by the names that programs open, to the end of the run."""
    from assistant.virtual.melfa.communication_lines import line_to

    lines = {}
    for name, target in given.items():
        try:
            lines[f"{name.rstrip(':')}:"], leave = line_to(target)
        except OSError as wrong:
            # Lines that are open already are closed again: the run never begins.
            for close in kernel.leaving:
                close()
            raise Refused(_NO_LINE(name=name, reason=wrong), exit_status=2) from None
        kernel.leaving.append(leave)
    return lines


OPEN: Final = "MB"
"""The family of the languages that have options."""
STARTS: Final[Mapping[str, Start]] = {"RA": _tasks, OPEN: _slots}
"""By the family of a language."""
