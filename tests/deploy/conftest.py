"""Deployments start in an empty folder, as a record holds the commit of the working folder."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def outside_of_a_repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Asking git about this project takes longer than a deployment to a virtual controller."""
    monkeypatch.chdir(tmp_path)
