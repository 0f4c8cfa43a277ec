"""Cyclic control of an arm, one command for each packet of the controller, for any maker.

`trajectory` resamples a trajectory to the cycle, `process` starts a process that runs the `loop` of
`worker` and follows the trajectory or leads by corrections, `setpoint_source` gives the row of each
cycle, and `link` is the interface that the packets of a maker have to answer.
"""

from __future__ import annotations

from assistant.controllers.cyclic.loop import Delays, Endpoint, Link, Measured, Report, Timing
from assistant.controllers.cyclic.process import Ended, Leading, Progress, follow
from assistant.controllers.cyclic.setpoint_source import Settings
from assistant.controllers.cyclic.trajectory import ArmLimits, Limits, Trajectory, resampled

__all__ = [
    "ArmLimits",
    "Delays",
    "Ended",
    "Endpoint",
    "Leading",
    "Limits",
    "Link",
    "Measured",
    "Progress",
    "Report",
    "Settings",
    "Timing",
    "Trajectory",
    "follow",
    "resampled",
]
