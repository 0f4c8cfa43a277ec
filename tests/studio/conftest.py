"""Studios of folders, and a browser."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.studio.scenes import cell
from tests.studio.serving import Page, served
from tests.view.test_browser import browser

__all__ = ["browser", "cell"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """An empty one, of which a studio is served."""
    made = tmp_path / "cell"
    made.mkdir()
    return made


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a studio that one test after another has."""
    with served(tmp_path_factory.mktemp("studio")) as found:
        yield found


@pytest.fixture
def address(shared: str, folder: Path) -> str:
    """Of a studio of the folder, which no window is open of."""
    opening = Page(shared)
    with opening.line() as line:
        while not opening.writes:  # windows of the test before this one are closing
            opening.hear(line)
        assert opening.post("project/open", folder=str(folder)).status == 200
    return shared


@pytest.fixture
def page(address: str) -> Iterator[Page]:
    """A page whose window writes."""
    made = Page(address)
    with made.line() as line:
        while not made.writes:
            made.hear(line)
        yield made
