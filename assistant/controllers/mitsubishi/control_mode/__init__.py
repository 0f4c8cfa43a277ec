"""Data link control mode: joint positions on one line, the status of the arm on another.

with ControlMode(controller, "192.168.0.20:10003", "192.168.0.20:10004", limits=limits) as mode:
    mode.follow(joints)
mode.recording.save("run.csv")
"""

from assistant.controllers.mitsubishi.control_mode.measuring import Measuring
from assistant.controllers.mitsubishi.control_mode.mode import ControlMode
from assistant.controllers.mitsubishi.control_mode.status import FORM, Status

__all__ = ["FORM", "ControlMode", "Measuring", "Status"]
