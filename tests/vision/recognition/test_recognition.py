"""Objects in drawn pictures, whose truth is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.cameras.synthetic_pictures import Card, VisibleBody
from assistant.vision.opencv import opencv
from assistant.vision.recognition.object_library import Library
from assistant.vision.recognition.objects_from_pictures import ObjectView, learn_solid
from assistant.vision.recognition.pose_estimation import Plane
from assistant.vision.recognition.recogniser import Recogniser
from tests.vision.recognition.counting import EXACT, Counts, add, counted, difference
from tests.vision.recognition.scenes import (
    ABOVE,
    LEFT,
    PARTS,
    RIGHT,
    STRANGE,
    Flat,
    Truth,
    face_picture,
    laid,
    surface,
    taken,
)


def good(counts: Counts) -> None:
    assert counts.precision >= 0.95, counts.wrong
    assert counts.recall >= 0.9, counts.missed
    mm, degrees = np.array(counts.mm), np.array(counts.degrees)
    assert mm.mean() < 0.1
    assert degrees.mean() < 0.2
    # Of three numbers, where none of them is surer or less sure than it is said to be, 3.
    assert 0.3 < np.mean(counts.distances) < 6.0


def test_known_objects_are_found_and_unknown_ones_are_not_named(recogniser, ten, tell):
    counts = counted(recogniser, [4], ten, known=4, strange=1)
    tell(f"one scene: {counts.figures()}")
    assert not counts.wrong
    assert not counts.missed


@pytest.mark.slow
def test_known_objects_of_many_scenes_are_found(recogniser, ten, tell):
    counts = counted(recogniser, range(60), ten)
    tell(f"60 scenes of ten objects, up to 30 % hidden: {counts.figures()}")
    tell(f"named and not there: {counts.wrong}; missed: {counts.missed}")
    good(counts)


@pytest.mark.slow
def test_the_covariance_is_that_of_many_pictures_of_one_object(ten, tell):
    """The scatter of what is found in pictures that differ in their noise alone."""
    one = ten.objects["tee"]
    part = next(part for part in PARTS if part.name == "tee")
    alone = Recogniser(opencv(), Library({"tee": one}))
    pose = laid(np.array([0.0, 30.0, 0.0]), np.array([20.0, 10.0]), 33.0)
    found, told = [], []
    for seed in range(40):
        picture = taken(ABOVE, [surface(part, pose, (200, 180, 90))], seed, noise=6.0)
        (seen,) = alone.see({"above": picture}, {"above": ABOVE}, EXACT).found
        found.append(difference(seen, Truth(one, pose, 0.0))[[0, 1, 5]])
        told.append(np.sqrt(np.diag(seen.estimate.covariance))[[0, 1, 5]])
    scatter, said = np.std(found, axis=0), np.mean(told, axis=0)
    tell(f"scatter of 40 pictures {scatter.round(4)} mm, mm, degrees; told {said.round(4)}")
    assert (said > 0.8 * scatter).all()
    assert (said < 5.0 * scatter).all()


def test_several_of_one_kind_are_numbered(ten):
    part, one = PARTS[0], ten.objects["bracket"]
    alone = Recogniser(opencv(), Library({"bracket": one}))
    middle = np.array([30.0, 25.0, 0.0])
    poses = [
        laid(middle, np.array(at), turn) for at, turn in (((-90, 10), 20.0), ((90, -20), 200.0))
    ]
    things = [surface(part, pose, (190, 200, 120)) for pose in poses]
    things.append(surface(STRANGE[3], laid(middle, np.array([0.0, 120.0]), 0.0), (190, 200, 120)))
    sight = alone.see({"above": taken(ABOVE, things, 3)}, {"above": ABOVE}, EXACT)
    assert sorted(one.name for one in sight.found) == ["bracket", "bracket_2"]
    counts = Counts()
    add(counts, sight.found, [Truth(one, pose, 0.0) for pose in poses])
    assert counts.right == 2
    (unknown,) = sight.unknown
    assert np.hypot(unknown.x, unknown.y - 120.0) < 15.0
    assert [one.code for one in sight.findings] == ["VS344"]


@pytest.mark.slow
def test_two_cameras_locate_better_than_each_and_tell_when_they_disagree(ten, tell):
    one = ten.objects["astronaut"]
    alone = Recogniser(opencv(), Library({"astronaut": one}))
    turn = rotations.canonical(
        rotations.multiply(rotations.about((0, 0, 1), 25.0), rotations.about((1, 0, 0), 14.0))
    )
    pose = Pose.of(np.array([15.0, -10.0, 40.0]), turn)
    things = [VisibleBody(Card(one.texture.size, face_picture("astronaut.png")), pose)]
    pictures = {"left": taken(LEFT, things, 1), "right": taken(RIGHT, things, 2)}
    cameras = {"left": LEFT, "right": RIGHT}
    off = {}
    for names in (("left",), ("right",), ("left", "right")):
        sight = alone.see(
            {name: pictures[name] for name in names}, {name: cameras[name] for name in names}
        )
        (seen,) = sight.found
        assert "VS345" in [finding.code for finding in sight.findings]  # it lies on no plane
        off[names] = float(np.linalg.norm(difference(seen, Truth(one, pose, 0.0))[:3]))
        assert seen.estimate.sigma_mm < 3.0
    both = off["left", "right"]
    tell(f"a card above the plane: {off['left',]:.2f}, {off['right',]:.2f}, by both {both:.2f} mm")
    assert both < max(off["left",], off["right",])
    assert both < 0.5
    moved = {"left": LEFT, "right": replace(RIGHT, pose=RIGHT.pose @ Pose((12.0, 0.0, 0.0)))}
    sight = alone.see(pictures, moved)
    assert "VS342" in [finding.code for finding in sight.findings]


def test_a_card_far_away_may_be_tilted_in_two_ways(ten):
    """The farther it is, the less its near edge looks larger than its far one."""
    one = ten.objects["astronaut"]
    alone = Recogniser(opencv(), Library({"astronaut": one}))
    turn = rotations.multiply(rotations.about((0, 0, 1), 25.0), rotations.about((1, 0, 0), 14.0))
    pose = Pose.of(np.array([15.0, -10.0, 40.0]), rotations.canonical(turn))
    things = [VisibleBody(Card(one.texture.size, face_picture("astronaut.png")), pose)]
    lens = Lens((640, 480), (3000.0, 3000.0), (320.0, 240.0), (0.0,) * 5)
    far = Camera("above", lens, looking_at((40.0, -900.0, 3000.0), (0.0, 0.0, 0.0)))
    sight = alone.see({"above": taken(far, things, 1)}, {"above": far})
    assert [finding.code for finding in sight.findings] == ["VS343"]


@pytest.mark.slow
def test_what_may_be_turned_in_two_ways_is_doubted(ten):
    """Two teeth of a gear are covered, of which the only wide one may be either."""
    part, one = PARTS[3], ten.objects["gear"]
    pose = laid(np.zeros(3), np.array([0.0, 0.0]), 70.0)
    turns = np.radians(np.linspace(-12.0, 92.0, 12))
    rim = [(45.0 * float(np.cos(turn)), 45.0 * float(np.sin(turn))) for turn in turns]
    over = surface(Flat("cover", [(14.0, 12.0), *rim], []), pose.offset(z=0.2), (30, 40, 160))
    picture = taken(ABOVE, [surface(part, pose, (200, 190, 90)), over], 4)
    alone = Recogniser(opencv(), Library({"gear": one}))
    sight = alone.see({"above": picture}, {"above": ABOVE}, EXACT)
    assert "VS347" in [finding.code for finding in sight.findings]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("z", [-18.0, -8.0, 8.0, 15.0])
def test_a_part_on_another_plane_than_stated_is_an_error(ten, z: float):
    """The picture shows its size to 0.2 %: 8 mm at 640 mm are 1.25 %."""
    part, one = PARTS[0], ten.objects["bracket"]
    alone = Recogniser(opencv(), Library({"bracket": one}))
    pose = laid(np.array([30.0, 25.0, 0.0]), np.array([10.0, 0.0]), 20.0)
    picture = taken(ABOVE, [surface(part, pose, (190, 200, 120))], 3)
    sight = alone.see({"above": picture}, {"above": ABOVE}, Plane(Pose((0.0, 0.0, z))))
    (seen,) = sight.found
    assert [finding.code for finding in sight.findings] == ["VS348"]
    off = float(np.linalg.norm(np.subtract(seen.pose.position, pose.position)))
    assert off < 2.0 * seen.estimate.sigma_mm
    assert seen.confidence < 0.5
    right = alone.see({"above": picture}, {"above": ABOVE}, Plane())
    assert right.findings == ()
    assert right.found[0].confidence == pytest.approx(1.0)


@pytest.mark.parametrize("scale", [0.97, 1.04])
def test_a_part_of_another_size_is_not_the_known_one(ten, scale: float):
    part, one = PARTS[0], ten.objects["bracket"]
    corners = [(scale * x, scale * y) for x, y in part.corners]
    holes = [(scale * x, scale * y, scale * r) for x, y, r in part.holes]
    alone = Recogniser(opencv(), Library({"bracket": one}))
    pose = laid(np.array([30.0, 25.0, 0.0]), np.array([10.0, 0.0]), 20.0)
    things = [surface(Flat("scaled", corners, holes), pose, (190, 200, 120))]
    sight = alone.see({"above": taken(ABOVE, things, 3)}, {"above": ABOVE})
    if sight.found:
        assert "VS348" in {finding.code for finding in sight.findings}
        assert sight.found[0].larger == pytest.approx(100.0 * (scale - 1.0), abs=0.6)
    else:
        assert [finding.code for finding in sight.findings] == ["VS344"]


def test_a_camera_that_does_not_see_the_plane_is_told(recogniser):
    below = replace(ABOVE, pose=looking_at((0.0, 0.0, -500.0), (0.0, 0.0, 0.0)))
    with pytest.raises(Refused) as refused:
        recogniser.see({"above": taken(ABOVE, [], 0)}, {"above": below}, Plane())
    assert refused.value.findings[0].code == "VS336"


def boxed(pose: Pose) -> list[VisibleBody]:
    """A box of 90 × 70 × 50 mm with real pictures on its top and two of its sides."""
    across = rotations.from_matrix(np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]]))
    along = rotations.from_matrix(np.array([[0, 0, 1.0], [1.0, 0, 0], [0, 1.0, 0]]))
    sides = (
        ("astronaut.png", (90.0, 70.0), Pose((0.0, 0.0, 50.0))),
        ("coffee.png", (90.0, 50.0), Pose.of(np.array([0.0, -35.0, 25.0]), across)),
        ("chelsea.png", (70.0, 50.0), Pose.of(np.array([45.0, 0.0, 25.0]), along)),
    )
    return [VisibleBody(Card(size, face_picture(file)), pose @ on) for file, size, on in sides]


@pytest.mark.slow
def test_a_box_is_learnt_by_two_cameras_and_found_by_one_and_by_both(tell):
    """Nothing of it is flat, so that its marks have places in space."""
    cv = opencv()
    one = replace(LEFT, pose=looking_at((150.0, -330.0, 420.0), (0.0, 0.0, 20.0)))
    two = replace(RIGHT, pose=looking_at((230.0, -270.0, 430.0), (0.0, 0.0, 20.0)))
    cameras = {"left": one, "right": two}
    shown = [
        ObjectView(name, taken(camera, boxed(Pose()), seed), camera)
        for seed, (name, camera) in enumerate(cameras.items())
    ]
    box = learn_solid(cv, "box", shown, EXACT).object
    assert not box.texture.flat
    by = Pose.of(
        np.array([25.0, -15.0, 30.0]),
        rotations.canonical(
            rotations.multiply(
                rotations.about((0.0, 0.0, 1.0), 12.0), rotations.about((1.0, 0.0, 0.0), 9.0)
            )
        ),
    )
    pictures = {n: taken(c, boxed(by), 7 + i) for i, (n, c) in enumerate(cameras.items())}
    middle = np.median(box.texture.points, axis=0)
    alone = Recogniser(cv, Library({"box": box}))
    stood = alone.see({v.name: v.picture for v in shown}, cameras, EXACT).found[0].pose
    for names in (("left",), ("left", "right")):
        sight = alone.see({n: pictures[n] for n in names}, {n: cameras[n] for n in names}, EXACT)
        (seen,) = sight.found
        off = np.linalg.norm(seen.pose.moved(middle[None]) - (by @ stood).moved(middle[None]))
        turn = float(rotations.angle_between(seen.pose.quaternion, (by @ stood).quaternion))
        tell(f"a box by {' and '.join(names)}: {off:.2f} mm and {turn:.2f} degrees off")
        assert off < 1.0
        assert turn < 1.5
    plain = replace(shown[0], name="again")
    with pytest.raises(Refused) as refused:
        learn_solid(cv, "box", [shown[0], plain], EXACT)
    assert refused.value.findings[0].code == "VS327"
