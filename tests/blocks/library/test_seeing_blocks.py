"""Cameras, pointing devices and distances as blocks: drawn pictures, and cells of the samples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams import Block, Diagram, RunResult, run
from assistant.blocks.library.ports import pose_signal
from assistant.blocks.library.sensors import (
    CollisionDistance,
    LiveValues,
    PointingDevice,
    ProjectedMarker,
    SeenMarker,
)
from assistant.blocks.library.sources import Constant, PoseToPose, Table
from assistant.cell.cell_file import read_scene
from assistant.cell.collision.model import Model
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, looking_at
from assistant.vision.cameras.camera_file import Rig
from assistant.vision.cameras.synthetic_pictures import Card, VisibleBody, draw
from assistant.vision.pointing.devices import ball
from assistant.vision.servoing.visual_targets import Marker
from tests.vision.pointing.scenes import LENS, SMALL, grey, pair, shown, taken

MARKER = Marker(7, 60.0)
DOWN = (0.0, 1.0, 0.0, 0.0)
CAMERA = Camera("above", LENS, looking_at((0.0, 0.0, 600.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
CELLS = Path(__file__).parents[3] / "samples" / "cell"
IRB = robots.get("irb1200-7-0.7")


def alone(block: Block, *sources: Block, seconds: float = 1.0, step: float = 0.1) -> RunResult:
    diagram = Diagram()
    diagram.add(block)
    for source, port in zip(sources, block.inputs, strict=True):
        diagram.add(source)
        diagram.wire((source, source.outputs[0].name), (block, port.name))
    return run(diagram, seconds, step)


def test_a_marker_that_moves_out_of_the_picture_is_seen_until_then() -> None:
    way = PoseToPose("way", Pose(), Pose((600.0, 0.0, 0.0)), 1.0)
    ran = alone(ProjectedMarker("camera", CAMERA, MARKER), way)
    assert ran["camera.seen"][0] == 1.0 and ran["camera.seen"][-1] == 0.0
    assert ran["camera.pixels"][0] == pytest.approx(CAMERA.project(MARKER.points).ravel())
    assert np.isnan(ran["camera.pixels"][-1]).all()


def test_a_camera_in_the_hand_goes_with_what_carries_it_and_noise_is_the_same_each_time() -> None:
    hand = Camera("hand", LENS, Pose(), "arm.flange")
    flange = Pose((100.0, 0.0, 600.0), DOWN)
    given = [
        Constant(name, pose_signal(pose.position, pose.quaternion))
        for name, pose in (("marker", Pose((100.0, 0.0, 0.0))), ("flange", flange))
    ]
    exact = alone(ProjectedMarker("camera", hand, MARKER), *given)["camera.pixels"]
    assert exact[0].reshape(4, 2).mean(axis=0) == pytest.approx(LENS.centre, abs=0.1)
    block = ProjectedMarker("camera", hand, MARKER, noise=0.5)
    first, second = (alone(block, *given)["camera.pixels"] for _ in range(2))
    assert np.array_equal(first, second)
    assert 0.0 < np.abs(first - exact).max() < 3.0


def pictures(folder: Path, *places: tuple[float, float]) -> Path:
    """A marker on a table, seen from above, at each of these places."""
    import cv2

    folder.mkdir()
    for number, (x, y) in enumerate(places):
        card = Card((MARKER.edge, MARKER.edge), MARKER.picture())
        picture = draw(CAMERA, [VisibleBody(card, Pose((x, y, 0.0)))])
        cv2.imwrite(str(folder / f"{number}.png"), picture)
    return folder


def test_a_marker_is_found_in_pictures_in_the_time_of_the_model(tmp_path: Path) -> None:
    places = (0.0, 0.0), (40.0, 20.0), (9000.0, 0.0)
    folder = pictures(tmp_path / "seen", *places)
    block = SeenMarker("camera", CAMERA, MARKER, "seen", folder=folder.parent, rate=5.0)
    ran = alone(block)
    assert ran["camera.number"].tolist() == [0, 0, 1, 1, 2, 2, 2, 2, 2, 2, 2]
    assert ran["camera.seen"].tolist() == [1, 1, 1, 1, *[0] * 7]
    for row, (x, y) in ((0, places[0]), (2, places[1])):
        wanted = CAMERA.project(MARKER.points + np.array([x, y, 0.0]))
        assert ran["camera.pixels"][row] == pytest.approx(wanted.ravel(), abs=0.5)


def test_a_camera_that_is_not_there_is_told(tmp_path: Path) -> None:
    block = SeenMarker("camera", CAMERA, MARKER, "nowhere", folder=tmp_path)
    with pytest.raises(Refused, match="VS"):
        alone(block)


def test_what_comes_by_itself_is_gathered_beside_the_model() -> None:
    from contextlib import contextmanager
    from threading import Event

    taken = Event()

    @contextmanager
    def opening():  # type: ignore[no-untyped-def]
        def coming():  # type: ignore[no-untyped-def]
            yield 0.0, "first"
            yield 1.0, "second"
            taken.wait(10)
            raise Refused(block_gone)

        yield coming()

    from assistant.vision.rules import CAMERA_LOST

    block_gone = CAMERA_LOST(name="camera", count=2)
    live: LiveValues[str] = LiveValues(opening)
    live.begin()
    try:
        while live.at(0.0) != "second":
            pass
        taken.set()
        with pytest.raises(Refused, match=block_gone.code):
            while True:
                live.at(0.0)
    finally:
        live.end()


def test_a_device_is_followed_and_not_believed_where_it_is_hidden(tmp_path: Path) -> None:
    import cv2

    rng = np.random.default_rng(3)
    cameras, device = pair(SMALL), ball()
    poses = [Pose((10.0 * i, 0.0, 290.0), DOWN) for i in range(3)]
    for camera in cameras:
        (tmp_path / camera.name).mkdir()
        seen = [shown(camera, pose, rng, device) for pose in poses]
        for number, picture in enumerate([*seen, taken(grey(camera), rng)]):
            cv2.imwrite(str(tmp_path / camera.name / f"{number}.png"), picture)
    rig = Rig(
        {c.name: c for c in cameras}, sources={c.name: c.name for c in cameras}, folder=tmp_path
    )
    ran = alone(PointingDevice("hand", rig, device, rate=10.0), seconds=0.5)
    assert ran["hand.seen"].tolist() == [1, 1, 1, 0, 0, 0]
    assert (ran["hand.confidence"] > 0.5).tolist() == [True] * 3 + [False] * 3
    for row, pose in enumerate([*poses, poses[-1]]):
        assert ran["hand.pose"][row, :3] == pytest.approx(pose.position, abs=2.0)


def test_the_least_distance_is_that_of_the_cell_and_its_bodies_are_named() -> None:
    file = CELLS / "station-irb1200-7-0.7.toml"
    block = CollisionDistance("apart", file)
    down = IRB.home + np.array([0.0, 90.0, 0.0, 0.0, 0.0, 0.0])
    rows = np.array([IRB.home, down])
    ran = alone(block, Table("joints", [0.0, 1.0], rows), step=0.25)
    scene, _ = read_scene(file)
    model = Model(scene)
    least, which = model.nearest(np.linspace(rows[0], rows[1], 5))
    assert ran["apart.distance"] == pytest.approx(least)
    assert ran["apart.distance"][-1] < ran["apart.distance"][0]
    contact = model.contact(down, int(which[-1]))
    assert block.nearest == (contact.one, contact.other)
    nowhere = Constant("joints", [np.nan, *down[1:]])
    with pytest.raises(Refused, match=r"BL110.*`apart`.*no numbers"):  # not "nothing is near"
        alone(CollisionDistance("apart", file), nowhere, seconds=0.0)


def test_each_robot_has_an_input_and_others_stay_at_home(tmp_path: Path) -> None:
    file = tmp_path / "two.toml"
    file.write_text(
        '[robots.left]\nrobot = "rv-2aj"\n'
        '[robots.right]\nrobot = "rv-2aj"\nposition = [400, 0, 0]\n',
        encoding="utf-8",
    )
    with pytest.raises(Refused, match=r"BL507.*`left`, `right`"):
        CollisionDistance("apart", file)
    with pytest.raises(Refused, match="BL507"):
        CollisionDistance("apart", file, ["left", "middle"])
    arm = robots.get("rv-2aj")
    both = CollisionDistance("apart", file, ["left", "right"])
    assert [port.name for port in both.inputs] == ["left", "right"]
    forward = arm.home + np.array([0.0, 90.0, -90.0, 0.0, 0.0])
    home = alone(both, Constant("a", arm.home), Constant("b", arm.home), seconds=0.0)
    lone = alone(CollisionDistance("apart", file, ["left"]), Constant("a", forward), seconds=0.0)
    same = alone(both, Constant("a", forward), Constant("b", arm.home), seconds=0.0)
    assert lone["apart.distance"][0] == same["apart.distance"][0] < home["apart.distance"][0]
