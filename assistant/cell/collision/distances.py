"""Signed distances between shapes: in closed form where both are round or boxes, else by coal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths
from assistant.cell.collision.closed_forms import (
    NearestPoints,
    box_distances,
    capsule_box_distances,
    capsule_distances,
)
from assistant.cell.collision.geometry import coal_geometry, coal_library, distance_request
from assistant.cell.collision.insides import InsideTest
from assistant.cell.shapes import Box, Capsule, Mesh, Shape, Sphere

WorldPoses = tuple[Floats, Floats]
"""Places (k, 3) mm and turns (k, 3, 3) of k shapes in the world."""


class Distances:
    """Distances of shapes by their numbers. Pairs that are not `closed` need the library coal."""

    def __init__(self, shapes: Sequence[Shape]) -> None:
        self.shapes = tuple(shapes)
        round_ = [isinstance(shape, Sphere | Capsule) for shape in self.shapes]
        self._round: Truths = np.array(round_, dtype=bool)
        self._boxed: Truths = np.array([isinstance(s, Box) for s in self.shapes], dtype=bool)
        self._radii: Floats = np.array([float(getattr(s, "radius", 0.0)) for s in self.shapes])
        sizes = [s.size if isinstance(s, Box) else (0.0, 0.0, 0.0) for s in self.shapes]
        self._halves: Floats = np.array(sizes, dtype=np.float64).reshape(-1, 3) / 2.0
        lengths = [s.length / 2.0 if isinstance(s, Capsule) else 0.0 for s in self.shapes]
        self._lengths: Floats = np.array(lengths)

    def closed(self, one: Rows, other: Rows) -> Truths:
        """(k,) whether the distances of shapes one (k,) and other (k,) have a closed form."""
        form = self._round | self._boxed
        return form[one] & form[other]

    def signed(self, one: Rows, other: Rows, at_one: WorldPoses, at_other: WorldPoses) -> Floats:
        """(k,) mm between shapes one (k,) and other (k,), below 0 the depth of the contact."""
        out = np.empty(len(one))
        for some, found in self._closed_forms(one, other, at_one, at_other):
            out[some] = found.distance
        rest = np.flatnonzero(~self.closed(one, other))
        if len(rest):
            out[rest] = self._by_library(
                one[rest], other[rest], _of(at_one, rest), _of(at_other, rest)
            )
        return out

    def nearest(
        self, one: int, other: int, at_one: WorldPoses, at_other: WorldPoses
    ) -> NearestPoints:
        """Distance of one pair, with its points and its normal in the world."""
        i, o = np.array([one]), np.array([other])
        for _, found in self._closed_forms(i, o, at_one, at_other):
            return found
        frames = [self._frame(at[0][0], at[1][0]) for at in (at_one, at_other)]
        distance = self._distance(one, other, *frames)
        points = self._result.getNearestPoint1(), self._result.getNearestPoint2()
        normal = np.array([self._result.normal])
        return NearestPoints(
            np.array([distance]), np.array([points[0]]), np.array([points[1]]), normal
        )

    # ------------------------------------------------------------------------- closed forms

    def _closed_forms(
        self, one: Rows, other: Rows, at_one: WorldPoses, at_other: WorldPoses
    ) -> Iterator[tuple[Rows, NearestPoints]]:
        """Which of k pairs (m,), and their distances, points and normals in the world."""
        round_one, round_other = self._round[one], self._round[other]
        box_one, box_other = self._boxed[one], self._boxed[other]
        some = np.flatnonzero(round_one & round_other)
        if len(some):
            i, o = one[some], other[some]
            radii = np.stack([self._radii[i], self._radii[o]], axis=1)
            segments = self._segment(i, _of(at_one, some)), self._segment(o, _of(at_other, some))
            yield some, capsule_distances(*segments, radii)
        some = np.flatnonzero(round_one & box_other)
        if len(some):
            yield some, self._of_box(one[some], other[some], _of(at_one, some), _of(at_other, some))
        some = np.flatnonzero(box_one & round_other)
        if len(some):
            back = self._of_box(other[some], one[some], _of(at_other, some), _of(at_one, some))
            yield some, NearestPoints(back.distance, back.other, back.one, -back.normal)
        some = np.flatnonzero(box_one & box_other)
        if len(some):
            (p, turn), (p_other, turn_other) = _of(at_one, some), _of(at_other, some)
            relative = np.einsum("kji,kjl->kil", turn, turn_other)
            place = np.einsum("kji,kj->ki", turn, p_other - p)
            found = box_distances(
                relative, place, self._halves[one[some]], self._halves[other[some]]
            )
            yield some, _transforms(found, p, turn)

    def _segment(self, shape: Rows, at: WorldPoses) -> tuple[Floats, Floats]:
        along = at[1][:, :, 2] * self._lengths[shape][:, None]
        return at[0] - along, at[0] + along

    def _of_box(
        self, capsule: Rows, box: Rows, at_capsule: WorldPoses, at_box: WorldPoses
    ) -> NearestPoints:
        place, turn = at_box
        ends = self._segment(capsule, at_capsule)
        p0, p1 = (np.einsum("kji,kj->ki", turn, end - place) for end in ends)
        found = capsule_box_distances(p0, p1, self._halves[box], self._radii[capsule])
        return _transforms(found, place, turn)

    # ----------------------------------------------------------------------------- by coal

    @cached_property
    def _result(self) -> Any:
        return coal_library().DistanceResult()

    @cached_property
    def _request(self) -> Any:
        return distance_request()

    @cached_property
    def _geometries(self) -> dict[int, Any]:
        return {}

    def _geometry(self, shape: int) -> Any:
        if shape not in self._geometries:
            self._geometries[shape] = coal_geometry(self.shapes[shape])
        return self._geometries[shape]

    @cached_property
    def _inside(self) -> InsideTest | None:
        """None without closed meshes: their triangles are a surface, with nothing inside."""
        solid = any(isinstance(shape, Mesh) and shape.solid for shape in self.shapes)
        return InsideTest(self.shapes) if solid else None

    @staticmethod
    def _frame(place: Floats, turn: Floats) -> Any:
        return coal_library().Transform3s(turn, place)

    def _by_library(
        self, one: Rows, other: Rows, at_one: WorldPoses, at_other: WorldPoses
    ) -> Floats:
        make = coal_library().Transform3s
        frames = [
            [make(turn, place) for place, turn in zip(*at, strict=True)]
            for at in (at_one, at_other)
        ]
        pairs = zip(one.tolist(), other.tolist(), *frames, strict=True)
        return np.array([self._distance(*pair) for pair in pairs])

    def _distance(self, one: int, other: int, at_one: Any, at_other: Any) -> float:
        self._result.clear()  # or an older, smaller distance of a mesh stays
        found = coal_library().distance(
            *(self._geometry(one), at_one, self._geometry(other), at_other),
            *(self._request, self._result),
        )
        if found > 0.0 and self._inside is not None:
            found = self._inside.signed(found, one, other, at_one, at_other)
        return float(found)


def _of(at: WorldPoses, some: Rows) -> WorldPoses:
    return at[0][some], at[1][some]


def _transforms(found: NearestPoints, place: Floats, turn: Floats) -> NearestPoints:
    """Transform from frames with origins (k, 3) and rotations (k, 3, 3) to the world."""
    one, other = (np.einsum("kij,kj->ki", turn, p) + place for p in (found.one, found.other))
    return NearestPoints(found.distance, one, other, np.einsum("kij,kj->ki", turn, found.normal))
