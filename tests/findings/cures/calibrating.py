"""Cures of what is told when an arm is calibrated by measured poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from tests.findings.cures.case import Case, sample
from tests.learning.calibration.truth import Truth, drawn, joints_of, placed, points_of

ARM: Final = "rv-2aj"
NAMES: Final = ("j1_deg", "j2_deg", "j3_deg", "j5_deg", "j6_deg", "x_mm", "y_mm", "z_mm")
MEASURED: Final = sample("calibration/rv-2aj.csv").decode()
CALIBRATE: Final = f"robots calibrate {ARM} m.csv -o mine.toml"


def table(truth: Truth, count: int, seed: int, names: Sequence[str] = NAMES) -> dict[str, str]:
    """Measured poses as a file."""
    joints = joints_of(truth.name, count, seed)
    rows = np.hstack([joints, points_of(truth, joints)])
    cells = (",".join(f"{value:.4f}" for value in row) for row in rows)
    return {"m.csv": "\n".join([",".join(names), *cells])}


def rows(count: int) -> dict[str, str]:
    """The first ones of the sample."""
    return {"m.csv": "\n".join(MEASURED.split("\n")[: count + 1])}


ALL: Final = {"m.csv": MEASURED}
KNOWN: Final = Truth(ARM, zeros=np.full(6, 0.2), tool=placed((40.0, -25.0, 90.0)))
TILTED: Final = table(drawn(ARM, 8, tilts=0.2), 60, 8)

LEARN: Final = f"learn {ARM} --point 30,0,60 --steps 20 --lattice 2x2x2 -o map.npz"

CASES: Final = (
    Case("LN009", LEARN, {}, (f"{LEARN} --tool free",)),
    Case("LN103", CALIBRATE, rows(7), (f"{CALIBRATE} --estimate zeros",), slow=True),
    Case(
        "LN112",
        CALIBRATE,
        table(KNOWN, 40, 5),
        (f"{CALIBRATE} --tool 40,-25,90 --in-base",),
        slow=True,
    ),
    Case(
        "LN114",
        f"{CALIBRATE} --estimate chain",
        table(drawn(ARM, 2), 13, 2),
        (f"{CALIBRATE} --estimate zeros",),
        slow=True,
    ),
    Case("LN116", CALIBRATE, TILTED, (f"{CALIBRATE} --estimate chain",), slow=True),
    Case("LN119", f"{CALIBRATE} --estimate chain", ALL, (f"{CALIBRATE} --estimate lengths",)),
)
