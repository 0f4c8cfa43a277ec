"""Serve object poses to running programs over a data link.

A program sends `see NAME` and gets seven numbers, one a line, see `assistant.sources.sights`. An
object that is out of sight or doubtful is answered with that state and zeros, and the program ends
without a move. A line that is not a question is not answered, so the program waits.
"""

from __future__ import annotations

import datetime
import math
import time
from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.controllers.mitsubishi.data_link import DataLink
from assistant.controllers.rules import Lost
from assistant.program.geometry import Pose
from assistant.program.settings_tables import shown
from assistant.sources.seen_settings import DEFAULT_TRUST, Trust
from assistant.sources.sights import DOUBTFUL, FOUND, NOT_THERE, QUESTION, Sight, doubts

_NOT_A_QUESTION: Final = error(
    "VS380",
    "`{text}` is no question for where an object is, and is not answered",
    "have the program send `see NAME`, as one does that is compiled with --ask-at",
)
_ASKED_NOT_SEEN: Final = error(
    "VS381",
    "a program asked for `{name}`, which is not in sight",
    "put it where the cameras see it",
)
_ROBOT_POSE_UNKNOWN: Final = error(
    "VS382",
    "`{name}` was seen in the world of the cell, and where the robot stands in it is not known",
    "name the cell with --cell and its robot with --robot, or see it in the robot's base",
)
_DECIMALS: Final = 4
_LISTENING_SLICE: Final = 0.2
"""Seconds that a line is listened to at a time, so that the whole can be ended."""
_LONGEST_WAIT: Final = 1e6
"""Seconds that a socket waits at the most."""

ObjectLookup = Callable[[str], Sight | None]
"""Looks for an object by its name; None where it is not in sight. May raise Refused."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer to a program. name: the requested name, empty without a question. state: the first of
    the numbers; None without an answer. pose: in the robot's base. findings: reasons for a missing
    pose.
    """

    name: str
    state: int | None
    pose: Pose | None = None
    findings: tuple[Diagnostic, ...] = ()


def serve_program(
    link: DataLink,
    look: ObjectLookup,
    *,
    trust: Trust = DEFAULT_TRUST,
    base: Pose | None = None,
    patience: float = math.inf,
) -> Iterator[Answer]:
    """Serve one program, from the time it opens its line until it closes it.

    link: not open yet. trust: limits within which a sighting counts as found. base: pose of the
    robot in the world of the cell. patience: seconds without a word after which Lost is raised.
    Each answer is yielded after it was sent. Raises Lost if the line cannot be opened or fails
    during an answer.
    """
    _open_link(link, patience)
    try:
        while (line := _next_question(link, patience)) is not None:
            told = answer_line(line, look, trust=trust, base=base)
            if told.state is not None:
                for number in answer_numbers(told):
                    link.send(number)
            yield told
    finally:
        link.close()


def answer_line(
    line: str, look: ObjectLookup, *, trust: Trust = DEFAULT_TRUST, base: Pose | None = None
) -> Answer:
    """Return the answer to a line of a program."""
    word, _, name = line.strip().partition(" ")
    name = name.strip()
    if word.lower() != QUESTION or not name:
        return Answer("", None, findings=(_NOT_A_QUESTION(text=shown(line)),))
    try:
        sight = look(name)
    except Refused as refused:
        return Answer(name, NOT_THERE, findings=refused.findings)
    if sight is None:
        return Answer(name, NOT_THERE, findings=(_ASKED_NOT_SEEN(name=shown(name)),))
    why = tuple(doubts(sight, trust, datetime.datetime.now(datetime.UTC)))
    if sight.frame == "world" and base is None:
        why += (_ROBOT_POSE_UNKNOWN(name=shown(name)),)
    if why:
        return Answer(name, DOUBTFUL, findings=why)
    pose = sight.pose if sight.frame == "base" or base is None else base.inverse() @ sight.pose
    return Answer(name, FOUND, pose)


def answer_numbers(told: Answer) -> tuple[float, ...]:
    """The seven of an answer: state, mm, degrees about x, y, z of R = Rz·Ry·Rx."""
    if told.state != FOUND or told.pose is None:
        return (told.state or NOT_THERE, *(0.0,) * 6)
    z, y, x = rotations.to_euler(np.array(told.pose.quaternion), "ZYX").tolist()
    values = (*told.pose.position, x, y, z)
    return (FOUND, *(round(value, _DECIMALS) + 0.0 for value in values))


def _open_link(link: DataLink, patience: float) -> None:
    """Opens a line as soon as the program does; raises Lost if it has not in time."""
    whole, link.timeout = link.timeout, min(patience, _LONGEST_WAIT)
    try:
        link.prepare()
        link.open()
    finally:
        link.timeout = whole


def _next_question(link: DataLink, patience: float) -> str | None:
    """The next line, None once the other end has closed; raises Lost if none comes in time."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        try:
            line = link.wait(_LISTENING_SLICE)
        except Lost:
            return None
        if line is not None:
            return line
    return link.receive(0.0)
