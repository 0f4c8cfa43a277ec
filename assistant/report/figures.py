"""Figures of matplotlib without a screen: poses, motions, runs and learned maps over time.

matplotlib is the extra `plot`; without it `new_figure` raises Refused. Pictures are PNG or SVG
without version or date, so that the same figure gives the same bytes. Lengths are mm, angles
degrees, times seconds; quaternions are scalar first.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, evenly_spaced
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, error
from assistant.base.installation import missing_extra
from assistant.program.se3 import METRE, Unit
from assistant.report.track import Track
from assistant.robots import Robot
from assistant.robots.timing import Simulation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


NEEDS_PLOT: Final = missing_extra(
    "CL008",
    "drawing needs matplotlib, which is not installed",
    "plot",
)
NO_PICTURE: Final = error(
    "CL009", "`{name}` is no picture that can be drawn", "end its name in .png or .svg"
)
FORMATS: Final = {".png": "png", ".svg": "svg"}
"""Picture format by file suffix."""


def format_of(name: str) -> str:
    """`png` or `svg` by the end of a file name; raises Refused for another."""
    known = FORMATS.get(PurePath(name).suffix.lower())
    if known is None:
        raise Refused(NO_PICTURE(name=name), exit_status=2)
    return known


def cell_edges(values: Floats) -> Floats:
    """(n + 1,) between coloured cells about values (n,) that are evenly apart."""
    half = (values[1] - values[0]) / 2.0 if len(values) > 1 else 0.5
    return np.append(values - half, values[-1] + half)


def new_figure(width: float, height: float) -> Figure:
    """An empty figure, inches; raises Refused, naming the extra, without matplotlib."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise Refused(NEEDS_PLOT(), exit_status=2) from None

    class Shown(Figure):
        """A figure that notebooks show without pyplot."""

        def _repr_png_(self) -> bytes:
            return picture(self)

    empty = Shown(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(empty)
    return empty


def picture(drawn: Figure, format: str = "png") -> bytes:
    """The bytes of a figure, without version or date: the same figure gives the same bytes."""
    import matplotlib

    nameless = {"png": {"Software": None}, "svg": {"Date": None}}[format]
    data = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "robot-assistant"}):
        drawn.savefig(data, format=format, dpi=110, metadata=nameless)
    return data.getvalue()


def pose_plot(track: Track, title: str, unit: Unit = "mm") -> bytes:
    """TCP position and orientation (quaternion) over the way, lengths in a unit, as a PNG."""
    along, label = track.lengths() / METRE[unit], f"way of the TCP in {unit}"
    return _pose_figure(along, track.positions, track.quaternions, label, title, "png", unit)


def exchange_plot(
    seconds: Floats,
    positions: Floats,
    quaternions: Floats,
    title: str,
    format: str = "png",
    unit: Unit = "mm",
) -> bytes:
    """Poses that a robot answered over time: (n,) s, (n, 3) mm, (n, 4) scalar first.

    unit: of the positions in the plot. A quaternion and its negative are one orientation: each is
    drawn with the sign that is nearer to the one before.
    """
    turns = rotations.unflipped(quaternions)
    return _pose_figure(seconds, positions, turns, "time in s", title, format, unit)


