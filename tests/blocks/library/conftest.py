"""A bdsim that knows our blocks."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.fixture
def sim() -> Any:
    return pytest.importorskip("bdsim").BDSim(
        packages="assistant", toolboxes=False, graphics=False, progress=False, quiet=True,
        sysargs=False, hold=False,
    )  # fmt: skip
