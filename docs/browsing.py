"""The system's Chromium, which takes pictures of pages."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Final

BROWSERS: Final = ("chromium", "chromium-browser", "google-chrome")
PLAIN: Final = ("--no-sandbox",)
WITHOUT_CARD: Final = (*PLAIN, "--enable-unsafe-swiftshader")
"""As people start it who have no graphics card: scenes may be drawn by the processor."""
SOFTWARE: Final = (
    *WITHOUT_CARD,
    *("--use-gl=angle", "--use-angle=swiftshader", "--ignore-gpu-blocklist"),
)
"""The whole page is put together as if there were a card: slower, with nothing on its console."""


def installed() -> str | None:
    """The path of the browser of this computer."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


@contextmanager
def chromium(arguments: Sequence[str] = SOFTWARE) -> Iterator[Any]:
    """The browser, for as long as the context; raises SystemExit where there is none."""
    from playwright.sync_api import sync_playwright

    found = installed()
    if found is None:
        raise SystemExit("there is no Chromium here: install it by the system's packages")
    with sync_playwright() as one:
        opened = one.chromium.launch(executable_path=found, args=list(arguments))
        try:
            yield opened
        finally:
            opened.close()
