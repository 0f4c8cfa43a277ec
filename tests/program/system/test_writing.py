"""A set of files appears complete or not at all."""

from __future__ import annotations

import os
import stat
import subprocess
import sys

import pytest

from assistant.base.diagnostics import Refused
from assistant.base.file_sets import reporting_leftovers, scratch_folder, write_all, write_files


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
from assistant.base.diagnostics import Refused
from assistant.base.file_sets import write_files
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


# ------------------------------------------------------------------------------- a name stays


@pytest.fixture
def told():
    """Codes and sentences of what earlier runs have left."""
    found = []
    with reporting_leftovers(lambda finding: found.append((finding.code, finding.message))):
        yield found


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such permissions")
def test_permissions_of_what_is_replaced_stay(tmp_path):
    (tmp_path / "a.mod").write_bytes(b"old")
    (tmp_path / "a.mod").chmod(0o640)
    write_files({"a.mod": b"new", "b.mod": b"new"}, tmp_path)
    assert stat.S_IMODE((tmp_path / "a.mod").stat().st_mode) == 0o640


@pytest.mark.skipif(os.name == "nt", reason="links need a right there")
def test_a_link_stays_one_and_its_file_is_written(tmp_path):
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "a.mod").write_bytes(b"old")
    (tmp_path / "a.mod").symlink_to("kept/a.mod")
    write_files({"a.mod": b"new", "b.mod": b"new"}, tmp_path)
    assert (tmp_path / "a.mod").is_symlink()
    assert (tmp_path / "kept" / "a.mod").read_bytes() == b"new"
    assert os.listdir(tmp_path / "kept") == ["a.mod"]


@pytest.mark.skipif(os.name == "nt", reason="links need a right there")
def test_a_ring_of_links_is_refused(tmp_path):
    (tmp_path / "a.mod").symlink_to("a.mod")
    with pytest.raises(Refused) as refused:
        write_files({"a.mod": b"new"}, tmp_path)
    assert refused.value.findings[0].code == "CO201"
    assert os.listdir(tmp_path) == ["a.mod"] and (tmp_path / "a.mod").is_symlink()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_what_is_no_plain_file_is_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "b.mod")
    with pytest.raises(Refused) as refused:
        write_files({"a.mod": b"new", "b.mod": b"new"}, tmp_path)
    assert "no plain file" in refused.value.findings[0].message
    assert os.listdir(tmp_path) == ["b.mod"]


def test_two_names_of_one_file_are_refused(tmp_path):
    with pytest.raises(Refused):
        write_all({tmp_path / "a": b"one", tmp_path / "x" / ".." / "a": b"two"})
    assert os.listdir(tmp_path) == []


def test_folders_that_were_made_go_if_nothing_comes_of_it(tmp_path):
    (tmp_path / "a.mod").mkdir()
    with pytest.raises(Refused):
        write_all({tmp_path / "new" / "b.mod": b"new", tmp_path / "a.mod": b"new"})
    assert os.listdir(tmp_path) == ["a.mod"]


def test_who_reads_meanwhile_finds_the_name_at_any_time(tmp_path):
    """Two write, in processes of their own, until both were seen at it."""
    names = [f"{i}.mod" for i in range(20)]
    write_files(dict.fromkeys(names, b"0"), tmp_path)
    command = [sys.executable, "-c", WRITER, str(tmp_path)]
    pipe = subprocess.PIPE
    with (
        subprocess.Popen([*command, "1"], stdin=pipe) as one,
        subprocess.Popen([*command, "2"], stdin=pipe) as other,
    ):
        seen = set()
        while not {b"1", b"2"} <= seen and one.poll() is None and other.poll() is None:
            seen |= {(tmp_path / name).read_bytes() for name in names}
    assert (one.returncode, other.returncode) == (0, 0)
    assert {b"1", b"2"} <= seen <= {b"0", b"1", b"2"}
    assert len({(tmp_path / name).read_bytes() for name in names}) == 1, "of one of the two"
    assert sorted(os.listdir(tmp_path)) == sorted(names)


