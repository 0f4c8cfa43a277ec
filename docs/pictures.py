"""Draws the pictures of the pages into docs/pictures, from the samples.

python -m docs.pictures [NAME ...]

Scenes are pages of `view`, photographed by Chromium, which the system has to have.
"""

from __future__ import annotations

import io
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from contextlib import chdir
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

from assistant.cli.app import app
from docs import models, studio_pictures
from docs.browsing import chromium

PROJECT: Final = Path(__file__).parent.parent
FOLDER: Final = PROJECT / "docs" / "pictures"
SIZE: Final = {"width": 1000, "height": 560}
COLOURS: Final = 96  # of a palette, which keeps a picture below 80 KiB


def scene(*view: str, does: Sequence[str] = ()) -> bytes:
    """The page that `robot-assistant view` writes, as PNG, after scripts were run on it.

    view: its arguments, files as they stand in the project.
    does: JavaScript, such as `view.setTime(2)`.
    """
    with chdir(PROJECT), tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "scene.html"
        app(["view", *view, "--html", str(page)], standalone_mode=False)
        return photographed(page, does)


def photographed(page: Path, does: Sequence[str] = ()) -> bytes:
    """A page as PNG, after scripts were run on it."""
    with chromium() as opened:
        tab = opened.new_page(viewport=SIZE)
        tab.goto(page.as_uri())
        for script in does:
            tab.evaluate(script)
        tab.wait_for_timeout(1000)
        taken: bytes = tab.screenshot()
    return taken


def small(png: bytes) -> bytes:
    """The same picture in fewer bytes."""
    from PIL import Image

    out = io.BytesIO()
    Image.open(io.BytesIO(png)).convert("RGB").quantize(COLOURS).save(out, "PNG", optimize=True)
    return out.getvalue()


def contact() -> bytes:
    """The gripper touches the clamp, at the first contact that is found."""
    return scene(
        *("samples/plate.dxf", "--cell", "samples/cell/clamped.toml"),
        does=[
            "document.querySelector('#findings button').click()",
            "document.querySelector('#with-names').click()",
        ],
    )


def viewing() -> bytes:
    """The tool on its way along what is glued, with the line of the program that it is at."""
    return scene(
        *("samples/rapid/gluing.mod", "--robot", "irb1200-7-0.7"),
        does=["view.setTime(4)", "view.aim([420, 0, 330], 1300)"],
    )


def demo() -> bytes:
    """The page that the demo makes, while the arm glues."""
    with tempfile.TemporaryDirectory() as folder:
        app(["demo", "-o", folder], standalone_mode=False)
        return photographed(
            Path(folder) / "report.html",
            [
                "view.setTime(24)",
                "view.aim([310, 0, 330], 900)",
                "document.querySelector('#with-names').click()",
                "document.querySelector('#source').scrollIntoView()",
            ],
        )


def around() -> bytes:
    """The arm on its way over the wall."""
    return scene(
        *("samples/cell/station.dxf", "--cell", "samples/cell/station-rv-2aj.toml"),
        does=["view.setTime(15)", "view.aim([290, 0, 280], 900)"],
    )


def travel() -> bytes:
    """The gripper on its way around the clamp."""
    return scene(
        *("samples/cell/around.pseudo", "--cell", "samples/cell/clamped.toml"),
        does=["view.setTime(1.46)", "view.aim([262, -10, 300], 700)"],
    )


def turned() -> bytes:
    """The nozzle is turned so that its holder stays away from the post."""
    return scene(
        *("samples/ring.dxf", "--cell", "samples/cell/ring.toml"),
        does=["view.setTime(20)", "view.aim([330, 20, 260], 950)"],
    )


def reach() -> bytes:
    """What the arm reaches over its stand, in three levels."""
    region = ("--tip", "0,0,60", "--x", "0:700:25", "--y", "-400:400:25", "--z", "250:450:100")
    return drawn("reach", "map", "--cell", "samples/cell/stand.toml", *region)


def places() -> bytes:
    """Where a tray stands best."""
    grid = ("--tip", "0,0,60", "--x", "-300:100:25", "--y", "-600:100:25")
    return drawn("reach", "place", "tray", "--cell", "samples/cell/tray.toml", *grid)


def swept() -> bytes:
    """What the arm sweeps in the program of a drawing."""
    program = ("samples/plate.dxf", "--cell", "samples/cell/stand.toml")
    return drawn("reach", "swept", *program)


