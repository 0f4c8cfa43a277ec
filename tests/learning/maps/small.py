"""The saved map of the three-joint experiment: `python -m tests.learning.maps.small` makes it."""

from __future__ import annotations

from pathlib import Path

from assistant.learning.experiments import three_joints
from assistant.learning.map_file import save_map
from assistant.learning.map_training import train_and_measure, usual_plan

SMALL = Path(__file__).parent / "data" / "three_joints.npz"
STEPS = 30_000

if __name__ == "__main__":
    made = three_joints()
    net = made.start()
    train_and_measure(net, made.arm, made.space, usual_plan(STEPS))
    save_map(net, SMALL)
