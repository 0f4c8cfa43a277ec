"""Files that are no programs: tables, drawings, process files, robots, projects, histories."""

from __future__ import annotations

import hashlib
import io
import json
import os
import shutil
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Final

import numpy as np

import assistant
from assistant import robots
from assistant.base.source_text import decode
from assistant.cell.cell_file import read_scene
from assistant.cell.link_bodies import drawn_links
from assistant.cell.scene_export import cell_files
from assistant.compiler.cell_defaults import with_cell_values
from assistant.compiler.checker import check_files
from assistant.compiler.simulated_run import parse_script
from assistant.controllers.named import controllers_of
from assistant.deploy.history import read_journal, steps_of
from assistant.deploy.record import Record, read_record
from assistant.findings.severities import severities_for
from assistant.learning.arm_calibration import calibrate
from assistant.learning.experiments import three_joints
from assistant.learning.map_file import COLUMNS, load_map, save_map
from assistant.learning.map_training import start_map_with_shape, train_and_measure, usual_plan
from assistant.learning.measured_poses import read_measured
from assistant.learning.proposals import MapInUse
from assistant.program import pseudo
from assistant.program.settings_tables import ENCODINGS
from assistant.project import project_of
from assistant.project.builds import BUILD_FILE, read_build
from assistant.report.scenes import record as said
from assistant.robots import robot_file
from assistant.sources.cell_values import read_cell
from assistant.sources.process.file import read_process
from tests.fuzz.target import (
    ROOT,
    Target,
    file,
    files_of,
    folder,
    promise,
    refusing,
    sound,
)


def source(name: str) -> Callable[[bytes], None]:
    """A drawing, a table, or poses: loaded, checked, and printed as pseudo text."""

    def run(data: bytes) -> None:
        path = file(name, data)
        with refusing():
            loaded = assistant.load(path)
            sound(loaded.findings)
            promise(bool(pseudo.print_program(loaded.program).text), "it prints as nothing")
            sound(check_files([path]).findings)

    return run


def process(data: bytes) -> None:
    path = file("input.process.toml", data)
    table = file("points.csv", b"x,y,z\n1,2,3\n4,5,6\n")
    with refusing():
        sound(read_process(path).findings)
        sound(assistant.load(table, process=path).findings)
        drawing = ROOT / "samples" / "plate.dxf"
        sound(assistant.load(drawing, process=path).findings)


def cell(data: bytes) -> None:
    path = file("input.cell.toml", data)
    moves = b"MoveL pHome,vNear,zNear,tGrip;\nMoveAbsJ jHome,vNear,fine,tool0;\nnParts:=1;\n"
    text = b"MODULE m\nPROC main()\n" + moves + b"rWash;\nENDPROC\nENDMODULE\n"
    program = file("uses.mod", text)
    with refusing():
        promise(read_cell(path).text != "" or not data.strip(), "a cell file is read as nothing")
        with_cell_values(assistant.load(program), read_cell(path), path)


def scene(data: bytes) -> None:
    """What is written of a scene reads as what is written alike."""
    path = file("input.cell.toml", data)
    with refusing():
        read, findings = read_scene(path)
        sound(findings)
        said(read)
        files = cell_files(read, "written", folder())
        for name, content in files.items():
            file(name, content)
        again = cell_files(read_scene(folder() / "written.toml")[0], "written", folder())
        promise(again == files, "a scene that was written reads as another one")


def robot(data: bytes) -> None:
    with refusing():
        arm = robot_file.read(data, str(folder() / "robot.toml"))
        promise(bool(arm.name), "a robot without a name")
        if arm.outlines is not None:
            drawn_links("arm", arm, {})


def learned_map(data: bytes) -> None:
    """A map answers inside the ranges of its joints, whatever it is shown."""
    path = file("input.npz", data if data.startswith(b"PK") else _archive(data, COLUMNS))
    with refusing():
        net = load_map(path)
        shown = net.scale.middle + np.linspace(-200.0, 200.0, 9)[:, None] * np.ones(net.task.seen)
        found = MapInUse(net).proposed(shown)
        low, high = net.scale.low, net.scale.high
        inside = (found.joints >= low) & (found.joints <= high)
        promise(bool((inside.all(axis=1) | ~found.known).all()), "joints outside their ranges")


def measured_poses(data: bytes) -> None:
    """Joints beside measured points, few enough to be calibrated by."""
    path = file("measured.csv", data)
    with refusing():
        poses = read_measured(path, robots.get("rv-2aj"))
        sound(poses.findings)
        if len(poses) < 60:
            done = calibrate(robots.get("rv-2aj"), poses)
            sound(done.findings)
            promise(bool(np.isfinite(done.fit.state.values).all()), "a correction is no number")


def script(data: bytes) -> None:
    with refusing():
        parse_script(decode(data, "input.signals.toml", ENCODINGS))


def project(data: bytes) -> None:
    """Everything that reads a project's file, each by itself: one refuses what another takes."""
    place = folder() / "project"
    place.mkdir(exist_ok=True)
    (place / "assistant.toml").write_bytes(data)
    for read in (project_of, controllers_of, severities_for):
        with refusing():
            read(place)


def signed(data: bytes) -> bytes:
    """A record with the digest that fits what it says, so that more of it is looked at."""
    try:
        content = json.loads(data)
        content["digest"] = ""
        del content["digest"]
        text = json.dumps(content, indent=2, sort_keys=True) + "\n"
        return json.dumps({**content, "digest": hashlib.sha256(text.encode()).hexdigest()}).encode()
    except (ValueError, TypeError, RecursionError):
        return data


def record(data: bytes) -> None:
    data = signed(data)
    with refusing():
        one = read_record(data, "record.json")
        again = read_record(one.written(), "record.json")
        promise(again == one, "written again, the record is another one")


