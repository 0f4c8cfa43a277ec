"""All targets. A module of targets has a `TARGETS` of its own, which is named here."""

from __future__ import annotations

from typing import Final

from tests.fuzz import answering, command, crossing, files, programs, serving
from tests.fuzz.target import Target
from tests.fuzz.valid import targets as valid

TARGETS: Final[dict[str, Target]] = {
    target.name: target
    for module in (programs, crossing, valid, files, answering, serving, command)
    for target in module.TARGETS
}
"""By name, in the order in which they are run."""
