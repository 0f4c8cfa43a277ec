"""What is run together: files and folders, tasks of a backup, slots, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused
from assistant.compiler.simulated_run import programs
from assistant.virtual.events import Said
from assistant.virtual.program_run import Settings, prepared

SAMPLES = Path(__file__).parents[2] / "samples"
MAIN = "MODULE {name}\nPROC main()\nWaitTime {seconds};\n{more}ENDPROC\nENDMODULE\n"
SHARED = "MODULE all\nPROC Both()\nWaitTime 1;\nENDPROC\nENDMODULE\n"


def write(folder: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="ascii")
    return folder


def refused(*named: object, **options: str) -> list[str]:
    with pytest.raises(Refused) as caught:
        programs([str(one) for one in named], **options)
    return [finding.code for finding in caught.value.findings]


def test_modules_of_a_folder_are_one_task(tmp_path: Path) -> None:
    folder = write(
        tmp_path,
        {
            "a.mod": MAIN.format(name="a", seconds=1, more="Other;\n"),
            "b.sys": "MODULE b\nPROC Other()\nWaitTime 2;\nENDPROC\nENDMODULE\n",
            "a.pgf": "<Program><Module>a.mod</Module></Program>",
        },
    )
    found = programs([str(folder)])
    assert [(part.name, len(part.trees)) for part in found.parts] == [("T_ROB1", 2)]
    run = prepared(found).run()
    assert (run.ended, run.seconds) == ("end", 3.0)


def test_a_list_of_modules_loads_them(tmp_path: Path) -> None:
    write(
        tmp_path,
        {
            "a.mod": MAIN.format(name="a", seconds=1, more=""),
            "cell.pgf": "<Program><Module>a.mod</Module></Program>",
        },
    )
    assert prepared(programs([str(tmp_path / "cell.pgf")])).run().seconds == 1.0


def test_the_tasks_of_a_backup_run_together(tmp_path: Path) -> None:
    folder = write(
        tmp_path / "cell",
        {
            "BACKINFO/backinfo.txt": ">>TASK1: (T_SIDE,,)\n>>TASK2: (T_ROB1,,)\n",
            "SYSPAR/SYS.cfg": 'SYS:CFG_1.0:5:0::\n#\nCAB_TASKS:\n  -Name "T_SIDE" -Type "NORMAL"\n'
            '\n  -Name "T_ROB1" -Type "NORMAL" -MotionTask\n#\nOTHER:\n  -Name "T_X"\n',
            "RAPID/TASK0/SYSMOD/all.sys": SHARED,
            "RAPID/TASK1/PROGMOD/a.mod": MAIN.format(name="a", seconds=1, more="Both;\n"),
            "RAPID/TASK2/PROGMOD/b.mod": MAIN.format(name="b", seconds=3, more="Both;\n"),
            "HOME/old.mod": MAIN.format(name="old", seconds=9, more=""),
        },
    )
    found = programs([str(folder)])
    assert [(part.name, len(part.trees)) for part in found.parts] == [("T_ROB1", 2), ("T_SIDE", 2)]
    run = prepared(found).run()
    assert [(row.time, row.task) for row in run.log] == [
        *((0.0, "T_ROB1"), (0.0, "T_SIDE"), (1.0, "T_SIDE"), (3.0, "T_ROB1")),
    ]
    assert run.seconds == 4.0


def test_programs_of_several_slots_run_together(tmp_path: Path) -> None:
    write(tmp_path, {"A.prg": '10 CALLP "SUB"\n20 END\n', "SUB.prg": "10 DLY 1\n20 END\n"})
    write(tmp_path, {"B.prg": "10 DLY 2\n20 END\n"})
    found = programs([str(tmp_path / "A.prg"), str(tmp_path / "B.prg")])
    assert [(part.name, part.names) for part in found.parts] == [("1", ("A", "SUB")), ("2", ("B",))]
    run = prepared(found).run()
    assert run.ended == "end"
    assert sorted(row.task for row in run.log) == ["1", "2"]
    assert run.seconds == pytest.approx(2.0, abs=0.01)


def test_what_cannot_be_run_together_is_refused(tmp_path: Path) -> None:
    write(tmp_path, {"x/a.prg": "10 DLY 1\n20 END\n", "x/b.prg": "10 DLY 2\n20 END\n"})
    write(tmp_path, {"l/a.pgf": "<Program><Module>a.mod</Module></Program>"})
    write(tmp_path, {"l/b.pgf": "<Program><Module>b.mod</Module></Program>", "none/x.txt": "x"})
    write(tmp_path, {"bad.mod": "MODULE a\nPROC main(\nENDMODULE\n"})
    rapid, melfa = SAMPLES / "rapid" / "gluing.mod", SAMPLES / "melfa" / "LOADER.prg"
    assert refused(SAMPLES / "rapid") == ["VC204"]
    assert refused(tmp_path / "x") == ["VC202"]
    assert refused(tmp_path / "l") == ["VC205"]
    assert refused(tmp_path / "none") == ["CO403"]
    assert refused(rapid, melfa) == ["CO022"]
    assert refused(rapid, tmp_path / "x") == ["CO021"]
    assert refused(rapid, SAMPLES / "plate.dxf") == ["CO021"]
    assert refused(rapid, unit="mm") == ["CO023"]
    assert refused(tmp_path / "no.mod") == ["IN001"]


def test_a_module_that_is_wrong_is_refused_with_its_place(tmp_path: Path) -> None:
    write(tmp_path, {"bad.mod": "MODULE a\nPROC main(\nENDMODULE\n"})
    with pytest.raises(Refused) as caught:
        programs([str(tmp_path / "bad.mod")])
    assert caught.value.findings[0].path == str(tmp_path / "bad.mod")


def test_the_tasks_of_a_backup_share_persistents(tmp_path: Path) -> None:
    """The background task ends what the other one waits for, and itself with that."""
    folder = write(
        tmp_path / "cell",
        {
            "SYSPAR/SYS.cfg": 'CAB_TASKS:\n  -Name "T_ROB1" -MotionTask\n  -Name "T_BACK" -Type '
            '"SEMISTATIC"\n',
            "BACKINFO/backinfo.txt": ">>TASK1: (T_ROB1,,)\n>>TASK2: (T_BACK,,)\n",
            "RAPID/TASK1/PROGMOD/a.mod": "MODULE a\nPERS num parts:=0;\nPROC main()\n"
            "WaitUntil parts=3;\nTPWrite ValToStr(parts);\nENDPROC\nENDMODULE\n",
            "RAPID/TASK2/PROGMOD/b.mod": "MODULE b\nPERS num parts:=0;\nPROC main()\n"
            "WaitTime 1;\nparts:=parts+1;\nENDPROC\nENDMODULE\n",
        },
    )
    run = prepared(programs([str(folder)])).run()
    assert [(row.time, row.task) for row in run.log if row.what == Said("3")] == [(3.0, "T_ROB1")]
    assert run.ended == "end"


@pytest.mark.parametrize(("entry", "cure"), [("nix", "--entry: main, Bead"), ("Add", "--entry")])
def test_a_procedure_to_begin_with_has_to_be_there(entry: str, cure: str) -> None:
    found = programs([str(SAMPLES / "rapid" / "gluing.mod")])
    with pytest.raises(Refused) as caught:
        prepared(found, Settings(entry=entry))
    (finding,) = caught.value.findings
    assert finding.code == "VC218" and cure in finding.cure


def test_two_procedures_to_begin_with_are_refused(tmp_path: Path) -> None:
    write(tmp_path, {name + ".mod": MAIN.format(name=name, seconds=1, more="") for name in "ab"})
    with pytest.raises(Refused) as caught:
        prepared(programs([str(tmp_path)]))
    assert [finding.code for finding in caught.value.findings] == ["VC219"]
