"""Persistent data that the tasks of a backup share, in programs of several slots."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler.cell_defaults import with_neutral_cell
from assistant.compiler.motion_proof import Proving
from assistant.compiler.program_files import load_task, tasks_of
from assistant.compiler.simulated_run import programs
from assistant.compiler.translation import Translation, translate
from assistant.virtual.events import Switched
from assistant.virtual.program_run import Settings, prepared

COUNTING = r"""MODULE Counting
PERS num parts:=3;
PERS string kind:="none";
PERS num limit:=6;
PERS num row{2}:=[1,2];
LOCAL VAR num turns:=0;
PROC main()
IF parts>20 parts:=0;
WHILE parts<limit DO
WaitTime 1;
parts:=parts+1;
row{1}:=parts;
ENDWHILE
kind:="full";
ENDPROC
ENDMODULE
"""
WAITING = r"""MODULE Waiting
PERS num parts:=3;
PERS string kind:="none";
PERS num limit:=6;
PERS num row{2}:=[1,2];
TASK PERS num turns:=0;
PROC main()
{waits}turns:=turns+1;
IF kind="full" SetDO doFull,1;
SetGO goParts,parts;
show 2;
ENDPROC
PROC show(num parts)
SetGO goShown,parts;
ENDPROC
ENDMODULE
"""


WAITS = 'WaitUntil parts>=limit;\nWaitUntil kind="full";\n'


def translated(folder: Path, waits: str, proving: Proving | None = None) -> list[Translation]:
    """Both tasks of a backup."""
    files = []
    for task, text in (("TASK1", COUNTING), ("TASK2", WAITING.replace("{waits}", waits))):
        file = folder / "RAPID" / task / "PROGMOD" / f"{task}.mod"
        file.parent.mkdir(parents=True)
        file.write_text(text, "latin-1")
        files.append(str(file))
    done = []
    for one in tasks_of(files):
        loaded = load_task(one)
        codes = [f.code for f in loaded.findings]
        assert (codes.count("RA395"), codes.count("RA396")) == (2, 1)
        done.append(translate(with_neutral_cell(loaded), to="melfa-basic-6", proving=proving))
    return done


def text_of(done: Translation) -> str:
    assert done.ok, [f.message for f in done.findings]
    (data,) = done.files.values()
    return data.decode("utf-8")


def test_what_tasks_share_is_one_variable_of_all_programs(tmp_path: Path) -> None:
    done = translated(tmp_path, "", Proving(runs=2, seconds=0.3))
    for one in done:
        assert one.motion is not None and one.motion.holds, one.motion
    counting, waiting = map(text_of, done)
    assert "M_00=M_00+1" in counting and 'C_00$="full"' in counting
    assert "M_00=3" in counting and 'C_00$="none"' in counting
    assert "Def Float M_00" not in waiting
    assert "M_00=3" not in waiting and "M_Out16(5)=M_00" in waiting
    assert "Mparts" in waiting  # the parameter of that name


def test_both_programs_run_beside_each_other(tmp_path: Path) -> None:
    written = []
    for number, one in enumerate(translated(tmp_path, WAITS), 1):
        file = tmp_path / f"TASK{number}.prg"
        file.write_bytes(text_of(one).encode("utf-8"))
        written.append(str(file))
    run = prepared(programs(written), Settings(most_time=9.0, most_steps=20_000)).run()
    on = [row for row in run.log if isinstance(row.what, Switched) and row.what.value]
    assert {row.what for row in on} == {Switched(str(n), 1.0) for n in (4, 6, 7, 22)}  # 6, and 2
    assert 3.0 <= on[0].time < 3.2


@pytest.mark.parametrize(
    ("use", "shared"),
    [
        ("WaitTestAndSet taken;", True),
        ("VAR num n;\nchanged n,taken;", False),
        ("changed taken,5;", True),
    ],
)
def test_data_that_a_call_changes_are_shared(tmp_path: Path, use: str, shared: bool) -> None:
    kind = "bool" if "Wait" in use else "num"
    value = "FALSE" if "Wait" in use else "1"
    files = []
    for task in ("TASK1", "TASK2"):
        file = tmp_path / "RAPID" / task / "PROGMOD" / f"{task}.mod"
        file.parent.mkdir(parents=True)
        file.write_text(
            f"MODULE m\nPERS {kind} taken:={value};\nPROC main()\n{use}\nENDPROC\n"
            f"PROC changed(INOUT num n,num by)\nn:=by;\nENDPROC\nENDMODULE\n",
            "latin-1",
        )
        files.append(str(file))
    for one in tasks_of(files):
        assert ("RA395" in [f.code for f in load_task(one).findings]) is shared


READING = """MODULE Reading
PERS tooldata tHand;
PERS num parts;
PERS num row{2};
PROC main()
MoveL [[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tHand;
WHILE parts<row{2} DO
parts:=parts+1;
ENDWHILE
ENDPROC
ENDMODULE
"""
STATING = """MODULE Stating
PERS tooldata tHand:=[TRUE,[[0,0,150],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
PERS num parts:=3;
PERS num row{2}:=[1,7];
PROC main()
SetGO goParts,parts;
SetGO goRow,row{1};
ENDPROC
ENDMODULE
"""


def test_a_value_that_another_task_states_is_asked_of_nobody(tmp_path: Path) -> None:
    files = []
    for task, text in (("TASK1", READING), ("TASK2", STATING)):
        file = tmp_path / "RAPID" / task / "PROGMOD" / f"{task}.mod"
        file.parent.mkdir(parents=True)
        file.write_text(text)
        files.append(str(file))
    done = [
        translate(load_task(task), to="melfa-basic-6", cell=tmp_path / "cell.toml", draft=True)
        for task in tasks_of(files)
    ]
    assert [one.name for one in done[0].wanting] == []
    first, second = (b"".join(one.files.values()).decode("ascii") for one in done)
    assert "M_00=3" in first and "M_00=3" not in second
    assert "(+0.00,+0.00,+150.00," in first
    assert "Mrow(2)=7" in first and "Mrow(1)=1" in second


@pytest.mark.parametrize(
    ("first", "second", "given"),
    [
        ("CONST num k:=9;", "CONST num k:=5;\nPERS num a:=k;", "Ma=5"),
        ("", "CONST num k:=5;\nPERS num a:=k+1;", "Ma=5+1"),
        ("CONST num k:=9;", "CONST num j:=5;\nCONST num k:=j;\nPERS num a:=k;", "Ma=0"),
    ],
)
def test_a_constant_in_a_value_is_that_of_the_task_that_states_it(
    tmp_path: Path, first: str, second: str, given: str
) -> None:
    bodies = (f"{first}\nPERS num a;", second)
    files = []
    for task, data in zip(("TASK1", "TASK2"), bodies, strict=True):
        file = tmp_path / "RAPID" / task / "PROGMOD" / f"{task}.mod"
        file.parent.mkdir(parents=True)
        file.write_text(f"MODULE m\n{data}\nPROC main()\nWaitTime a;\nENDPROC\nENDMODULE\n")
        files.append(str(file))
    done = translate(load_task(tasks_of(files)[0]), to="melfa-basic-6")
    assert f" {given}\n" in text_of(done).replace("\r\n", "\n")


@pytest.mark.parametrize(
    ("first", "second", "told"),
    [
        ("PERS num a:=3;", "PERS num a:=5;", True),
        ("PERS num a:=3;", "PERS num a:=3.0;", False),
        ("PERS num a:=3;", "CONST num k:=3;\nPERS num A:=k;", False),
        ("PERS num a:=3;", "CONST num k:=4;\nPERS num a:=k;", True),
        ("PERS num a:=3;", "PERS num a;", False),
        ("PERS num a:=2+3;", "PERS num a:=2+4;", True),
        ("PERS num a:=2+3;", "PERS num a:=2 + 3;", False),
        ("PERS num a:=3;", "TASK PERS num a:=5;", False),
        ("PERS num a{2}:=[1,2];", "PERS num a{2}:=[1,3];", True),
        ("PERS bool a:=TRUE;", "PERS bool a:=FALSE;", True),
        ("PERS pos a:=[1,2,3];", "PERS pos a:=[1,2,-3];", True),
    ],
)
def test_tasks_that_state_different_values_are_told(
    tmp_path: Path, first: str, second: str, told: bool
) -> None:
    files = []
    for task, data in (("TASK1", first), ("TASK2", second)):
        file = tmp_path / "RAPID" / task / "PROGMOD" / f"{task}.mod"
        file.parent.mkdir(parents=True)
        file.write_text(f"MODULE m\n{data}\nPROC main()\nWaitTime 1;\nENDPROC\nENDMODULE\n")
        files.append(str(file))
    found = [f for task in tasks_of(files) for f in load_task(task).findings if f.code == "RA398"]
    assert len(found) == told
    for one in found:
        assert one.path == files[1] and f"{files[0]}:2" in one.message


def test_different_targets_of_tasks_are_told_in_long_tables(tmp_path: Path) -> None:
    row = "PERS robtarget p{}:=[[{},0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
    files = []
    for task, shift in (("TASK1", 0), ("TASK2", 1)):
        file = tmp_path / "RAPID" / task / "PROGMOD" / f"{task}.mod"
        file.parent.mkdir(parents=True)
        rows = "".join(row.format(n, 400 + n + shift * (n == 50)) for n in range(100))
        file.write_text(
            f"MODULE m\n{rows}PROC main()\nMoveL p1,v100,fine,tool0;\nENDPROC\nENDMODULE\n"
        )
        files.append(str(file))
    found = [f for task in tasks_of(files) for f in load_task(task).findings if f.code == "RA398"]
    assert ["`p50`" in one.message for one in found] == [True]
