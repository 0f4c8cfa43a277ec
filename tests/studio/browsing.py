"""The studio in a real browser."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final

import pytest

WIDE: Final = {"width": 1280, "height": 800}
TABLET: Final = {"width": 820, "height": 1180}
LONGEST: Final = 120_000.0
"""Milliseconds that a page has for whatever is waited for."""
STEP: Final = 50.0


@contextmanager
def studio_page(
    browser: Any, address: str, size: Mapping[str, int] = WIDE, **options: Any
) -> Iterator[Any]:
    """A window of the studio that is ready to write. options: of a context of playwright.

    It has `wrong`, what its console said, but for refusals that a browser logs by their status.
    """
    context = browser.new_context(viewport=dict(size), **{"locale": "en", **options})
    page = context.new_page()
    page.set_default_timeout(LONGEST)
    page.wrong = []
    page.on("console", lambda said: "status of 422" in said.text or page.wrong.append(said.text))
    page.on("pageerror", lambda fault: page.wrong.append(str(fault)))
    page.on("request", lambda asked: _own(page, asked.url, address))
    try:
        page.goto(address)
        page.wait_for_selector("body.ready")
        until(page, "!document.body.classList.contains('reads')")
        yield page
    finally:
        context.close()


def until(page: Any, what: str) -> None:
    """Waits for what JavaScript tells; playwright's own way is not allowed on the page."""
    for _ in range(int(LONGEST / STEP)):
        if page.evaluate(what):
            return
        page.wait_for_timeout(STEP)
    pytest.fail(f"not within {LONGEST / 1000:.0f} s: {what}")


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
