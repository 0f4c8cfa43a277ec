"""Robots: the catalogue, kinematics, configurations, and what a program asks of an arm."""

from __future__ import annotations

from assistant.robots.catalogue import get, load, names
from assistant.robots.configure import configure
from assistant.robots.robot import Robot

__all__ = ["Robot", "configure", "get", "load", "names"]
