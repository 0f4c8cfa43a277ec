"""What RAPID writes of targets and loads."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.languages.rapid import rules
from assistant.languages.rapid.lower.data import NO_LOAD
from assistant.languages.rapid.lower.expressions import RECORDS
from assistant.languages.rapid.tables.words import UNUSED
from assistant.languages.records import load_of
from assistant.program.geometry import Load
from assistant.program.motion import UNSTATED
from assistant.program.passes.legalisation import Loads, Positions


def _stated_branches(branches: NDArray[np.int8]) -> NDArray[np.int8]:
    """Arm branches (n, 6) with zeros for unstated ones."""
    return np.where(branches[:, :1] == UNSTATED, np.int8(0), branches)


def _written_load(load: Load) -> Load:
    return load_of(*RECORDS.values(load))


LOADS: Final = Loads(
    least=NO_LOAD, missing=rules.NO_LOAD, centre="0.001 mm before the flange", written=_written_load
)
POSITIONS: Final = Positions(
    decimals=RECORDS.joint,
    not_finite=rules.NOT_FINITE,
    branches=_stated_branches,
    unstated=rules.NO_CONFIGURATION,
    unused=UNUSED,
    quaternions=True,
    padded=True,
    loads=LOADS,
)
