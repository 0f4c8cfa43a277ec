"""The nodes of lines, statements and expressions."""

from __future__ import annotations

from dataclasses import is_dataclass
from typing import Final

from assistant.languages.walking import Walk

_WALK: Final = Walk(is_dataclass)
nodes: Final = _WALK.nodes
inside: Final = _WALK.inside
