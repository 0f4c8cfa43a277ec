"""Robots: the catalogue, kinematics, configurations, and what a program asks of an arm."""

from __future__ import annotations

from assistant.robots.catalogue import get, load, names
from assistant.robots.configure import configure, journey
from assistant.robots.robot import Robot
from assistant.robots.solved_program import Journey

__all__ = ["Journey", "Robot", "configure", "get", "journey", "load", "names"]
