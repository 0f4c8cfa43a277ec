"""The library of objects: what is written comes back, and what is damaged is told."""

from __future__ import annotations

import io
import pickle
import shutil
import zipfile

import ezdxf
import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.vision.opencv import opencv
from assistant.vision.recognition.object_library import add_objects, read_library
from assistant.vision.recognition.objects_from_drawings import read_part
from assistant.vision.recognition.objects_from_pictures import ObjectView, learn_face
from assistant.vision.recognition.outline_edges import symmetry_of
from assistant.vision.recognition.outline_matching import contour_moments
from tests.vision.recognition.scenes import PARTS, drawing, face_picture


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("library")
    part = drawing(PARTS[0], folder, glue=[(5, 5), (70, 12)], grasp=True)
    one = read_part(part, "bracket", contour="part", lines=["GLUE"], height=2.5).object
    view = ObjectView("coffee.png", face_picture("coffee.png", 200))
    card = learn_face(opencv(), "card", [view], 80.0).object
    add_objects(folder / "lib", [one, card])
    return folder / "lib"


@pytest.fixture
def lib(written, tmp_path):
    return shutil.copytree(written, tmp_path / "lib")


def codes(refused: pytest.ExceptionInfo[Refused]) -> list[str]:
    return [one.code for one in refused.value.findings]


def test_what_is_written_comes_back(lib):
    read = read_library(lib).objects
    assert list(read) == ["bracket", "card"]
    bracket, card = read["bracket"], read["card"]
    assert bracket.height == 2.5
    assert len(bracket.outline.rings) == 2
    np.testing.assert_allclose(bracket.outline.rings[0], PARTS[0].corners)
    np.testing.assert_allclose(bracket.lines["glue"].points, [[5, 5, 0], [70, 12, 0]])
    (place,) = bracket.places.values()
    assert place.pose.position == (0.0, 0.0, 0.0)
    assert card.texture.size == (80.0, pytest.approx(80.0 * 133 / 200, abs=0.5))
    assert card.texture.descriptors.dtype == np.uint8


def test_an_object_that_is_there_is_only_replaced_if_that_is_asked_for(lib):
    one = read_library(lib).objects["bracket"]
    with pytest.raises(Refused) as refused:
        add_objects(lib, [one])
    assert codes(refused) == ["VS305"]
    add_objects(lib, [one], again=True)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("version = 2\n", "VS302"),
        ("version = 0\n", "VS302"),
        ('version = "1"\n', "VS301"),
        ("", "IN005"),
        ("versions = [\n", "CT301"),
    ],
)
def test_a_library_of_another_version_is_not_read(lib, text, code):
    (lib / "library.toml").write_text(text)
    with pytest.raises(Refused) as refused:
        read_library(lib)
    assert codes(refused) == [code]
    assert refused.value.exit_status == 2


def test_what_is_no_library_is_told(tmp_path, lib):
    for folder, code in ((tmp_path / "none", "VS301"), (tmp_path, "VS301")):
        with pytest.raises(Refused) as refused:
            read_library(folder)
        assert codes(refused) == [code]
    for file in lib.iterdir():
        if file.stem in ("bracket", "card"):
            file.unlink()
    with pytest.raises(Refused) as refused:
        read_library(lib)
    assert codes(refused) == ["VS304"]
    with pytest.raises(Refused) as refused:
        add_objects(tmp_path, [])
    assert codes(refused) == ["VS301"]


def archive(**columns: object) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **columns)
    return buffer.getvalue()


KIND = {"kind": np.array("known object"), "version": np.array([1.0])}
RING = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


class Nasty:
    def __reduce__(self):
        return print, ("executed",)


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", "IN005"),
        (b"PK\x03\x04 and then nothing", "TB406"),
        (archive(kind=np.array("something else")), "VS303"),
        (archive(**{**KIND, "version": np.array([7.0])}), "VS302"),
        (archive(**KIND), "VS303"),
        (archive(**KIND, outline=RING * np.nan, rings=np.array([3])), "VS303"),
        (archive(**KIND, outline=RING, rings=np.array([4])), "VS303"),
        (archive(**KIND, outline=RING * 0.0, rings=np.array([3])), "VS303"),
        (archive(**KIND, outline=RING.T, rings=np.array([2])), "VS303"),
        (archive(**KIND, points=np.zeros((4, 3)), descriptors=np.zeros((3, 128))), "VS303"),
        (archive(**KIND, points=np.zeros((4, 3)), descriptors=np.full((4, 128), 300)), "VS303"),
        (archive(**KIND, outline=np.array([Nasty()], dtype=object)), "TB403"),
    ],
    ids=range(12),
)
def test_damaged_and_hostile_columns_are_told_and_never_run(lib, data, code, capsys):
    (lib / "bracket.npz").write_bytes(data)
    with pytest.raises(Refused) as refused:
        read_library(lib)
    assert codes(refused) == [code]
    assert "executed" not in capsys.readouterr().out


def test_an_archive_of_pickles_is_not_opened(lib, capsys):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as made:
        made.writestr("kind.npy", pickle.dumps(Nasty()))
    (lib / "bracket.npz").write_bytes(buffer.getvalue())
    with pytest.raises(Refused):
        read_library(lib)
    assert "executed" not in capsys.readouterr().out


