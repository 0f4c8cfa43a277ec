"""How closely the ways between targets are looked at, by whom, and why.

Each of them asks another question: what is close enough for one would be too coarse for the next,
or too slow. All take their poses from `along`.
"""

from __future__ import annotations

from typing import Final

import numpy as np


class TurnSampling:
    """`on_the_way`: how often the axes turn between targets, within reach and limits or not.

    Every program asks this of all its moves, so that most are answered by their ends.
    """

    WIDE: Final = 20.0
    """degrees or mm that an axis moves in one move from which on the way is looked at."""
    LONG: Final = 50.0
    """mm of a move from which on the way is looked at all the same."""
    BULGE: Final = 1.0
    """mm that an arc is off the straight line from which on it is looked at all the same."""
    SAMPLES: Final = np.array([3, 12, 40])
    """Poses on a way: the second for a line, and for an arc as few as leave bulges of about
    `BULGE` between them."""
    FINE: Final = 240
    """Parts of a way that is looked at again, since its poses leave a doubt."""
    LEAP: Final = 45.0
    """degrees or mm of an axis from pose to pose from which on more poses are looked at."""
    NEAR: Final = 2.0
    """degrees or mm from a limit, beside the largest step, from which on more are looked at."""
    STRETCHED: Final = 0.3
    """Sine of the elbow within which the end of the reach may be between two poses."""
    SPLIT: Final = 8
    """Parts of each stretch on which an axis still leaps, looked at again."""
    SPLITS: Final = 6
    """How often they are divided, for a tool that passes axis 1 at a micrometre."""
    PEAK: Final = 64
    """Parts between the poses beside a peak, where an axis turns back near to a limit."""


class PeakSampling:
    """`checks.extremes`: how fast the axes would have to be, and how near a singularity is.

    A finding tells the worst place, which beside a singularity is short; so there are more places
    the further the axes go.
    """

    STRAIGHT: Final = 5.0
    """degrees, or mm, of every axis up to which a move is looked at by its ends alone."""
    PARTS: Final = ((30.0, 24), (90.0, 64), (float("inf"), 192))
    """Up to so many degrees of an axis a move is looked at in so many parts."""
    MOST_PLACES: Final = 1_000_000
    """Places on the ways of a run; longer runs get fewer on each move."""
    MOST_FOLLOWED: Final = 20_000
    """The same for an arm without a closed form, which is solved by numbers, place by place."""
    LEAST_PARTS: Final = 4
    """Parts of a move in the longest runs."""
    UNEVEN: Final = 1.5
    """How much faster than on average a joint is somewhere in a move that is looked at again."""
    MOST_PARTS: Final = 1500
    """Parts at most of a move that is looked at again."""
    CLOSER: Final = 6
    """How often at most the fastest step of such a move is divided again."""
    CLOSER_PARTS: Final = 24
    """Parts that its fastest step is divided into."""
    FASTER: Final = 1.01
    """By how much that has to find it faster to be done once more."""


class TimeSampling:
    """`timing.knots`: how long a move takes, with the joints linear from knot to knot."""

    APART: Final = 10.0
    """mm between knots at most."""
    TURNED: Final = 1.5
    """degrees (or mm) that the tool or an axis turns between knots at most."""
    MOST: Final = 400
    """Steps of a move, and of a corner."""
    MOST_KNOTS: Final = 2_000_000
    """Steps of a way from which on long moves get fewer of them: about 300 bytes each."""
    SPANS: Final = 21
    """Parabolas of a corner at least; odd, so that its moves meet in the middle of one."""


class DrawingSampling:
    """`report.track`: pictures, in which nobody sees less than a few degrees of an arc."""

    ARC: Final = 24
    """Chords an arc is drawn with at least."""
    OFF: Final = 0.05
    """mm that they are off at most."""
    MOST: Final = 1000
    """Chords of an arc that is larger than any work."""