def history(data: bytes) -> None:
    """The folder of a deployment, its files in one: see `_PARTS`."""
    place = folder() / "0001"
    shutil.rmtree(place, ignore_errors=True)
    for name in ("before", "after"):
        (place / name).mkdir(parents=True)
    for name, part in zip(_PARTS, data.split(_CUT), strict=False):
        (place / name).write_bytes(signed(part) if name == "record.json" else part)
    with refusing():
        steps_of(place)
        read_journal(place)


def kept(data: bytes) -> None:
    place = folder() / "kept"
    (place / ".robot-assistant").mkdir(parents=True, exist_ok=True)
    (place / "assistant.toml").write_text("")
    there = project_of(place)
    (there.kept / BUILD_FILE).write_bytes(data)
    read_build(there)


# ------------------------------------------------------------------------------ seeds

_CUT: Final = b"\n=====\n"
_PARTS: Final = ("record.json", "programs.json", "journal.jsonl", "after/1-a.mod", "earlier.json")


def npz(data: bytes) -> None:
    """An archive, or the arrays of one by turns with their names: their sums fit then."""
    if not data.startswith(b"PK"):
        data = _archive(data, ("positions", "quaternions", "unit", "../a", ""))
    source("input.npz")(data)


def _archive(data: bytes, names: Iterable[str]) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name, part in zip(names, data.split(_CUT), strict=False):
            archive.writestr(f"{name}.npy", part)
    return made.getvalue()


def array(values: object) -> bytes:
    made = io.BytesIO()
    np.save(made, np.asarray(values))
    return made.getvalue()


POSES: Final = [[1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0], [4.0, 5.0, 6.0, 0.0, 0.0, 1.0, 0.0]]


def _npy() -> Iterable[bytes]:
    return [
        array(POSES),
        array(np.array(POSES, dtype=">f4")),
        array(np.asfortranarray(np.stack([np.eye(4)] * 2))),
        array([1, 2]),
        array([["a"]]),
    ]


def _npz() -> Iterable[bytes]:
    whole = io.BytesIO()
    np.savez(whole, positions=np.ones((2, 3)), quaternions=np.eye(4)[:2], unit="mm")
    packed = io.BytesIO()
    np.savez_compressed(packed, a=np.array(POSES))
    parts = (array(np.ones((2, 3))), array(np.eye(4)[:2]), array("mm"))
    return [whole.getvalue(), packed.getvalue(), _CUT.join(parts), _CUT.join([array(POSES)])]


def _learned() -> Iterable[bytes]:
    """A small map as its archive, and as its arrays by turns."""
    made = three_joints()
    net = start_map_with_shape((2, 3, 2), made.arm, made.space, made.ranges)
    train_and_measure(net, made.arm, made.space, usual_plan(50))
    path = str(folder() / "seed.npz")
    save_map(net, path)
    with np.load(path) as archive:
        arrays = [array(archive[name]) for name in COLUMNS]
    return [Path(path).read_bytes(), _CUT.join(arrays)]


def _record() -> Iterable[bytes]:
    one = Record("20260101T000000Z-abcdef", "ftp://h", "2026-01-01T00:00:00+00:00", "me@here")
    return [one.written()]


def _history() -> Iterable[bytes]:
    programs = b'[{"name": "a.mod", "before": {"file": null, "loaded": null}, "after": {"file": '
    programs += (
        b'"after/1-a.mod", "loaded": null}, "sha256": {"after/1-a.mod": "'
        + os.fsencode("ca978112ca1bbdcafac231b39a23dc4da786eff8147c4e72b9807785afee48bb")
        + b'"}}]'
    )
    steps = b'{"time": "", "step": "begun"}\n{"time": "", "step": "done"}\n'
    (one,) = _record()
    return [_CUT.join((one, programs, steps, b"a"))]


_TOML: Final = (
    "\n[a]\n",
    "\n[[a]]\n",
    "=",
    '"""',
    "'''",
    "{a = 1}",
    "1979-05-27T07:32:00Z",
    "0x1F",
)

TARGETS: Final = (
    Target("csv", source("input.csv"), files_of("samples/*.csv", "tests/fuzz/seeds/csv/*")),
    Target("measured", measured_poses, files_of("samples/calibration/*.csv"), tried=6),
    Target("learned", learned_map, _learned, tried=6),
    Target("taught", source("input.toml"), files_of("tests/fuzz/seeds/taught/*"), lambda: _TOML),
    Target("npy", source("input.npy"), _npy),
    Target("npz", npz, _npz),
    Target("json", source("input.json"), files_of("tests/fuzz/seeds/json/*")),
    Target(
        "dxf",
        source("input.dxf"),
        files_of("tests/fuzz/seeds/dxf/*"),
        together=2,
        most=6000,
        tried=12,
    ),
    Target("process", process, files_of("tests/fuzz/seeds/process/*"), lambda: _TOML, tried=12),
    Target("cell", cell, files_of("tests/fuzz/seeds/cell/*"), lambda: _TOML, tried=12),
    Target("scene", scene, files_of("tests/fuzz/seeds/scene/*"), lambda: _TOML, tried=12),
    Target("robot", robot, files_of("assistant/robots/catalogue/r*.toml"), lambda: _TOML),
    Target("urdf", robot, files_of("tests/fuzz/seeds/urdf/*")),
    Target("script", script, files_of("tests/fuzz/seeds/script/*"), lambda: _TOML),
    Target("project", project, files_of("tests/fuzz/seeds/project/*"), lambda: _TOML),
    Target("record", record, _record),
    Target("history", history, _history),
    Target("kept", kept, files_of("tests/fuzz/seeds/kept/*")),
)