def explored() -> bytes:
    """What is known of a workshop after forty random moves."""
    cells = [f"samples/cell/{name}.toml" for name in ("explored", "workshop")]
    with chdir(PROJECT), tempfile.TemporaryDirectory() as folder:
        chart = str(Path(folder) / "arm.npz")
        wander = ("wander", cells[0], "--hidden", cells[1], "--runs", "40", "--chart", chart)
        app(["explore", *wander], standalone_mode=False)
        return drawn("explore", "show", chart)


def contours() -> bytes:
    """The ways of a cutter beside a plate, its holes, and a part in one of them."""
    with chdir(PROJECT), tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "contours.png"
        app(["check", "samples/nested.dxf", "--plot", str(picture)], standalone_mode=False)
        return picture.read_bytes()


def seen() -> bytes:
    """The glue line of a program where the bracket is seen."""
    from docs import seen_frames

    return seen_frames.picture()


def drawn(*words: str) -> bytes:
    """The picture that a command writes with `-o`."""
    with chdir(PROJECT), tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "picture.png"
        app([*words, "-o", str(picture)], standalone_mode=False)
        return picture.read_bytes()


def camera() -> bytes:
    """A cell and a wand as a synthetic camera sees them, with the axes of the world."""
    at = "x_mm,y_mm,z_mm,qw,qx,qy,qz\n330,-180,330,0.24,0.96,0.144222,0\n"
    with chdir(PROJECT), tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "at.csv").write_text(at, encoding="utf-8")
        cell = ("--cell", "samples/cell/stand.toml", "--at", str(folder / "at.csv"), "--noise", "0")
        rig = "samples/cameras/view.toml"
        app(["camera", "draw", rig, *cell, "-o", str(folder)], standalone_mode=False)
        seen = ("--source", str(folder / "above"), "-o", str(folder / "seen.png"))
        app(["camera", "view", rig, "above", *seen], standalone_mode=False)
        return (folder / "seen.png").read_bytes()


def objects() -> bytes:
    """A bracket on a table, found though part of it is covered, with its glue line."""
    with chdir(PROJECT), tempfile.TemporaryDirectory() as name:
        folder, samples = Path(name), "samples/objects/"
        rig, lib = samples + "cameras.toml", str(folder / "lib")
        draw = ["camera", "draw", rig, "--cell", samples + "table.toml", "--noise", "0", "-o"]
        add = ["objects", "add", lib, "bracket", samples + "bracket.dxf", "--line", "GLUE"]
        taken, shown = str(folder / "above" / "0000.png"), str(folder / "seen.png")
        see = ["see", taken, "--cameras", rig, "--objects", lib, "--plane", "200", "--draw", shown]
        app([*draw, str(folder)], standalone_mode=False)
        app([*add, "--height", "3"], standalone_mode=False)
        app(see, standalone_mode=False)
        return (folder / "seen.png").read_bytes()


def pointing() -> bytes:
    """A wand as two synthetic cameras see it, with what is found of it and the place it shows."""
    import cv2
    import numpy as np

    from assistant.base import rotations
    from assistant.program.geometry import Pose
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.cameras.synthetic_pictures import Optics
    from assistant.vision.cameras.synthetic_pictures import draw as taken
    from assistant.vision.pointing.device_tracking import Sighting, locate_device
    from assistant.vision.pointing.devices import bodies_of_device, wand
    from assistant.vision.pointing.mark_detection import find_spots

    device = wand()
    turn = rotations.canonical((0.0, 0.28, 0.95, 0.14))
    things = bodies_of_device(device, Pose.of(np.array([285.0, 30.0, 170.0]), turn))
    cameras = tuple(read_cameras(PROJECT / "samples/cameras/pointing.toml").cameras.values())
    pictures = [taken(camera, things, Optics(noise=0.0)) for camera in cameras]
    seen = locate_device(device, cameras, pictures)
    assert isinstance(seen, Sighting), seen
    axes = seen.pose.moved(np.concatenate([np.zeros((1, 3)), 60.0 * np.eye(3)]))
    large, views = 16.0, []
    for camera, picture in zip(cameras, pictures, strict=True):
        for (spot, *_), name in zip(find_spots(picture, camera, device.marks), "ABC", strict=True):
            middle = [round(large * part) for part in spot.place]
            radius = round(large * spot.radius)
            cv2.circle(picture, middle, radius, (255, 255, 255), 1, cv2.LINE_AA, shift=4)
            side = (round(spot.place[0] + spot.radius + 8), round(spot.place[1] + 5))
            told = f"{name} {spot.place[0]:.2f} {spot.place[1]:.2f}"
            cv2.putText(picture, told, side, 0, 0.42, (255, 255, 255), 1, cv2.LINE_AA)
        tip, *ends = np.round(large * camera.project(axes)).astype(int).tolist()
        for end, colour in zip(ends, ((60, 60, 255), (60, 230, 60), (255, 140, 60)), strict=True):
            cv2.line(picture, tip, end, colour, 2, cv2.LINE_AA, shift=4)
        views.append(picture[20:460, 90:590])
    place = " ".join(f"{part:.2f}" for part in seen.pose.position)
    told = f"tip at {place} mm"
    cv2.putText(views[0], told, (12, 424), 0, 0.5, (255, 255, 255), 1, cv2.LINE_AA)
    return bytes(cv2.imencode(".png", np.hstack(views))[1])


