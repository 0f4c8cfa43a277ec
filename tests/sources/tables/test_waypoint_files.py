"""NPY, NPZ and JSON waypoints, and sequences of pose objects: all the same columns."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from assistant import sources
from assistant.base import rotations
from assistant.base.diagnostics import Refused, Severity
from assistant.program.expressions import Name
from assistant.program.geometry import Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import Program
from assistant.program.statements import Follow, Move
from assistant.sources.process import NO_PROCESS, Defaults, Process
from assistant.sources.tables import waypoints
from tests.examples import drawn
from tests.tables import every_row

RNG = np.random.default_rng(3)
POSITIONS = RNG.uniform(-400, 400, (9, 3))
QUATERNIONS = rotations.canonical(RNG.normal(size=(9, 4)))
SEVENS = np.column_stack([POSITIONS, QUATERNIONS])


def homogeneous(positions: np.ndarray, quaternions: np.ndarray) -> np.ndarray:
    matrices = np.tile(np.eye(4), (len(positions), 1, 1))
    matrices[:, :3, :3] = rotations.to_matrix(quaternions)
    matrices[:, :3, 3] = positions
    return matrices


MATRICES = homogeneous(POSITIONS, QUATERNIONS)


def shaped(shape: str, kind: str = "<f8") -> bytes:
    """The begin of an array, with nothing behind it."""
    said = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\1\0" + len(said).to_bytes(2, "little") + said


def zipped(name: str, data: bytes) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr(name, data)
    return stream.getvalue()


def npy(array: np.ndarray, **options: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array, **options)
    return stream.getvalue()


def npz(save: Any = np.savez, **members: Any) -> bytes:
    stream = io.BytesIO()
    save(stream, **members)
    return stream.getvalue()


@pytest.fixture
def read(tmp_path: FilePath) -> Any:
    def of(name: str, data: bytes | str, process: Process = NO_PROCESS) -> sources.Reading:
        path = tmp_path / name
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return waypoints.read(path, process)

    return of


def paths_of(program: Program) -> list[Path]:
    body = program.procedures[0].body
    assert all(isinstance(statement, Follow) for statement in body)
    return [statement.path for statement in body if isinstance(statement, Follow)]


def assert_same_poses(path: Path, scale: float = 1.0) -> None:
    assert np.abs(path.positions - POSITIONS * scale).max() < 1e-9 * scale
    assert rotations.angle_between(path.quaternions, QUATERNIONS).max() < 1e-6


POSE_OBJECTS = [
    {"position": p.tolist(), "quaternion": q.tolist()}
    for p, q in zip(POSITIONS, QUATERNIONS, strict=True)
]
SAME_POSES: dict[str, tuple[str, bytes | str]] = {
    "npy rows": ("seam.npy", npy(SEVENS)),
    "npy matrices": ("seam.npy", npy(MATRICES)),
    "npy fortran order": ("seam.npy", npy(np.asfortranarray(SEVENS))),
    "npy big endian": ("seam.npy", npy(SEVENS.astype(">f8"))),
    "npz one": ("whatever.npz", npz(seam=SEVENS)),
    "npz compressed": ("whatever.npz", npz(np.savez_compressed, seam=MATRICES, unit="mm")),
    "npz two columns": ("seam.npz", npz(positions=POSITIONS, quaternions=QUATERNIONS)),
    "json rows": ("seam.json", json.dumps(SEVENS.tolist())),
    "json matrices": ("seam.json", json.dumps(MATRICES.tolist())),
    "json objects": ("seam.json", json.dumps(POSE_OBJECTS)),
    "json poses": ("seam.json", json.dumps({"unit": "mm", "poses": POSE_OBJECTS}, indent=1)),
    "json paths": ("x.json", "\ufeff" + json.dumps({"paths": {"seam": SEVENS.tolist()}})),
}


@pytest.mark.parametrize("case", SAME_POSES)
def test_every_form_gives_the_same_path(case: str, read: Any) -> None:
    reading = read(*SAME_POSES[case])
    (path,) = paths_of(reading.program)
    assert reading.findings == ()
    assert path.name == "seam"
    assert_same_poses(path)


def test_metres_where_the_file_says_so(read: Any) -> None:
    for name, data in (
        ("seam.npz", npz(positions=POSITIONS, quaternions=QUATERNIONS, unit="m")),
        ("seam.json", json.dumps({"unit": "m", "poses": SEVENS.tolist()})),
    ):
        (path,) = paths_of(read(name, data).program)
        assert_same_poses(path, 1000.0)


def test_several_arrays_are_several_paths_in_their_order(read: Any) -> None:
    reading = read("all.npz", npz(weld=SEVENS, approach=MATRICES[:4], **{"2nd pass": SEVENS}))
    assert [path.name for path in paths_of(reading.program)] == ["weld", "approach", "n_2nd_pass"]
    assert [len(path) for path in paths_of(reading.program)] == [9, 4, 9]
    assert [f.code for f in reading.findings] == ["NM001"]


def test_motion_comes_from_the_process() -> None:
    process = Process(
        defaults=Defaults("joint", Speed(150.0), Blend(100.0), "GRIPPER"),
        tools={"GRIPPER": Tool(Pose((0.0, 0.0, 60.0)))},
    )
    program = waypoints.from_poses(SEVENS, process, "seam", unit="mm")
    (path,) = paths_of(program)
    assert program.tools == dict(process.tools)
    assert (path.kinds == Kind.JOINT).all()
    assert (path.speeds, path.tools) == ((Speed(150.0),), ("GRIPPER",))
    first, *between, last = (path.blends[index] for index in path.blend)
    assert set(between) == {Blend(100.0)} and first == last == FINE


def test_each_of_several_paths_begins_and_ends_in_a_stop(read: Any) -> None:
    process = Process(defaults=Defaults(blend=Blend(3.0)))
    away = np.add(SEVENS, [500, 0, 0, 0, 0, 0, 0])
    first, second = paths_of(read("all.npz", npz(one=SEVENS, two=away), process).program)
    for path in (first, second):
        start, *between, end = (path.blends[index] for index in path.blend)
        assert set(between) == {Blend(3.0)} and start == end == FINE
    single = read("p.json", json.dumps(SEVENS[:1].tolist()), process).program
    (move,) = single.statements()
    assert move.motion.blend == FINE


def test_one_pose_is_a_move() -> None:
    program = waypoints.from_poses([[1, 2, 3, 1, 0, 0, 0]], name="p", unit="mm")
    assert program.targets == {"p_1": Target(Pose((1.0, 2.0, 3.0)))}
    assert program.procedures[0].body == (Move("joint", Name("p_1"), NO_PROCESS.defaults.motion),)


def test_a_warning_if_millimetres_look_like_metres(read: Any) -> None:
    (finding,) = read("seam.npy", npy(np.column_stack([POSITIONS / 1000, QUATERNIONS]))).findings
    assert (finding.code, finding.severity) == ("TB208", Severity.WARNING)


def test_nearly_rigid_matrices_are_repaired_with_one_warning(read: Any) -> None:
    rounded = MATRICES.copy()
    rounded[:, :3, :3] = np.round(rounded[:, :3, :3], 4)
    reading = read("seam.npy", npy(rounded))
    assert [(f.code, f.severity) for f in reading.findings] == [("TB206", Severity.WARNING)]
    (path,) = paths_of(reading.program)
    assert np.abs(np.linalg.norm(path.quaternions, axis=1) - 1).max() < 1e-15
    assert rotations.angle_between(path.quaternions, QUATERNIONS).max() < 0.02


def changed(array: np.ndarray, index: Any, value: float) -> np.ndarray:
    copy = array.copy()
    copy[index] = value
    return copy


class Danger:
    """An object that would tell if it were ever unpickled."""

    def __reduce__(self) -> Any:
        return (pytest.fail, ("a pickle was loaded",))


BAD: dict[str, tuple[str, bytes | str, str, str | None]] = {
    "nan": ("a.npy", npy(changed(SEVENS, (4, 1), np.nan)), "TB201", "[4]"),
    "inf": ("a.npy", npy(changed(MATRICES, (5, 0, 3), np.inf)), "TB201", "[5]"),
    "huge": ("a.npy", npy(changed(SEVENS, (2, 0), 2e6)), "TB202", "[2]"),
    "huge matrix": (
        "a.npy", npy(changed(np.round(MATRICES, 4), (2, 0, 3), 2e6)), "TB202", "[2]",
    ),
    "long quaternion": ("a.npy", npy(changed(SEVENS, (3, 3), 2.0)), "TB203", "[3]"),
    "reflection": (
        "a.npy", npy(MATRICES * np.array([[1, 1, -1, 1]])), "TB205", "[0]",
    ),
    "scaled": ("a.npy", npy(changed(MATRICES, (6, 0, 0), 3.0)), "TB205", "[6]"),
    "transposed": ("a.npy", npy(np.swapaxes(MATRICES, 1, 2)), "TB207", "[0]"),
    "six columns": ("a.npy", npy(SEVENS[:, :6]), "TB411", None),
    "one row only": ("a.npy", npy(SEVENS[0]), "TB411", None),
    "no rows": ("a.npy", npy(SEVENS[:0]), "TB412", None),
    "text": ("a.npy", npy(np.array(["a"])), "TB404", None),
    "complex": ("a.npy", npy(SEVENS.astype(complex)), "TB404", None),
    "half": ("a.npy", npy(SEVENS.astype(np.float16)), "TB405", None),
    "objects": ("a.npy", npy(np.array([Danger()], dtype=object)), "TB403", None),
    "cut": ("a.npy", npy(SEVENS)[:-1], "TB402", None),
    "cut header": ("a.npy", npy(SEVENS)[:50], "TB401", None),
    "no npy": ("a.npy", b"x_mm,y_mm\n", "TB401", None),
    "a size that is not there": (
        "a.npy", npy(SEVENS).replace(b"(9, 7), }       ", b"(900000000, 7), }"), "TB402", None,
    ),
    "an extent beyond all": ("a.npy", shaped("(0, 9999999999999999999999)"), "TB401", None),
    "extents beyond all together": ("a.npy", shaped("(0, 9223372036854775807, 7)"), "TB401", None),
    "seventy dimensions": ("a.npy", shaped(str((1,) * 70)) + bytes(8), "TB401", None),
    "no character": (
        "a.npz", zipped("unit.npy", shaped("()", "<U1") + b"m\0\0?"), "TB401", "`unit`",
    ),
    "no zip": ("a.npz", b"PK..", "TB406", None),
    "cut zip": ("a.npz", npz(seam=SEVENS)[:-30], "TB406", None),
    "member of no array": ("a.npz", b"", "TB408", "zip"),
    "nothing inside": ("a.npz", npz(), "TB412", None),
    "one of two": ("a.npz", npz(positions=POSITIONS), "TB415", None),
    "uneven": ("a.npz", npz(positions=POSITIONS, quaternions=QUATERNIONS[1:]), "TB414", None),
    "more than two": (
        "a.npz", npz(positions=POSITIONS, quaternions=QUATERNIONS, speeds=POSITIONS), "TB423", None,
    ),
    "inches": ("a.npz", npz(seam=SEVENS, unit="inch"), "TB413", "`unit`"),
    "nan in a member": ("a.npz", npz(seam=changed(SEVENS, (7, 2), np.nan)), "TB201", "seam[7]"),
    "no json": ("a.json", "{", "TB421", None),
    "json text": ("a.json", '"poses"', "TB422", None),
    "json empty": ("a.json", "[]", "TB412", None),
    "json deep": ("a.json", "[" * 200_000, "TB421", None),
    "json long number": ("a.json", "[[" + "9" * 5000 + "]]", "TB421", None),
    "json big number": ("a.json", "[[" + "9" * 400 + ",1,1,1,0,0,0]]", "TB424", None),
    "json nan": ("a.json", "[[1,2,NaN,1,0,0,0],[1,2,3,1,0,0,0]]", "TB201", "[0]"),
    "json string": ("a.json", '[[1,2,3,1,0,0,0],[1,2,"3",1,0,0,0]]', "TB424", "[1]"),
    "json truth": ("a.json", "[[1,2,3,1,0,0,0],[1,2,true,1,0,0,0]]", "TB424", "[1]"),
    "json changing form": (
        "a.json", json.dumps([POSE_OBJECTS[0], SEVENS[1].tolist()]), "TB424", "[1]",
    ),
    "json more keys": (
        "a.json", json.dumps([POSE_OBJECTS[0] | {"speed": 3}]), "TB424", "[0]",
    ),
    "json unknown key": ("a.json", '{"poses": [[1,2,3,1,0,0,0]], "units": "m"}', "TB423", None),
    "json unit": ("a.json", '{"poses": [[1,2,3,1,0,0,0]], "unit": 3}', "TB413", "`unit`"),
    "json key twice": ("a.json", '{"poses": [], "poses": [[1,2,3,1,0,0,0]]}', "TB425", None),
    "no text": ("a.json", b"\xff\xfe\x00", "IN006", None),
}  # fmt: skip


@every_row("case", list(BAD))
def test_bad_input_is_refused_with_its_place_and_a_cure(case: str, read: Any) -> None:
    name, data, code, place = BAD[case]
    if place == "zip":
        data, place = zipped("../../readme.txt", b"hello"), None
    with pytest.raises(Refused) as refused:
        read(name, data)
    (finding,) = [f for f in refused.value.findings if f.severity is Severity.ERROR]
    assert finding.code == code
    assert (finding.path or "").endswith(name)
    assert place is None or finding.place == place
    assert finding.cure
    assert "\n" not in finding.message


def test_a_json_mistake_is_shown_with_line_and_column(read: Any) -> None:
    with pytest.raises(Refused) as refused:
        read("a.json", "[\n  [1, 2, 3, 1, 0, 0, 0],\n  [1, 2 3, 1, 0, 0, 0]\n]")
    (finding,) = refused.value.findings
    assert (finding.line, finding.column) == (3, 9)
    assert finding.excerpt == "  [1, 2 3, 1, 0, 0, 0]"
    assert refused.value.exit_status == 2


def test_lines_of_json_are_told_as_those_of_the_file(read: Any) -> None:
    with pytest.raises(Refused) as refused:
        read("a.json", '{"unit": "mm",\r "poses": x}')
    (finding,) = refused.value.findings
    assert (finding.line, finding.column, finding.excerpt) == (2, 11, ' "poses": x}')


@given(at=st.integers(0, 10_000), put=st.binary(max_size=4), gone=st.integers(0, 4))
@settings(deadline=None, max_examples=drawn(200))
def test_damaged_arrays_are_read_or_refused_never_crash(at: int, put: bytes, gone: int) -> None:
    for whole, read in ((npy(SEVENS), waypoints._read_npy), (npz(s=SEVENS), waypoints._read_npz)):
        at %= len(whole)
        data = whole[:at] + put + whole[at + gone :]
        try:
            reading = read(data, "a", "a", NO_PROCESS)
        except Refused as refused:
            assert all(f.path == "a" for f in refused.findings)
        else:
            for path in paths_of(reading.program):
                assert np.isfinite(path.positions).all()


@given(st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=4) | st.integers(),
    lambda inner: st.lists(inner, max_size=7)
    | st.dictionaries(st.sampled_from(["poses", "paths", "unit", "position"]), inner, max_size=3),
    max_leaves=20,
))  # fmt: skip
@settings(deadline=None, max_examples=drawn(200))
def test_any_json_is_read_or_refused(document: Any) -> None:
    try:
        waypoints._read_json(json.dumps(document).encode(), "a", "a", NO_PROCESS)
    except Refused as refused:
        assert all(f.path == "a" for f in refused.findings)


@given(
    raw=arrays.arrays(np.float64, (5, 7), elements=st.floats(-1, 1)),
    unit=st.sampled_from(["mm", "m"]),
)
@settings(deadline=None)
def test_rows_matrices_and_se3_are_the_same(raw: np.ndarray, unit: Any) -> None:
    from spatialmath import SE3

    raw[np.linalg.norm(raw[:, 3:], axis=1) < 0.1, 3:] = (0.5, 0.5, -0.5, 0.5)
    positions, quaternions = raw[:, :3], rotations.canonical(raw[:, 3:])
    matrices = homogeneous(positions, quaternions)
    forms: list[Any] = [
        np.column_stack([positions, quaternions]),
        matrices,
        SE3([SE3(m, check=False) for m in matrices]),
        [SE3(m, check=False) for m in matrices],
        (SE3(m, check=False) for m in matrices),
    ]
    scale = 1000.0 if unit == "m" else 1.0
    for form in forms:
        (path,) = paths_of(waypoints.from_poses(form, unit=unit))
        assert np.abs(path.positions - positions * scale).max() < 1e-9
        assert rotations.angle_between(path.quaternions, quaternions).max() < 1e-5


def test_a_single_se3_is_one_pose() -> None:
    from spatialmath import SE3

    program = waypoints.from_poses(SE3(0.1, 0.2, 0.3), name="p", unit="m")
    assert program.targets["p_1"].pose == Pose((100.0, 200.0, 300.0))


@pytest.mark.parametrize("poses", [3, "abc", ["abc"], [[1, 2], [3]], np.zeros((3, 5)), []])
def test_what_is_no_sequence_of_poses_is_refused(poses: Any) -> None:
    with pytest.raises(Refused) as refused:
        waypoints.from_poses(poses, unit="mm")
    assert refused.value.findings[0].code in {"TB444", "TB411", "TB412"}


def test_the_unit_of_poses_must_be_stated() -> None:
    with pytest.raises(Refused) as refused:
        waypoints.from_poses(SEVENS, unit="inch")  # type: ignore[arg-type]
    assert refused.value.findings[0].code == "TB413"
    with pytest.raises(TypeError):
        waypoints.from_poses(SEVENS)  # type: ignore[call-arg]
