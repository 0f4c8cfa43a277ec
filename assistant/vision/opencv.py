"""OpenCV, which the extra `vision` brings; it is loaded when a picture is looked at."""

from __future__ import annotations

from typing import Any

from assistant.program.diagnostics import Refused
from assistant.vision.rules import NO_LIBRARY


def opencv() -> Any:
    """The module; raises Refused where it is not installed."""
    try:
        import cv2
    except ImportError:
        raise Refused(NO_LIBRARY(), exit_status=2) from None
    return cv2