def fmu() -> bytes:
    """An arm that goes where it is told: joint and speed, with and without a first order."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    from assistant import robots
    from assistant.blocks.library.arms import ArmMotion

    t, robot = np.arange(0.0, 1.6, 0.004), robots.get("rv-2aj")
    wanted = np.where(t < 0.1, 0.0, np.where(t < 0.8, 60.0, 10.0))
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True)
    upper.step(t, wanted, "0.6", where="post", label="J1_wanted")
    for lag, style in ((0.0, "C0-"), (0.05, "C1--")):
        arm, joints, speeds = ArmMotion.of(robot, lag=lag), [], []
        for goal in wanted:
            joints.append(arm.joints[0])
            speeds.append(arm.speed[0])
            arm.towards([goal, *robot.home[1:]])
            arm.step(0.004)
        upper.plot(t, joints, style, label=f"J1, time_constant {lag:g} s")
        if not lag:
            lower.plot(t, speeds, style, label="J1_speed")
    top = robot.speeds[0]
    lower.axhline(top, color="0.6", lw=0.8)
    lower.axhline(-top, color="0.6", lw=0.8, label="J1_speed_limit")
    upper.set_ylabel("degrees")
    lower.set(xlabel="seconds", ylabel="degrees/s", xlim=(0.0, 1.6))
    for axes in (upper, lower):
        axes.legend(loc="upper right", fontsize=8)
        axes.grid(alpha=0.3)
    figure.tight_layout()
    out = io.BytesIO()
    figure.savefig(out, dpi=100)
    plt.close(figure)
    return out.getvalue()


def servoing() -> bytes:
    """The way of a marker through the picture of a camera in the hand, by both laws."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    from assistant import robots
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.servoing.interaction import flange_of
    from assistant.vision.servoing.servo_loop import servo
    from assistant.vision.servoing.servo_task import open_eyes, read_servo, set_up_servo
    from assistant.vision.servoing.simulation import (
        DrawnEyes,
        IdealArm,
        ProjectedEyes,
        ServoWorld,
        SteppedClock,
    )

    samples = PROJECT / "samples/servoing"
    file, rig = read_servo(samples / "marker.toml"), read_cameras(samples / "cameras.toml")
    assert file.drawn is not None and file.target is not None
    robot = robots.get("rv-2aj")
    begin = np.array([-2.0, 1.0, 78.0, 87.0, -60.0])
    figure, (seen, left) = plt.subplots(1, 2, figsize=(9, 3.4))
    image, pose = replace(file, law="image"), replace(file, law="pose")
    for task, colour, name in ((image, "C1", "image-based"), (pose, "C0", "position-based")):
        setting = set_up_servo(task, rig, robot)
        arm, clock = IdealArm(begin, setting.guard.speeds), SteppedClock()
        world = ServoWorld(robot, arm.joints, (file.target, file.drawn))
        eyes = ProjectedEyes(setting.cameras, world, clock, noise=0.1)
        done = servo(eyes, setting.law, arm, setting.guard, clock=clock)
        placed = [setting.cameras[0].carried(flange_of(robot, row)) for row in arm.rows]
        points = file.drawn.moved(file.target.points)
        ways = np.array([camera.project(points) for camera in placed])
        seen.plot(ways[..., 0], ways[..., 1], color=colour, lw=1.4)
        seen.plot(*ways[-1].T, "o", color=colour, ms=4, label=name)
        columns = done.columns
        left.semilogy(columns["seconds"], columns["distance"], color=colour, label=f"{name}, mm")
        left.semilogy(columns["seconds"], columns["turn"], color=colour, ls="--")
    with open_eyes(setting, lambda: begin) as drawn:
        assert isinstance(drawn, DrawnEyes)
        seen.imshow(drawn.pictures()[0][..., ::-1])
    seen.set(xticks=(), yticks=(), title="from the first picture on")
    seen.legend(fontsize=8, loc="lower left")
    left.plot([], [], color="0.4", ls="--", label="degrees")
    left.set(xlabel="seconds", ylabel="left to the goal, as it is seen")
    left.grid(alpha=0.3)
    left.legend(fontsize=8)
    figure.tight_layout()
    out = io.BytesIO()
    figure.savefig(out, dpi=100)
    plt.close(figure)
    return out.getvalue()