@pytest.mark.parametrize(
    "text",
    [
        "height = -1\n",
        'height = "3"\n',
        "weight = 3\n",
        "[places.grasp]\nposition = [1, 2]\n",
        "[places.grasp]\nquaternion = [0, 0, 0, 0]\n",
        "[lines.glue]\npoints = [[0, 0]]\n",
        "[lines.glue]\nspeed = 5\n",
        "[lines.glue]\npoints = [[0, 0], [1, 0], [2, 0]]\nvias = [2]\n",
        "[lines.glue]\npoints = [[0, 0], [1, 0], [2, 0], [3, 0]]\nvias = [1, 2]\n",
        "[lines.glue]\npoints = [[0, 0], [1e9, 0]]\n",
        '[lines."../glue"]\npoints = [[0, 0], [1, 0]]\n',
        "[places.grasp]\nquaternion = [1, 0, 0, 0]\neuler_zyx = [0, 0, 0]\n",
    ],
)
def test_wrong_values_of_an_object_are_told_at_their_lines(lib, text):
    (lib / "bracket.toml").write_text(text)
    with pytest.raises(Refused) as refused:
        read_library(lib)
    assert refused.value.exit_status == 2
    assert all(one.line is not None for one in refused.value.findings)


def layered(path, *shapes: tuple[str, list[tuple[float, float]]], level: float = 0.0):
    document = ezdxf.new(units=4)
    for layer, corners in shapes:
        document.modelspace().add_lwpolyline(
            corners, close=True, dxfattribs={"layer": layer, "elevation": level}
        )
    document.saveas(path)
    return path


SQUARE = [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0), (0.0, 30.0)]
BESIDE = [(50.0, 0.0), (60.0, 0.0), (60.0, 10.0)]
CROSSED = [(0.0, 0.0), (30.0, 30.0), (30.0, 0.0), (0.0, 30.0)]
TINY = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.3)]


@pytest.mark.parametrize(
    ("shapes", "asked", "code"),
    [
        ([("A", SQUARE), ("B", BESIDE)], {}, "VS311"),
        ([("A", SQUARE)], {"contour": "B"}, "VS310"),
        ([("A", SQUARE)], {"lines": ["A"]}, "VS310"),
        ([("A", SQUARE)], {"lines": ["GLUE"]}, "VS313"),
        ([("A", SQUARE), ("A", BESIDE)], {}, "VS312"),
        ([("A", CROSSED)], {}, "VS312"),
        ([("A", TINY)], {}, "VS312"),
    ],
)
def test_drawings_that_are_no_part_are_told(tmp_path, shapes, asked, code):
    path = layered(tmp_path / "part.dxf", *shapes)
    with pytest.raises(Refused) as refused:
        read_part(path, "part", **asked)
    assert codes(refused) == [code]


def test_a_layer_that_is_named_is_the_outline(tmp_path):
    path = layered(tmp_path / "part.dxf", ("A", SQUARE), ("B", BESIDE))
    one = read_part(path, "part", contour="b").object
    assert len(one.outline.rings[0]) == 3


def test_an_outline_drawn_at_a_height_has_its_frame_there(tmp_path):
    path = layered(tmp_path / "part.dxf", ("A", SQUARE), ("GLUE", BESIDE), level=7.0)
    one = read_part(path, "part", contour="A", lines=["GLUE"]).object
    assert np.allclose(one.lines["glue"].points[:, 2], 0.0)


def test_what_looks_the_same_when_it_is_turned_is_told(tmp_path, ten):
    drawn = read_part(layered(tmp_path / "part.dxf", ("A", SQUARE)), "square")
    assert drawn.object.symmetry == 4
    assert "VS314" in [one.code for one in drawn.findings]
    assert {name: one.symmetry for name, one in ten.objects.items() if one.outline} == {
        part.name: 1 for part in PARTS
    }
    document = ezdxf.new(units=4)
    document.modelspace().add_circle((3, 4), 20)
    document.saveas(tmp_path / "disc.dxf")
    assert symmetry_of(read_part(tmp_path / "disc.dxf", "disc").object.outline) == 0


def test_moments_of_contours_are_those_of_their_pixels(ten):
    """OpenCV counts the pixels of a mask; ours go round its outline."""
    cv = opencv()
    for part in PARTS:
        rings = ten.objects[part.name].outline.rings
        found = contour_moments(cv, rings)
        scale = 8.0
        mask = np.zeros((1200, 1200), np.uint8)
        polygons = [np.rint((ring + 50.0) * scale).astype(np.int32) for ring in rings]
        cv.fillPoly(mask, polygons, 1)
        told = cv.moments(mask, True)
        assert found.area == pytest.approx(told["m00"] / scale**2, rel=0.01)
        middle = np.array([told["m10"], told["m01"]]) / told["m00"] / scale - 50.0
        np.testing.assert_allclose(found.middle, middle, atol=0.15)
        hu = cv.HuMoments(told).ravel()
        np.testing.assert_allclose(found.hu[:4], hu[:4], rtol=0.03, atol=2e-5)
