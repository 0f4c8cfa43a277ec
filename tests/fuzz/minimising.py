"""Inputs that fail, made small: what can be left out while it fails in the same way."""

from __future__ import annotations

import os
import re
import time
from typing import Final

from tests.fuzz.state import kind_of
from tests.fuzz.target import Target

SECONDS: Final = 60.0
"""After which the smallest so far is taken."""


def minimised(target: Target, data: bytes) -> bytes:
    """The smallest input found that fails like this one; this one if it does not fail."""
    os.environ["ROBOT_ASSISTANT_TRACEBACK"] = "1"
    wanted = failure(target, data)
    if wanted is None:
        return data
    end = time.monotonic() + SECONDS
    for pattern in (rb"[^\n]*\n?", rb"\w+|\s+|.", rb"."):
        parts = re.findall(pattern, data, re.DOTALL)
        size = max(1, len(parts) // 2)
        while time.monotonic() < end:
            at, before = 0, len(parts)
            while at < len(parts) and time.monotonic() < end:
                fewer = parts[:at] + parts[at + size :]
                if failure(target, b"".join(fewer)) == wanted:
                    parts = fewer
                else:
                    at += size
            if size == 1 and len(parts) == before:
                break
            size = max(1, size // 2)
        data = b"".join(parts)
    return data


def failure(target: Target, data: bytes) -> str | None:
    """How an input fails, None if it does not."""
    try:
        target.run(data)
    except Exception as error:
        return kind_of(error)
    return None
