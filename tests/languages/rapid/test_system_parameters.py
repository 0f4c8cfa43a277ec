"""What system parameters beside a program say, so that nobody is asked for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import robots
from assistant.compiler import Translation, translate
from assistant.compiler.program_files import load_task, tasks_of

EIO = """EIO:CFG_1.0:6:1::
#
EIO_SIGNAL:

      -Name "doArc" -SignalType "DO" -DeviceMap "7"
      -Name "doGrip" -SignalType "DO" -DeviceMap "5"
"""
SYS = """SYS:CFG_1.0:6:0::
#
CAB_TASKS:

      -Name "T_ROB1" -Type "NORMAL" -MotionTask
      -Name "T_WATCH" -Type "SEMISTATIC"\\
      -Entry "watch"
"""
MOC = """MOC:CFG_1.0:6:1::
#
JOINT:

      -name "rob1_1" -logical_axis 1 -kinematic_axis_number 1
      -name "track" -logical_axis 7
#
ROBOT:

      -name "ROB_1" -use_robot_type "ROB1_1200_0.9_5_TypeB" -base_frame_pos_z {height}\\
      -base_frame_orient_u0 1
"""
PROC = """PROC:CFG_1.0:6:1::
#
ARC_EQUIP_IO_DO:

      -name "stdIO_T_ROB1" -GasOn "doGas" -WeldOn "doArc"
"""
INFO = ">>SYSTEM_ID:\ncell\n\n>>TASK1: (T_ROB1,,)\nPROGMOD/m.mod @\n\n>>TASK2: (T_WATCH,,)\n"
MODULE = """MODULE m
    CONST robtarget p1:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    PERS seamdata s1:=[0,0,[0,0,0,0,0,0,0,0,0],0,0,0,0,0,[0,0,0,0,0,0,0,0,0],0,0,
        [0,0,0,0,0,0,0,0,0],0,0,[0,0,0,0,0,0,0,0,0],0];
    PERS welddata w1:=[10,0,[0,0,0,0,0,0,0,0,0],[0,0,0,0,0,0,0,0,0]];
    CONST jointtarget home:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    PROC main()
        MoveAbsJ home,v100,fine,tool0;
        MoveL p1,v100,fine,tool0;
        IF GetTaskName()="T_ROB1" THEN
            SetDO doGrip,1;
        ENDIF
        ArcLStart Offs(p1,10,0,0),v100,s1,w1,fine,tool0;
        ArcLEnd Offs(p1,20,0,0),v100,s1,w1,fine,tool0;
    ENDPROC
ENDMODULE
"""
WATCH = """MODULE w
    PROC watch()
        SetDO doGrip,0;
    ENDPROC
