"""Files of learned maps: whole or not at all, and refused where they are something else."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.learning.map_file import load_map, save_map
from tests.learning.maps.small import SMALL


def columns() -> dict[str, np.ndarray]:
    with np.load(SMALL) as archive:
        return dict(archive)


def refused(path: Path, **changed: object) -> str:
    np.savez(path, **(columns() | changed))  # type: ignore[arg-type]
    return code_of(path)


def code_of(path: Path) -> str:
    with pytest.raises(Refused) as caught:
        load_map(path)
    assert caught.value.exit_status == 2
    (finding,) = caught.value.findings
    assert finding.path == str(path)
    return finding.code


def test_a_map_comes_back_as_it_was(tmp_path) -> None:
    first = load_map(SMALL)
    save_map(first, tmp_path / "map.npz")
    again = load_map(tmp_path / "map.npz")
    assert (again.task, again.shape, again.steps) == (first.task, first.shape, first.steps)
    for name in ("places", "answers", "wins", "missed"):
        assert np.array_equal(getattr(again, name), getattr(first, name), equal_nan=True)
    for name in ("middle", "frame", "low", "high"):
        assert np.array_equal(getattr(again.scale, name), getattr(first.scale, name))
    again.places[0] = 0.0  # a loaded map learns


def test_a_file_that_cannot_be_written_leaves_the_old_one(tmp_path) -> None:
    file = tmp_path / "map.npz"
    file.mkdir()
    with pytest.raises(Refused):
        save_map(load_map(SMALL), file)
    assert [one.name for one in tmp_path.iterdir()] == ["map.npz"]


def test_another_version_says_so(tmp_path) -> None:
    assert refused(tmp_path / "map.npz", about=np.array([2.0, 10.0, 1.0])) == "LN002"


@pytest.mark.parametrize(
    "changed",
    [
        {"kind": np.array("explored space")},
        {"shape": np.array([7.0, 12.0, 5.0])},
        {"shape": np.array([1e9, 1e9])},
        {"shape": np.array([])},
        {"places": np.full((336, 4), np.nan)},
        {"answers": np.full((336, 15), 1e300)},
        {"places": np.zeros((336, 4), dtype=np.float32)},
        {"places": np.array("text")},
        {"answers": np.zeros((336, 14))},
        {"robot": np.zeros(3)},
        {"about": np.zeros(2)},
        {"about": np.array([1.0, -1.0, 1.0])},
        {"low": np.array([90.0, 120.0, 120.0])},
        {"frame": np.zeros((4, 4))},
        {"wins": np.array([None] * 336)},
        {"cameras": np.array("left")},
    ],
    ids=str,
)
def test_columns_that_are_no_map_are_refused(tmp_path, changed) -> None:
    assert refused(tmp_path / "map.npz", **changed) == "LN001"


def test_damaged_files_are_refused(tmp_path) -> None:
    data, file = SMALL.read_bytes(), tmp_path / "map.npz"
    draw = np.random.default_rng(4)
    file.write_bytes(b"")
    assert code_of(file) == "IN005"
    for end in [1, 100, *draw.integers(0, len(data), 30).tolist()]:
        file.write_bytes(data[:end])
        assert code_of(file) == "LN001"
    for at in draw.integers(0, len(data), 60).tolist():
        file.write_bytes(data[:at] + bytes([data[at] ^ 0x55]) + data[at + 1 :])
        try:
            load_map(file)  # a byte of a date, or one that nothing reads
        except Refused as caught:
            assert [one.code for one in caught.findings] in (["LN001"], ["LN002"])


def test_a_header_that_claims_more_than_there_is_allocates_nothing(tmp_path) -> None:
    head = io.BytesIO()
    said = {"descr": "<f8", "fortran_order": False, "shape": (10**15,)}
    np.lib.format.write_array_header_1_0(head, said)
    file = tmp_path / "map.npz"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("places.npy", head.getvalue())
    assert code_of(file) == "LN001"


def test_a_bomb_is_not_unpacked(tmp_path) -> None:
    file = tmp_path / "map.npz"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        archive.writestr("places.npy", b"small")
    data = bytearray(file.read_bytes())
    at = data.index(b"PK\1\2") + 24  # how large the directory says that it will be
    data[at : at + 4] = (4_000_000_000).to_bytes(4, "little")
    file.write_bytes(data)
    assert code_of(file) == "LN001"


def test_a_missing_file_is_told(tmp_path) -> None:
    with pytest.raises(Refused) as caught:
        load_map(tmp_path / "none.npz")
    assert caught.value.exit_status == 2
