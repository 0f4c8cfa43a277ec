"""A set of files appears complete or not at all."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from assistant.program.diagnostics import Refused
from assistant.program.writing import write_files


def test_writes_all_files_and_nothing_else(tmp_path):
    written = write_files({"a.mod": b"one", "b.mod": b"two"}, tmp_path / "new" / "folder")
    assert [path.read_bytes() for path in written] == [b"one", b"two"]
    assert sorted(os.listdir(tmp_path / "new" / "folder")) == ["a.mod", "b.mod"]


def test_replaces_what_was_there(tmp_path):
    (tmp_path / "a.mod").write_bytes(b"old")
    write_files({"a.mod": b"new"}, tmp_path)
    assert (tmp_path / "a.mod").read_bytes() == b"new"


def test_a_folder_in_the_way_leaves_everything_as_it_was(tmp_path):
    (tmp_path / "a.mod").write_bytes(b"old")
    (tmp_path / "b.mod").mkdir()
    with pytest.raises(Refused) as refused:
        write_files({"a.mod": b"new", "b.mod": b"new"}, tmp_path)
    assert refused.value.exit_status == 2
    assert refused.value.findings[0].code == "CO201"
    assert (tmp_path / "a.mod").read_bytes() == b"old"
    assert sorted(os.listdir(tmp_path)) == ["a.mod", "b.mod"]


def test_a_file_in_place_of_the_folder(tmp_path):
    (tmp_path / "out").write_bytes(b"")
    with pytest.raises(Refused):
        write_files({"a.mod": b"new"}, tmp_path / "out")


@pytest.mark.parametrize("name", ["../a.mod", "x/y.mod", "", ".."])
def test_names_never_leave_the_folder(tmp_path, name):
    with pytest.raises(Refused) as refused:
        write_files({name: b"x"}, tmp_path / "out")
    assert refused.value.findings[0].code == "CO202"
    assert not (tmp_path / "a.mod").exists()


FULL = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
from assistant.program.writing import write_files
from assistant.program.diagnostics import Refused
try:
    write_files({"a.mod": b"new", "b.mod": b"x" * 5000}, sys.argv[1])
except Refused as refused:
    print(refused.findings[0].code)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no file-size limit to set")
def test_no_room_for_the_second_file_keeps_the_first_as_it_was(tmp_path):
    (tmp_path / "a.mod").write_bytes(b"old")
    run = subprocess.run(
        [sys.executable, "-c", FULL, str(tmp_path)], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "CO201"
    assert (tmp_path / "a.mod").read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.mod"]
