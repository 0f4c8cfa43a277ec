"""Pictures that were really taken: those inside scikit-image."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.vision.cameras.camera import Camera, Lens
from assistant.vision.opencv import opencv
from assistant.vision.recognition.objects_from_pictures import ObjectView, learn_face
from assistant.vision.recognition.photo import analyse_picture
from assistant.vision.recognition.stereo_depth import match_rows
from assistant.vision.recognition.texture_matching import TextureIndex, find_textures
from tests.vision.recognition.scenes import REAL, face_picture, real

SIDE = 120
"""Pixels of a part of the motorcycle that is learnt."""
OTHERS = ("coffee.png", "astronaut.png", "chelsea.png", "camera.png", "coins.png", "rocket.jpg",
          "page.png", "ihc.png")  # fmt: skip
UNKNOWN = ("hubble_deep_field.jpg", "retina.jpg", "brick.png", "moon.png", "text.png")


def disparity() -> np.ndarray:
    """(h, w) pixels, measured by structured light by who took the pair (Middlebury 2014)."""
    return np.load(str(REAL / "motorcycle_disp.npz"))["arr_0"]


@pytest.mark.slow
def test_parts_of_one_picture_of_a_pair_are_found_in_the_other(tell):
    """Learnt from what the left camera took, looked for in what the right one took."""
    cv = opencv()
    left, right, told = real("motorcycle_left.png"), real("motorcycle_right.png"), disparity()
    known, places = [], {}
    for row in range(0, left.shape[0] - SIDE + 1, 95):
        for column in range(60, left.shape[1] - SIDE + 1, 103):
            part = left[row : row + SIDE, column : column + SIDE]
            try:
                one = learn_face(
                    cv, f"p{row}_{column}", [ObjectView("part", part)], float(SIDE)
                ).object
            except Refused as refused:
                assert refused.findings[0].code == "VS320"
                continue
            here = told[row : row + SIDE, column : column + SIDE]
            shift = float(np.median(here[np.isfinite(here)]))
            known.append(one)
            places[one.name] = np.array([column - shift, row]) + (SIDE - 1) / 2.0
    others = [
        learn_face(cv, n.partition(".")[0], [ObjectView(n, face_picture(n))], 100.0).object
        for n in OTHERS
    ]
    camera = Camera("right", Lens.ideal((right.shape[1], right.shape[0]), 900.0))
    found = find_textures(
        cv, analyse_picture(cv, camera, right), TextureIndex.of([*known, *others]), None
    )
    names = [one.object.name for one in found]
    off = [
        float(np.linalg.norm(camera.project(np.array([one.estimate.pose.position]))[0]
                             - places[one.object.name]))
        for one in found if one.object.name in places
    ]  # fmt: skip
    right_ones = sum(one < 8.0 for one in off)
    precision, recall = right_ones / len(found), right_ones / len(known)
    tell(
        f"{len(known)} parts of a real picture in another one: precision {precision:.3f}, recall "
        f"{recall:.3f}, median {np.median(off):.1f} pixels from the measured disparity"
    )
    assert not set(names) & {one.name for one in others}
    assert precision >= 0.95
    assert recall >= 0.9


@pytest.mark.slow
def test_real_pictures_of_other_things_have_no_names(recogniser):
    cv = opencv()
    for name in UNKNOWN:
        picture = real(name)
        part = 640.0 / max(picture.shape[:2])
        picture = cv.resize(picture, None, fx=part, fy=part, interpolation=cv.INTER_AREA)
        camera = Camera("one", Lens.ideal((picture.shape[1], picture.shape[0]), 700.0))
        found = find_textures(cv, analyse_picture(cv, camera, picture), recogniser.marks, None)
        assert [one.object.name for one in found] == [], name


def test_all_coins_on_an_uneven_background_are_regions():
    """24 coins, four rows of six, lit from one side."""
    cv = opencv()
    picture = real("coins.png")
    camera = Camera("one", Lens.ideal((picture.shape[1], picture.shape[0]), 700.0))
    photo = analyse_picture(cv, camera, picture)
    areas = np.array(photo.areas[: photo.pieces])
    assert (areas > 500).sum() == 24


def test_depth_agrees_with_the_measured_disparity(tell):
    cv = opencv()
    pair = [cv.cvtColor(real(f"motorcycle_{n}.png"), cv.COLOR_BGR2GRAY) for n in ("left", "right")]
    found, told = match_rows(cv, *pair, 5.0, 75.0), disparity()
    both = np.isfinite(found) & np.isfinite(told)
    off = np.abs(found - told)[both]
    tell(
        f"disparity of the motorcycle: {both.sum() / np.isfinite(told).sum():.0%} of pixels, "
        f"median {np.median(off):.2f} pixels off, {np.mean(off > 2.0):.1%} by more than 2"
    )
    assert both.sum() > 0.85 * np.isfinite(told).sum()
    assert np.median(off) < 0.3
    assert np.mean(off > 2.0) < 0.08


@pytest.mark.parametrize("name", ["hubble_deep_field.jpg", "moon.png"])
def test_a_picture_that_shows_few_marks_is_no_face(name):
    cv = opencv()
    plain = cv.GaussianBlur(real(name), (0, 0), 40.0)
    with pytest.raises(Refused) as refused:
        learn_face(cv, "plain", [ObjectView(name, plain)], 100.0)
    assert refused.value.findings[0].code == "VS320"
