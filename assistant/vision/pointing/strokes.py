"""A stroke: the way of a device from one place at which it is held still to the next one.

Moments at one place become one point, so that who halts on the way leaves no knot. The points are
smoothed by straight lines that fit their neighbours along the way (Cleveland, Robust locally
weighted regression, 1979, without his robustness), and taken at even distances. The two places that
were held are kept as they are.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.pointing import rules
from assistant.vision.pointing.devices import Device
from assistant.vision.pointing.holding import USUAL_HOLD, HeldPosition, HoldLimits, find_holds
from assistant.vision.pointing.locating import USUAL_LIMITS, Limits, Sighting
from assistant.vision.pointing.tracking import Observation

SAME_POINT: Final = 2.0
"""mm within which moments are one point of the way."""
HELD_RADIUS: Final = 6.0
"""mm from a place that was held within which moments belong to it."""


@dataclass(frozen=True, slots=True)
class Smoothing:
    """step: mm between waypoints. window: mm of the way to both sides that each is fitted to.
    gap: mm that the device may go unseen. shortest: mm of a stroke.
    """

    step: float = 5.0
    window: float = 12.0
    gap: float = 25.0
    shortest: float = 20.0


USUAL_SMOOTHING: Final = Smoothing()


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """positions: (n, 3) mm and quaternions: (n, 4) along the way. length: mm.

    scatter: mm, root mean square, of what was seen from it. first, last: the places between
    which it was shown.
    """

    positions: Floats
    quaternions: Floats
    length: float
    scatter: float
    first: HeldPosition
    last: HeldPosition

    def csv(self) -> str:
        """As a table of waypoints, mm and unit quaternions."""
        text = io.StringIO()
        text.write("x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n")
        turns = rotations.canonical(self.quaternions)
        for p, q in zip(self.positions.tolist(), turns.tolist(), strict=True):
            numbers = [f"{v + 0.0:.3f}" for v in p] + [f"{v + 0.0:.7f}" for v in q]
            text.write(",".join(numbers) + "\n")
        return text.getvalue()


def find_strokes(
    looks: Iterable[Observation],
    device: Device,
    cameras: Sequence[Camera],
    limits: Limits = USUAL_LIMITS,
    still: HoldLimits = USUAL_HOLD,
    smoothing: Smoothing = USUAL_SMOOTHING,
    tell: Callable[[Diagnostic], None] = lambda _: None,
) -> Iterator[Stroke]:
    """The ways between two holds, the first, the third … of which begin one.

    Raises Refused for a stroke of no length, and for one that was not seen as a whole.
    """
    seen: list[tuple[float, Sighting]] = []

    def remembered() -> Iterator[Observation]:
        for look in looks:
            if isinstance(look.seen, Sighting):
                seen.append((look.seconds, look.seen))
            yield look

    first: HeldPosition | None = None
    for held in find_holds(remembered(), device, cameras, limits, still, tell):
        if first is None:
            first = held
            continue
        between = [s for t, s in seen if first.ended < t < held.began]
        yield fit_stroke(first, between, held, smoothing)
        first = None
        seen.clear()


def fit_stroke(
    first: HeldPosition,
    between: Sequence[Sighting],
    last: HeldPosition,
    smoothing: Smoothing = USUAL_SMOOTHING,
) -> Stroke:
    """The way from one held place past sightings to another one; raises Refused."""
    ends = [np.array(held.pose.position) for held in (first, last)]
    points = np.array([s.pose.position for s in between]).reshape(-1, 3)
    turns = np.array([s.pose.quaternion for s in between]).reshape(-1, 4)
    near = [np.linalg.norm(points - end, axis=1) < HELD_RADIUS for end in ends]
    begin = len(points) - int(np.argmax(near[0][::-1])) if near[0].any() else 0
    end = int(np.argmax(near[1])) if near[1].any() else len(points)
    points, turns = points[begin:end], turns[begin:end]
    whole = np.concatenate([ends[:1], points, ends[1:]])
    steps = np.linalg.norm(np.diff(whole, axis=0), axis=1)
    if float(steps.max()) > smoothing.gap:
        finding = rules.GAP_IN_STROKE(distance=float(steps.max()), most=smoothing.gap)
        raise Refused(finding)
    nodes, at, weights = _merge_points(whole, np.array([1.0, *np.ones(len(points)), 1.0]))
    nodes[0], nodes[-1] = ends
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))])
    if along[-1] < smoothing.shortest:
        raise Refused(rules.SHORT_STROKE(length=float(along[-1])))
    own = [np.array(held.pose.quaternion) for held in (first, last)]
    turns = rotations.unflipped(np.concatenate([own[:1], turns, own[1:]]))
    turned = np.stack([turns[at == i].mean(axis=0) for i in range(len(nodes))])
    dense = np.linspace(0.0, along[-1], max(2, int(np.ceil(along[-1] / smoothing.step * 4.0)) + 1))
    values = np.concatenate([nodes, turned], axis=1)
    smooth = _fit_local_lines(along, values, weights, dense, smoothing.window)
    smooth[0, :3], smooth[-1, :3] = ends
    positions, quaternions = _resample(smooth[:, :3], smooth[:, 3:], smoothing.step)
    scatter = _stroke_scatter(nodes, positions)
    length = float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())
    return Stroke(positions, quaternions, length, scatter, first, last)


def _merge_points(points: Floats, weights: Floats) -> tuple[Floats, Rows, Floats]:
    """Means (k, 3) of points that follow each other within `NEAR`; which of them each point of
    (n,) belongs to; how many belong to each (k,).
    """
    at: Rows = np.zeros(len(points), dtype=np.intp)
    centre, count, number = points[0].copy(), 1, 0
    for i in range(1, len(points)):
        if np.linalg.norm(points[i] - centre) > SAME_POINT or i == len(points) - 1:
            number, centre, count = number + 1, points[i].copy(), 1
        else:
            count += 1
            centre += (points[i] - centre) / count
        at[i] = number
    total: Floats = np.bincount(at, weights).astype(np.float64)
    means = [np.bincount(at, weights * points[:, k]) / total for k in range(3)]
    return np.stack(means, axis=1), at, total


def _fit_local_lines(
    along: Floats, values: Floats, weights: Floats, at: Floats, window: float
) -> Floats:
    """Lines through neighbours (k, c) along a way, at places (m,) of it; weights fall to 0."""
    found = np.empty((len(at), values.shape[1]))
    for i, s in enumerate(at):
        away = np.abs(along - s)
        reach = max(window, float(np.sort(away)[min(2, len(away) - 1)]) * 1.5)
        w = weights * np.maximum(1.0 - (away / reach) ** 3, 0.0) ** 3
        x = along - s
        total, mean = w.sum(), (w @ x) / w.sum()
        middle = (w @ values) / total
        spread = w @ (x - mean) ** 2
        slope = (w * (x - mean)) @ values / spread if spread > 1e-9 else 0.0 * middle
        found[i] = middle - slope * mean
    return found


def _resample(positions: Floats, quaternions: Floats, step: float) -> tuple[Floats, Floats]:
    """At even distances along the way, at most `step` apart, with both ends."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], max(2, int(np.ceil(along[-1] / step)) + 1))
    p = np.stack([np.interp(at, along, positions[:, k]) for k in range(3)], axis=1)
    q = np.stack([np.interp(at, along, quaternions[:, k]) for k in range(4)], axis=1)
    return p, rotations.canonical(q)


def _stroke_scatter(nodes: Floats, way: Floats) -> float:
    """mm, root mean square, from nodes (k, 3) to the straight parts between points of a way."""
    a, along = way[:-1], np.diff(way, axis=0)
    part = np.einsum("kmi,mi->km", nodes[:, None] - a, along) / (along**2).sum(axis=1)
    foot = a + np.clip(part, 0.0, 1.0)[..., None] * along
    least = ((nodes[:, None] - foot) ** 2).sum(axis=2).min(axis=1)
    return float(np.sqrt(least.mean()))


def stroke_in_frame(stroke: Stroke, frame: Pose) -> Stroke:
    """The same way in a frame whose pose in the world is given."""
    back = frame.inverse()
    turns = rotations.multiply(np.array(back.quaternion), stroke.quaternions)
    return replace(stroke, positions=back.moved(stroke.positions), quaternions=turns)
