"""Using a learned map: joints for what is seen, how sure they are, watched movements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.learning.maps.extended_map import ExtendedMap, Pace
from assistant.learning.maps.lattice import pairs
from assistant.learning.maps.rules import FAR, LOST, NO_TARGET, NOT_THERE
from assistant.learning.maps.trials import Arm, Trials, learn, looked, times
from assistant.program.arrays import Floats, Rows, Truths, norms
from assistant.program.diagnostics import Diagnostic, Refused

NEAR: Final = 2.0
"""Times the distance between neighbours up to which a target is like what was learnt."""
MORE: Final = 5.0
"""Times what a unit usually misses by above which a movement is told of."""
LEAST: Final = 1.0
"""Pixels below which nothing is told of."""


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """joints: (m, a) for m targets, inside their ranges. winners: (m,) units that answer.

    How sure they are: away: (m,) how far the target is from the winner, in distances between the
    winner and its neighbours; above `NEAR` nothing like it was learnt. spread: (m,) degrees (mm of
    an axis that slides) by which the winner's neighbours would answer otherwise, root mean square.
    expected: (m,) pixels that the winner missed by lately after both movements, NaN if it never
    won.
    """

    joints: Floats
    winners: Rows
    away: Floats
    spread: Floats
    expected: Floats

    @property
    def known(self) -> Truths:
        """(m,) whether something like the target was learnt."""
        return np.asarray((self.away <= NEAR) & np.isfinite(self.expected))


@dataclass(frozen=True, slots=True, eq=False)
class Reached:
    """joints: (a,) at which the arm is. seen: (d,) pixels there. missed: pixels after each
    movement, root mean square. findings: what is to be looked at.
    """

    joints: Floats
    seen: Floats
    missed: tuple[float, ...]
    findings: tuple[Diagnostic, ...] = ()


@dataclass(slots=True, eq=False)
class User:
    """A map in use."""

    net: ExtendedMap
    _gaps: Floats | None = field(default=None, init=False)
    _pairs: Rows = field(init=False)

    def __post_init__(self) -> None:
        self._pairs = pairs(self.net.shape)

    def proposed(self, targets: Floats) -> Proposal:
        """Targets (m, d) pixels; raises Refused for what is no picture. Nothing moves."""
        net, scale = self.net, self.net.scale
        wanted = scale.pictures(checked(net, targets))
        winners = net.winners(wanted)
        joints = scale.joints(_answers(net, winners, wanted))
        distance = norms(wanted - net.places[winners])
        spread = self._spread(winners, wanted, joints)
        return Proposal(joints, winners, distance / self.gaps[winners], spread, net.missed[winners])

    def reach(
        self,
        arm: Arm,
        target: Floats,
        corrections: int = 1,
        pace: Pace | None = None,
        asks: Callable[[Floats], bool] = lambda _: True,
    ) -> Reached:
        """Moves an arm to a target (d,) pixels: a coarse movement and so many fine ones.

        pace: learn from them, by this (`cooling.in_use`). asks: called with the joints (a,) of the
        first movement before anything moves; False ends it with a Refused. Raises Refused, before
        anything moves, for a target that is no picture or like nothing that was learnt, and where
        the tool gets out of sight; then the arm stays where it is.
        """
        net, scale = self.net, self.net.scale
        proposal = self.proposed(target[None])
        if not proposal.known[0]:
            raise Refused(FAR(times=float(proposal.away[0])), exit_status=1)
        if not asks(proposal.joints[0]):
            raise Refused(exit_status=1)
        wanted, slopes = scale.pictures(target[None]), net.slopes[proposal.winners]
        joints: list[Floats] = [proposal.joints]
        seen: list[Floats] = []
        missed: list[float] = []
        for movement in range(1 + corrections):
            if movement:
                off = wanted - scale.pictures(seen[-1])
                joints.append(scale.joints(scale.angles(joints[-1]) + times(slopes, off)))
            seen.append(looked(arm, joints[-1], len(target)))
            if not np.isfinite(seen[-1]).all():
                raise Refused(LOST(movement=movement + 1), exit_status=1)
            missed.append(float(np.sqrt(((seen[-1] - target) ** 2).mean())))
        usual = float(proposal.expected[0])
        if pace is not None and corrections:
            done = Trials(proposal.winners, joints[0], seen[0], joints[1], seen[1])
            learn(net, target[None], done, pace)
            self._gaps = None
        findings: tuple[Diagnostic, ...] = ()
        if missed[-1] > max(MORE * usual, LEAST):
            findings = (NOT_THERE(seen=missed[-1], movements=1 + corrections, usual=usual),)
        return Reached(joints[-1][0], seen[-1][0], tuple(missed), findings)

    @property
    def gaps(self) -> Floats:
        """(n,) mean distance of each unit from its neighbours, in spreads."""
        if self._gaps is None:
            first, last = self._pairs.T
            apart = norms(self.net.places[first] - self.net.places[last])
            total, count = np.zeros(self.net.units), np.zeros(self.net.units)
            for ends in (first, last):
                np.add.at(total, ends, apart)
                np.add.at(count, ends, 1.0)
            self._gaps = total / np.maximum(count, 1.0)
        return self._gaps

    def _spread(self, winners: Rows, wanted: Floats, joints: Floats) -> Floats:
        net, squares, count = self.net, np.zeros(len(winners)), np.zeros(len(winners))
        places = np.stack(np.unravel_index(winners, net.shape))
        for axis, size in enumerate(net.shape):
            for step in (-1, 1):
                there = places.copy()
                there[axis] += step
                rows = np.flatnonzero((there[axis] >= 0) & (there[axis] < size))
                units = np.ravel_multi_index(tuple(there[:, rows]), net.shape)
                other = net.scale.joints(_answers(net, units, wanted[rows]))
                squares[rows] += ((other - joints[rows]) ** 2).mean(axis=1)
                count[rows] += 1.0
        return np.asarray(np.sqrt(squares / np.maximum(count, 1.0)))


def checked(net: ExtendedMap, targets: Floats) -> Floats:
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


def _answers(net: ExtendedMap, units: Rows, wanted: Floats) -> Floats:
    return np.asarray(net.angles[units] + times(net.slopes[units], wanted - net.places[units]))
