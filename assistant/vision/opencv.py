"""OpenCV, installed by the extra `vision`; it is loaded for the first picture."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, Final

from assistant.base.diagnostics import Refused
from assistant.vision.rules import NO_OPENCV

MOST_PIXELS: Final = 100_000_000
"""Largest number of pixels of a picture; a small file can claim any number of them."""


@lru_cache(maxsize=1)
def opencv() -> Any:
    """The module; raises Refused where it is not installed."""
    os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(MOST_PIXELS))  # read when it is loaded
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # of what it says itself, nothing
    try:
        import cv2
    except ImportError:
        raise Refused(NO_OPENCV(), exit_status=2) from None
    return cv2


@contextmanager
def silent() -> Iterator[Any]:
    """Yield OpenCV without its messages about files that cannot be opened or read."""
    cv = opencv()
    before = cv.utils.logging.setLogLevel(cv.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield cv
    finally:
        cv.utils.logging.setLogLevel(before)