def calibrated() -> bytes:
    """Residuals of measured poses by the nominal and the corrected arm, and its corrections."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    from assistant import robots
    from assistant.learning.arm_calibration import calibrate
    from assistant.learning.measured_poses import read_measured

    arm = robots.get("rv-2aj")
    poses = read_measured(PROJECT / "samples/calibration/rv-2aj.csv", arm)
    done = calibrate(arm, poses)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), width_ratios=(3, 2))
    for state, colour, name in (
        (done.start, "C3", "nominal arm"),
        (done.fit.state, "C0", "corrected"),
    ):
        off = np.linalg.norm(done.fit.problem.errors(state)[0], axis=1)
        root = float(np.sqrt((off**2).mean()))
        left.semilogy(poses.rows, off, "o", color=colour, ms=4, label=f"{name}, {root:.3g} mm")
        left.axhline(root, color=colour, lw=0.8)
    left.axhline(done.out.point, color="0.4", lw=0.8, ls="--")
    left.plot([], [], color="0.4", lw=0.8, ls="--", label=f"held out, {done.out.point:.3g} mm")
    left.set(xlabel="row of the file", ylabel="residual, mm", ylim=(0.008, 500.0))
    left.legend(fontsize=8, loc="upper right")
    names = [f"{one.parameter.name}, {one.parameter.unit}" for one in done.corrections]
    values = [one.value for one in done.corrections]
    sigmas = [3.0 * one.sigma for one in done.corrections]
    right.errorbar(values, names, xerr=sigmas, fmt="o", ms=4, capsize=3)
    right.axvline(0.0, color="0.6", lw=0.8)
    right.invert_yaxis()
    right.set_xlabel("correction, bars of three sigmas")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    figure.tight_layout()
    out = io.BytesIO()
    figure.savefig(out, dpi=100)
    plt.close(figure)
    return out.getvalue()


def learned() -> bytes:
    """The lattice of a map at several stages, as two cameras see it."""
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "learned.png"
        made = ("learn", "rv-2aj", "--hold", "J5=60", "--hold", "J6=0", "-o", f"{folder}/map.npz")
        made = (*made, "--lattice", "4x8x3")
        app([*made, "--picture", str(picture)], standalone_mode=False)
        return picture.read_bytes()


PICTURES: Final[dict[str, Callable[[], bytes]]] = {
    "demo": demo,
    "contact": contact,
    "contours": contours,
    "around": around,
    "travel": travel,
    "reach": reach,
    "turned": turned,
    "viewing": viewing,
    "places": places,
    "swept": swept,
    "explored": explored,
    "seen": seen,
    "camera": camera,
    "pointing": pointing,
    "servoing": servoing,
    "objects": objects,
    "learned": learned,
    "fmu": fmu,
    "calibrated": calibrated,
    **{name: partial(models.model, name) for name in models.names()},
    **{name: partial(studio_pictures.picture, name) for name in studio_pictures.names()},
}
"""Each picture by the name of its file."""


def draw(names: Iterable[str]) -> None:
    FOLDER.mkdir(exist_ok=True)
    for name in names:
        drawn = small(PICTURES[name]())
        (FOLDER / f"{name}.png").write_bytes(drawn)
        sys.stdout.write(f"{name}: {len(drawn) / 1024:.0f} KiB\n")


if __name__ == "__main__":
    draw(sys.argv[1:] or PICTURES)
