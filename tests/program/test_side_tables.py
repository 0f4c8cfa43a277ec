"""Paths in side tables: exact, small, the same bytes every time, and refused when damaged."""

from __future__ import annotations

import hashlib
import io
import pickle
import re
import zipfile
from pathlib import Path as FilePath

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.program.expressions import Name
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.pseudo import Printed, parse, print_program, read
from assistant.program.statements import Follow

RANDOM = np.random.default_rng(7)


def seam(n: int = 50, name: str = "seam") -> Path:
    return Path.of(
        name,
        RANDOM.normal(size=(n, 3)) * 500,
        rotations.canonical(RANDOM.normal(size=(n, 4))),
        kinds=np.arange(n) % 2,
        speeds=[Speed(50.0), Name("v_unused"), Speed(100.0), Speed(50.0)],
        blends=[Blend(1.0), FINE],
        tools=["gripper"],
        frames=["base", "table"],
        speed=np.array([2, 0, 3])[np.arange(n) % 3],
        blend=np.arange(n) % 2,
        frame=1,
    )


def of(*paths: Path) -> Program:
    return Program("plate", (Procedure("main", tuple(Follow(p) for p in paths)),))


def written(printed: Printed, folder: FilePath) -> FilePath:
    for name, data in printed.tables.items():
        (folder / name).write_bytes(data)
    file = folder / "plate.pseudo"
    file.write_bytes(printed.encode())
    return file


def test_a_long_path_goes_to_a_table_and_its_speeds_stay_readable(tmp_path: FilePath) -> None:
    program = of(seam())
    printed = print_program(program, side_tables_above=49)
    digest = hashlib.sha256(printed.tables["plate_seam.npz"]).hexdigest()
    assert printed.text.splitlines()[3:-1] == [
        f'  follow seam from "plate_seam.npz" rows 50 sha256 {digest}',
        "    speed 100 mm/s",
        "    speed 50 mm/s",
        "    blend 1 mm",
        "    blend fine",
        "    tool gripper",
        "    frame table",
        "  end",
    ]
    assert read(written(printed, tmp_path)) == program
    assert parse(printed.text, side_tables=tmp_path) == program


def test_a_path_of_just_that_many_rows_stays_in_the_text() -> None:
    printed = print_program(of(seam()), side_tables_above=50)
    assert not printed.tables
    assert printed.text.count("\n") == 56


def test_tables_have_names_of_their_own() -> None:
    printed = print_program(of(seam(), seam(name="Seam"), seam()), side_tables_above=0)
    assert list(printed.tables) == ["plate_seam.npz", "plate_Seam_2.npz", "plate_seam_3.npz"]


def test_equal_paths_give_equal_bytes() -> None:
    path = seam()
    other = Path.of(
        path.name,
        path.positions,
        path.quaternions,
        kinds=path.kinds,
        speeds=[Speed(100.0), Speed(50.0)],
        blends=[FINE, Blend(1.0)],
        tools=["tool0", "gripper"],
        frames=["table"],
        speed=np.array([0, 1, 1])[np.arange(50) % 3],
        blend=1 - np.arange(50) % 2,
        tool=1,
    )
    assert path == other
    assert print_program(of(path), side_tables_above=0) == print_program(
        of(other), side_tables_above=0
    )


def test_constant_columns_are_stored_once() -> None:
    n = 10_000
    path = Path.of("line", RANDOM.normal(size=(n, 3)), [[1.0, 0, 0, 0]] * n, speeds=[Speed(1.0)])
    printed = print_program(of(path), side_tables_above=0)
    assert len(printed.tables["plate_line.npz"]) < n * 3 * 8 + 4000
    assert parse(printed.text, side_tables=printed.tables) == of(path)


def test_many_rows_in_the_text_come_back() -> None:
    program = of(seam(40_000))
    printed = print_program(program)
    (statement,) = parse(printed.text).procedures[0].body
    assert isinstance(statement, Follow)
    assert Program("plate", (Procedure("main", (statement,)),)) == program
    assert statement.path.positions.dtype == np.float64
    assert statement.path.speed.dtype == np.int32


# ---------------------------------------------------------------------------------- damaged


def refused(text: str, tables: object) -> str:
    with pytest.raises(Refused) as found:
        parse(text, side_tables=tables)  # type: ignore[arg-type]
    (finding,) = found.value.findings
    assert finding.line == 4
    return f"{finding.code} {finding.message}"


