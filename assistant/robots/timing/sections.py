"""Sections of a course: the straight ones, and the halves of bends that count.

With w = v² an acceleration A over a section d allows w to grow by 2 A d: the largest w is a
running minimum, forwards and then backwards, which is exact in columns. In a bend an acceleration
is left that depends on w itself; it is computed for the highest w there, which is then brought
down towards the one that is reached, so that each pass is in bounds and faster than the last.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Truths
from assistant.robots.timing.bounds import (
    LEAST_MOTION,
    UNBOUNDED_ACCELERATION,
    Bounds,
    column_norms,
)

LITTLE_BEND: Final = 0.02
"""Part of an acceleration that a bend takes at most to be in no section of its own."""
MOST_BEND: Final = 0.999
"""Part of an acceleration that a bend takes at most; the rest changes the speed."""
SPEED_PASSES: Final = 3
"""Times that the speeds are computed where there are bends."""

EndSpeeds = tuple[float, float]
"""Speeds at the start and the end of a course."""
AT_REST: Final[EndSpeeds] = (0.0, 0.0)


@dataclass(slots=True, eq=False)
class Sections:
    """p sections of s steps.

    step, offset, distance: (p,) see `Profile`. caps, why: (p,) the highest speeds and what makes
    them so. most: (p + 1,) the highest w between them. rise, fall: (p,) accelerations.
    bends: those in bends.
    """

    step: Rows
    offset: Floats
    distance: Floats
    caps: Floats
    why: NDArray[np.uint8]
    most: Floats
    rise: Floats
    fall: Floats
    bends: Bends | None = None

    def fastest(self) -> tuple[Floats, Floats]:
        """(p + 1,) the largest w between the sections, and (p,) its peaks in them."""
        ceiling, bends = self.caps**2, self.bends
        if bends is None:
            return section_speeds(self.most, ceiling, self.rise, self.fall, self.distance)
        for _ in range(SPEED_PASSES):
            at = bends.at
            ceiling[at] = bends.highest
            self.rise[at], self.fall[at] = bends.accelerations()
            w, peak = section_speeds(self.most, ceiling, self.rise, self.fall, self.distance)
            bends.highest = (bends.highest + peak[at]) / 2.0
        return w, peak


def sections_of(bounds: Bounds, ends: EndSpeeds = AT_REST) -> Sections:
    """The sections of a course, with the speeds and accelerations that they allow."""
    room, d, bend = bounds.course.room, bounds.course.distance, bounds.bend
    caps, why = bounds.caps
    with np.errstate(divide="ignore", over="ignore"):
        knots = np.where(room > 0.0, MOST_BEND / bend, 0.0)
    if len(d):
        knots[0], knots[-1] = ends[0] ** 2, ends[1] ** 2
    # Nothing is faster than this: as if bends took nothing of an acceleration.
    rise, fall = bounds.accelerations()
    w, peak = section_speeds(knots, caps**2, rise, fall, d)
    near, quickest = _more(peak, peak), _more(rise, fall)
    near = np.minimum(near, w + 2.0 * room * quickest)
    split = bend * near > LITTLE_BEND
    knots[split] = np.inf
    whole = ~split[1:-1] & (room[1:-1] > 0.0)
    accelerations = bounds.accelerations(np.where(split, 0.0, near))
    caps, rise, fall = (_beside(one, whole) for one in (caps, *accelerations))
    if not split.any():
        step = np.arange(len(d))
        return Sections(step, np.zeros(len(d)), d, caps, why, knots, rise, fall)
    own = np.where(split, room, 0.0)
    middle = d - own[:-1] - own[1:]
    parts = np.stack([own[:-1], np.where(middle > 1e-9 * d, middle, 0.0), own[1:]], axis=1)
    step, which = np.nonzero(parts)
    begin = np.stack([np.zeros(len(d)), own[:-1], d - own[1:]], axis=1)
    first = np.diff(step, prepend=-1) > 0
    most = np.append(np.where(first, knots[step], np.inf), knots[-1])
    at = np.flatnonzero(which != 1)
    bends = Bends(bounds, at, step[at], which[at] == 2, near)
    caps, why = caps[step], why[step]
    caps[at], why[at] = bends.limits
    bends.highest = np.minimum(bends.highest, caps[at] ** 2)
    offset, distance = begin[step, which], parts[step, which]
    return Sections(step, offset, distance, caps, why, most, rise[step], fall[step], bends)


def _more(after: Floats, before: Floats) -> Floats:
    """(s + 1,) at each knot the larger of what is in the steps (s,) after and before it."""
    most = np.append(after, 0.0)
    np.maximum(most[1:], before, out=most[1:])
    return most


def _beside(most: Floats, whole: Truths) -> Floats:
    """(s,) the most of speed or acceleration also in the bends at both ends of each step.

    whole: (s - 1,) bends in which the rates of the axes and the tool are, in the middle, the mean
    of both steps, so that what they ask of their bounds is the mean at most.
    """
    asked = 1.0 / most
    mean = np.where(whole, (asked[1:] + asked[:-1]) / 2.0, 0.0)
    asked[1:] = np.maximum(asked[1:], mean)
    asked[:-1] = np.maximum(asked[:-1], mean)
    return np.asarray(1.0 / asked)


class Bends:
    """b halves of bends.

    at: (b,) sections. highest: (b,) the highest w in them. limits: their highest speeds.
    """

    def __init__(self, bounds: Bounds, at: Rows, step: Rows, ends: Truths, near: Floats) -> None:
        """step: (b,) that each is in; ends: (b,) whether at its end. near: (s + 1,) highest w."""
        self.bounds, self.at, self.step = bounds, at, step
        knot = step + ends
        room = bounds.course.room[knot]
        self.tcp = np.maximum(bounds.tcp[knot - 1], bounds.tcp[knot])
        self.rates = []  # of the axes and of the tool: in the middle, at the border, and the bend
        for rates in (bounds.axes, bounds.tool):
            before, behind = rates[:, knot - 1], rates[:, knot]
            bend = (behind - before) / (2.0 * room)
            self.rates.append(((before + behind) / 2.0, rates[:, step], bend))
        axes, tool = self.rates
        steepest = np.maximum(np.abs(axes[0]), np.abs(axes[1]))
        longest = bounds.length[step]
        longest = np.maximum(
            longest, longest * column_norms(tool[0]) / np.maximum(column_norms(tool[1]), 1e-300)
        )
        turn = np.maximum(bounds.turn[knot - 1], bounds.turn[knot])
        self.limits = bounds.least(bounds.limits(step, steepest, longest, turn), steepest)
        self.highest = np.minimum(near[knot], MOST_BEND / bounds.bend[knot])

    def accelerations(self) -> tuple[Floats, Floats]:
        """(b,) to more and to less speed, for every w up to the highest.

        What is asked of an axis is linear in its rate and in w: it is enough to look at the ends.
        """
        bounds, w = self.bounds, self.highest
        up, down = bounds.up[self.step], bounds.down[self.step]
        most = bounds.drive.accelerations[:, None]
        middle, border, bend = self.rates[0]
        rise = fall = np.full(len(w), np.inf)
        with np.errstate(divide="ignore", over="ignore"):
            for rate in (middle, border):
                pushed = np.sign(rate) * bend * w
                size = np.abs(rate)
                more = (most * up - np.maximum(pushed, 0.0)) / size
                less = (most * down + np.minimum(pushed, 0.0)) / size
                rise, fall = np.minimum(rise, more.min(axis=0)), np.minimum(fall, less.min(axis=0))
        if np.isfinite(bounds.drive.tcp_acceleration):
            more, less = self._of_tool(up, down)
            rise, fall = np.minimum(rise, more), np.minimum(fall, less)
        return np.clip(rise, LEAST_MOTION, UNBOUNDED_ACCELERATION), np.clip(
            fall, LEAST_MOTION, UNBOUNDED_ACCELERATION
        )

    def _of_tool(self, up: Floats, down: Floats) -> tuple[Floats, Floats]:
        """(b,) each, that keep the acceleration of the tool, a vector, below its most."""
        w, most = self.highest, self.tcp
        middle, border, bend = self.rates[1]
        rise = fall = np.full(len(w), np.inf)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for rate in (middle, border):
                size = column_norms(rate)
                along = np.einsum("ij,ij->j", rate, bend) * w / size
                across = (column_norms(bend) * w) ** 2 - along**2
                for sign, factor in ((1.0, up), (-1.0, down)):
                    left = np.sqrt(np.maximum((most * factor) ** 2 - across, 0.0))
                    least = np.minimum(left - sign * along, most * factor) / size
                    least[~np.isfinite(least)] = np.inf
                    if sign > 0.0:
                        rise = np.minimum(rise, least)
                    else:
                        fall = np.minimum(fall, least)
        return rise, fall


def section_speeds(
    most: Floats, ceiling: Floats, rise: Floats, fall: Floats, d: Floats
) -> tuple[Floats, Floats]:
    """(p + 1,) the largest w between sections and (p,) its peaks, below most and ceiling."""
    lid = most.copy()
    np.minimum(lid[:-1], ceiling, out=lid[:-1])
    np.minimum(lid[1:], ceiling, out=lid[1:])
    w = _largest(lid, 2.0 * rise * d, 2.0 * fall * d)
    top = (fall * w[:-1] + rise * w[1:] + 2.0 * rise * fall * d) / (rise + fall)
    return w, np.maximum(np.minimum(top, ceiling), np.maximum(w[:-1], w[1:]))


def _largest(most: Floats, rises: Floats, falls: Floats) -> Floats:
    """(p + 1,) the largest w below `most` that grows by `rises` and shrinks by `falls` a step."""
    w = most
    for steps in (rises, falls[::-1]):
        grown = np.zeros(len(most))
        np.cumsum(steps, out=grown[1:])
        w = np.minimum(np.minimum.accumulate(w - grown) + grown, w)[::-1]
    return np.asarray(np.maximum(w, 0.0))