def _pose_figure(
    along: Floats,
    positions: Floats,
    quaternions: Floats,
    label: str,
    title: str,
    format: str,
    unit: Unit,
) -> bytes:
    figure = new_figure(8.0, 6.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    marker = "." if len(along) <= 200 else ""
    draw_pose_curves((upper, lower), along, positions, quaternions, unit, marker=marker)
    return label_poses(figure, (upper, lower), label, title, unit, format)


def draw_pose_curves(
    axes: tuple[Axes, Axes],
    along: Floats,
    positions: Floats,
    quaternions: Floats,
    unit: Unit,
    *,
    named: bool = True,
    **style: Any,
) -> None:
    """Draw positions (n, 3) mm, in a unit, and quaternions (n, 4) over (n,).

    named: in the legend. style: of the lines.
    """
    names = ("x", "y", "z"), ("q1 (w)", "q2 (x)", "q3 (y)", "q4 (z)")
    for place, columns, labels in zip(
        axes, (positions / METRE[unit], quaternions), names, strict=True
    ):
        for number, (column, name) in enumerate(zip(columns.T, labels, strict=True)):
            place.plot(along, column, color=f"C{number}", label=name if named else None, **style)


def label_poses(
    figure: Figure, axes: tuple[Axes, Axes], label: str, title: str, unit: Unit, format: str
) -> bytes:
    """Label the axes of positions above and quaternions below, and return the picture."""
    upper, lower = axes
    upper.set(ylabel=f"position of the TCP in {unit}", title=title)
    lower.set(ylabel="orientation", xlabel=label)
    for one in axes:
        one.grid(visible=True, alpha=0.3)
        one.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return picture(figure, format)


ARM_MARKS: Final = ".x+1234"
"""Marks of the arms that are drawn, in their order."""


@dataclass(frozen=True, slots=True)
class Poses:
    """Positions (n, 3) mm and unit quaternions (n, 4), scalar first."""

    positions: Floats
    quaternions: Floats

    def __len__(self) -> int:
        return len(self.positions)

    def deviation(self, other: Poses) -> tuple[float, float]:
        """Return the largest distance in mm and the largest angle in degrees between like rows."""
        apart = np.linalg.norm(self.positions - other.positions, axis=1)
        turned = rotations.angle_between(self.quaternions, other.quaternions)
        return float(apart.max(initial=0.0)), float(turned.max(initial=0.0))


def passed_poses(points: Poses, seen: Poses) -> Poses:
    """Return the poses at which a motion passes points, in the order of the points.

    points: n of them. seen: the motion, one or more samples of it in the order of time; between two
    samples it goes straight and turns evenly. The search for each point starts after the one before
    it and runs to the end of the motion; the pose is the one nearest to the point.
    """
    if len(seen) == 1:
        seen = Poses(np.repeat(seen.positions, 2, 0), np.repeat(seen.quaternions, 2, 0))
    starts = seen.positions[:-1]
    steps = np.diff(seen.positions, axis=0)
    squares = np.einsum("ij,ij->i", steps, steps)
    nearest = np.empty(len(points))
    reached = 0.0
    for index, point in enumerate(points.positions):
        first = min(int(reached), len(steps) - 1)
        along = np.einsum("ij,ij->i", point - starts[first:], steps[first:])
        parts = along / np.where(squares[first:] > 0.0, squares[first:], 1.0)
        lowest = np.zeros(len(parts))
        lowest[0] = reached - first
        parts = np.clip(parts, lowest, 1.0)
        places = starts[first:] + parts[:, None] * steps[first:]
        best = int(np.linalg.norm(places - point, axis=1).argmin())
        reached = nearest[index] = first + best + parts[best]
    rows = np.minimum(nearest.astype(int), len(steps) - 1)
    parts = nearest - rows
    return Poses(
        starts[rows] + parts[:, None] * steps[rows],
        rotations.between(seen.quaternions[rows], seen.quaternions[rows + 1], parts),
    )


def point_plot(
    points: Poses,
    arms: Mapping[str, Poses],
    title: str,
    *,
    unit: Unit = "mm",
    format: str = "png",
) -> bytes:
    """Position and quaternion of the TCP over the number of the point.

    points: the trajectory, drawn as lines. arms: name of an arm → where it passed the points,
    drawn as marks. unit: of the positions that are drawn.
    """
    figure = new_figure(8.0, 6.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    numbers = np.arange(1.0, len(points) + 1.0)
    turns = rotations.unflipped(points.quaternions)
    draw_pose_curves((upper, lower), numbers, points.positions, turns, unit)
    for mark, (name, there) in zip(ARM_MARKS, arms.items(), strict=False):
        other = np.einsum("ij,ij->i", there.quaternions, turns) < 0.0  # side of the sphere
        signed = np.where(other[:, None], -there.quaternions, there.quaternions)
        drawn = {"linestyle": "", "marker": mark}
        draw_pose_curves(
            (upper, lower), numbers, there.positions, signed, unit, named=False, **drawn
        )
        upper.plot([], [], color="black", label=name, **drawn)
    return label_poses(figure, (upper, lower), "point", title, unit, format)


MOST_CURVE_POINTS: Final = 4000
"""Points of a curve that are drawn."""


def motion_plot(simulation: Simulation, title: str, format: str = "png") -> bytes:
    """Five diagrams over the time in seconds, as `png` or `svg`."""
    robot, samples = simulation.robot, simulation.samples
    some = evenly_spaced(len(samples), MOST_CURVE_POINTS)
    t = samples.t[some]
    figure = new_figure(9.0, 11.0)
    place, turn, speed, joints, velocity = figure.subplots(5, 1, sharex=True)
    for axis, label in enumerate("xyz"):
        place.plot(t, samples.position[some, axis], label=label)
    for part, label in enumerate(("q1 (w)", "q2 (x)", "q3 (y)", "q4 (z)")):
        turn.plot(t, samples.quaternion[some, part], label=label)
    speed.plot(t, samples.tcp_speed[some], label="TCP")
    low, high = robot.limits.T
    for axis, label in enumerate(robot.axes):
        part = (samples.joints[some, axis] - low[axis]) / (high[axis] - low[axis])
        joints.plot(t, 100.0 * part, label=label)
        share = samples.joint_velocity[some, axis] / robot.speeds[axis]
        velocity.plot(t, 100.0 * share, label=label)
    for axes, limits in ((joints, (0.0, 100.0)), (velocity, (-100.0, 100.0))):
        for limit in limits:
            axes.axhline(limit, color="red", linestyle="--", linewidth=1.0)
    joints.set_ylim(-5.0, 105.0)
    velocity.set_ylim(-110.0, 110.0)
    place.set(title=title, ylabel="position in mm")
    turn.set(ylabel="orientation")
    speed.set(ylabel="speed of the tool in mm/s")
    joints.set(ylabel="joints, % of their range")
    velocity.set(ylabel="joint speeds, % of the most", xlabel="seconds")
    for axes in (place, turn, speed, joints, velocity):
        axes.grid(visible=True, alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return picture(figure, format)


SIGNAL_SPACING: Final = 1.5
"""Spacing of the signal curves, each between 0 and 1 of its largest value."""


def run_plot(
    columns: Mapping[str, np.ndarray], robot: Robot, title: str, format: str = "png"
) -> bytes:
    """Four diagrams over the time in seconds, as `png` or `svg`. columns: of the samples of a run:
    t, position, joints, speed, inputs and outputs with their names.
    """
    some = evenly_spaced(len(columns["t"]), MOST_CURVE_POINTS)
    t = columns["t"][some]
    figure = new_figure(9.0, 10.0)
    place, speed, joints, signals = figure.subplots(4, 1, sharex=True)
    for axis, label in enumerate("xyz"):
        place.plot(t, columns["position"][some, axis], label=label)
    speed.plot(t, columns["speed"][some], label="TCP")
    low, high = robot.limits.T
    for axis, label in enumerate(robot.axes):
        part = (columns["joints"][some, axis] - low[axis]) / (high[axis] - low[axis])
        joints.plot(t, 100.0 * part, label=label)
    for limit in (0.0, 100.0):
        joints.axhline(limit, color="red", linestyle="--", linewidth=1.0)
    joints.set_ylim(-5.0, 105.0)
    names: list[str] = []
    for kind in ("input", "output"):
        for column, name in enumerate(columns[f"{kind}_names"].tolist()):
            values = columns[f"{kind}s"][:, column]
            most = float(np.abs(values).max(initial=0.0)) or 1.0
            level = SIGNAL_SPACING * len(names)
            signals.step(columns["t"], values / most + level, where="post", linewidth=1.0)
            names.append(f"{kind} {name}")
    signals.set_yticks([SIGNAL_SPACING * level for level in range(len(names))], names, fontsize=7)
    place.set(title=title, ylabel="position in mm")
    speed.set(ylabel="speed of the tool in mm/s")
    joints.set(ylabel="joints, % of their range")
    signals.set(xlabel="seconds")
    for axes in (place, speed, joints, signals):
        axes.grid(visible=True, alpha=0.3)
    for axes in (place, speed, joints):
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return picture(figure, format)


LINK_COLOURS: Final = ("#20639b", "#c0392b", "#3c8d5a")
"""Colours of links along the first three axes of a lattice."""
GOAL_COLOUR: Final = "#c9ced3"


@dataclass(frozen=True, slots=True, eq=False)
class LatticeStage:
    """After so many steps: pixels (n, d) of the units, u and v of each camera for the first point
    of the tool in front. mm: mean error.
    """

    steps: int
    pixels: Floats
    mm: float


def lattice_picture(
    stages: Sequence[LatticeStage],
    shape: tuple[int, ...],
    goals: Floats,
    cameras: Sequence[str],
    format: str = "png",
) -> bytes:
    """Draw a row per camera, a column per stage; goals (m, d) pixels are dots in the background.

    For a lattice of more than three axes, the middle of the others is drawn. Raises Refused, naming
    the extra, without matplotlib.
    """
    from matplotlib.collections import LineCollection

    count = len(cameras)
    drawn = new_figure(2.6 * len(stages), 2.3 * count)
    rows = drawn.subplots(count, len(stages), squeeze=False, sharex="row", sharey="row")
    links = _lattice_links(shape)
    for i, name in enumerate(cameras):
        for axes, stage in zip(rows[i], stages, strict=True):
            at = stage.pixels[:, 2 * i : 2 * i + 2]
            axes.plot(*goals[:, 2 * i : 2 * i + 2].T, ".", color=GOAL_COLOUR, markersize=1.5)
            for pairs, colour in zip(links, LINK_COLOURS, strict=False):
                axes.add_collection(LineCollection(list(at[pairs]), colors=colour, linewidths=0.5))
            axes.set_aspect("equal")
            axes.tick_params(labelsize=7)
            if i == 0:
                axes.set_title(f"{stage.steps:,} steps: {stage.mm:.3g} mm", fontsize=9)
        _picture_limits(rows[i][0], goals[:, 2 * i : 2 * i + 2], name)
    return picture(drawn, format)


def curve_picture(steps: Sequence[int], mm: Floats, degrees: Floats, format: str = "png") -> bytes:
    """Mean and worst errors (n, 2) over steps, degrees NaN where only places count."""
    drawn = new_figure(6.4, 4.0)
    axes = drawn.subplots()
    axes.plot(steps, mm[:, 0], "o-", color=LINK_COLOURS[0], label="mean, mm")
    axes.plot(steps, mm[:, 1], "o:", color=LINK_COLOURS[0], label="worst, mm")
    if np.isfinite(degrees).any():
        axes.plot(steps, degrees[:, 0], "s-", color=LINK_COLOURS[1], label="mean, degrees")
        axes.plot(steps, degrees[:, 1], "s:", color=LINK_COLOURS[1], label="worst, degrees")
    axes.set(xscale="symlog", yscale="log", xlabel="steps", ylabel="error of the tool")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend()
    return picture(drawn, format)


def curve_csv(steps: Sequence[int], mm: Floats, degrees: Floats) -> bytes:
    """The same as a table."""
    out = io.StringIO()
    out.write("steps,mean_mm,worst_mm,mean_deg,worst_deg\n")
    for step, (mean, worst), (turn, most) in zip(steps, mm, degrees, strict=True):
        turned = f"{turn:.6g},{most:.6g}" if np.isfinite(turn) else ","
        out.write(f"{step},{mean:.6g},{worst:.6g},{turned}\n")
    return out.getvalue().encode()


def _picture_limits(axes: Axes, goals: Floats, name: str) -> None:
    """Limit the axes to the goals, v downwards as in a picture."""
    low, high = goals.min(axis=0), goals.max(axis=0)
    more = 0.1 * (high - low)
    axes.set_xlim(low[0] - more[0], high[0] + more[0])
    axes.set_ylim(high[1] + more[1], low[1] - more[1])
    axes.set_ylabel(f"{name}, px", fontsize=8)


def _lattice_links(shape: tuple[int, ...]) -> list[Rows]:
    """Return neighbours (m, 2) along each of up to three axes, in the middle of all others."""
    numbers = np.arange(int(np.prod(shape))).reshape(shape)
    middle = (slice(None),) * 3 + tuple(count // 2 for count in shape[3:])
    there = numbers[middle[: len(shape)]]
    out = []
    for axis, count in enumerate(there.shape):
        first = np.take(there, np.arange(count - 1), axis).ravel()
        last = np.take(there, np.arange(1, count), axis).ravel()
        out.append(np.column_stack([first, last]))
    return out
