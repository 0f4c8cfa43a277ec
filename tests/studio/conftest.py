"""Studios of folders, and a browser."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.studio.serving import Page, served
from tests.view.test_browser import browser

__all__ = ["browser"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """An empty one, of which a studio is served."""
    made = tmp_path / "cell"
    made.mkdir()
    return made


@pytest.fixture
def address(folder: Path) -> Iterator[str]:
    """Of the studio."""
    with served(folder) as found:
        yield found


@pytest.fixture
def page(address: str) -> Iterator[Page]:
    """A page whose window writes."""
    made = Page(address)
    with made.line():
        yield made
