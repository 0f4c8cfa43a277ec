"""Robots for people and as data: a table of several, all of one, and a drawing of its arm.

The drawing shows the arm at home from the side and from above, with its axes and what the wrist
reaches. Figures without a confirmed source carry the mark `_DOUBT`. Lengths are mm, angles degrees.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.report import figures
from assistant.robots import Robot
from assistant.robots.arms import FiveAxis, Placed, Scara, SixAxis

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_HEADINGS: Final = ("name", "title", "axes", "payload", "reach", "controller", "languages")
_DOUBT: Final = "?"
"""Mark after a figure that no source confirms."""
_DOUBTED: Final = f"{_DOUBT} no source at hand confirms it"
_COUNTS: Final = {
    "quadrants": "quadrants of axes 1, 4 and 6 (confdata)",
    "turns": "turns of axes 1, 4 and 6 (FLG1, FLG2)",
}


def robot_table(robots: Sequence[Robot]) -> Iterator[str]:
    """A line of headings and one for each robot, in columns."""
    rows = [_HEADINGS, *(_robot_row(robot) for robot in robots)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(_HEADINGS))]
    for row in rows:
        yield "  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
    if any(_DOUBT in cell for row in rows for cell in row):
        yield _DOUBTED


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
    """Return the contents of the table as plain data."""
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
        "lengths_mm": _arm_lengths(robot),
        "axes": [_axis_record(robot, i) for i in range(len(robot.axes))],
        "home_flange": {
            "position": _without_noise(position),
            "quaternion": _without_noise(quaternion),
        },
        "source": robot.source,
    }


def _arm_lengths(robot: Robot) -> dict[str, float]:
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
        yield f"{_DOUBTED}: {', '.join(robot.unconfirmed)}"
    for finding in robot.findings:
        yield finding.message


def _fact_lines(robot: Robot) -> Iterator[tuple[str, str]]:
    yield "name", robot.name
    yield "title", robot.title
    yield "maker", robot.maker
    yield "controller", f"{robot.controller}{_doubt_mark(robot, 'controller')}"
    yield "languages", ", ".join(robot.languages)
    yield "arm", f"{robot.arm.kind}, {robot.branches} branches"
    yield "configuration", f"{_COUNTS[robot.counts]}{_doubt_mark(robot, 'configuration')}"
    yield "payload", _known_text(robot, robot.payload, "kg", "payload_kg")
    yield "reach", f"{robot.reach:g} mm from axis 1 to the wrist{_doubt_mark(robot, 'reach_mm')}"
    yield "TCP speed", _known_text(robot, robot.tcp_speed, "mm/s", "tcp_speed_mm_s")
    yield "repeatability", _known_text(robot, robot.repeatability, "mm", "repeatability_mm")
    if robot.time_to_speed is not None:
        doubt = _doubt_mark(robot, "time_to_speed_s")
        yield "time to speed", f"{robot.time_to_speed:g} s with {robot.light:g} kg{doubt}"
    if found := _arm_lengths(robot):
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
    return _DOUBT if field in robot.unconfirmed else ""


def _without_noise(values: Sequence[float]) -> list[float]:
    """Without the noise of arithmetic: a ten-thousandth of a mm, six places of a quaternion."""
    return [float(v) for v in np.round(values, 6) + 0.0]


_PROBE_MOTION: Final = 10.0
"""degrees or mm by which a joint is moved to see its axis."""
_AREA_STEPS: Final = 49
"""Angles of a joint over its range for the area that an arm reaches."""
_SAME_POINT: Final = 1e-3
"""mm between points that are one."""
_ARM_VIEWS: Final = {"from the side": ("x", "z"), "from above": ("x", "y")}
_AXIS_COLUMNS: Final = {"x": 0, "y": 1, "z": 2}
_WRIST_POINT: Final = 4
"""Index of the wrist among the points of a vertical arm."""
_SIDE_COLUMNS: Final = [_AXIS_COLUMNS["x"], _AXIS_COLUMNS["z"]]
_SHORTEST_SEEN: Final = 0.1
"""Length in a view below which a unit vector points at the reader."""
_CROWDED_SHARE: Final = 0.05
"""Share of the reach between axes at which their names would overlap."""
_NAME_OFFSET: Final = 11.0
"""Points from an axis to its name."""
_ARM_COLOUR, _AREA_COLOUR, _AXIS_COLOUR, _REACH_COLOUR = "#1f3b57", "#dbe7f2", "#b3261e", "#6b8e23"


@dataclass(frozen=True, slots=True)
class JointAxis:
    """name: of the joint. point: (3,) mm on its axis, at the arm. direction: (3,) unit vector."""

    name: str
    point: Floats
    direction: Floats


def arm_drawing(robot: Robot, format: str = "png") -> bytes:
    """The picture as PNG or SVG; raises Refused, naming the extra, without matplotlib."""
    drawn = figures.new_figure(11.0, 6.5)
    chain = robot.chain(robot.home)[0]
    axes = joint_axes(robot)
    for view, (title, (across, up)) in zip(drawn.subplots(1, 2), _ARM_VIEWS.items(), strict=True):
        seen = [_AXIS_COLUMNS[across], _AXIS_COLUMNS[up]]
        _reached_area(view, robot, seen)
        _draw_arm(view, chain[:, seen])
        _draw_axes(view, axes, seen, robot.reach)
        view.set(xlabel=f"{across} in mm", ylabel=f"{up} in mm", title=title, aspect="equal")
        view.grid(visible=True, alpha=0.3)
    drawn.suptitle(f"{robot.title} at home, reach {robot.reach:g} mm")
    handles, labels = view.get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figures.picture(drawn, format)


def joint_axes(robot: Robot) -> tuple[JointAxis, ...]:
    """Return the axis of each joint at home, found by moving the joints one by one."""
    home = np.asarray(robot.home, dtype=np.float64)
    moved = home + _PROBE_MOTION * np.eye(len(home))
    p, q = robot.fk(np.vstack([home, moved]))
    chain = robot.chain(home)[0]
    found = []
    for i, name in enumerate(robot.axes, start=1):
        if robot.sliding[i - 1]:
            way = p[i] - p[0]
            found.append(JointAxis(name, chain[-1], way / np.linalg.norm(way)))
            continue
        turn = rotations.multiply(q[i], rotations.conjugate(q[0]))
        direction = turn[1:] * np.sign(turn[0]) / np.linalg.norm(turn[1:])
        matrix = rotations.to_matrix(turn)
        shift = p[i] - matrix @ p[0]
        # Of all points with p = turn · p + shift the one nearest to the origin.
        point = np.linalg.pinv(np.eye(3) - matrix) @ shift
        found.append(JointAxis(name, _axis_point(point, direction, chain), direction))
    return tuple(found)


def _axis_point(point: Floats, direction: Floats, chain: Floats) -> Floats:
    """The middle of the first link along an axis, or the point of the axis nearest to the arm."""
    along = (chain - point) @ direction
    feet = point + along[:, None] * direction
    off = np.linalg.norm(chain - feet, axis=1)
    near = feet[off < off.min() + _SAME_POINT]
    apart = near[np.linalg.norm(near - near[0], axis=1) > _SAME_POINT]
    return np.asarray(near[0] if not len(apart) else (near[0] + apart[0]) / 2.0)


def _reached_area(view: Axes, robot: Robot, seen: list[int]) -> None:
    """Draw the area that the wrist reaches, and from above the circle of the stretched arm."""
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Circle

    said: dict[str, Any] = {
        "color": _AREA_COLOUR,
        "zorder": 0,
        "label": f"{'wrist' if _wrist_of(robot) else 'flange'} within the limits",
    }
    swept = _wrist_points(robot, seen)
    if seen == _SIDE_COLUMNS or isinstance(robot.arm, Scara):
        corners = swept[..., seen]
        cells = np.stack(
            [corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]], axis=2
        )
        view.add_collection(
            PolyCollection(list(cells.reshape(-1, 4, 2)), linewidths=0.5, rasterized=True, **said)
        )
    else:
        view.fill(*_area_outline(robot, swept.reshape(-1, 3)).T, linewidth=0.0, **said)
    if seen != _SIDE_COLUMNS:
        ring = Circle((0.0, 0.0), robot.reach, fill=False, color=_REACH_COLOUR, linestyle="--")
        ring.set_label("reach")
        view.add_patch(ring)
    view.autoscale_view()


def _area_outline(robot: Robot, swept: Floats) -> Floats:
    """(k, 2) how far points (n, 3) come from axis 1 in each direction when it turns."""
    low, high = robot.limits[0] - robot.home[0]
    radii, azimuths = np.hypot(*swept.T[:2]), np.degrees(np.arctan2(*swept.T[1::-1]))
    directions = np.arange(0.0, 360.0, 1.0)
    turns = (directions[:, None] - azimuths - low) % 360.0
    farthest = np.where(turns <= high - low, radii, 0.0).max(axis=1)
    angles = np.radians(directions)
    return np.asarray(farthest[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]))


def _wrist_points(robot: Robot, seen: list[int]) -> Floats:
    """(STEPS, STEPS, 3) where the wrist is with two joints over their ranges, the rest at home.

    They are axes 2 and 3, which a vertical arm moves in its plane; of a SCARA seen from above 1
    and 2.
    """
    scara = isinstance(robot.arm, Scara)
    first = 0 if scara and seen != _SIDE_COLUMNS else min(1, len(robot.axes) - 2)
    joints = np.tile(robot.home, (_AREA_STEPS, _AREA_STEPS, 1))
    steps = np.linspace(0.0, 1.0, _AREA_STEPS)
    low, high = robot.limits.T
    for axis, at in ((first, steps[:, None]), (first + 1, steps)):
        joints[..., axis] = low[axis] + (high[axis] - low[axis]) * at
    chain = robot.chain(joints.reshape(-1, len(robot.axes)))
    return np.asarray(
        chain[:, _WRIST_POINT if _wrist_of(robot) else -1].reshape(_AREA_STEPS, _AREA_STEPS, 3)
    )


def _wrist_of(robot: Robot) -> bool:
    return isinstance(robot.arm, SixAxis | FiveAxis | Placed)


def _draw_arm(view: Axes, points: Floats) -> None:
    view.plot(
        *points.T, color=_ARM_COLOUR, linewidth=5.0, alpha=0.85, solid_capstyle="round", label="arm"
    )
    view.plot(*points.T, "o", color="white", markeredgecolor=_ARM_COLOUR, markersize=7.0)
    view.plot(*points[-1], "s", color=_ARM_COLOUR, markersize=8.0, label="flange")


def _draw_axes(view: Axes, axes: Sequence[JointAxis], seen: list[int], reach: float) -> None:
    """A dash-dotted line along each axis, or a ring where it points at the reader, and its name.

    Names that would be printed over each other are one text.
    """
    named: list[tuple[Floats, Floats, list[str]]] = []
    for axis in axes:
        point, direction = axis.point[seen], axis.direction[seen]
        if np.linalg.norm(direction) < _SHORTEST_SEEN:
            view.plot(*point, "o", color="none", markeredgecolor=_AXIS_COLOUR, markersize=13.0)
            aside = np.array([1.0, 1.0])
        else:
            ends = point + np.outer([-0.1, 0.1], direction) * reach
            view.plot(*ends.T, color=_AXIS_COLOUR, linewidth=1.0, linestyle="-.")
            aside = np.array([direction[1], -direction[0]])
        for place, _, names in named:
            if np.linalg.norm(place - point) < _CROWDED_SHARE * reach:
                names.append(axis.name)
                break
        else:
            named.append((point, aside, [axis.name]))
    for place, aside, names in named:
        view.annotate(
            ", ".join(names),
            (float(place[0]), float(place[1])),
            xytext=(_NAME_OFFSET * float(aside[0]), _NAME_OFFSET * float(aside[1])),
            textcoords="offset points",
            color=_AXIS_COLOUR,
            ha="left"
            if aside[0] > _SHORTEST_SEEN
            else "right"
            if aside[0] < -_SHORTEST_SEEN
            else "center",
            va="center",
            bbox={"facecolor": "white", "alpha": 0.7, "linewidth": 0.0, "pad": 0.5},
        )
