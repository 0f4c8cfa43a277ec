"""The folder of a backup: whole or not at all, and never taken for whole if it is not."""

import errno
import json
import os
import pathlib

import pytest

from assistant.base import file_access
from assistant.base.diagnostics import Refused
from assistant.controllers import backup_folder

FILES = {"programs/SEAM.prg": b"10 END\r\n", "parameters.txt": b"RLNG=1\n"}


def made(folder):
    with backup_folder.appearing_folder(folder, "toy") as place:
        for name, data in FILES.items():
            backup_folder.put_file(place, name, data)
    return folder


def codes(refused):
    return [finding.code for finding in refused.value.findings]


def test_it_comes_back_and_nothing_else_is_left(tmp_path):
    folder = made(tmp_path / "deep" / "copy")
    assert backup_folder.backup_contents(folder, "toy") == FILES
    assert backup_folder.backup_files(folder) == ("parameters.txt", "programs/SEAM.prg")
    assert [path.name for path in folder.parent.iterdir()] == ["copy"]


def test_two_backups_of_the_same_are_the_same_bytes(tmp_path):
    one, two = (made(tmp_path / name) / backup_folder.INDEX for name in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()


def test_line_ends_may_change_in_version_control(tmp_path):
    folder = made(tmp_path / "copy")
    (folder / "programs" / "SEAM.prg").write_bytes(b"10 END\n")
    assert backup_folder.backup_contents(folder, "toy")["programs/SEAM.prg"] == b"10 END\n"


def test_what_fails_leaves_nothing(tmp_path):
    with (
        pytest.raises(KeyboardInterrupt),
        backup_folder.appearing_folder(tmp_path / "copy", "toy") as place,
    ):
        backup_folder.put_file(place, "a", b"1")
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_there_is_left_alone(tmp_path):
    folder = made(tmp_path / "copy")
    with pytest.raises(Refused) as refused, backup_folder.appearing_folder(folder, "toy"):
        pass
    assert codes(refused) == ["CN401"]
    assert backup_folder.backup_contents(folder, "toy") == FILES


def test_a_place_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with (
        pytest.raises(Refused) as refused,
        backup_folder.appearing_folder(tmp_path / "file" / "x", "toy"),
    ):
        pass
    assert codes(refused) == ["CN402"]


def test_names_that_lead_out_of_it(tmp_path):
    folder = made(tmp_path / "copy")
    (tmp_path / "secret").write_bytes(b"x")
    index = json.loads((folder / backup_folder.INDEX).read_bytes())
    for name in ("../secret", str(tmp_path / "secret")):
        index["files"] = {name: "0"}
        (folder / backup_folder.INDEX).write_text(json.dumps(index))
        with pytest.raises(Refused) as refused:
            backup_folder.backup_contents(folder, "toy")
        assert "outside" in refused.value.findings[0].message


@pytest.mark.parametrize(
    "spoil",
    [
        lambda folder: (folder / "parameters.txt").unlink(),
        lambda folder: (folder / "parameters.txt").write_bytes(b"RLNG=2\n"),
        lambda folder: (folder / backup_folder.INDEX).unlink(),
        lambda folder: (folder / backup_folder.INDEX).write_bytes(b"{"),
        lambda folder: (folder / backup_folder.INDEX).write_bytes(b"[]"),
        lambda folder: (folder / backup_folder.INDEX).write_bytes(b'{"format": 2}'),
        lambda folder: (folder / backup_folder.INDEX).write_bytes(b'{"format": 1, "kind": "toy"}'),
        lambda folder: (folder / backup_folder.INDEX).write_bytes(
            b'{"format": 1, "kind": "other"}'
        ),
    ],
)
def test_what_is_not_whole_is_refused(tmp_path, spoil):
    folder = made(tmp_path / "copy")
    spoil(folder)
    with pytest.raises(Refused) as refused:
        backup_folder.backup_contents(folder, "toy")
    assert codes(refused) == ["CN403"] and refused.value.exit_status == 2


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes there")
@pytest.mark.parametrize("name", ["parameters.txt", backup_folder.INDEX])
def test_a_pipe_in_it_keeps_nobody_waiting(tmp_path, name):
    folder = made(tmp_path / "copy")
    (folder / name).unlink()
    os.mkfifo(folder / name)
    with pytest.raises(Refused) as refused:
        backup_folder.backup_contents(folder, "toy")
    assert codes(refused) == ["CN403"]


def when_the_disk_fails(monkeypatch, target, renamed_back):
    """The names of the folder above cannot be put on the disk once the new one is there."""
    settle, rename = file_access.sync_folder, pathlib.Path.rename

    def settled(folder):
        if folder == target.parent and target.exists():
            raise OSError(errno.EIO, "it failed")
        settle(folder)

    def renamed(path, other):
        if path == target and not renamed_back:
            raise OSError(errno.EIO, "it failed")
        return rename(path, other)

    monkeypatch.setattr(file_access, "sync_folder", settled)
    monkeypatch.setattr(pathlib.Path, "rename", renamed)


@pytest.mark.slow
def test_what_is_told_as_not_written_is_not_there(tmp_path, monkeypatch):
    when_the_disk_fails(monkeypatch, tmp_path / "copy", renamed_back=True)
    with pytest.raises(Refused) as refused:
        made(tmp_path / "copy")
    assert codes(refused) == ["CN402"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_what_cannot_be_taken_back_is_there_whole_and_told(tmp_path, monkeypatch):
    when_the_disk_fails(monkeypatch, tmp_path / "copy", renamed_back=False)
    with pytest.warns(RuntimeWarning, match="CO206: .*copy` is there whole"):
        folder = made(tmp_path / "copy")
    assert backup_folder.backup_contents(folder, "toy") == FILES
    assert list(tmp_path.iterdir()) == [folder]
