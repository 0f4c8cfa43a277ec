"""What all of the room says."""

from __future__ import annotations

from assistant.base.diagnostics import error

NO_OPENCV = error(
    "VS001",
    "pictures are handled by the library OpenCV, which is not installed",
    "install the extra: pip install 'robot-assistant[vision]'",
)
