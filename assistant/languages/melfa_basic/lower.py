"""From the pseudo-program to the tree: `adapt` finds the words, `build` writes them."""

from __future__ import annotations

from assistant.languages.melfa_basic.adapt import adapt
from assistant.languages.melfa_basic.build import build

__all__ = ["adapt", "build"]
