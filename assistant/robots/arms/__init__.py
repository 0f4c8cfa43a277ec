"""Kinds of arms: each with its kinematics, its branches and their descriptions."""

from __future__ import annotations

from assistant.robots.arms.arm import Arm, Joint, Link
from assistant.robots.arms.closed_form import FiveAxis, Lengths, Scara, SixAxis
from assistant.robots.arms.serial import Serial
from assistant.robots.arms.spherical_wrist import Placed

__all__ = ["Arm", "FiveAxis", "Joint", "Lengths", "Link", "Placed", "Scara", "Serial", "SixAxis"]
