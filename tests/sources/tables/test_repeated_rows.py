"""Rows that are where the row before them is: they are left out, as each would be a stop."""

import numpy as np
import pytest

import assistant
from assistant.program.statements import Follow, MoveJoints

HEAD = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z"


def ring(count):
    angle = np.linspace(0.0, np.pi, count)
    rows = np.zeros((count, 7))
    rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 4] = (
        500 * np.cos(angle),
        500 * np.sin(angle),
        300,
        1,
    )
    return rows


def csv(path, rows, more="", cells=()):
    cells = cells or [""] * len(rows)
    lines = [",".join(repr(float(v)) for v in row) + c for row, c in zip(rows, cells, strict=True)]
    path.write_text("\n".join([HEAD + more, *lines]) + "\n")
    return path


def path_of(source):
    program = assistant.load(source)
    return [s.path for s in program.program.procedures[0].body if isinstance(s, Follow)]


def stops(source):
    made = assistant.compile(source, language="rapid")
    text = "".join(text.decode() for text in made.files.values())
    return text.count(",fine,"), [f for f in made.findings if f.code == "TB314"]


@pytest.mark.parametrize("apart", [0.0, 1e-7, 5e-4])
@pytest.mark.parametrize("kind", ["csv", "npy", "npz", "json"])
def test_each_point_twice_is_no_stop(apart, kind, tmp_path):
    once = ring(40)
    rows = np.repeat(once, 2, axis=0)
    rows[1::2, 0] += apart
    path = tmp_path / f"a.{kind}"
    if kind == "csv":
        csv(path, rows)
    elif kind == "npy":
        np.save(path, rows)
    elif kind == "npz":
        np.savez(path, arc=rows)
    else:
        path.write_text(str({"unit": "mm", "poses": rows.tolist()}).replace("'", '"'))
    count, told = stops(path)
    assert count <= 2
    (finding,) = told
    assert finding.severity == "info"
    assert finding.message.startswith("40 rows")
    (path_,) = path_of(path)
    assert path_.positions == pytest.approx(once[:, :3])


def test_a_slow_drift_is_followed(tmp_path):
    rows = np.repeat(ring(2)[:1], 2001, axis=0)
    rows[:, 0] += 1e-4 * np.arange(2001)
    (path,) = path_of(csv(tmp_path / "a.csv", rows))
    assert path.positions[-1, 0] == pytest.approx(rows[-1, 0], abs=1e-3)
    assert np.diff(path.positions[:, 0]).min() > 1e-3


def test_rows_that_turn_or_differ_stay(tmp_path):
    rows = np.repeat(ring(2)[:1], 3, axis=0)
    rows[1, 3:] = (0.0, np.cos(0.01), np.sin(0.01), 0.0)
    (path,) = path_of(csv(tmp_path / "a.csv", rows))
    assert len(path) == 3
    same = np.repeat(ring(3), 2, axis=0)
    speeds = [",100", ",50"] * 3
    (path,) = path_of(csv(tmp_path / "b.csv", same, ",speed_mm_s", speeds))
    assert len(path) == 6
    (path,) = path_of(csv(tmp_path / "c.csv", same, ",speed_mm_s", [",100"] * 6))
    assert len(path) == 3


def test_arcs_keep_their_rows(tmp_path):
    rows = ring(5)[[0, 0, 2, 4, 4]]
    words = [",linear", ",linear", ",via", ",end", ",linear"]
    (path,) = path_of(csv(tmp_path / "a.csv", rows, ",motion", words))
    assert len(path) == 3


def test_repeated_joints_are_one_move(tmp_path):
    path = tmp_path / "a.csv"
    head = ",".join(f"j{i}_deg" for i in range(1, 7))
    path.write_text(f"{head}\n0,0,0,0,30,0\n0,0,0,0,30,0\n10,0,0,0,30,0\n")
    body = assistant.load(path).program.procedures[0].body
    assert len([s for s in body if isinstance(s, MoveJoints)]) == 2


def test_joined_trajectories_share_their_ends(tmp_path):
    path, rows = tmp_path / "a.npz", ring(21)
    np.savez(path, one=rows[:11], two=rows[10:])
    first, second = path_of(path)
    assert (len(first), len(second)) == (11, 10)
    assert len(stops(path)[1]) == 1


def test_named_rows_are_moves_each(tmp_path):
    rows = np.repeat(ring(2), 2, axis=0)
    path = csv(tmp_path / "a.csv", rows, ",name", [f",p{i}" for i in range(4)])
    assert len(assistant.load(path).program.targets) == 4


@pytest.mark.parametrize("kind", ["csv", "npy"])
def test_steps_far_below_the_tolerance_are_no_stops(kind, tmp_path):
    angle = np.linspace(0.0, np.pi / 2.0, 3142)  # 10 micrometres of a circle of 20 mm
    rows = np.zeros((2 * len(angle), 7))
    rows[: len(angle), 0], rows[: len(angle), 1] = 20 * np.cos(angle), 20 * np.sin(angle)
    rows[len(angle) :, 0] = -0.01 * np.arange(1, len(angle) + 1)  # then a corner and a line
    rows[len(angle) :, 1] = 20.0 - 0.01 * np.arange(1, len(angle) + 1)
    rows[:, 2], rows[:, 4] = 300, 1
    path = tmp_path / f"a.{kind}"
    if kind == "csv":
        csv(path, rows)
    else:
        np.save(path, rows)
    made = assistant.compile(path, language="rapid")
    text = "".join(text.decode() for text in made.files.values())
    assert text.count(",fine,") <= 2
    (finding,) = [f for f in made.findings if f.code == "TB315"]
    assert finding.severity == "info"
    (path_,) = path_of(path)
    assert len(path_) < 100
    line = path_.positions
    for point in rows[::7, :3]:
        way = np.diff(line, axis=0)
        share = ((point - line[:-1]) * way).sum(axis=1) / (way**2).sum(axis=1)
        foot = line[:-1] + np.clip(share, 0.0, 1.0)[:, None] * way
        assert np.linalg.norm(point - foot, axis=1).min() <= 0.05
    assert np.linalg.norm(line - (0.0, 20.0, 300.0), axis=1).min() < 0.01  # the corner stays


def test_short_rows_with_a_blend_or_data_of_their_own_stay(tmp_path):
    rows = np.repeat(ring(2)[:1], 50, axis=0)
    rows[:, 0] += 0.01 * np.arange(50)
    (path,) = path_of(csv(tmp_path / "a.csv", rows, ",blend_mm", [",0.01"] * 50))
    assert len(path) == 50
    (path,) = path_of(csv(tmp_path / "b.csv", rows, ",speed_mm_s", [",20", ",30"] * 25))
    assert len(path) == 50
    (path,) = path_of(csv(tmp_path / "c.csv", rows))
    assert len(path) == 2
