"""What is said about a word: an instruction, a declaration, a target with its pose."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.diagnostics import Refused
from assistant.base.rotations import to_euler
from assistant.editing.answers import Hover
from assistant.editing.naming import Named, editable, named, range_of, word_at
from assistant.editing.places import Place
from assistant.editing.workspace import Document

if TYPE_CHECKING:
    from assistant.program.geometry import Target
    from assistant.robots import Robot

MOST_COMMENT: Final = 5
"""Lines of a comment above a declaration that are shown."""


def hover(document: Document, place: Place) -> Hover | None:
    """See `service.hover`."""
    speaks = editable(document)
    at = word_at(document, place)
    if speaks is None or at is None:
        return None
    line, word = at
    found = named(document, place)
    if found is not None and found.declared is not None:
        text = "\n\n".join(_of_declared(document, found))
    else:
        known = speaks.known().get(speaks.folded(word.text)) or speaks.known().get(
            _with_next(document, line, word.start)
        )
        if known is None or (word.kind not in ("name", "keyword")):
            return None
        if not known.detail and not known.about:
            return None
        text = "\n\n".join(
            part for part in (_code(known.detail or known.name), known.about) if part
        )
    return Hover(text, range_of(document.lines, line, word.start, word.end))


def _with_next(document: Document, line: int, start: int) -> str:
    """A word and the one behind it: `def pos`."""
    words = [word for word in document.facts[line].words if word.start >= start][:2]
    return " ".join(word.text.lower() for word in words)


def _of_declared(document: Document, found: Named) -> Iterator[str]:
    assert found.declared is not None
    home = found.document
    lines = home.lines
    said = lines.line(found.at).strip()
    yield _code(said)
    comment = list(_comment_above(home, found.at))
    if comment:
        yield _escaped_markdown("\n".join(comment))
    if home is not document:
        yield _escaped_markdown(f"in {home.path}")
    if found.declared.kind == "target":
        yield from _of_target(home, found.declared.name)


def _comment_above(document: Document, line: int) -> Iterator[str]:
    above = line - 1
    while above >= 0 and line - above <= MOST_COMMENT:
        words = document.facts[above].words
        if len(words) != 1 or words[0].kind != "comment":
            break
        above -= 1
    speaks = document.spoken
    mark = "" if speaks is None else speaks.mark
    for at in range(above + 1, line):
        yield document.facts[at].words[0].text.removeprefix(mark).strip()


def _of_target(document: Document, name: str) -> Iterator[str]:
    """Its pose in mm and degrees, and the joints of the project's robot."""
    speaks = document.spoken
    assert speaks is not None and speaks.editable is not None
    key = speaks.editable.folded(name)
    try:
        source = document.declared(frozenset({key})).source(document.path)
        program = speaks.program(source, (), _project_robot(document))
    except Refused:
        return
    for known, target in program.targets.items():
        if known.lower() == key.lower():
            yield from _of_pose(document, target)
            return
    for known, joints in program.joint_targets.items():
        if known.lower() == key.lower():
            yield "joints: " + _numbers(joints.joints, "°")
            return


def _of_pose(document: Document, target: Target) -> Iterator[str]:
    x, y, z = target.pose.position
    euler = to_euler(np.array([target.pose.quaternion]))[0]
    yield (
        f"position: {_numbers((x, y, z), ' mm')}  \n"
        f"turned: {_numbers(euler[::-1], '°')} about x, y, z in turn (Euler ZYX)"
    )
    robot = _project_robot(document)
    if robot is None:
        return
    columns = np.array([_columns(target)])
    joints = robot.joints_of([target.pose.position], [target.pose.quaternion], columns)[0]
    if np.isnan(joints).any():
        yield f"{robot.name}: not within reach of the bare flange, in the robot's base"
    else:
        yield f"{robot.name}, bare flange, in the robot's base: {_numbers(joints, '°')}"


def _columns(target: Target) -> list[int]:
    from assistant.program.motion import configuration_row

    return list(configuration_row(target.configuration))


def _project_robot(document: Document) -> Robot | None:
    return document.workspace.robot(document)


def _numbers(values: object, unit: str) -> str:
    return ", ".join(f"{value:.2f}{unit}" for value in np.asarray(values, dtype=float).ravel())


def _code(text: str) -> str:
    fence = "`" * 3
    while fence in text:
        fence += "`"
    return f"{fence}\n{text}\n{fence}"


def _escaped_markdown(text: str) -> str:
    """A text that is no Markdown."""
    return "".join(f"\\{c}" if c in "\\`*_{}[]()#+-.!|<>&" else c for c in text)
