"""`fmt`: files rewritten in place, checked or shown as a diff, and never damaged."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from assistant import languages
from tests.cli.tables import each
from tests.cli.test_commands import run

UNTIDY = b"MODULE m\r\nvar num a := 1 ;\r\nENDMODULE"
TIDY = b"MODULE m\r\n    VAR num a:=1;\r\nENDMODULE\r\n"
BROKEN = b"MODULE m\nPROC p()\na:=1\nENDPROC\nENDMODULE\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two untidy modules, a tidy one, a broken one, and what is none of them."""
    files = {
        "one.mod": UNTIDY,
        "inner/two.sys": UNTIDY,
        "tidy.modx": TIDY,
        "inner/broken.mod": BROKEN,
        "driver.sys": b"\x00\x01",
        "notes.txt": UNTIDY,
        ".hidden/three.mod": UNTIDY,
    }
    for name, data in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(data)
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in folder.rglob("*")
        if file.is_file()
    }


def test_files_are_rewritten_in_place(capsys, folder):
    before = contents(folder)
    status, out, err = run(capsys, "fmt", folder)
    assert status == 1  # the broken one
    assert "RA1" in err and "broken.mod:" in err
    assert out == (
        f"formatted {folder / 'one.mod'}\nformatted {folder / 'inner' / 'two.sys'}\n"
        "4 files, 2 changed\n"
    )
    tidied = {"one.mod": TIDY, str(Path("inner", "two.sys")): TIDY}
    assert contents(folder) == before | tidied
    assert run(capsys, "fmt", folder / "one.mod", folder / "tidy.modx") == (
        0,
        "2 files, 0 changed\n",
        "",
    )


def test_check_writes_nothing_and_tells(capsys, folder):
    before = contents(folder)
    status, out, _ = run(capsys, "fmt", "--check", folder / "one.mod", folder / "tidy.modx")
    assert (status, out) == (1, f"would format {folder / 'one.mod'}\n2 files, 1 would change\n")
    assert run(capsys, "fmt", "--check", folder / "tidy.modx")[0] == 0
    assert contents(folder) == before


def test_diff_writes_nothing_and_shows(capsys, folder):
    before = contents(folder)
    name = folder / "one.mod"
    status, out, _ = run(capsys, "fmt", "--diff", name)
    assert status == 0
    assert out.replace("\r", "") == (
        f"--- {name}\n+++ {name} (formatted)\n@@ -1,3 +1,3 @@\n MODULE m\n-var num a := 1 ;\n"
        "-ENDMODULE\n\\ No newline at end of file\n+    VAR num a:=1;\n+ENDMODULE\n"
    )
    assert run(capsys, "fmt", "--diff", "--check", name)[0] == 1
    assert run(capsys, "fmt", "--diff", folder / "tidy.modx") == (0, "", "")
    assert contents(folder) == before


def test_what_cannot_be_read_is_said_and_the_rest_is_done(capsys, folder):
    nowhere, unknown, empty = folder / "nowhere.mod", folder / "driver.sys", folder / "empty"
    empty.mkdir()
    status, out, err = run(capsys, "fmt", nowhere, unknown, empty, folder / "one.mod")
    assert status == 2
    assert all(code in err for code in ("IN001", "CO402", "CO403"))
    assert (folder / "one.mod").read_bytes() == TIDY
    assert "1 file, 1 changed" in out
    assert run(capsys, "fmt", "-", "-")[0] == 2


def test_encoding_and_permissions_stay(capsys, folder):
    file = folder / "latin.mod"
    for encoding in ("utf-8-sig", "utf-8", "latin-1"):
        file.write_bytes("MODULE m\n! größe\nVAR num a;\nENDMODULE\n".encode(encoding))
        file.chmod(0o640)
        assert run(capsys, "fmt", file)[0] == 0
        wanted = "MODULE m\n    ! größe\n    VAR num a;\nENDMODULE\n"
        assert file.read_bytes() == wanted.encode(encoding)
        assert os.name == "nt" or file.stat().st_mode & 0o777 == 0o640


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_a_link_stays_one(capsys, folder):
    link = folder / "link.mod"
    link.symlink_to(folder / "one.mod")
    assert run(capsys, "fmt", link)[0] == 0
    assert link.is_symlink()
    assert (folder / "one.mod").read_bytes() == TIDY


