"""What ends a command from outside: its files are whole, and it says so."""

import os
import signal

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="it has no such signals")


def ended(forks, folder, number, *words):
    """Status and message of a command that gets a signal once its first file is in place."""
    done = forks.python("-c", f"SIGNAL = {int(number)}\n{SIGNALLED}", *words, cwd=folder)
    return done.returncode, done.stderr


SIGNALLED = """
import os, pathlib, sys
from assistant.cli import main
for name in ("replace", "rename"):
    def moved(self, target, real=getattr(pathlib.Path, name)):
        done = real(self, target)
        os.kill(os.getpid(), SIGNAL)
        return done
    setattr(pathlib.Path, name, moved)
sys.argv[0] = "robot-assistant"
main()
"""
POSES = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n500,0,500,0,0,1,0\n"


def test_sigterm_leaves_a_compiled_set_all_old_or_all_new(forks, tmp_path):
    names = [f"s{i}" for i in range(15)]
    for name in names:
        (tmp_path / f"{name}.csv").write_text(POSES)
    words = (
        "compile",
        *(f"{name}.csv" for name in names),
        "-l",
        "rapid",
        "-o",
        "out",
        "--overwrite",
    )
    (tmp_path / "out").mkdir()
    for name in names:
        (tmp_path / "out" / f"{name}.mod").write_text("old")
    status, said = ended(forks, tmp_path, signal.SIGTERM, *words)
    assert status == 143 and said.endswith("ended by SIGTERM\n")
    found = {one.name: one.read_text() for one in (tmp_path / "out").glob("*.mod")}
    assert set(found) == {f"{name}.mod" for name in names}
    assert len({text == "old" for text in found.values()}) == 1, "mixed"
    others = set(os.listdir(tmp_path / "out")) - set(found) - {".robot-assistant"}
    assert not others, "a folder is left"


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGINT"])
def test_fmt_never_takes_a_file_from_its_place(forks, tmp_path, name):
    number = getattr(signal, name)
    (tmp_path / "a.mod").write_text("MODULE a\nPROC main()\nENDPROC\nENDMODULE\n")
    status, said = ended(forks, tmp_path, number, "fmt", "a.mod")
    assert status == 128 + number and said.endswith(f"ended by {name}\n")
    assert os.listdir(tmp_path) == ["a.mod"]