def rewritten(printed: Printed, **members: object) -> tuple[str, dict[str, bytes]]:
    """The table with other members, and the text with its new sum."""
    (name,) = printed.tables
    columns = dict(np.load(io.BytesIO(printed.tables[name])))
    columns |= members
    buffer = io.BytesIO()
    np.savez(buffer, **{key: value for key, value in columns.items() if value is not None})
    return summed(printed.text, name, buffer.getvalue())


def summed(text: str, name: str, data: bytes) -> tuple[str, dict[str, bytes]]:
    digest = hashlib.sha256(data).hexdigest()
    return re.sub("sha256 .*", f"sha256 {digest}", text), {name: data}


@pytest.fixture
def printed() -> Printed:
    return print_program(of(seam()), side_tables_above=0)


def test_a_table_of_another_program_is_refused(printed: Printed) -> None:
    (other,) = print_program(of(seam()), side_tables_above=0).tables.values()
    assert refused(printed.text, {"plate_seam.npz": other}).startswith("PS414")


def test_a_missing_table_is_refused(printed: Printed, tmp_path: FilePath) -> None:
    assert refused(printed.text, tmp_path).startswith("PS413")
    assert refused(printed.text, {}).startswith("PS413")
    (tmp_path / "plate_seam.npz").mkdir()
    assert "is a folder" in refused(printed.text, tmp_path)


@pytest.mark.parametrize(
    ("members", "reason"),
    [
        ({"external": None}, "members are not the columns"),
        ({"more": np.zeros(3)}, "members are not the columns"),
        ({"positions": np.zeros((49, 3))}, "`positions` is"),
        ({"positions": np.zeros((1, 3))}, "`positions` is"),
        ({"positions": np.zeros((50, 3), dtype=np.float32)}, "`positions` is float32"),
        ({"positions": np.zeros((50, 3), order="F")}, "`positions` is"),
        ({"positions": np.zeros((5000, 3))}, "more rows than the text says"),
        ({"positions": np.full((50, 3), np.nan)}, "row 1: a coordinate is not a finite number"),
        ({"quaternions": np.ones((1, 4))}, "row 1: the quaternion is of length 2"),
        ({"speed": np.full(50, 7, dtype=np.int32)}, "speed index"),
        ({"speed": np.full(50, -1, dtype=np.int32)}, "speed index"),
        ({"kinds": np.full(50, 9, dtype=np.uint8)}, "no known kind"),
        ({"kinds": np.full(50, Kind.VIA, dtype=np.uint8)}, "row 1: a `via` row"),
        ({"configurations": np.full((1, 6), 3, dtype=np.int8)}, "no arm branch"),
        ({"positions": np.full((50, 3), {}, dtype=object)}, "positions"),
    ],
)
def test_a_table_that_does_not_fit_is_refused(
    printed: Printed, members: dict[str, object], reason: str
) -> None:
    message = refused(*rewritten(printed, **members))
    assert message.startswith("PS415") and reason in message


def test_objects_in_a_table_are_never_made(printed: Printed, tmp_path: FilePath) -> None:
    class Bomb:
        def __reduce__(self) -> tuple[object, tuple[object, ...]]:
            return FilePath.touch, (tmp_path / "went off",)

    bomb = np.empty((50, 3), dtype=object)
    bomb[:] = Bomb()
    assert refused(*rewritten(printed, positions=bomb)).startswith("PS415")
    assert not (tmp_path / "went off").exists()
    pickle.loads(pickle.dumps(Bomb()))
    assert (tmp_path / "went off").exists()


def test_a_file_that_is_no_archive_is_refused(printed: Printed) -> None:
    (data,) = printed.tables.values()
    for damaged in (b"", b"PK\x03\x04", data[:-30], data[:500], b"text" * 100):
        assert refused(*summed(printed.text, "plate_seam.npz", damaged)).startswith("PS415")


def test_a_flipped_bit_in_an_archive_is_refused(printed: Printed) -> None:
    (data,) = printed.tables.values()
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        at = archive.getinfo("positions.npy").header_offset + 400
    flipped = data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]
    assert refused(printed.text, {"plate_seam.npz": flipped}).startswith("PS414")
    assert refused(*summed(printed.text, "plate_seam.npz", flipped)).startswith("PS415")


@pytest.mark.parametrize("name", ["../x.npz", "a/b.npz", "a\\b.npz", "C:x.npz", "..", "", "a\0b"])
def test_a_table_is_only_ever_beside_its_text(
    printed: Printed, tmp_path: FilePath, name: str
) -> None:
    escaped = name.replace("\\", "\\\\").replace("\0", "\\x00")
    text = printed.text.replace("plate_seam.npz", escaped)
    assert refused(text, tmp_path).startswith("PS412")
    assert refused(text, {name: b""}).startswith("PS412")
