"""Pictures prepared for recognition: sound and assigned to cameras, then segmented.

The background is the colour of most of the picture and changes smoothly across it, as light does.
Everything else is foreground, which is cut along its edges into regions of one colour. The pictures
of one moment must have the calibrated size and be neither dark nor saturated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Singles, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Severity
from assistant.program.settings_tables import listed, shown
from assistant.vision import rules as of_cameras
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.capture import exposure_findings, read_picture
from assistant.vision.rules import AMBIGUOUS_CAMERA, TWO_PICTURES

if TYPE_CHECKING:
    from types import ModuleType


Picture = NDArray[np.uint8]
"""(h, w, 3), blue, green, red."""

_LEAST_COLOUR_DIFFERENCE: Final = 8.0
"""Units of CIE L*a*b* that colours differ by to be two, beside what noise does."""
_NOISE_SIGMAS: Final = 4.0
"""Times the noise of the smoothed picture that they differ by as well."""
_LEAST_REGION_AREA: Final = 120
"""Pixels of a region; smaller ones are left out."""
_PICTURE_SMOOTHING: Final = 1.2
"""Pixels, sigma, by which the picture is smoothed before colours are compared."""
_BACKGROUND_STRIDE: Final = 4
"""Every so many pixels along and across tell the background."""
_BACKGROUND_ROUNDS: Final = 6


@dataclass(frozen=True, slots=True, eq=False)
class Photo:
    """smooth: (h, w, 3) for edges. lab: (h, w, 3) colours. noise: grey levels, one sigma.
    foreground: (h, w). regions: of each region its boundaries, (n, 2) pixels each, holes the other
    way round than the one about it, which is the first; areas: pixels of each. The first `pieces`
    of them are whole pieces of foreground, the others parts of these of one colour.
    """

    camera: Camera
    picture: Picture
    smooth: Singles
    lab: Singles
    noise: float
    different: float
    foreground: Truths
    regions: tuple[tuple[Floats, ...], ...]
    areas: tuple[int, ...]
    pieces: int

    def colours(self, pixels: Floats) -> Floats:
        """(n, 3) L*a*b* at pixels (n, 2); NaN outside of the picture."""
        u, v, inside = self._places(pixels)
        return np.where(inside[:, None], self.lab[v, u], np.nan)

    def is_foreground(self, pixels: Floats) -> Truths:
        """(n,); False outside of the picture."""
        u, v, inside = self._places(pixels)
        return np.asarray(inside & self.foreground[v, u])

    def _places(self, pixels: Floats) -> tuple[Any, Any, Truths]:
        height, width = self.foreground.shape
        inside = self.camera.within(pixels) & np.isfinite(pixels).all(axis=1)
        at = np.where(inside[:, None], np.nan_to_num(pixels), 0.0)
        whole = np.rint(at).astype(np.intp)
        return np.clip(whole[:, 0], 0, width - 1), np.clip(whole[:, 1], 0, height - 1), inside


def analyse_picture(cv: ModuleType, camera: Camera, picture: Picture) -> Photo:
    """Compute all data of a picture that do not depend on the known objects."""
    noise = _picture_noise(cv, picture)
    exact = picture.astype(np.float32)
    smooth = cv.GaussianBlur(exact, (0, 0), 0.7)
    lab = _lab(cv, cv.GaussianBlur(cv.medianBlur(picture, 3), (0, 0), _PICTURE_SMOOTHING))
    # Noise of L*, which follows grey levels by 100 / 255, after smoothing by a Gaussian.
    rest = noise * 100.0 / 255.0 / (2.0 * np.sqrt(np.pi) * _PICTURE_SMOOTHING)
    different = _LEAST_COLOUR_DIFFERENCE + _NOISE_SIGMAS * rest
    away = np.linalg.norm(lab - _fit_background(lab), axis=2)
    foreground = _without_specks(cv, away > different)
    found, areas, pieces = _regions(cv, lab, foreground, rest)
    return Photo(
        *(camera, picture, smooth, lab, noise, different, foreground),
        *(found, areas, pieces),
    )


def _picture_noise(cv: ModuleType, picture: Picture) -> float:
    """Grey levels, one sigma, of white noise in a picture, robustly.

    By the mask that knows no planes (Immerkær, Fast noise variance estimation, 1996).
    """
    grey = cv.cvtColor(picture, cv.COLOR_BGR2GRAY).astype(np.float32)
    mask = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], dtype=np.float32)
    found = np.abs(cv.filter2D(grey, -1, mask))[1:-1, 1:-1]
    return float(1.4826 * np.median(found) / 6.0)


def _fit_background(lab: Singles) -> Singles:
    """(h, w, 3) the colour of the background everywhere: a cubic in the places of pixels that
    fits most of those that are near to the commonest colour.
    """
    height, width = lab.shape[:2]
    rows, columns = np.mgrid[0:height, 0:width].astype(np.float32)
    terms = _cubic_terms(columns / width - 0.5, rows / height - 0.5)
    some = terms[::_BACKGROUND_STRIDE, ::_BACKGROUND_STRIDE].reshape(-1, terms.shape[2])
    colours = lab[::_BACKGROUND_STRIDE, ::_BACKGROUND_STRIDE].reshape(-1, 3)
    near = (
        np.linalg.norm(colours - _commonest_colour(colours), axis=1)
        < 3.0 * _LEAST_COLOUR_DIFFERENCE
    )
    fit = np.zeros((some.shape[1], 3), np.float32)
    fit[0] = np.median(colours[near], axis=0)
    for i in range(_BACKGROUND_ROUNDS):
        away = np.linalg.norm(colours - some @ fit, axis=1)
        near = away < max(
            _LEAST_COLOUR_DIFFERENCE,
            3.0 * _LEAST_COLOUR_DIFFERENCE * (1.0 - i / (_BACKGROUND_ROUNDS - 2)),
        )
        if near.sum() < 10 * some.shape[1]:
            break
        rows = some[near].astype(np.float64)
        # A little towards none keeps terms small that the places of the background do not tell.
        damped = rows.T @ rows + 1e-6 * len(rows) * np.eye(rows.shape[1])
        fit = np.linalg.solve(damped, rows.T @ colours[near]).astype(np.float32)
    return np.asarray(terms @ fit)


def _cubic_terms(x: Singles, y: Singles) -> Singles:
    second = x * x, x * y, y * y
    third = x * second[0], x * second[1], x * second[2], y * second[2]
    return np.stack([np.ones_like(x), x, y, *second, *third], axis=2)


def _commonest_colour(colours: Singles) -> Singles:
    """The middle of the fullest of cells of ten units, and its neighbours."""
    cells = np.floor(colours / 10.0).astype(np.int64) + 20
    keys = (cells[:, 0] * 64 + cells[:, 1]) * 64 + cells[:, 2]
    fullest = np.bincount(keys).argmax()
    return np.asarray(np.median(colours[keys == fullest], axis=0))


def _lab(cv: ModuleType, picture: Picture) -> Singles:
    return np.asarray(cv.cvtColor(picture.astype(np.float32) / 255.0, cv.COLOR_BGR2Lab))


def _without_specks(cv: ModuleType, mask: Truths) -> Truths:
    """Without specks and pinholes."""
    disc = cv.getStructuringElement(cv.MORPH_ELLIPSE, (3, 3))
    opened = cv.morphologyEx(mask.astype(np.uint8), cv.MORPH_OPEN, disc)
    return np.asarray(opened, dtype=np.bool_)


def _regions(
    cv: ModuleType, lab: Singles, foreground: Truths, rest: float
) -> tuple[tuple[tuple[Floats, ...], ...], tuple[int, ...], int]:
    """Boundaries and areas: of each piece of foreground, and of its parts of one colour."""
    count, pieces, stats, _ = cv.connectedComponentsWithStats(foreground.astype(np.uint8))
    whole = [i for i in range(1, count) if stats[i, cv.CC_STAT_AREA] >= _LEAST_REGION_AREA]
    parts = _parts_of_one_colour(cv, lab, foreground, rest)
    found: list[tuple[Floats, ...]] = []
    areas: list[int] = []
    for labels, kept, alone in ((pieces, whole, False), (parts, _large_regions(parts), True)):
        boxes = _boxes(labels)
        for i in kept:
            rows, columns = boxes[i]
            mask = labels[rows, columns] == i
            if alone:
                inside = pieces[rows, columns][mask]
                piece = int(np.bincount(inside).argmax())
                if mask.sum() > 0.9 * stats[piece, cv.CC_STAT_AREA]:
                    continue  # the piece itself
            found.append(_boundaries(cv, mask, (columns.start, rows.start)))
            areas.append(int(mask.sum()))
    return tuple(found), tuple(areas), len(whole)


def _parts_of_one_colour(cv: ModuleType, lab: Singles, foreground: Truths, rest: float) -> Any:
    """(h, w) numbers of parts of one colour, grown from where nothing changes; 0 for others."""
    slope = np.hypot(cv.Sobel(lab, -1, 1, 0, ksize=3), cv.Sobel(lab, -1, 0, 1, ksize=3)).max(axis=2)
    calm = foreground & (slope / 8.0 < 1.5 + _NOISE_SIGMAS * rest / 2.0)
    calm = cv.erode(calm.astype(np.uint8), np.ones((3, 3), np.uint8))
    count, cores, stats, _ = cv.connectedComponentsWithStats(calm, connectivity=4)
    small = stats[:, cv.CC_STAT_AREA] < _LEAST_REGION_AREA / 4
    cores[small[cores]] = 0
    cores[calm == 0] = 0
    markers = np.where(foreground, cores, count).astype(np.int32)
    picture = np.clip(lab + np.array([0.0, 128.0, 128.0]), 0, 255).astype(np.uint8)
    grown = cv.watershed(picture, markers)
    # Lines between parts belong to one of them, so that no part is thinner than it is.
    grown = np.where(grown == -1, 0, grown).astype(np.float32)
    filled = cv.dilate(grown, np.ones((3, 3), np.uint8))
    grown = np.where(grown == 0, filled, grown).astype(np.int32)
    grown[~foreground | (grown == count)] = 0
    return grown


def _large_regions(labels: Any) -> list[int]:
    return [i for i, n in enumerate(np.bincount(labels.ravel())) if i and n >= _LEAST_REGION_AREA]


def _boxes(labels: Any) -> list[tuple[slice, slice]]:
    """Rows and columns that each number is in."""
    count = int(labels.max()) + 1
    low, high = np.full((count, 2), 1 << 30), np.zeros((count, 2), np.int64)
    rows, columns = np.nonzero(labels)
    at = labels[rows, columns]
    for i, places in enumerate((rows, columns)):
        np.minimum.at(low[:, i], at, places)
        np.maximum.at(high[:, i], at, places + 1)
    return [(slice(a, c), slice(b, d)) for (a, b), (c, d) in zip(low, high, strict=True)]


def _boundaries(cv: ModuleType, mask: Truths, corner: tuple[int, int]) -> tuple[Floats, ...]:
    """Its closed boundaries, the one about it first, smoothed along themselves."""
    padded = np.pad(mask, 1).astype(np.uint8)
    rings, _ = cv.findContours(padded, cv.RETR_CCOMP, cv.CHAIN_APPROX_NONE)
    found = [ring[:, 0].astype(np.float64) - 1.0 + corner for ring in rings if len(ring) >= 24]
    found.sort(key=lambda ring: -abs(signed_area(ring)))
    return tuple(map(_smooth_ring, found))


def signed_area(ring: Floats) -> float:
    """Return the signed area of a closed polygon (n, 2) by the shoelace formula; positive if
    counter-clockwise.
    """
    x, y = (ring - ring[0]).T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def _smooth_ring(ring: Floats) -> Floats:
    kernel = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
    shifts = (np.roll(ring, k - 2, axis=0) * w for k, w in enumerate(kernel))
    return np.asarray(sum(shifts))


def read_pictures_of_cameras(
    given: Sequence[str], cameras: Mapping[str, Camera]
) -> dict[str, Picture]:
    """Pictures by their cameras: of CAMERA=FILE, of files named like their camera, or the only
    picture of the only camera. Raises Refused, see `read_picture_of_camera`.
    """
    files: dict[str, str] = {}
    for one in given:
        name, file = split_camera_and_file(one, cameras, alone=len(given) == 1)
        if name in files:
            raise Refused(TWO_PICTURES(name=name), exit_status=2)
        files[name] = file
    return {name: read_picture_of_camera(file, cameras[name]) for name, file in files.items()}


def read_picture_of_camera(file: str, camera: Camera) -> Picture:
    """Read the picture of a file; raises Refused for a size other than the calibrated one, and for
    a dark or saturated picture, which allows no reliable result.
    """
    picture = read_picture(file)
    size = picture.shape[1], picture.shape[0]
    if size != camera.lens.size:
        said, wanted = (f"{w} × {h}" for w, h in (size, camera.lens.size))
        told = of_cameras.OTHER_PICTURE_SIZE(path=file, name=camera.name, given=said, wanted=wanted)
        raise Refused(told, exit_status=2)
    return check_exposure(picture, camera, file)


def check_exposure(picture: Picture, camera: Camera, source: str) -> Picture:
    """The picture itself; raises Refused for a dark or saturated one."""
    doubts = exposure_findings(camera, picture)
    if doubts:
        raise Refused(*(replace(one, severity=Severity.ERROR, path=source) for one in doubts))
    return picture


def split_camera_and_file(
    given: str, cameras: Mapping[str, Camera], *, alone: bool
) -> tuple[str, str]:
    """Name of the camera and file of a picture; alone: the only camera took it, if it names none.

    Raises Refused (exit status 2) where that is not told.
    """
    name, equals, file = given.partition("=")
    if equals and name in cameras:
        return name, file
    stem = FilePath(given).stem
    if stem in cameras:
        return stem, given
    if alone and len(cameras) == 1:
        return next(iter(cameras)), given
    names = listed(list(cameras))
    raise Refused(AMBIGUOUS_CAMERA(name=shown(given), names=names), exit_status=2)
