"""Ends of programs for controllers that begin the next cycle behind an end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.rewording import Rewording

FOR_GOOD: Final = p.While(e.Number(1), (p.Stop(),))
"""A stop that a start does not lead out of: it goes on behind one that stands alone."""


def end_for_good(r: Rewording, node: p.Stop) -> Iterator[p.Statement]:
    """A stop in a loop for an end that is one for good."""
    if node.end and r.job.can.ended is not None:
        r.job.findings.append(r.job.can.ended())
        yield replace(FOR_GOOD, body=(p.Stop(span=node.span),), span=node.span)
    else:
        yield node
