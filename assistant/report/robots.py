"""What is known of robots: a table of several, all of one; for people and as plain data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any, Final

import numpy as np

from assistant.robots import Robot
from assistant.robots.arms import FiveAxis, Placed, Scara, SixAxis

HEADINGS: Final = ("name", "title", "axes", "payload", "reach", "controller", "languages")
DOUBT: Final = "?"
"""Stands behind a figure that no source confirms."""
DOUBTED: Final = f"{DOUBT} no source at hand confirms it"
COUNTS: Final = {
    "quadrants": "quadrants of axes 1, 4 and 6 (confdata)",
    "turns": "turns of axes 1, 4 and 6 (FLG1, FLG2)",
}


def robot_table(robots: Sequence[Robot]) -> Iterator[str]:
    """A line of headings and one for each robot, in columns."""
    rows = [HEADINGS, *(_robot_row(robot) for robot in robots)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEADINGS))]
    for row in rows:
        yield "  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
    if any(DOUBT in cell for row in rows for cell in row):
        yield DOUBTED


def _robot_row(robot: Robot) -> tuple[str, ...]:
    return (
        robot.name,
        robot.title,
        str(len(robot.axes)),
        _known_text(robot, robot.payload, "kg", "payload_kg"),
        f"{robot.reach:g} mm{_doubt_mark(robot, 'reach_mm')}",
        f"{robot.controller}{_doubt_mark(robot, 'controller')}",
        ", ".join(robot.languages),
    )


def brief_record(robot: Robot) -> dict[str, Any]:
    """What the table says, as plain data."""
    return {
        "name": robot.name,
        "title": robot.title,
        "maker": robot.maker,
        "axes": len(robot.axes),
        "payload_kg": robot.payload,
        "reach_mm": robot.reach,
        "controller": robot.controller,
        "languages": list(robot.languages),
        "unconfirmed": list(robot.unconfirmed),
    }


def robot_record(robot: Robot) -> dict[str, Any]:
    """All of a robot as plain data; the names of figures tell their units as a robot file does."""
    position, quaternion = (column[0].tolist() for column in robot.fk(robot.home))
    return brief_record(robot) | {
        "arm": robot.arm.kind,
        "branches": robot.branches,
        "configuration": robot.counts,
        "tcp_speed_mm_s": robot.tcp_speed,
        "repeatability_mm": robot.repeatability,
        "time_to_speed_s": robot.time_to_speed,
        "time_to_speed_kg": robot.light,
        "coupling": robot.coupling,
        "lengths_mm": arm_lengths(robot),
        "axes": [_axis_record(robot, i) for i in range(len(robot.axes))],
        "home_flange": {
            "position": _without_noise(position),
            "quaternion": _without_noise(quaternion),
        },
        "source": robot.source,
    }


def arm_lengths(robot: Robot) -> dict[str, float]:
    """Lengths of the arm in mm by their names in a robot file; none of an arm of another kind."""
    match robot.arm:
        case SixAxis(lengths=found) | FiveAxis(lengths=found) | Placed(lengths=found):
            return asdict(found)
        case Scara(l1=l1, l2=l2):
            return {"l1": l1, "l2": l2}
        case _:
            return {}


def _axis_record(robot: Robot, i: int) -> dict[str, Any]:
    rates = robot.accelerations
    return {
        "name": robot.axes[i],
        "unit": robot.units[i],
        "limits": robot.limits[i].tolist(),
        "speed": float(robot.speeds[i]),
        "acceleration": None if rates is None else float(rates[i]),
        "zero": float(robot.zero[i]),
        "home": float(robot.home[i]),
    }


def robot_lines(robot: Robot) -> Iterator[str]:
    """All of a robot for people."""
    said = dict(_fact_lines(robot))
    width = max(len(name) for name in said)
    for name, text in said.items():
        yield f"{name:{width}}  {text}"
    yield ""
    yield from _axis_table(robot)
    yield ""
    yield f"source: {robot.source}"
    if robot.unconfirmed:
        yield f"{DOUBTED}: {', '.join(robot.unconfirmed)}"
    for finding in robot.findings:
        yield finding.message


def _fact_lines(robot: Robot) -> Iterator[tuple[str, str]]:
    yield "name", robot.name
    yield "title", robot.title
    yield "maker", robot.maker
    yield "controller", f"{robot.controller}{_doubt_mark(robot, 'controller')}"
    yield "languages", ", ".join(robot.languages)
    yield "arm", f"{robot.arm.kind}, {robot.branches} branches"
    yield "configuration", f"{COUNTS[robot.counts]}{_doubt_mark(robot, 'configuration')}"
    yield "payload", _known_text(robot, robot.payload, "kg", "payload_kg")
    yield "reach", f"{robot.reach:g} mm from axis 1 to the wrist{_doubt_mark(robot, 'reach_mm')}"
    yield "TCP speed", _known_text(robot, robot.tcp_speed, "mm/s", "tcp_speed_mm_s")
    yield "repeatability", _known_text(robot, robot.repeatability, "mm", "repeatability_mm")
    if robot.time_to_speed is not None:
        doubt = _doubt_mark(robot, "time_to_speed_s")
        yield "time to speed", f"{robot.time_to_speed:g} s with {robot.light:g} kg{doubt}"
    if found := arm_lengths(robot):
        named = ", ".join(
            f"{k} {v:g}{_doubt_mark(robot, f'lengths_mm.{k}')}" for k, v in found.items()
        )
        yield "lengths", f"{named} mm"
    if robot.coupling:
        yield "coupling", f"axis 3 turns by {robot.coupling:g} of J2 as well"
    position, quaternion = (column[0].tolist() for column in robot.fk(robot.home))
    yield "flange at home", "x {:g}, y {:g}, z {:g} mm".format(*_without_noise(position))
    yield "turned", "q {:g}, {:g}, {:g}, {:g}".format(*_without_noise(quaternion))


def _axis_table(robot: Robot) -> Iterator[str]:
    """The limits, speeds and home of each axis, in columns."""
    rates = robot.accelerations
    rows = [("axis", "lowest", "highest", "speed", "acceleration", "home", "unit")]
    for i, (name, unit) in enumerate(zip(robot.axes, robot.units, strict=True)):
        table = "axes_deg" if unit == "degrees" else "axes_mm"
        low, high = (
            f"{value:g}{_doubt_mark(robot, f'{table}.{name}.limits')}" for value in robot.limits[i]
        )
        speed = f"{robot.speeds[i]:g}{_doubt_mark(robot, f'{table}.{name}.speed')}"
        rate = "-" if rates is None else f"{rates[i]:g}"
        rate += "" if rates is None else _doubt_mark(robot, f"{table}.{name}.acceleration")
        rows.append((name, low, high, speed, rate, f"{robot.home[i]:g}", unit))
    for first, *numbers, unit in rows:
        yield f"{first:6}" + "".join(f"{n:>13}" for n in numbers) + f"  {unit}"


def _known_text(robot: Robot, value: float | None, unit: str, field: str) -> str:
    return "not known" if value is None else f"{value:g} {unit}{_doubt_mark(robot, field)}"


def _doubt_mark(robot: Robot, field: str) -> str:
    return DOUBT if field in robot.unconfirmed else ""


def _without_noise(values: Sequence[float]) -> list[float]:
    """Without the noise of arithmetic: a ten-thousandth of a mm, six places of a quaternion."""
    return [float(v) for v in np.round(values, 6) + 0.0]
