"""Folders as users have them: projects and backups, and what in them is no program."""

from __future__ import annotations

from pathlib import Path

import pytest

import assistant
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.compiler.program_files import OutputFolder, programs_in

PROGRAM = "Mvs P1\nEnd\nP1=(+400.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)\n"
MODULE = "MODULE {0}\n    PROC {1}()\n        SetDO do1,1;\n    ENDPROC\nENDMODULE\n"


def written(folder: Path, texts: dict[str, str]) -> str:
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return str(folder)


def listed(folder: str) -> tuple[list[str], list[str]]:
    told = list[Diagnostic]()
    found = [
        Path(one).relative_to(folder).as_posix() for one in programs_in(folder, None, told.append)
    ]
    return found, [one.message for one in told]


def test_of_a_project_the_programs_are_read_and_its_copies_left_out(tmp_path: Path) -> None:
    texts = {
        "RC1/Program/A.prg": PROGRAM,
        "RC1/Program/EMPTY.prg": "",
        "RC1/Backup/20240101/A.prg": PROGRAM,
        "RC1/Backup/20240101/A.MB6": "ROBPRG\x01\x02",
        "RC1/RoboSim/sysorg.MB6": "ROBPRG\x01\x02",
    }
    found, told = listed(written(tmp_path, texts))
    assert found == ["RC1/Program/A.prg"]
    assert sorted(told) == [
        "`RC1/Backup/20240101/A.MB6`, `RC1/RoboSim/sysorg.MB6` left out: "
        "what a controller makes of a program, and no text",
        "`RC1/Backup/20240101/A.prg` left out: a copy of a program, kept by the project",
        "`RC1/Program/EMPTY.prg` left out: empty",
    ]


def test_a_backup_that_is_named_by_itself_is_read(tmp_path: Path) -> None:
    texts = {"RC1/Program/A.prg": PROGRAM, "RC1/Backup/20240101/A.prg": PROGRAM}
    found, told = listed(f"{written(tmp_path, texts)}/RC1/Backup")
    assert (found, told) == (["20240101/A.prg"], [])


def test_the_cure_of_a_file_that_is_left_out_depends_on_why(tmp_path: Path) -> None:
    texts = {
        "m.mod": MODULE.format("m", "main"),
        "none.mod": "\n",
        "sound.mod": "Extended Module: a tune\n",
    }
    told = list[Diagnostic]()
    folder = written(tmp_path, texts)
    assert len(list(programs_in(folder, None, told.append))) == 1
    cures = {one.message.partition(" ")[0]: one.cure for one in told}
    assert cures["`none.mod`"].startswith("export or save it again")
    assert "(--from)" in cures["`sound.mod`"]
    assert len(list(programs_in(f"{folder}/sound.mod", "rapid", told.append))) == 1


def test_an_empty_module_of_a_folder_is_said(tmp_path: Path) -> None:
    texts = {"m.mod": MODULE.format("m", "main"), "none.mod": "\n"}
    found, told = listed(written(tmp_path, texts))
    assert (found, told) == (["m.mod"], ["`none.mod` left out: empty"])


def test_a_folder_with_one_program_is_that_program(tmp_path: Path) -> None:
    texts = {
        "m.mod": MODULE.format("m", "main").replace("SetDO do1,1", "do_a"),
        "a.mod": MODULE.format("a", "do_a"),
    }
    folder = written(tmp_path, texts)
    done = assistant.translate(folder, to="melfa-basic-6", process=signal(tmp_path))
    assert done.ok, done.findings
    (text,) = (data.decode() for data in done.files.values())
    assert "M_Out(3)=1" in text
    assert assistant.compile(folder, language="rapid").ok
    assert {one.name for one in assistant.load(folder).program.procedures} == {"main", "do_a"}


def signal(folder: Path) -> Path:
    path = folder / "cell.toml"
    path.write_text('[signals.do1]\ndirection = "output"\nnumber = 3\n')
    return path


def test_of_a_folder_with_several_programs_one_has_to_be_named(tmp_path: Path) -> None:
    texts = {f"{n}.mod": MODULE.format(n, "main") for n in ("first", "second")}
    with pytest.raises(Refused, match="holds 2 programs"):
        assistant.translate(written(tmp_path, texts), to="melfa-basic-6")


def test_what_was_written_into_a_folder_of_it_is_no_source(tmp_path: Path) -> None:
    texts = {
        "A.prg": "10 Hlt\n",
        "out/A.prg": "10 Hlt\n",
        "b.mod": "MODULE b\nPROC main()\nENDPROC\nENDMODULE\n",
    }
    folder = written(tmp_path, texts)
    told: list[Diagnostic] = []
    made = OutputFolder(str(tmp_path / "out"), "melfa-basic-6")
    found = [Path(one) for one in programs_in(folder, None, told.append, made)]
    assert found == [tmp_path / "A.prg", tmp_path / "b.mod"]
    assert [(one.code, "`out/A.prg`" in one.message) for one in told] == [("CO308", True)]
    assert "write to another folder" in told[0].cure
    inside = OutputFolder(folder, "melfa-basic-6")  # a program may be translated where it is
    assert len(list(programs_in(folder, None, None, inside))) == 3