ENDMODULE
"""


def backup(folder: Path, height: float = 0) -> list[str]:
    texts = {
        "BACKINFO/backinfo.txt": INFO,
        "SYSPAR/EIO.cfg": EIO,
        "SYSPAR/SYS.cfg": SYS,
        "SYSPAR/MOC.cfg": MOC.format(height=height),
        "SYSPAR/PROC.cfg": PROC,
        "RAPID/TASK1/PROGMOD/m.mod": MODULE,
        "RAPID/TASK2/PROGMOD/w.mod": WATCH,
    }
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return [str(folder / name) for name in texts if name.endswith(".mod")]


def translated(folder: Path, file: int, height: float = 0) -> Translation:
    task = tasks_of(backup(folder, height))[file]
    return translate(load_task(task), to="melfa-basic-6", robot="rv-7frl")


def test_a_backup_says_its_task_its_arm_and_what_lights_the_arc(tmp_path: Path) -> None:
    done = translated(tmp_path, 0)
    assert done.ok, [(f.code, f.message) for f in done.whole if f.severity == "error"]
    (text,) = (data.decode() for data in done.files.values())
    assert "M_Out(5)=1" in text and "M_Out(7)=1" in text
    told = [f.message for f in done.whole if f.code == "CO046"]
    assert any("`controller_task`" in message for message in told)
    assert any("irb1200-5-0.9" in message for message in told)
    assert not any(f.code == "RA381" for f in done.whole)


def test_a_task_begins_with_its_main_entry_and_runs_beside_the_robot(tmp_path: Path) -> None:
    done = translated(tmp_path, 1)
    assert done.ok, [(f.code, f.message) for f in done.whole]
    codes = {f.code: f.message for f in done.whole}
    assert "SEMISTATIC" in codes["RA382"]
    assert any(f.code == "CO046" and "`watch`" in f.message for f in done.whole)
    (text,) = (data.decode() for data in done.files.values())
    assert "M_Out(5)=0" in text


@pytest.mark.parametrize(
    ("stated", "codes", "task"),
    [
        ("", {"CO046"}, "T_ROB1"),
        ('[data.controller_task]\ntype = "string"\nvalue = "T_ROB1"\n', set(), "T_ROB1"),
        ('[data.controller_task]\ntype = "string"\nvalue = "T_X"\n', {"CO083"}, "T_X"),
        ('[data.controller_task]\ntype = "string"\nvalue = "?"\n', {"CO046"}, "T_ROB1"),
    ],
)
def test_what_a_cell_file_states_of_the_controller_counts_and_is_said_once(
    tmp_path: Path, stated: str, codes: set[str], task: str
) -> None:
    files, cell = backup(tmp_path), tmp_path / "cell.toml"
    cell.write_text(f'{stated}[arms.taught_on]\narm = "irb1200-5-0.9"\n', encoding="utf-8")
    loaded = load_task(tasks_of(files)[0])
    done = translate(loaded, to="melfa-basic-6", robot="rv-7frl", cell=cell)
    assert done.ok and not done.wanting, [f.message for f in done.findings]
    assert {f.code for f in done.whole} & {"CO046", "CO079", "CO083"} == codes
    (text,) = (data.decode() for data in done.files.values())
    assert f'controller_task$="{task}"' in text.replace('If controller_task$="T_ROB1"', "")
    assert text.count('controller_task$="') == 2


def test_another_arm_than_that_of_the_controllers_files_is_told(tmp_path: Path) -> None:
    files, cell = backup(tmp_path), tmp_path / "cell.toml"
    cell.write_text('[arms.taught_on]\narm = "irb1200-7-0.7"\n', encoding="utf-8")
    loaded = load_task(tasks_of(files)[0])
    done = translate(loaded, to="melfa-basic-6", robot="rv-7frl", cell=cell)
    (told,) = (f.message for f in done.whole if f.code == "CO083")
    assert "irb1200-5-0.9" in told
    assert not any("irb1200-5-0.9" in f.message for f in done.whole if f.code == "CO046")


def test_a_robot_that_does_not_stand_at_the_origin_of_its_world_is_told(tmp_path: Path) -> None:
    (found,) = (f for f in translated(tmp_path, 0, 0.5).whole if f.code == "RA381")
    assert "(0, 0, 500) mm" in found.message


@pytest.mark.parametrize(("places", "whole"), [("9E9,7,9", True), ("5,7,9", False)])
def test_external_axes_that_the_controller_has_not_stand_still(
    tmp_path: Path, places: str, whole: bool
) -> None:
    """It has `eax_a` alone: what targets say of others is left out, of that one it cannot be."""
    files = backup(tmp_path)
    module = MODULE.replace("0,0,0,0],[9E9,9E9,9E9,", f"0,0,0,0],[{places},", 1)
    Path(files[0]).write_text(module, encoding="utf-8")
    done = translate(load_task(tasks_of(files)[0]), to="melfa-basic-6", robot="rv-7frl")
    assert done.ok
    text = "".join(data.decode() for data in done.files.values())
    assert ("L1" in text or ",+5.00" in text) != whole


OLD = """    PROC {name}()
        VAR egmident sensor;
        EGMReset sensor;
    ENDPROC
