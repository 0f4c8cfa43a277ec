"""Joints for targets from a learned map, their uncertainty, and supervised movements.

Pictures of a tool that some joints move lie on a surface among all pictures, and the lattice lies
on it. A target far beside the surface was not seen of the tool: two cameras see two things there,
or one of them has moved. Such a target, and one far from all units, is refused; an arm whose error
grows stops.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.learning.extended_map import (
    ArmFunction,
    ExtendedMap,
    LearningRates,
    Trials,
    apply_slopes,
    learn_trials,
    observe_arm,
)
from assistant.learning.rules import (
    NO_TARGET,
    TARGET_BEYOND_RANGE,
    TARGET_MISSED,
    TARGET_TOO_FAR,
    TARGET_UNLIKE_TOOL,
    TOOL_LOST,
    UNEXPLAINED_MISS,
)

_FLAT_SURFACE: Final = 0.15
"""Distances between neighbours by which a target may be beside a surface that is not bent."""
_NOISE_RATIO: Final = 3.0
"""Times what a unit misses by that it may be as well."""
_MOST_BESIDE: Final = 0.75
"""By trial no target of a map that has learnt is farther beside."""
_LEAST_GAP: Final = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class _UnitSurroundings:
    """Surroundings of m units, in spreads. gap: (m,) mean distance from their neighbours. planes:
    (m, d, k) orthogonal axes that span the surface there. bend: (m,) distance of neighbours from
    it.
    """

    gap: Floats
    planes: Floats
    bend: Floats

    def beside(self, offsets: Floats) -> Floats:
        """(m,) how far offsets (m, d) from the units lead away from the surface."""
        along = np.einsum("mdk,md->mk", self.planes, offsets)
        return norms(offsets - np.einsum("mdk,mk->md", self.planes, along))


def _unit_surroundings(net: ExtendedMap, units: Rows) -> _UnitSurroundings:
    at = np.stack(np.unravel_index(units, net.shape))
    total, count = np.zeros(len(units)), np.zeros(len(units))
    along: list[Floats] = []
    bent: list[Floats] = []
    for axis, size in enumerate(net.shape):
        for step in (-1, 1):
            there = _shift_along_axis(at, axis, step, size)
            total += norms(_unit_places(net, there) - _unit_places(net, at))
            count += there[axis] != at[axis]
        inner = at.copy()
        inner[axis] = np.clip(at[axis], 1, max(size - 2, 1))
        low, high = (
            _unit_places(net, _shift_along_axis(inner, axis, step, size)) for step in (-1, 1)
        )
        along.append(high - low)
        bent.append(high + low - 2.0 * _unit_places(net, inner) if size > 2 else np.zeros_like(low))
    gap = np.maximum(total / count, _LEAST_GAP)
    found = _UnitSurroundings(gap, np.linalg.qr(np.stack(along, axis=2))[0], np.zeros(len(units)))
    bend = np.max([found.beside(one) for one in bent], axis=0)
    return _UnitSurroundings(gap, found.planes, bend)


def _distance_beside(
    net: ExtendedMap, units: Rows, offsets: Floats, about: _UnitSurroundings
) -> Floats:
    """(m,) how far offsets from units lead away from what was learnt, above 1 too far; NaN of a
    unit that never won.
    """
    noise = net.missed[units] * net.scale.pixel
    allowed = _FLAT_SURFACE + (about.bend + _NOISE_RATIO * noise) / about.gap
    return np.asarray(about.beside(offsets) / about.gap / np.minimum(allowed, _MOST_BESIDE))


def _shift_along_axis(at: Rows, axis: int, step: int, size: int) -> Rows:
    """Places one step along an axis, where the lattice goes on there."""
    there = at.copy()
    there[axis] = np.clip(at[axis] + step, 0, size - 1)
    return there


def _unit_places(net: ExtendedMap, at: Rows) -> Floats:
    return np.asarray(net.places[np.ravel_multi_index(tuple(at), net.shape)])


_NEAR_UNIT: Final = 1.4
"""Times the distance between neighbours up to which a target is like what was learnt."""
_WORSE_RATIO: Final = 2.0
"""Times what the movement before missed by above which an arm stops."""
_LEAST_REPORTED: Final = 1.0
"""Pixels, root mean square, below which nothing is reported: the noise of what cameras measure.
The usual residual of a map is no excuse: pixels that remain are an error of the tool."""
RANGE_TOLERANCE: Final = 0.01
"""Part of the range of an axis by which an answer may leave it: rounding, and noise of pictures."""
_OVERSHOOT_RATIO: Final = 3.0
"""Times the disagreement of its neighbours by which a unit's first answer may leave the ranges too;
the movement after it corrects that."""


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """Joints for targets, with their reliability.

    joints: (m, a) for m targets, inside their ranges. clipped: (m, a) degrees (mm) by which the
    answers left the ranges; above 0 beyond the upper end. winners: (m,) units that answer.

    Reliability: away: (m,) distance of the target from the winner, in distances between the winner
    and its neighbours; above `_NEAR_UNIT` the target is unlike all learnt ones. beside: (m,) its
    distance from all pictures of the tool there; above 1 the cameras see something else, or have
    moved. spread: (m,) degrees (mm of a sliding axis) by which the answers of the winner's
    neighbours differ, root mean square. expected: (m,) pixels of the winner's recent error after
    both movements, NaN if it never won.
    """

    joints: Floats
    clipped: Floats
    winners: Rows
    away: Floats
    beside: Floats
    spread: Floats
    expected: Floats

    @property
    def known(self) -> Truths:
        """(m,) whether something like the target was learnt."""
        return np.asarray(self.near & (self.beside <= 1.0))

    @property
    def near(self) -> Truths:
        """(m,) whether it is not far from a unit that has learnt."""
        return np.asarray((self.away <= _NEAR_UNIT) & np.isfinite(self.expected))


@dataclass(frozen=True, slots=True, eq=False)
class Reached:
    """joints: (a,) at which the arm is. seen: (d,) pixels there. missed: pixels after each
    movement, root mean square. findings: what is to be looked at.
    """

    joints: Floats
    seen: Floats
    missed: tuple[float, ...]
    findings: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class MapInUse:
    """A map in use."""

    net: ExtendedMap

    def proposed(self, targets: Floats) -> Proposal:
        """Targets (m, d) pixels; raises Refused for what is no picture. Nothing moves."""
        net, scale = self.net, self.net.scale
        wanted = scale.pictures(_check_targets(net, targets))
        winners = net.winners(wanted)
        angles = _unit_answers(net, winners, wanted)
        joints = scale.joints(angles)
        offsets, about = wanted - net.places[winners], _unit_surroundings(net, winners)
        away = norms(offsets) / about.gap
        spread = self._spread(winners, wanted, joints)
        off = _distance_beside(net, winners, offsets, about)
        clipped = scale.clipped(angles)
        return Proposal(joints, clipped, winners, away, off, spread, net.missed[winners])

    def reach(
        self,
        arm: ArmFunction,
        target: Floats,
        corrections: int = 1,
        pace: LearningRates | None = None,
        asks: Callable[[Floats], bool] = lambda _: True,
    ) -> Reached:
        """Move an arm to a target (d,) pixels: a coarse movement and `corrections` fine ones.

        pace: learning rates for the movements (`rates_in_use`). asks: called with the joints (a,)
        of the first movement before anything moves; False ends the call with a Refused. Raises
        Refused, before anything moves, for a target that is not a picture, is unlike all learnt
        ones, or is reached only outside the ranges of the joints. It also raises Refused if the
        tool leaves the view, or goes to a position that its map does not explain: then the arm
        stays there.
        """
        net, scale = self.net, self.net.scale
        proposal = self.proposed(target[None])
        _check_known(proposal)
        self._check_inside(proposal.clipped, _OVERSHOOT_RATIO * float(proposal.spread[0]))
        if not asks(proposal.joints[0]):
            raise Refused(exit_status=1)
        wanted, slopes = scale.pictures(target[None]), net.slopes[proposal.winners]
        joints: list[Floats] = [proposal.joints]
        seen: list[Floats] = []
        missed: list[float] = []
        for movement in range(1 + corrections):
            if movement:
                off = wanted - scale.pictures(seen[-1])
                angles = scale.angles(joints[-1]) + apply_slopes(slopes, off)
                self._check_inside(scale.clipped(angles), 0.0, movement)
                joints.append(scale.joints(angles))
            seen.append(observe_arm(arm, joints[-1], len(target)))
            if not np.isfinite(seen[-1]).all():
                raise Refused(TOOL_LOST(movement=movement + 1), exit_status=1)
            missed.append(float(np.sqrt(((seen[-1] - target) ** 2).mean())))
            self._check_explained(proposal, wanted, seen[-1], missed)
        usual = float(proposal.expected[0])
        if pace is not None and corrections:
            done = Trials(proposal.winners, joints[0], seen[0], joints[1], seen[1])
            learn_trials(net, target[None], done, pace)
        findings: tuple[Diagnostic, ...] = ()
        if missed[-1] > _LEAST_REPORTED:
            findings = (TARGET_MISSED(seen=missed[-1], movements=1 + corrections, usual=usual),)
        return Reached(joints[-1][0], seen[-1][0], tuple(missed), findings)

    def _check_inside(self, clipped: Floats, more: float, movement: int = 0) -> None:
        """Raises Refused where joints would leave the ranges that were learnt.

        clipped: (1, a) by which; more: degrees (mm) that are allowed beside `RANGE_TOLERANCE`.
        """
        scale = self.net.scale
        ranges = scale.high - scale.low
        axis = int(np.argmax(np.abs(clipped[0]) / ranges))
        over = float(clipped[0, axis])
        if abs(over) <= RANGE_TOLERANCE * float(ranges[axis]) + more:
            return
        end = scale.high[axis] if over > 0.0 else scale.low[axis]
        where = "nothing has moved" if movement == 0 else f"it has stopped after {movement}"
        name = self.net.task.axes[axis]
        finding = TARGET_BEYOND_RANGE(axis=name, over=abs(over), end=float(end), where=where)
        raise Refused(finding, exit_status=1)

    def _check_explained(
        self, proposal: Proposal, wanted: Floats, seen: Floats, missed: list[float]
    ) -> None:
        """Raises Refused where a movement ended farther from the target than a line of the map
        leads, or than the movement before it.
        """
        if len(missed) == 1:
            gap = _unit_surroundings(self.net, proposal.winners).gap
            times = float((norms(wanted - self.net.scale.pictures(seen)) / gap)[0]) / _NEAR_UNIT
            most = missed[0] / times if times else missed[0]
        else:
            most = _WORSE_RATIO * missed[-2] + _LEAST_REPORTED
        if missed[-1] > most:
            raise Refused(
                UNEXPLAINED_MISS(movement=len(missed), seen=missed[-1], most=most), exit_status=1
            )

    def _spread(self, winners: Rows, wanted: Floats, joints: Floats) -> Floats:
        net, squares, count = self.net, np.zeros(len(winners)), np.zeros(len(winners))
        places = np.stack(np.unravel_index(winners, net.shape))
        for axis, size in enumerate(net.shape):
            for step in (-1, 1):
                there = places.copy()
                there[axis] += step
                rows = np.flatnonzero((there[axis] >= 0) & (there[axis] < size))
                units = np.ravel_multi_index(tuple(there[:, rows]), net.shape)
                other = net.scale.joints(_unit_answers(net, units, wanted[rows]))
                squares[rows] += ((other - joints[rows]) ** 2).mean(axis=1)
                count[rows] += 1.0
        return np.asarray(np.sqrt(squares / np.maximum(count, 1.0)))


def _check_known(proposal: Proposal) -> None:
    if not proposal.near[0]:
        raise Refused(TARGET_TOO_FAR(times=float(proposal.away[0])), exit_status=1)
    if not proposal.known[0]:
        raise Refused(TARGET_UNLIKE_TOOL(times=float(proposal.beside[0])), exit_status=1)


def _check_targets(net: ExtendedMap, targets: Floats) -> Floats:
    """Targets (m, d); raises Refused for another number of pixels, or any that is not seen."""
    reason = ""
    if targets.ndim != 2 or targets.shape[1] != net.task.seen:
        wide = targets.shape[-1] if targets.ndim else 0
        reason = f"it has {wide} numbers, and the map sees {net.task.seen}"
    elif not np.isfinite(targets).all():
        reason = "a camera does not see it"
    if reason:
        raise Refused(NO_TARGET(reason=reason), exit_status=1)
    return targets


def _unit_answers(net: ExtendedMap, units: Rows, wanted: Floats) -> Floats:
    return np.asarray(
        net.angles[units] + apply_slopes(net.slopes[units], wanted - net.places[units])
    )
