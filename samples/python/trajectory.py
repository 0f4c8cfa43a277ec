"""A Cartesian trajectory of the Robotics Toolbox, as programs for two makers, and its plot.

Needs `python -m pip install '.[plot,toolbox]'`; writes into the folder that it runs in.

    python trajectory.py positioning.png
"""

import sys
from pathlib import Path

from roboticstoolbox import ctraj
from spatialmath import SE3

import assistant
from assistant.program.se3 import columns_of
from assistant.report.figures import Poses, passed_poses, point_plot

start = SE3(0.25, -0.08, 0.3) * SE3.RPY(180, 0, 60, unit="deg")
end = SE3(0.3, 0.08, 0.24) * SE3.RPY(180, 0, 150, unit="deg")
poses = ctraj(start, end, 35)
program = assistant.from_poses(poses, unit="m", name="positioning", speed=150, blend=5)
points, arms = Poses(*columns_of(poses, unit="m")), {}
for robot, language in (("irb1200-7-0.7", "rapid"), ("rv-2aj", "melfa-basic-4")):
    print(*assistant.compile(program, language=language, robot=robot).write("."))
    samples = assistant.simulate(program, robot=robot).simulation.samples
    arms[robot] = passed_poses(points, Poses(samples.position, samples.quaternion))
    apart, turned = points.deviation(arms[robot])
    print(f"{robot} passes within {apart:.2f} mm and {turned:.2f} degrees")
Path(sys.argv[1]).write_bytes(point_plot(points, arms, "positioning", unit="m"))
