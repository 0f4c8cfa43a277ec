"""The saved map of the three-joint experiment: `python -m tests.learning.maps.small` makes it."""

from __future__ import annotations

from pathlib import Path

from assistant.learning.maps.experiments import three_joints
from assistant.learning.maps.map_file import save
from assistant.learning.maps.training import trained, usual

SMALL = Path(__file__).parent / "data" / "three_joints.npz"
STEPS = 30_000

if __name__ == "__main__":
    made = three_joints()
    net = made.start()
    trained(net, made.arm, made.space, usual(STEPS))
    save(net, SMALL)
