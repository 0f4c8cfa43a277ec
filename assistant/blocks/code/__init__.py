"""Generated code: the kinematics of an arm as plain source that needs nothing of ours."""

from __future__ import annotations

from assistant.blocks.code.kinematics import LANGUAGES, SourceNames, kinematics, source_of

__all__ = ["LANGUAGES", "Named", "kinematics", "source_of"]
