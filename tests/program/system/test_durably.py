"""A file that is written whole, and what others have left beside it."""

from __future__ import annotations

import os

import pytest

from assistant.base import file_access
from assistant.base.file_access import UNFINISHED, write_whole


@pytest.mark.skipif(os.name == "nt", reason="what is open cannot be deleted there")
def test_what_a_killed_one_has_left_goes_and_what_is_under_way_stays(tmp_path):
    (tmp_path / f"{UNFINISHED}left").write_bytes(b"half")
    under_way = tmp_path / f"{UNFINISHED}now"
    with under_way.open("wb") as file:
        lock = file_access.lock_open_file(file.fileno())
    write_whole(tmp_path / "a.mod", b"one")
    assert sorted(os.listdir(tmp_path)) == [under_way.name, "a.mod"]
    file_access.free_lock(lock)
    write_whole(tmp_path / "a.mod", b"two")
    assert os.listdir(tmp_path) == ["a.mod"]
    assert (tmp_path / "a.mod").read_bytes() == b"two"


def test_a_folder_in_the_way_leaves_nothing_behind(tmp_path):
    (tmp_path / "a.mod").mkdir()
    with pytest.raises(OSError, match=r"a\.mod"):
        write_whole(tmp_path / "a.mod", b"one")
    assert os.listdir(tmp_path) == ["a.mod"]
