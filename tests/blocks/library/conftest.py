"""A bdsim that knows our blocks; quick commands."""

from __future__ import annotations

from typing import Any

import pytest

from assistant.controllers.mitsubishi.cr import Cr


@pytest.fixture
def sim() -> Any:
    return pytest.importorskip("bdsim").BDSim(
        packages="assistant", toolboxes=False, graphics=False, progress=False, quiet=True,
        sysargs=False, hold=False,
    )  # fmt: skip


@pytest.fixture(autouse=True)
def quick_commands(monkeypatch: pytest.MonkeyPatch) -> None:
    """A virtual controller needs no pause between commands while a program runs."""
    monkeypatch.setitem(Cr.__init__.__kwdefaults__, "pace", 0.01)
