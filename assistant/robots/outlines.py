"""What a file of a robot says its links look like: shapes and names of mesh files, none of them
opened.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from assistant.base.diagnostics import Diagnostic
from assistant.program.geometry import Pose, Vector

Kind = Literal["box", "sphere", "cylinder", "capsule", "mesh"]


@dataclass(frozen=True, slots=True)
class Outline:
    """A shape of a link.

    carrier: `base`, `J1` … or `flange`; pose: in its frame, see `Robot.link_frames`. sizes: mm; of
    a box its edges, of a sphere its radius, of a cylinder and a capsule radius and length (of the
    capsule between its half spheres). file: of a mesh in metres, as the robot's file names it, and
    scale, by which its coordinates are multiplied.
    """

    link: str
    carrier: str
    pose: Pose
    kind: Kind
    sizes: tuple[float, ...] = ()
    file: str = ""
    scale: Vector = (1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Outlines:
    """Shapes of the links of a robot.

    folder: that relative names of files go from. wrong: shapes that are none. still: joints that
    move, but are no axes of the arm, so that what hangs on them is where it is with them at 0.
    """

    shapes: tuple[Outline, ...]
    folder: str
    wrong: tuple[Diagnostic, ...] = ()
    still: tuple[str, ...] = ()
