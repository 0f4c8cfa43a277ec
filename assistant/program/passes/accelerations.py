"""Accelerations, for a language with one value for speeding up and braking."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.rewording import Rewording


def one_acceleration(r: Rewording, node: p.SetAcceleration) -> Iterator[p.Statement]:
    """The smaller of two values for both, not less than the language takes."""
    one, two, can = node.acceleration, node.deceleration, r.job.can.acceleration
    if can is None:
        yield node
        return
    value = one
    if isinstance(one, e.Number) and isinstance(two, e.Number):
        least = max(min(one.value, two.value), can.least)
        if (least, least) != (one.value, two.value):
            r.job.changed(
                f"acceleration {one.value} and deceleration {two.value} percent",
                f"{least} percent for both",
                can.cure_of_least,
            )
        value = e.Number(least)
    elif one != two:
        r.job.changed("the deceleration", "the acceleration", can.cure)
    yield replace(node, acceleration=value, deceleration=value)