def test_standard_input_goes_to_standard_output(forks):
    def given(text, *options):
        program = [forks.folder / "robot-assistant", "fmt", "-", *options]
        return subprocess.run(program, input=text, capture_output=True)

    done = given(UNTIDY)
    assert (done.returncode, done.stdout) == (0, TIDY)
    done = given(BROKEN)
    assert (done.returncode, done.stdout) == (1, BROKEN)
    assert b"standard input:" in done.stderr
    assert given(UNTIDY, "--check").returncode == 1


def test_programs_are_written_in_the_layout(capsys, tmp_path):
    source = Path(__file__).parents[2] / "samples" / "positioning.csv"
    for name in languages.names():
        if name == "rapid":
            continue
        robot, folder = "rv-2aj" if name == "melfa-basic-4" else "rv-4frl", tmp_path / name
        run(capsys, "compile", source, "-l", name, "-r", robot, "-o", folder)
        (file,) = folder.glob("*.prg")
        written = file.read_bytes()
        assert run(capsys, "fmt", "--check", file)[0] == 0, name
        file.write_bytes(written.replace(b"=(", b" = ( "))
        assert run(capsys, "fmt", "--check", file)[0] == 1, name
        assert run(capsys, "fmt", file)[0] == 0, name
        assert file.read_bytes() == written, name


def test_a_numbering_that_is_none_is_wrong_usage(capsys, folder):
    before = contents(folder)

    def check(value):
        status, out, err = run(capsys, "fmt", f"--renumber={value}", folder / "one.mod")
        assert status == 2
        assert "CL005" in err and "--renumber 10,10" in err and not out
        assert contents(folder) == before

    each(("", "x", "0", "10,0", "10,10,10", "-1,1", "1.5"), check)


def test_steps_are_numbered_anew(capsys, tmp_path, folder):
    file = tmp_path / "job.prg"
    file.write_bytes(b"1 *L\r\n5 MOV P1 \r\n7 GOTO 5\r\nP1=(1,2,3,0,0,0)(7,0)\r\n")
    assert run(capsys, "fmt", "--check", "--renumber", "10,5", file)[0] == 1
    assert run(capsys, "fmt", "--renumber", "10,5", file)[0] == 0
    assert file.read_bytes() == (
        b"10 *L\r\n15 MOV P1\r\n20 GOTO 15\r\nP1=(+1.00,+2.00,+3.00,+0.00,+0.00,+0.00)(7,0)\r\n"
    )
    assert run(capsys, "fmt", "--check", "--renumber", "10,5", file)[0] == 0
    before = contents(folder)
    status, _, err = run(capsys, "fmt", "--renumber", "10", folder / "one.mod")
    assert status == 2 and "CO404" in err
    assert contents(folder) == before


def test_a_form_feed_behind_a_comment_ends_no_line_of_a_diff(capsys, tmp_path):
    name = tmp_path / "page.mod"
    name.write_bytes(b"MODULE m\n    ! one\x0c\n    VAR num a := 1;\nENDMODULE\n")
    status, out, _ = run(capsys, "fmt", "--diff", name)
    assert status == 0
    assert out.split("\n", 2)[2] == (
        "@@ -1,4 +1,4 @@\n MODULE m\n-    ! one\ufffd\n-    VAR num a := 1;\n"
        "+    ! one\n+    VAR num a:=1;\n ENDMODULE\n"
    )


def test_a_form_feed_in_a_comment_is_told_of_and_nothing_is_laid_out(capsys, tmp_path):
    name = tmp_path / "page.mod"
    text = b"MODULE m\n    ! one\x0ctwo\n    VAR num a := 1;\nENDMODULE\n"
    name.write_bytes(text)
    for options in (["--diff"], ["--check"], []):
        status, out, err = run(capsys, "fmt", *options, name)
        assert status == 1
        assert re.search(r"IN008 error \S*page\.mod:2:10: ", err)
        assert "VAR num" not in out
        assert name.read_bytes() == text
