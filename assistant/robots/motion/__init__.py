"""The motion of an arm along runs of moves: arm branches, whole turns, reach and joints."""

from __future__ import annotations
