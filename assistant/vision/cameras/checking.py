"""Whether cameras are as they were calibrated: their pictures, and whether two of them agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic
from assistant.vision.cameras import rules
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.capture import Frame, exposure_findings
from assistant.vision.cameras.triangulating import triangulate


@dataclass(frozen=True, slots=True)
class Agreement:
    """How well two cameras agree on corners of a board that both see. corners: how many. pixels:
    root mean square left by the points. mm: the same of distances between neighbours, beside what
    the board says.
    """

    cameras: tuple[str, str]
    corners: int
    pixels: float
    mm: float


MOST_RESIDUAL = 1.0
"""Pixels from which on two cameras do not stand as they were calibrated."""


def check_agreement(
    cameras: Sequence[Camera], pixels: Sequence[Floats], corners: Floats
) -> tuple[Agreement, tuple[Diagnostic, ...]]:
    """Two cameras in the world that see the same corners. corners: (n, 3) mm on the board."""
    found = triangulate(cameras, pixels)
    names = (cameras[0].name, cameras[1].name)
    good = np.isfinite(found.residuals)
    if good.sum() < 2:
        told = rules.CAMERAS_DISAGREE(one=names[0], other=names[1], pixels=np.inf)
        return Agreement(names, 0, np.inf, np.inf), (told,)
    seen, known = found.points[good], corners[good]
    off = np.linalg.norm(np.diff(seen, axis=0), axis=1) - np.linalg.norm(
        np.diff(known, axis=0), axis=1
    )
    left = float(np.sqrt((found.residuals[good] ** 2).mean()))
    mm = float(np.sqrt((off**2).mean()))
    findings = (
        (rules.CAMERAS_DISAGREE(one=names[0], other=names[1], pixels=left),)
        if left > MOST_RESIDUAL
        else ()
    )
    return Agreement(names, int(good.sum()), left, mm), findings


def pictures_findings(
    cameras: Mapping[str, Camera], frames: Mapping[str, Frame]
) -> tuple[Diagnostic, ...]:
    """Dark and saturated pictures."""
    return tuple(
        one
        for name, frame in frames.items()
        for one in exposure_findings(cameras[name], frame.picture)
    )
