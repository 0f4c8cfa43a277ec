"""Externally Guided Motion (EGM): an ABB arm led cycle by cycle over UDP, each 4 ms.

report = guide("192.168.125.1", Trajectory.of_joints(joints), Limits(speeds))
report.save("run.csv")
"""

from assistant.controllers.abb.egm.guidance import guide
from assistant.controllers.abb.egm.link import Egm

__all__ = ["Egm", "guide"]
