"""The disk of a controller: what its programs can reach, and what they cannot."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.virtual.rapid.controller import Controller
from assistant.virtual.rapid.disk import Disk
from tests.virtual.rapid_cell import ran, said

WRITE = """Open {path},f\\Write;
Write f,"x";
TPWrite "written";
ERROR
IF ERRNO=ERR_FILEACC TPWrite "no way";
IF ERRNO=ERR_FILEOPEN TPWrite "not there";
RETURN;"""


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ('"HOME:/inside.txt"', "written"),
        ('"HOME:inside.txt"', "written"),
        ('"home:/sub/../inside.txt"', "written"),
        ('"HOME:/../outside.txt"', "no way"),
        ('"HOME:\\\\..\\\\outside.txt"', "no way"),
        ('"../outside.txt"', "no way"),
        ('"HOME:/link/outside.txt"', "no way"),
        ('"HOME:/a\\00b"', "no way"),
        ('"HOME:/missing/a.txt"', "not there"),
        ('"HOME:/sub"', "not there"),
    ],
)
def test_paths_stay_in_their_unit(path: str, told: str, tmp_path: Path) -> None:
    home, outside = tmp_path / "home", tmp_path / "outside"
    disk = Disk(home)
    for folder in (home, outside, home / "sub"):
        folder.mkdir()
    (home / "link").symlink_to(outside)
    before = sorted(outside.rglob("*"))
    main = WRITE.format(path=path)
    assert said(main, data="VAR iodev f;", controller=Controller(disk=disk)) == [told]
    assert sorted(outside.rglob("*")) == before
    assert not list(tmp_path.glob("*.txt"))


def test_what_stands_on_the_disk_of_another_run_is_there(tmp_path: Path) -> None:
    write = 'Open "n.txt",f\\Append;\nWrite f,"a";\nEXIT;'
    for _ in range(2):
        controller = Controller(disk=Disk(tmp_path))
        assert ran(write, data="VAR iodev f;", controller=controller).ended == "end"
    assert (tmp_path / "n.txt").read_text() == "a\na\n"


@pytest.mark.parametrize("path", ['"/etc/hostname"', '"HOME://etc/hostname"', '"com1:"'])
def test_other_devices_and_absolute_paths_are_not_simulated(path: str) -> None:
    found = ran(f"Open {path},f\\Read;", data="VAR iodev f;")
    assert (found.ended, "are files here" in found.message) == ("unknown", True)
