"""Robots from URDF files: the chain of joints from the base to the flange."""

from __future__ import annotations

from assistant.robots.urdf.reading import MOST_AXES, Drawn, read

__all__ = ["MOST_AXES", "Drawn", "read"]
