"""Draws the icons of our blocks for the editor of bdsim, where that looks for them.

python -m docs.icons

It wants a PNG of 250 by 250 for each class, named by it in small letters: black on nothing.
"""

from __future__ import annotations

import io
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

FOLDER: Final = Path(__file__).parent.parent / "assistant" / "blocks" / "Icons"
SIZE: Final = 250
Stroke = NDArray[np.float64]
"""(n, 2) points of a line in a square from 0 to 1."""


def _stroke(*points: tuple[float, float]) -> Stroke:
    return np.array(points, dtype=np.float64)


def _bow(start: tuple[float, float], by: tuple[float, float], end: tuple[float, float]) -> Stroke:
    """A bent way between two points, drawn towards a third."""
    t = np.linspace(0.0, 1.0, 40)[:, None]
    a, b, c = (np.array(one) for one in (start, by, end))
    return np.asarray((1.0 - t) ** 2 * a + 2.0 * t * (1.0 - t) * b + t**2 * c)


def _ring(x: float, y: float, radius: float = 0.16) -> Stroke:
    turn = np.linspace(0.0, 2.0 * np.pi, 40)
    return np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)])


@dataclass(frozen=True, slots=True)
class Icon:
    """strokes, dots: of what is drawn. text: formula of mathtext; at: where its middle is."""

    text: str = ""
    strokes: Sequence[Stroke] = ()
    dots: Sequence[tuple[float, float]] = ()
    at: tuple[float, float] = (0.5, 0.5)
    size: float = 58.0


START, END = (0.12, 0.2), (0.72, 0.5)
BENT: Final = _bow(START, (0.2, 0.72), END)
STRAIGHT: Final = _stroke(START, END)
ROUND: Final = np.column_stack(
    [
        0.5 - 0.36 * np.cos(np.linspace(0.0, np.pi, 40)),
        0.3 + 0.36 * np.sin(np.linspace(0.0, np.pi, 40)),
    ]
)
ARM: Final = _stroke((0.2, 0.12), (0.2, 0.36), (0.42, 0.78), (0.76, 0.62), (0.82, 0.4))
TABLE: Final = tuple(
    [_stroke((0.15, y), (0.85, y)) for y in (0.2, 0.4, 0.6, 0.8)]
    + [_stroke((x, 0.2), (x, 0.8)) for x in (0.15, 0.4, 0.85)]
)


def _move(way: Stroke, goal: str) -> Icon:
    return Icon(f"${goal}$", [way], [START, END], (0.8, 0.8))


FRAME: Final = _stroke((0.14, 0.22), (0.14, 0.7), (0.86, 0.7), (0.86, 0.22), (0.14, 0.22))
STEPS: Final = _stroke(
    *[(0.14 + 0.18 * k + d, 0.18 + 0.16 * k + r) for k in range(4) for d, r in ((0, 0), (0, 0.16))],
    (0.86, 0.82),
)
FINGERS: Final = (
    _stroke((0.5, 0.9), (0.5, 0.68)),
    _stroke((0.26, 0.16), (0.26, 0.68), (0.74, 0.68), (0.74, 0.16)),
)

ICONS: Final[Mapping[str, Icon]] = {
    "JointMovJoint": _move(BENT, "q"),
    "JointMovCart": _move(BENT, "T"),
    "LinMovJoint": _move(STRAIGHT, "q"),
    "LinMovCart": _move(STRAIGHT, "T"),
    "CircularMov": Icon("", [ROUND], [(0.14, 0.3), (0.5, 0.66), (0.86, 0.3)]),
    "Status": Icon("", [ROUND, _stroke((0.5, 0.3), (0.72, 0.62))], [(0.5, 0.3)]),
    "RelJoint": Icon(r"$\Delta q$"),
    "RelCart": Icon(r"$\Delta T$"),
    "ArmFK": Icon("$T(q)$"),
    "ArmIK": Icon("$q(T)$"),
    "ArmJacobian": Icon("$J(q)$"),
    "SimArm": Icon("", [ARM], [(0.2, 0.36), (0.42, 0.78), (0.76, 0.62)]),
    "MotionTable": Icon("$t$", TABLE, (), (0.275, 0.7), 28.0),
    "PoseLine": Icon("", [_stroke((0.16, 0.24), (0.84, 0.76))], [(0.16, 0.24), (0.84, 0.76)]),
    "PoseToSE3": Icon(r"$\to$SE3", size=44.0),
    "SE3ToPose": Icon(r"SE3$\to$", size=44.0),
    "ExternalControl": Icon("", [STEPS]),
    "ExchangedPose": Icon("$T$", [_stroke((0.12, 0.25), (0.88, 0.25))], (), (0.5, 0.6), 58.0),
    "InputSignals": Icon("", [_stroke((0.1, 0.5), (0.6, 0.5)), _ring(0.74, 0.5)]),
    "OutputSignal": Icon("", [_stroke((0.4, 0.5), (0.9, 0.5)), _ring(0.26, 0.5)]),
    "Gripper": Icon("", FINGERS),
    "ProjectedMarker": Icon("$uv$", [FRAME], (), (0.5, 0.44), 40.0),
    "SeenMarker": Icon("", [FRAME, _ring(0.5, 0.46)]),
    "PointingDevice": Icon("", [_stroke((0.2, 0.15), (0.62, 0.62)), _ring(0.74, 0.74)]),
    "CollisionDistance": Icon(
        "", [_stroke((0.34, 0.5), (0.66, 0.5)), _ring(0.2, 0.5, 0.12), _ring(0.8, 0.5, 0.12)]
    ),
}
"""What each block looks like, by the name of its class."""


def drawn(icon: Icon) -> bytes:
    """It as PNG."""
    from matplotlib.figure import Figure
    from PIL import Image

    figure = Figure(figsize=(2.5, 2.5), dpi=SIZE / 2.5)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.axis("off")
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    for stroke in icon.strokes:
        axes.plot(*stroke.T, color="black", lw=9.0, solid_capstyle="round", solid_joinstyle="round")
    for x, y in icon.dots:
        axes.plot([x], [y], "o", color="black", ms=24.0)
    axes.text(*icon.at, icon.text, fontsize=icon.size, ha="center", va="center", color="black")
    out, small = io.BytesIO(), io.BytesIO()
    figure.savefig(out, format="png", transparent=True, metadata={"Software": None})
    Image.open(out).convert("LA").convert("RGBA").save(small, "PNG", optimize=True)
    return small.getvalue()


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    for name, icon in ICONS.items():
        (FOLDER / f"{name.lower()}.png").write_bytes(drawn(icon))
    sys.stdout.write(f"{len(ICONS)} icons in {FOLDER}\n")


if __name__ == "__main__":
    main()
