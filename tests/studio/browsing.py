"""The studio in a real browser."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final

from tests.view.test_browser import until

__all__ = ["clean", "studio_page", "until"]

WIDE: Final = {"width": 1280, "height": 800}
TABLET: Final = {"width": 820, "height": 1180}
SECONDS: Final = 15_000.0
"""Milliseconds that a page has for whatever is waited for."""


@contextmanager
def studio_page(
    browser: Any, address: str, size: Mapping[str, int] = WIDE, **options: Any
) -> Iterator[Any]:
    """A window of the studio that is ready to write. options: of a context of playwright."""
    context = browser.new_context(viewport=dict(size), **{"locale": "en", **options})
    page = context.new_page()
    page.set_default_timeout(SECONDS)
    page.wrong = []
    page.on("console", lambda said: page.wrong.append(said.text))
    page.on("pageerror", lambda fault: page.wrong.append(str(fault)))
    page.on("request", lambda asked: _own(page, asked.url, address))
    try:
        page.goto(address)
        page.wait_for_selector("body.ready")
        until(page, "!document.body.classList.contains('reads')")
        yield page
    finally:
        context.close()


def _own(page: Any, url: str, address: str) -> None:
    """Nothing is fetched from outside."""
    ours = (address, address.replace("http", "ws", 1), "data:", "blob:")
    if not url.startswith(ours):
        page.wrong.append(f"asked {url}")


@contextmanager
def clean(page: Any) -> Iterator[None]:
    """Nothing goes wrong on the page, and it asks nobody else."""
    yield
    assert page.wrong == []
