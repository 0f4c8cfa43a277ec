"""`debug`: a program on its virtual controller, held and stepped by an editor."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from io import FileIO
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.cli.presentation import print_findings

if TYPE_CHECKING:
    from assistant.virtual.debugging.break_points import Lines
    from assistant.virtual.debugging.messages import Object
    from assistant.virtual.kernel import Kernel

WRONG_LAUNCH: Final = error(
    "CL120",
    "the editor's launch request is wrong: {reason}",
    "name program, and where wanted {known}, in the configuration that the editor launches",
)
BROKEN_MESSAGE: Final = error(
    "CL121",
    "what was read is no message of the Debug Adapter Protocol: {reason}",
    "let an editor start this command; to run a program in a terminal there is `run`",
)
LAUNCH_KEYS: Final[Mapping[str, type]] = {
    "program": str,
    "robot": str,
    "language": str,
    "signals": str,
    "entry": str,
    "maxSteps": int,
    "stopOnEntry": bool,
}
"""What a configuration may say; `program` may be a list of texts too."""
EDITOR_KEY_PREFIX: Final = frozenset({"type", "request", "name", "cwd", "noDebug", "presentation"})
"""What editors add, with names that begin with two underscores."""


def run_debug() -> int:
    """0 when the editor has left, 2 if what it said was no message."""
    from assistant.virtual.debugging import Adapter

    # Not buffered: a reading thread that holds the buffer's lock would stop Python from ending.
    source = FileIO(sys.stdin.fileno(), closefd=False)
    adapter = Adapter(source, sys.stdout.buffer, _launched_programs)
    adapter.serve()
    if adapter.broken:
        print_findings([BROKEN_MESSAGE(reason=adapter.broken)], explained=True)
        return 2
    return 0


def _launched_programs(wanted: Object) -> tuple[Kernel, Lines]:
    """The programs of a launch request, ready to run, and their lines; raises Refused."""
    from assistant.compiler.arms import robot_of
    from assistant.compiler.simulated_run import programs
    from assistant.virtual.debugging.break_points import statement_lines
    from assistant.virtual.program_run import MOST_STEPS, Settings, prepared

    for name, value in wanted.items():
        if name.startswith("__") or name in EDITOR_KEY_PREFIX:
            continue
        if name not in LAUNCH_KEYS:
            raise _wrong_launch(f"`{name}` is not known")
        if name == "program" and isinstance(value, list):
            continue
        if not isinstance(value, LAUNCH_KEYS[name]):
            raise _wrong_launch(f"`{name}` is no {TYPE_NAMES[LAUNCH_KEYS[name]]}")
    program = wanted.get("program")
    named = program if isinstance(program, list) else [program]
    if not named or not all(isinstance(one, str) and one for one in named):
        raise _wrong_launch("`program` names no file")
    texts = {name: value for name, value in wanted.items() if isinstance(value, str)}
    robot = robot_of(texts.get("robot"))
    steps = wanted.get("maxSteps")
    found = programs(
        [str(one) for one in named],
        language=texts.get("language"),
        robot=robot,
        entry=texts.get("entry"),
    )
    most = steps if isinstance(steps, int) and steps > 0 else MOST_STEPS
    settings = Settings(robot=robot, entry=texts.get("entry"), most_steps=most)
    return prepared(found, settings), statement_lines(found)


def _wrong_launch(reason: str) -> Refused:
    known = ", ".join(name for name in LAUNCH_KEYS if name != "program")
    return Refused(WRONG_LAUNCH(reason=reason, known=known), exit_status=2)


TYPE_NAMES: Final[Mapping[type, str]] = {str: "text", int: "whole number", bool: "truth"}
