"""Motion that is commanded cycle by cycle, whosever controller it is.

`trajectory.py` brings a trajectory to the cycle, `process.py` starts a process that sends it by
`loop.py`, paced by the controller's packets; `leading.py` leads by corrections that are worked out
meanwhile; `link.py` is what a maker's packets have to answer.
"""

from assistant.controllers.cyclic.leading import Leading
from assistant.controllers.cyclic.link import Endpoint, Link, Measured
from assistant.controllers.cyclic.process import Ended, Progress, follow
from assistant.controllers.cyclic.report import Delays, Report, Timing
from assistant.controllers.cyclic.settings import Settings
from assistant.controllers.cyclic.space import ArmLimits, Limits
from assistant.controllers.cyclic.trajectory import Trajectory, resampled

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
