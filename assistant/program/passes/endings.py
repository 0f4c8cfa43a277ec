"""Ends of programs for controllers that begin the next cycle behind an end."""

from __future__ import annotations

from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p

FOR_GOOD: Final = p.While(e.Number(1), (p.Stop(),))
"""A stop that a start does not lead out of: it goes on behind one that stands alone."""
