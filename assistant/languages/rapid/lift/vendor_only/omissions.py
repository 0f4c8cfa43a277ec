"""Instructions, options and declarations that are left out for other languages, and what is lost.

The tables give, for each instruction or option in lower case, the loss and its cure. Handles (a
socket, a file) have no value and are left out. Other declarations are left out if nothing refers to
them, as are targets with more external axes than arms of other controllers have and tools whose tip
is farther from the flange than any tool is long.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Set
from dataclasses import replace
from typing import Any, Final, TypeVar

import numpy as np

from assistant.base.diagnostics import Declared, Findings, ProgramTable
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.predefined import is_handle
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import names_in, texts_in
from assistant.program.geometry import JointTarget, Target, Tool
from assistant.program.program import Declaration, Procedure, Program, walk
from assistant.program.rewriting import records, with_vendor_statements_replaced
from assistant.program.vendor_statements import effect_of

Loss = tuple[str, str]
"""Loss of an omission, and its cure."""

_NO_CURE: Final = "none is needed"
_USE_EQUIVALENT: Final = "set what the other controller has of the kind, or leave it"
_LIMIT_SPEEDS: Final = "state speeds and accelerations that the part can take"
_ACCELERATIONS: Final = ("the arm accelerates as fast as its load lets it", _LIMIT_SPEEDS)
_SOFT_SERVO: Final = (
    "the axes stay stiff",
    "use the other arm's soft mode, or see that nothing presses against it",
)
_TUNED: Final = ("the servos work as the controller has them", _USE_EQUIVALENT)
_WRIST_ON_LINES: Final = (
    "the tool keeps its orientation on straight moves and arcs: near a straight wrist the arm may "
    "stop, where RAPID turns the tool a little",
    "see that no move passes a straight wrist",
)

_MECHANICAL_UNIT: Final = (
    "the unit stays as the controller has it",
    "switch it on and off at the other controller",
)
_STORED_PATHS: Final = (
    "no move is held, kept or taken up again: the arm stands where its program goes on",
    "see that nothing counts on a move that was interrupted",
)
_ZONE_SHAPE: Final = (
    "the shape of the zone is not kept",
    "note its corners for the other controller",
)
_WORLD_ZONE: Final = (
    "nobody watches the zone: the arm is not stopped at its border",
    "set the zone in the other controller, among the areas that it watches, before the first run",
)

_FOLDERS: Final = (
    "the files of the controller are in no folders: none is made or looked into",
    "see that the names of files in several folders differ",
)

NO_EXTERNAL_AXES: Final = (
    "no target states a place of an external axis that it would move",
    _NO_CURE,
)
"""Loss when an offset of external axes is omitted in a program without external axes."""
OMITTED_INSTRUCTIONS: Final[Mapping[str, Loss]] = {
    "tperase": ("what stands on the teach pendant stays there", _NO_CURE),
    "tpshow tp_latest": ("the teach pendant shows what it shows", _NO_CURE),
    "confl off": (
        "straight moves go on in the configuration that they begin in, whatever their targets "
        "state; another controller may stop where they state another",
        "state the configurations that the arm really takes, or name it with --robot",
    ),
    "confj off": (
        "joint moves take the nearest turn of the wrist, whatever their targets state; here they "
        "take the configuration that is stated",
        "see that the targets state the configurations that the arm takes",
    ),
    "singarea wrist": _WRIST_ON_LINES,
    "singarea lockaxis4": _WRIST_ON_LINES,
    "pathacclim": _ACCELERATIONS,
    "worldacclim": _ACCELERATIONS,
    "pathresol": ("the way is worked out as finely as the controller does it", _USE_EQUIVALENT),
    "cirpathmode": ("the tool turns on arcs as the controller has it", "state more targets"),
    "motionsup": ("collisions are watched for as the controller has it", _USE_EQUIVALENT),
    "softact": _SOFT_SERVO,
    "softdeact": ("the axes are as stiff as ever", _NO_CURE),
    "tuneservo": _TUNED,
    "tunereset": _TUNED,
    "gripload": (
        "the controller goes on with the load that its tool has",
        "set the load of the hand in the other controller",
    ),
    "mechunitload": ("the load of the unit is not told", "set it in the other controller"),
    **dict.fromkeys(("actunit", "deactunit"), _MECHANICAL_UNIT),
    **dict.fromkeys(("clearpath", "storepath", "restopath", "startmove"), _STORED_PATHS),
    **dict.fromkeys(("wzboxdef", "wzcyldef", "wzsphdef"), _ZONE_SHAPE),
    **dict.fromkeys(("wzlimjointdef", "wzhomejointdef"), _ZONE_SHAPE),
    **dict.fromkeys(("wzlimsup", "wzenable", "wzdisable", "wzfree"), _WORLD_ZONE),
    "bookerrno": ("the number of an error of the program's own is not reserved", _NO_CURE),
    "save": (
        "no module is written to a file: the values of its data stay in the controller alone",
        "back the controller up",
    ),
    **dict.fromkeys(("makedir", "opendir", "closedir"), _FOLDERS),
    "skipwarn": ("the log of the controller has what it has", _NO_CURE),
    "resetretrycount": ("retries are not counted", _NO_CURE),
}
"""Instructions by their name, or by name, options and plain arguments, in lower case.

