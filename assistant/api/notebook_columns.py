"""Pages of notebooks: robots, and what is kept in columns: paths, samples, recordings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.columns import columns_html, html_text
from assistant.program.motion import Kind

if TYPE_CHECKING:
    from assistant.program.motion import Path
    from assistant.robots import Robot
    from assistant.robots.timing.simulation import Samples

ARM_SIZE: Final = 260.0
"""px of the picture of an arm."""


class RecordedColumns(Protocol):
    """A recording of a controller: labels of its columns, and its rows (n, k)."""

    @property
    def labels(self) -> tuple[str, ...]: ...

    def rows(self) -> Floats: ...


def robot_html(robot: Robot) -> str:
    """An arm: its limits and speeds, and how it stands at home, seen from the side."""
    told = [f"{robot.title}, {robot.maker}", f"arm {robot.arm.kind}, reach {robot.reach:.0f} mm"]
    if robot.payload is not None:
        told.append(f"payload {robot.payload:g} kg")
    told.append(f"languages {', '.join(robot.languages)}")
    head = "".join(f"<th>{one}</th>" for one in ("", "from", "to", "home", "speed a second", "in"))
    rows = "".join(
        f"<tr><td>{html_text(name)}</td><td>{low:g}</td><td>{high:g}</td><td>{home:g}</td>"
        f"<td>{speed:g}</td><td>{unit}</td></tr>"
        for name, (low, high), home, speed, unit in zip(
            *(robot.axes, robot.limits, robot.home, robot.speeds, robot.units), strict=True
        )
    )
    lines = "".join(f"<p>{html_text(line)}</p>" for line in told)
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    return f"<div><b>{html_text(robot.name)}</b>{lines}{table}{_links_at_home(robot)}</div>"


def path_html(path: Path) -> str:
    """A path: how each row is reached, and where it is."""
    kinds = np.array([Kind(kind).name.lower() for kind in path.kinds])
    places = dict(zip(("x", "y", "z"), path.positions.T, strict=True))
    turns = dict(zip(("qw", "qx", "qy", "qz"), path.quaternions.T, strict=True))
    return columns_html(repr(path)[1:-1], {"by": kinds} | places | turns)


def samples_html(samples: Samples) -> str:
    """The motion of a simulation."""
    places = dict(zip(("x", "y", "z"), samples.position.T, strict=True))
    told = repr(samples)[1:-1]
    return columns_html(
        told, {"s": samples.t, "joint": samples.joints} | places | {"mm/s": samples.tcp_speed}
    )


def recording_html(recording: RecordedColumns) -> str:
    return columns_html(
        repr(recording)[1:-1], dict(zip(recording.labels, recording.rows().T, strict=True))
    )


def _links_at_home(robot: Robot) -> str:
    """The links at home in the plane that the arm stands in, as a line."""
    points = robot.chain(robot.home[None])[0]
    out = np.hypot(points[-1, 0], points[-1, 1])
    way = points[-1, :2] / out if out > 1.0 else np.array([1.0, 0.0])
    flat = np.column_stack([points[:, :2] @ way, points[:, 2]])
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = (ARM_SIZE - 40.0) / max(float((high - low).max()), 1e-9)
    places = (flat - (low + high) / 2.0) * scale * [1.0, -1.0] + ARM_SIZE / 2.0
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4"/>' for x, y in places)
    x, y, z = robot.fk(robot.home)[0][0]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{ARM_SIZE:.0f}" height="{ARM_SIZE:.0f}" '
        f'viewBox="0 0 {ARM_SIZE:.0f} {ARM_SIZE:.0f}" style="background:white" fill="#1f5f8b">'
        f'<polyline points="{line}" fill="none" stroke="#1f5f8b" stroke-width="5" '
        f'stroke-linecap="round" stroke-linejoin="round"/>{dots}</svg>'
        f"<p><small>at home, from the side; flange at {x:.1f}, {y:.1f}, {z:.1f} mm</small></p>"
    )
