"""Options of commands that prove by motion: how that is sought."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from assistant.base.diagnostics import Refused, error

if TYPE_CHECKING:
    from assistant.compiler.motion_proof import Proving

SIGNALS_WITHOUT_PROOF = error(
    "CL020", "--signals says nothing without --prove", "add --prove, or leave it out"
)


def proof_settings(wanted: bool, signals: Path | None, seed: int) -> Proving | None:
    """How a proof by motion is sought, None for none; raises Refused (exit status 2)."""
    from assistant.compiler.motion_proof import Proving

    if not wanted:
        if signals is not None:
            raise Refused(SIGNALS_WITHOUT_PROOF(), exit_status=2)
        return None
    return Proving(script=signals, seed=seed)