They set how the controller moves the arm, watches it or says something, but not where to it moves
(RAPID reference manual, instructions).
"""

_WAIT_MESSAGE: Final = ("nobody is told what the program waits for", _NO_CURE)
_CONCURRENT: Final = (
    "what follows is done when the arm has arrived, not while it moves",
    "see that nothing has to happen on the way, or set it there by TriggL",
)
_DISPLAY_OPTIONS: Final = dict.fromkeys(
    (
        *("visualize", "header", "message", "msgarray", "wrap", "icon", "image"),
        *("visualizetime", "uiactivesignal"),
    ),
    _WAIT_MESSAGE,
)
_POLL_RATE: Final = ("how often the condition is asked", _NO_CURE)
_MOVE_OPTIONS: Final[Mapping[str, Loss]] = {
    "conc": _CONCURRENT,
    "noeoffs": ("", ""),
    "id": (
        "the arm moves without waiting for those that would move together with it",
        "see that the arms do not meet, or move them one after the other",
    ),
    "corr": ("corrections from a sensor are not added", "see that none are written"),
}
_NO_SYNC: Final = ("the program does not wait until the output has its value", _NO_CURE)

OMITTED_OPTIONS: Final[Mapping[str, Mapping[str, Loss]]] = {
    **{f"wait{kind}": _DISPLAY_OPTIONS for kind in ("di", "do", "gi", "go", "ai", "ao")},
    "waituntil": {**_DISPLAY_OPTIONS, "pollrate": _POLL_RATE},
    **dict.fromkeys(("movej", "movel", "movec", "moveabsj"), _MOVE_OPTIONS),
    "accset": {
        "finepointramp": ("the arm brakes at stop points as fast as anywhere", _LIMIT_SPEEDS)
    },
    "setdo": {"sync": _NO_SYNC},
}
"""Options of instructions that can go, by instruction and option; without words nothing is lost."""


def has_external_axes(program: Program) -> bool:
    """True if any target or path of a program states the position of an external axis."""
    given: list[Target | JointTarget] = [*program.targets.values()]
    given += program.joint_targets.values()
    if any(map(_states_external_axis, given)):
        return True
    for record in records((program.procedures, tuple(program.variables.values()))):
        match record:
            case e.TargetValue(target) | e.JointValue(target):
                if _states_external_axis(target):
                    return True
            case p.Follow(path):
                if np.isfinite(path.external).any():
                    return True
    return False


def _states_external_axis(target: Target | JointTarget) -> bool:
    return any(map(math.isfinite, target.external))


T = TypeVar("T")

_FARTHEST_TIP: Final = 1e6
"""mm from the flange; no tool is that long, and other controllers refuse the number."""
_MOST_EXTERNAL_AXES: Final = 2
"""External axes at most of a target in the other languages here."""


def with_needed_declarations(program: Program, findings: Findings) -> Program:
    """Return the program without unneeded declarations, with a finding for each."""
    data = {d: item for d in program.declarations if (item := _declared_data(d)) is not None}
    if data:
        said = Counter(_used_names(program))
        idle = {
            d for d, item in data.items() if is_handle(item.type) or not _is_used(said, item, d)
        }
        for one in idle:
            _report_omission(findings, data[one], one)
        kept = tuple(d for d in program.declarations if d not in idle)
        program = replace(program, declarations=kept)

    program = _without_idle_targets(program, findings)

    if not any(map(_local_data, _vendor_texts(program))):
        return program
    procedures = tuple(_without_idle_locals(program, q, findings) for q in program.procedures)
    return replace(program, procedures=procedures)


def _without_idle_locals(program: Program, procedure: Procedure, findings: Findings) -> Procedure:
    """A procedure without declarations of handles, and of what nothing in it speaks of."""
    if not any(isinstance(node, p.Opaque) and _local_data(node) for node in walk(procedure.body)):
        return procedure
    said = Counter(_names_in_record((procedure.body, procedure.variables)))

    def needed(node: p.Opaque) -> Iterator[p.Statement]:
        item = _local_data(node)
        if item is None or not (is_handle(item.type) or not _is_used(said, item, node)):
            yield node
        else:
            _report_omission(findings, item, node)

    (made,) = with_vendor_statements_replaced(
        replace(program, procedures=(procedure,)), needed
    ).procedures
    return made


def _without_idle_targets(program: Program, findings: Findings) -> Program:
    """The program without such targets and tools that nothing speaks of."""
    idle: dict[ProgramTable, set[str]] = {
        "targets": {n for n, one in program.targets.items() if _has_too_many_axes(one)},
        "joint_targets": {n for n, one in program.joint_targets.items() if _has_too_many_axes(one)},
        "tools": {n for n, one in program.tools.items() if _is_out_of_reach(one)},
        "variables": {n for n, one in program.variables.items() if _has_too_many_axes(one.initial)},
    }
    if not any(idle.values()):
        return program
    parts = (program.procedures, tuple(program.variables.values()))
    said = texts_in(parts) | {name.lower() for name in names_in(parts)}
    for one in program.declarations:
        said |= effect_of(one).names
    for table, names in idle.items():
        names -= {name for name in names if name.lower() in said}
        for name in sorted(names):
            findings.append(rules.NOT_NEEDED(name=name, about=Declared(name, table)))
    return replace(
        program,
        targets=_without_names(program.targets, idle["targets"]),
        joint_targets=_without_names(program.joint_targets, idle["joint_targets"]),
        tools=_without_names(program.tools, idle["tools"]),
        variables=_without_names(program.variables, idle["variables"]),
    )


def _without_names(table: Mapping[str, T], names: Set[str]) -> dict[str, T]:
    return {name: one for name, one in table.items() if name not in names}


def _is_out_of_reach(tool: Tool) -> bool:
    """True if the tip of a tool is at an impossible distance, as after a failed calibration."""
    # Written as a negation, so that NaN counts as out of reach.
    return not all(abs(value) < _FARTHEST_TIP for value in tool.tip.position)


def _has_too_many_axes(value: Target | JointTarget | e.Expression | None) -> bool:
    match value:
        case e.TargetValue(target) | e.JointValue(target):
            return _has_too_many_axes(target)
        case Target() | JointTarget():
            # An axis without a position is NaN, which differs from itself.
            return any(place == place for place in value.external[_MOST_EXTERNAL_AXES:])
    return False


def _report_omission(findings: Findings, item: s.Data, node: Declaration | p.Opaque) -> None:
    with findings.at(node.span):
        findings.append(rules.NOT_NEEDED(name=item.name))


def _declared_data(declaration: Declaration) -> s.Data | None:
    if declaration.language != verbatim.LANGUAGE:
        return None
    match verbatim.understood(verbatim.items, declaration.text):
        case (s.Data() as item,):
            return item
    return None


def _vendor_texts(program: Program) -> Iterator[p.Opaque]:
    return (node for node in program.statements() if isinstance(node, p.Opaque))


def _local_data(node: p.Opaque) -> s.Data | None:
    """The data that a statement declares."""
    if node.language != verbatim.LANGUAGE:
        return None
    match verbatim.understood(verbatim.statements, node.text):
        case (s.Data() as item,):
            return item
    return None


def _used_names(program: Program) -> Iterator[str]:
    """Names in lower case that the program uses, also in text that is kept."""
    yield from _names_in_record((program.procedures, program.declarations, program.variables))


def _names_in_record(value: Any) -> Iterator[str]:
    for part in records(value):
        match part:
            case e.Name(name):
                yield name.lower()
            case p.Opaque() | e.Verbatim() | Declaration():
                yield from effect_of(part).names
            case p.Motion(tool=tool, frame=frame):
                yield from (tool.lower(), frame.lower())


def _is_used(said: Counter[str], item: s.Data, declaration: Declaration | p.Opaque) -> bool:
    """True if anything but its declaration names some data."""
    low = item.name.lower()
    # The declaration itself is one of the mentions, if its text counts among those.
    return said[low] > (low in effect_of(declaration).names)
