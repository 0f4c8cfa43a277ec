"""Paths that state no blend: corners rounded within the tolerance, and a joint move to begin."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import assistant
from assistant import sources
from assistant.program.motion import FINE, Blend, Kind
from assistant.program.statements import Follow, Move
from assistant.sources.contours.path_tolerance import ROUNDING_RADII, rounding_radii
from assistant.sources.process import Defaults, Process
from assistant.sources.tables import waypoints
from tests.examples import drawn

TURN = (1.0, 0.0, 0.0, 0.0)
HEADER = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z"


def poses(positions):
    return np.column_stack([positions, np.tile(TURN, (len(positions), 1))])


def path_of(program):
    (statement,) = program.procedures[0].body
    assert isinstance(statement, Follow)
    return statement.path


def blends(path):
    return [path.blends[i].radius for i in path.blend]


def to_lines(points, corners):
    """Mm from points (m, 3) to the nearest of the lines through corners (n, 3)."""
    a, along = corners[:-1], np.diff(corners, axis=0)
    size = np.maximum((along**2).sum(axis=1), 1e-30)
    t = np.clip(((points[:, None] - a) * along).sum(axis=2) / size, 0.0, 1.0)
    return np.linalg.norm(points[:, None] - (a + t[..., None] * along), axis=2).min(axis=1)


@settings(max_examples=drawn(60), deadline=None)
@given(st.integers(0, 2**32), st.floats(0.01, 2.0))
def test_a_rounded_way_stays_within_the_tolerance(seed, tolerance):
    random = np.random.default_rng(seed)
    steps = random.normal(size=(20, 3)) * 10 ** random.uniform(-2, 2, (20, 1))
    corners = np.cumsum(steps, axis=0)
    sizes = rounding_radii(corners, np.full(20, Kind.LINEAR), np.ones(19, dtype=bool), tolerance)
    way = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    assert sizes[0] == sizes[-1] == 0.0
    assert set(sizes[1:-1]) <= {0.0, *ROUNDING_RADII}
    assert (sizes[1:-1] <= np.minimum(way[:-1], way[1:]) / 2 * (1 + 1e-6)).all()
    for i in range(1, 19):
        before = corners[i] + (corners[i - 1] - corners[i]) / way[i - 1] * sizes[i]
        after = corners[i] + (corners[i + 1] - corners[i]) / way[i] * sizes[i]
        t = np.linspace(0, 1, 21)[:, None]
        for bow in (0.0, 0.5, 1.0):  # a chord, a parabola, the corner itself
            middle = (1 - bow) * (before + after) / 2 + bow * corners[i]
            cut = (1 - t) ** 2 * before + 2 * t * (1 - t) * middle + t**2 * after
            assert to_lines(cut, corners[i - 1 : i + 2]).max() <= tolerance * (1 + 1e-6)
            assert np.linalg.norm(cut - corners[i], axis=1).min() <= tolerance * (1 + 1e-6)


def test_a_line_of_many_points_is_not_a_row_of_stops():
    x = 80_000.0 + np.arange(200_000) * 0.1
    path = path_of(waypoints.from_poses(poses(np.column_stack([x, 0 * x, 0 * x])), unit="mm"))
    radius = np.array([b.radius or 0.0 for b in path.blends])[path.blend]
    assert (radius[[0, -1]] == 0.0).all()
    assert (radius[1:-1] == 0.05).all()


def test_an_arc_that_goes_on_smoothly_is_no_corner():
    rows = "0,0,0,1,0,0,0,\n100,0,0,1,0,0,0,linear\n170.710678,29.289322,0,1,0,0,0,via\n"
    rows += "200,100,0,1,0,0,0,end\n200,200,0,1,0,0,0,linear\n0,200,0,1,0,0,0,linear\n"
    path = path_of(sources_of(f"{HEADER},motion\n{rows}"))
    assert path.kinds.tolist() == [Kind.JOINT, Kind.LINEAR, Kind.VIA, Kind.END, *[Kind.LINEAR] * 2]
    # r²/2R is 0.05 mm at 3.16 mm; the corner of 90 degrees takes 0.07 mm
    assert blends(path) == [None, 1.0, None, 1.0, 0.05, None]


def sources_of(text, process=""):
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "way.csv"
        file.write_text(text)
        if process:
            file.with_suffix(".process.toml").write_text(process)
        return sources.read(file).program


SQUARE = "".join(f"{x},{y},0,1,0,0,0\n" for x, y in ((0, 0), (50, 0), (50, 50), (0, 50)))


@pytest.mark.parametrize(
    ("process", "wanted"),
    [
        ("", [None, 0.05, 0.05, None]),
        ("tolerance = 1", [None, 1.0, 1.0, None]),
        ('[motion]\nblend = "fine"', [None] * 4),
        ("[motion]\nblend = 7", [None, 7.0, 7.0, None]),
    ],
)
def test_what_the_process_file_says_holds(process, wanted):
    assert blends(path_of(sources_of(f"{HEADER}\n{SQUARE}", process))) == wanted


def test_what_rows_say_holds():
    rows = "0,0,0,1,0,0,0,\n50,0,0,1,0,0,0,fine\n50,50,0,1,0,0,0,3\n"
    rows += "0,50,0,1,0,0,0,\n0,0,0,1,0,0,0,2"
    path = path_of(sources_of(f"{HEADER},blend_mm\n{rows}\n"))
    assert blends(path) == [None, None, 3.0, 0.05, 2.0]


def test_frames_that_change_are_not_measured_across():
    rows = "0,0,0,1,0,0,0,a\n50,0,0,1,0,0,0,a\n60,0,0,1,0,0,0,b\n70,0,0,1,0,0,0,b\n"
    process = "[frames.a]\nposition=[0,0,0]\n[frames.b]\nposition=[0,500,0]\n"
    path = path_of(sources_of(f"{HEADER},frame\n{rows}", process))
    assert blends(path) == [None] * 4


def test_turning_on_the_spot_is_a_stop():
    where = np.array([[0, 0, 0], [10, 0, 0], [10, 0, 0], [20, 0, 0]], dtype=float)
    path = path_of(waypoints.from_poses(poses(where), unit="mm"))
    assert blends(path) == [None] * 4


def test_the_way_to_the_first_point_is_a_joint_move(tmp_path):
    program = waypoints.from_poses(poses(np.eye(3) * 100), unit="mm")
    assert path_of(program).kinds.tolist() == [Kind.JOINT, Kind.LINEAR, Kind.LINEAR]
    stated = Process(Defaults(kind="joint", blend=FINE))
    path = path_of(waypoints.from_poses(poses(np.eye(3)), stated, unit="mm"))
    assert (path.kinds == Kind.JOINT).all()
    assert path.blends == (FINE,)
    parts = {"one": poses(np.eye(3)), "two": poses(np.eye(3) + 50)}
    np.savez(tmp_path / "parts.npz", **parts)
    one, two = sources.read(tmp_path / "parts.npz").program.procedures[0].body
    assert one.path.kinds[0] == Kind.JOINT
    assert two.path.kinds[0] == Kind.LINEAR  # from where the first one ends
    said = sources_of(f"{HEADER},motion\n0,0,0,1,0,0,0,linear\n9,0,0,1,0,0,0,linear\n")
    assert path_of(said).kinds[0] == Kind.LINEAR  # as the row says


def first_move(text, process=""):
    """The first move of a table: its mm/s, and mm of its corner."""
    path = path_of(sources_of(text, process))
    return path.speeds[path.speed[0]].tcp, path.blends[path.blend[0]].radius


@pytest.mark.parametrize(
    ("columns", "rows", "process", "wanted"),
    [
        ("", ["", ""], "[motion]\nspeed = 8\nblend = 3", (200.0, None)),
        ("", ["", ""], "[motion]\nspeed = 8\nblend = 3\ntravel = 120", (120.0, None)),
        (",blend_mm", [",5", ",5"], "[motion]\nspeed = 8", (200.0, None)),
        (",speed_mm_s", [",9", ",8"], "", (9.0, None)),
        (",motion,blend_mm", [",joint,5", ",linear,5"], "[motion]\nspeed = 8", (8.0, 5.0)),
        ("", ["", ""], '[motion]\nkind = "joint"\nspeed = 8\nblend = 3', (8.0, None)),
    ],
)
def test_the_way_to_the_first_point_is_a_joint_move_of_its_own(columns, rows, process, wanted):
    one, two = (f"{x},0,0,1,0,0,0{row}" for x, row in zip((10, 90), rows, strict=True))
    assert first_move(f"{HEADER}{columns}\n{one}\n{two}\n", process) == wanted


def test_named_targets_begin_with_a_joint_move_and_stop():
    program = sources_of(f"name,{HEADER}\np,0,0,0,1,0,0,0\nq,9,0,0,1,0,0,0\n")
    first, second = program.procedures[0].body
    assert isinstance(first, Move) and isinstance(second, Move)
    assert (first.kind, second.kind) == ("joint", "linear")
    assert first.motion.blend == second.motion.blend == FINE


@pytest.mark.parametrize("language", assistant.languages.names())
def test_every_language_can_say_it(language):
    t = np.linspace(0, 1, 50)[:, None]
    way = np.column_stack([400 + 50 * t, 100 * t, 300 + 20 * np.sin(6 * t)])
    turned = np.column_stack([way, np.tile((0.0, 1.0, 0.0, 0.0), (50, 1))])
    compiled = assistant.compile(waypoints.from_poses(turned, unit="mm"), language=language)
    assert compiled.ok, compiled.findings
    assert Blend(0.3) in path_of(waypoints.from_poses(turned, unit="mm")).blends
