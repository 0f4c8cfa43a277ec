"""OpenCV, which recognition looks at pictures with."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assistant.program.diagnostics import Refused
from assistant.vision.recognition.rules import NO_OPENCV

if TYPE_CHECKING:
    from types import ModuleType


def opencv() -> ModuleType:
    """The library; raises Refused, naming the extra, without it."""
    try:
        import cv2
    except ImportError:
        raise Refused(NO_OPENCV(), exit_status=2) from None
    return cv2