WRITER = """
import sys, threading
from assistant.base.file_sets import write_files
waiting = threading.Thread(target=sys.stdin.read, daemon=True)
waiting.start()
while waiting.is_alive():
    write_files({f"{i}.mod": sys.argv[2].encode() for i in range(20)}, sys.argv[1])
"""


# --------------------------------------------------------------------------- what was left


KILLED = """
import os, pathlib, sys
from assistant.base.file_sets import write_files
count, real = int(sys.argv[2]), pathlib.Path.replace
def replace(self, target):
    global count
    count -= 1
    if count < 0:
        os._exit(9)
    return real(self, target)
pathlib.Path.replace = replace
write_files({"a.mod": b"new a", "b.mod": b"new b", "c.mod": b"new c"}, sys.argv[1])
"""


def killed(folder, replaced):
    """What is left of a run that dies once so many names are new."""
    for name in "ab":
        (folder / f"{name}.mod").write_bytes(f"old {name}".encode())
    done = subprocess.run([sys.executable, "-c", KILLED, str(folder), str(replaced)])
    assert done.returncode == 9
    (left,) = folder.glob(".robot-assistant-*")
    return left


def texts(folder):
    return {one.name: one.read_text() for one in folder.iterdir() if one.is_file()}


@pytest.mark.parametrize("replaced", [0, 2])
def test_what_was_cut_off_is_put_back_by_the_next_who_writes_there(tmp_path, told, replaced):
    left = killed(tmp_path, replaced)
    write_files({"z": b""}, tmp_path)
    assert texts(tmp_path) == {"a.mod": "old a", "b.mod": "old b", "z": ""}
    ((code, said),) = told
    assert code == "CO203" and "`a.mod`, `b.mod`, `c.mod`: they are as they were before" in said
    assert not left.exists()


def test_what_somebody_has_changed_since_stays_and_what_it_was_is_kept(tmp_path, told):
    left = killed(tmp_path, 2)
    (tmp_path / "b.mod").write_text("by hand")
    for _ in range(2):
        write_files({"z": b""}, tmp_path)
        assert texts(tmp_path) == {"a.mod": "old a", "b.mod": "by hand", "z": ""}
    assert [code for code, _ in told] == ["CO204", "CO204"] and str(left) in told[0][1]
    assert (left / "old" / "b.mod").read_text() == "old b"


@pytest.mark.skipif(os.name == "nt", reason="links need a right there")
def test_no_link_is_put_in_the_place_of_a_file(tmp_path, told):
    left = killed(tmp_path, 2)
    (left / "old" / "b.mod").unlink()
    (left / "old" / "b.mod").symlink_to(tmp_path.parent / "elsewhere")
    (tmp_path.parent / "elsewhere").write_text("not ours")
    write_files({"z": b""}, tmp_path)
    assert not (tmp_path / "b.mod").is_symlink() and [code for code, _ in told] == ["CO204"]
    assert texts(tmp_path) == {"a.mod": "old a", "b.mod": "new b", "z": ""}


def test_what_is_not_ours_is_told_and_left_alone(tmp_path, told):
    """An earlier version kept files so: they may be the only copies."""
    kept = tmp_path / ".robot-assistant-abc" / "replaced"
    kept.mkdir(parents=True)
    (kept / "a.mod").write_text("old a")
    write_files({"a.mod": b"new a"}, tmp_path)
    assert [code for code, _ in told] == ["CO204"]
    assert (kept / "a.mod").read_text() == "old a"


def test_what_is_under_way_is_no_leftover(tmp_path, told):
    with scratch_folder(tmp_path) as place:
        (place / "a.mod").write_bytes(b"under way")
        write_files({"a.mod": b"new a"}, tmp_path)
        assert (place / "a.mod").read_bytes() == b"under way"
    assert told == [] and os.listdir(tmp_path) == ["a.mod"]
