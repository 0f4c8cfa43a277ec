"""Robots from URDF files: the chain of joints from the base to the flange."""

from __future__ import annotations

from assistant.robots.urdf.reading import Drawn, read

__all__ = ["Drawn", "read"]
