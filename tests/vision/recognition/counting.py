"""What was found, beside what is there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from assistant.base import rotations
from assistant.base.diagnostics import has_errors
from assistant.vision.recognition.pose_estimation import Plane
from assistant.vision.recognition.recogniser import FoundObject, Recogniser, face_centre
from tests.vision.recognition.scenes import ABOVE, Truth, scene, taken

EXACT = Plane(sigma=0.01, sigma_deg=0.005)
"""Drawn things lie on it exactly."""
FREE = [0, 1, 5]
"""x, y and the turn about z, which pictures tell of what lies on a plane."""
NEAR = 5.0
"""mm from where an object is, beyond which another one is found."""


@dataclass
class Counts:
    """wrong: found and not there; missed: there and not found; doubted: found, and told not to be
    acted on."""

    right: int = 0
    wrong: list[str] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)
    doubted: int = 0
    mm: list[float] = field(default_factory=list)
    degrees: list[float] = field(default_factory=list)
    distances: list[float] = field(default_factory=list)
    textured: list[bool] = field(default_factory=list)

    @property
    def precision(self) -> float:
        return self.right / max(self.right + len(self.wrong), 1)

    @property
    def recall(self) -> float:
        return self.right / max(self.right + len(self.missed), 1)

    def figures(self) -> str:
        said = [
            f"precision {self.precision:.3f}, recall {self.recall:.3f} of "
            f"{self.right + len(self.missed)} objects, {self.doubted} doubted"
        ]
        for name, kind in (("outlines", False), ("textures", True)):
            rows = np.array(self.textured) == kind
            if rows.any():
                mm, degrees = np.array(self.mm)[rows], np.array(self.degrees)[rows]
                away = np.array(self.distances)[rows]
                said.append(
                    f"{name}: mean {mm.mean():.3f} mm and {degrees.mean():.3f} degrees off, worst "
                    f"{mm.max():.2f} mm and {degrees.max():.2f}; squared Mahalanobis distance "
                    f"{away.mean():.2f} of 3"
                )
        return "; ".join(said)


def counted(
    recogniser: Recogniser, seeds: Sequence[int], lib, known: int = 6, strange: int = 3
) -> Counts:
    counts = Counts()
    for seed in seeds:
        drawn = scene(seed, lib, known, strange)
        sight = recogniser.see({"above": taken(ABOVE, drawn, seed)}, {"above": ABOVE}, EXACT)
        doubted = {
            one.name
            for one in sight.found
            for finding in sight.findings
            if has_errors([finding]) and f"`{one.name}`" in finding.message
        }
        add(counts, sight.found, drawn.truth, doubted)
    return counts


def add(
    counts: Counts,
    found: Sequence[FoundObject],
    truth: Sequence[Truth],
    doubted: set[str] = frozenset(),
) -> None:
    left = list(truth)
    for one in found:
        middle = face_centre(one.object)[None]
        at = one.pose.moved(middle)[0]
        hit = next(
            (
                t
                for t in left
                if t.known.name == one.object.name
                and np.linalg.norm(t.pose.moved(middle)[0] - at) < NEAR
            ),
            None,
        )
        if hit is None:
            counts.wrong.append(one.name)
            continue
        left.remove(hit)
        counts.right += 1
        if one.name in doubted:
            counts.doubted += 1
            continue
        off = difference(one, hit)
        counts.mm.append(float(np.linalg.norm(at - hit.pose.moved(middle)[0])))
        counts.degrees.append(float(np.linalg.norm(off[3:])))
        covariance = one.estimate.covariance[np.ix_(FREE, FREE)]
        counts.distances.append(float(off[FREE] @ np.linalg.solve(covariance, off[FREE])))
        counts.textured.append(one.object.texture is not None)
    counts.missed += [one.known.name for one in left]


def difference(found: FoundObject, truth: Truth) -> np.ndarray:
    """(6,) mm and degrees about the axes of the world."""
    turns = rotations.turns(np.array(truth.pose.quaternion), np.array(found.pose.quaternion))
    return np.concatenate([np.array(found.pose.position) - truth.pose.position, np.degrees(turns)])