ENDMODULE
"""
"""A routine that no other language has."""
ENTRIES = {
    "an event": (
        "SYS",
        'CAB_EXEC_HOOKS:\n\n      -Routine "Sweep" -Shelf "POWER_ON" -Task "T_ROB1"',
    ),
    "an event of all tasks": (
        "SYS",
        'CAB_EXEC_HOOKS:\n\n      -Routine "sweep" -Shelf "RESET" -Task "T_X"\\\n      -AllTask',
    ),
    "an input": (
        "EIO",
        'SYSSIG_IN:\n\n      -Signal "diCall" -Action "Interrupt" -Arg1 "sweep" -Arg2 "T_ROB1"',
    ),
    "a service routine": ("MMC", 'MMC_SERV_ROUT:\n\n      -name "sweep"'),
    "a process": ("PROC", 'DISP_EQUIP:\n\n      -name "gun" -clean_proc "sweep"'),
}
STRANGERS = {
    "nothing": ("SYS", "CAB_EXEC_HOOKS:\n"),
    "an event of another task": (
        "SYS",
        'CAB_EXEC_HOOKS:\n\n      -Routine "sweep" -Shelf "POWER_ON" -Task "T_WATCH"',
    ),
    "an input that does something else": (
        "EIO", 'SYSSIG_IN:\n\n      -Signal "diCall" -Action "Load" -Arg1 "sweep"',
    ),
}  # fmt: skip


def with_routine(folder: Path, routine: str, entry: tuple[str, str]) -> Translation:
    """The task of the robot with a routine more, and a section more in a file of parameters."""
    files = backup(folder)
    module = MODULE.replace("ENDMODULE\n", routine.format(name="sweep"))
    Path(files[0]).write_text(module, encoding="utf-8")
    path = folder / "SYSPAR" / f"{entry[0]}.cfg"
    text = path.read_text("utf-8") if path.exists() else f"{entry[0]}:CFG_1.0:6:1::\n"
    path.write_text(f"{text}#\n{entry[1]}\n", encoding="utf-8")
    return translate(load_task(tasks_of(files)[0]), to="melfa-basic-6", robot="rv-7frl")


def codes(done: Translation) -> list[str]:
    return [f.code for f in (*done.whole, *(r for row in done.rows for r in row.reasons))]


@pytest.mark.parametrize("kind", ENTRIES)
def test_a_routine_that_the_controller_calls_is_not_left_out(tmp_path: Path, kind: str) -> None:
    done = with_routine(tmp_path, OLD, ENTRIES[kind])
    assert not done.ok
    assert "CO015" not in codes(done) and "MB209" in codes(done)
    assert "CO048" in codes(done)


@pytest.mark.parametrize("kind", STRANGERS)
def test_a_routine_that_nothing_calls_is_left_out(tmp_path: Path, kind: str) -> None:
    done = with_routine(tmp_path, OLD, STRANGERS[kind])
    assert done.ok, codes(done)
    assert "CO015" in codes(done) and "CO048" not in codes(done)


def test_an_event_routine_that_is_translated_is_reported(tmp_path: Path) -> None:
    """The other controller does not call it."""
    routine = "    PROC {name}()\n        SetDO doGrip,0;\n    ENDPROC\nENDMODULE\n"
    done = with_routine(tmp_path, routine, ENTRIES["an event"])
    assert done.ok
    said = [r.message for row in done.rows for r in row.reasons if r.code == "CO048"]
    said += [f.message for f in done.whole if f.code == "CO048"]
    assert said and all("at POWER_ON" in message for message in said)


def test_the_entry_of_a_task_that_the_backup_does_not_tell_is_kept(tmp_path: Path) -> None:
    """The parameters name entries of tasks, and none says which one the module is of."""
    (tmp_path / "SYS.cfg").write_text(SYS.replace("watch", "sweep"), encoding="utf-8")
    module = "MODULE m\n    PROC main()\n        Stop;\n    ENDPROC\n"
    file = tmp_path / "m.mod"
    file.write_text(module + OLD.format(name="sweep"), encoding="utf-8")
    assert "CO015" not in codes(translate(file, to="melfa-basic-6"))
    (tmp_path / "SYS.cfg").unlink()
    assert "CO015" in codes(translate(file, to="melfa-basic-6"))


@pytest.mark.parametrize("kind", ["an event", "nothing"])
def test_a_cell_changes_nothing_in_what_the_controller_calls(tmp_path: Path, kind: str) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text("[tools]\nnozzle = { tip = [0, 0, 100] }\n", encoding="utf-8")
    files = backup(tmp_path)
    text = MODULE.replace("MoveL p1,v100,fine,tool0", "MoveL p1,v100,fine,nozzle")
    text = text.replace("ENDMODULE\n", OLD.format(name="sweep")).replace("main()", "begin()")
    Path(files[0]).write_text(text, encoding="utf-8")
    path = tmp_path / "SYSPAR" / "SYS.cfg"
    tasks = SYS.replace("-MotionTask", '-Entry "begin"')
    path.write_text(f"{tasks}#\n{({**ENTRIES, **STRANGERS})[kind][1]}\n", encoding="utf-8")
    loaded = load_task(tasks_of(files)[0])
    done = translate(loaded, to="melfa-basic-6", robot="rv-7frl", cell=cell)
    assert ("CO015" in codes(done)) == (kind == "nothing"), codes(done)


def arm_findings(folder: Path, kind: str, from_robot: str | None = None) -> dict[str, str]:
    files = backup(folder)
    path = folder / "SYSPAR" / "MOC.cfg"
    path.write_text(path.read_text("utf-8").replace("ROB1_1200_0.9_5_TypeB", kind), "utf-8")
    task = load_task(tasks_of(files)[0])
    done = translate(task, to="melfa-basic-6", robot="rv-7frl", from_robot=from_robot)
    return {f.code: f.message for f in done.whole if f.code in ("CO085", "CO086")}


def test_an_arm_is_named_that_the_backup_does_not_state(tmp_path: Path) -> None:
    known, strange = "ROB1_1200_0.9_5_TypeB", "ROB1_1660ID_1.55_4"
    found = arm_findings(tmp_path, known, "irb120-3-0.58")
    assert list(found) == ["CO085"]
    assert "`irb120-3-0.58`" in found["CO085"] and "`irb1200-5-0.9`" in found["CO085"]
    assert f"`{strange}`" in arm_findings(tmp_path, strange, "irb120-3-0.58")["CO085"]
    assert not arm_findings(tmp_path, known, "irb1200-5-0.9")
    assert not arm_findings(tmp_path, known)


def test_an_arm_of_the_backup_that_the_catalogue_lacks_is_reported(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    text = Path(robots.__file__).with_name("catalogue").joinpath("irb1200-5-0.9.toml")
    own.write_text(text.read_text("utf-8").replace("irb1200-5-0.9", "irb1660id"), "utf-8")
    strange = "ROB1_1660ID_1.55_4"
    assert list(arm_findings(tmp_path, strange)) == ["CO086"]
    assert not arm_findings(tmp_path, strange, str(own))


WIRED = """{eio}#
SYSSIG_IN:

      -Signal "E_Stop_Robot" -Action "QuickStop"
      -Signal "diCall" -Action "Interrupt" -Arg1 "sweep"
      -Signal "E_Run" -Action "Start" -Arg1 "CONT"
#
SYSSIG_OUT:

      -Status "MotorOn" -Signal "doMotors"
"""


def test_signals_of_the_controller_itself_are_one_warning(tmp_path: Path) -> None:
    files = backup(tmp_path)
    assert "RA383" not in codes(translate(load_task(tasks_of(files)[0]), to="melfa-basic-6"))
    (tmp_path / "SYSPAR" / "EIO.cfg").write_text(WIRED.format(eio=EIO), encoding="utf-8")
    done = translate(load_task(tasks_of(files)[0]), to="melfa-basic-6")
    (finding,) = (f for f in done.whole if f.code == "RA383")
    for words in ("`E_Stop_Robot` commands QuickStop", "`E_Run` commands Start"):
        assert words in finding.message
    assert "`doMotors` shows MotorOn" in finding.message and "diCall" not in finding.message
    assert finding.path is not None and finding.path.endswith("EIO.cfg")
