"""Which of many files are one program."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from assistant.compiler import check_files, load, translate
from assistant.compiler.motion_proof import Proving
from assistant.compiler.program_files import load_task, tasks_of

MAIN = "MODULE {name}\n    PROC main()\n{body}    ENDPROC\nENDMODULE\n"
LIBRARY = (
    "MODULE {name}\n    PERS num {data}:=1;\n    PROC {routine}()\n{body}    ENDPROC\nENDMODULE\n"
)


def main(name: str, body: str = "") -> str:
    return MAIN.format(name=name, body=body)


def library(name: str, body: str = "") -> str:
    return LIBRARY.format(name=name, data=f"n{name}", routine=f"do_{name}", body=body)


def listed(*names: str) -> str:
    modules = "".join(f"<Module>{name}</Module>" for name in names)
    return f"<?xml version='1.0'?><Program>{modules}</Program>"


def written(folder: Path, texts: Mapping[str, str]) -> list[str]:
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return [str(folder / name) for name in texts]


def grouped(folder: Path, texts: Mapping[str, str]) -> dict[str, list[str]]:
    """Tasks by the paths that they are known by, with the names of their files."""
    tasks = tasks_of(written(folder, texts))
    return {
        Path(task.name).relative_to(folder).as_posix(): [Path(file).name for file in task.files]
        for task in tasks
    }


def test_files_that_share_data_or_calls_are_one_program(tmp_path: Path) -> None:
    texts = {
        "m.mod": main("m", "        do_a;\n"),
        "a.mod": library("a", "        nb:=nb+1;\n"),
        "b.mod": library("b"),
        "other.mod": library("other"),
    }
    assert grouped(tmp_path, texts) == {
        "m.mod": ["m.mod", "a.mod", "b.mod"],
        "other.mod": ["other.mod"],
    }


def test_names_in_comments_and_strings_join_nothing(tmp_path: Path) -> None:
    texts = {"m.mod": main("m", '        TPWrite "do_a"; ! do_a\n'), "a.mod": library("a")}
    assert grouped(tmp_path, texts) == {"m.mod": ["m.mod"], "a.mod": ["a.mod"]}


def test_each_main_is_a_program(tmp_path: Path) -> None:
    texts = {
        "m.mod": main("m", "        do_a;\n"),
        "n.mod": main("n", "        do_a;\n"),
        "a.mod": library("a"),
    }
    assert grouped(tmp_path, texts) == {"m.mod": ["m.mod", "a.mod"], "n.mod": ["n.mod", "a.mod"]}


def test_what_uses_the_data_of_the_only_task_belongs_to_it(tmp_path: Path) -> None:
    texts = {
        "m.mod": main("m", "        do_a;\n"),
        "a.mod": library("a"),
        "part.mod": library("part", "        na:=2;\n"),
    }
    assert grouped(tmp_path, texts) == {"m.mod": ["m.mod", "a.mod", "part.mod"]}


def test_a_list_is_its_modules_and_the_system_modules(tmp_path: Path) -> None:
    texts = {
        "one.pgf": listed("m.mod", "a.mod"),
        "m.mod": main("m"),
        "a.mod": library("a"),
        "tools.sys": library("tools"),
    }
    assert grouped(tmp_path, texts) == {"one.pgf": ["one.pgf", "m.mod", "a.mod", "tools.sys"]}


def test_a_list_of_files_that_are_not_there_says_so(tmp_path: Path) -> None:
    texts = {"one.pgf": listed("m.mod", "gone.mod"), "m.mod": main("m")}
    files = written(tmp_path, texts)
    (task,) = tasks_of(files)
    for findings in (
        load_task(task).findings,
        load(files[0]).findings,
        check_files(files[:1]).findings,
    ):
        (missing,) = (f for f in findings if f.code == "CO041")
        assert "gone.mod" in missing.message and missing.path == files[0]


def test_the_tasks_of_a_backup_load_their_folders_and_what_is_shared(tmp_path: Path) -> None:
    texts = {
        "RAPID/TASK1/PROGMOD/m.mod": main("m"),
        "RAPID/TASK1/PROGMOD/a.mod": library("a"),
        "RAPID/TASK1/SYSMOD/user.sys": library("user"),
        "RAPID/TASK2/PROGMOD/m.mod": main("m", "        do_a;\n"),
        "RAPID/TASK0/SYSMOD/all.sys": library("all"),
    }
    assert grouped(tmp_path, texts) == {
        "RAPID/TASK1": ["m.mod", "a.mod", "user.sys", "all.sys"],
        "RAPID/TASK2": ["m.mod", "all.sys"],
    }


def test_modules_that_a_controller_could_not_load_together_are_apart(tmp_path: Path) -> None:
    texts = {
        "m.mod": main("m", "        do_a;\n"),
        "a_m.mod": library("a"),
        "a_old.mod": library("a"),
    }
    first, second = tasks_of(written(tmp_path, texts))
    assert [Path(file).name for file in first.files] == ["m.mod", "a_m.mod"]
    assert [f.code for f in first.findings] == ["CO042"]
    assert [Path(file).name for file in second.files] == ["a_old.mod"]


def test_routines_of_another_folder_are_read_where_one_file_has_them(tmp_path: Path) -> None:
    texts = {
        "server/m.mod": main("m", "        do_a;\n        nb:=1;\n"),
        "common/a.mod": library("a"),
        "common/b.mod": library("b"),
    }
    assert grouped(tmp_path, texts) == {
        "server/m.mod": ["m.mod", "a.mod"],
        "common/b.mod": ["b.mod"],
    }


def test_persistent_data_of_other_tasks_is_read_where_one_module_has_nothing_else(
    tmp_path: Path,
) -> None:
    data = "MODULE {0}\n    ! of all tasks\n    {1} num n{0}:=1;\nENDMODULE\n"
    texts = {
        "left/m.mod": main("m", "        nshared:=nown+nvar+nmixed;\n"),
        "right/r.mod": main("r", "        nshared:=2;\n"),
        "right/shared.mod": data.format("shared", "PERS"),
        "right/own.mod": data.format("own", "TASK PERS"),
        "right/var.mod": data.format("var", "VAR"),
        "right/mixed.mod": library("mixed"),
    }
    assert grouped(tmp_path, texts)["left/m.mod"] == ["m.mod", "shared.mod"]


@pytest.mark.parametrize("twice", [False, True])
def test_files_that_are_named_twice_or_with_what_loads_them(tmp_path: Path, twice: bool) -> None:
    body = '        Load "HOME:/a.mod";\n        do_a;\n'
    files = written(tmp_path, {"m.mod": main("m", body), "a.mod": library("a")})
    tasks = tasks_of([*files, *files] if twice else files[::-1])
    assert [sorted(Path(file).name for file in task.files) for task in tasks] == [
        ["a.mod", "m.mod"]
    ]


def test_a_task_is_translated_as_one_program(tmp_path: Path) -> None:
    texts = {"m.mod": main("m", "        do_a;\n"), "a.mod": library("a", "        na:=na+1;\n")}
    (task,) = tasks_of(written(tmp_path, texts))
    found = translate(load_task(task), to="melfa-basic-6")
    assert found.ok
    assert {Path(row.place.path or "").name for row in found.rows} == {"m.mod", "a.mod"}


def test_a_file_that_cannot_be_read_is_a_task_by_itself(tmp_path: Path) -> None:
    files = written(tmp_path, {"m.mod": main("m"), "a.mod": library("a")})
    (tmp_path / "empty.mod").write_bytes(b"")
    tasks = tasks_of([*files, str(tmp_path / "empty.mod")])
    assert [Path(task.name).name for task in tasks] == ["m.mod", "a.mod", "empty.mod"]


def test_signals_of_a_backup_are_those_of_its_controller(tmp_path: Path) -> None:
    body = "        SetDO doGrip,1;\n        WaitDI diPart,1;\n        SetGO goNum,3;\n"
    rows = (
        '-Name "doGrip" -SignalType "DO" -DeviceMap "5"',
        '-Name "diPart" -SignalType "DI" -DeviceMap "6"',
        '-Name "goNum" -SignalType "GO" -DeviceMap "8-11"',
        '-Name "odd" -SignalType "ZZ"',
    )
    table = "\n".join(f"      {row}" for row in rows)
    eio = f'EIO_SIGNAL:\n{table}\nEIO_CROSS:\n      -Res "doGrip" -Act1 "diPart"\n'
    texts = {
        "RAPID/TASK1/PROGMOD/m.mod": main("m", body),
        "RAPID/TASK1/PROGMOD/a.mod": library("a"),
    }
    files = written(tmp_path, texts)
    written(tmp_path, {"SYSPAR/EIO.cfg": eio})
    (task,) = tasks_of(files)
    loaded = load_task(task)
    assert sorted(f.code for f in loaded.findings) == ["CO043", "CO044", "CO045"]
    found = translate(loaded, to="melfa-basic-6", proving=Proving(runs=3))
    assert found.ok and found.motion is not None and found.motion.holds
    (text,) = (data.decode() for data in found.files.values())
    assert "M_Out(5)=1" in text and "M_In(6)=1" in text
    assert load(files[0]).program.signals["doGrip"].number == 5


def test_a_broken_file_keeps_no_other_from_crossing(tmp_path: Path) -> None:
    texts = {
        "RAPID/TASK1/PROGMOD/m.mod": main("m", "        do_a;\n"),
        "RAPID/TASK1/PROGMOD/a.mod": library("a"),
        "RAPID/TASK1/PROGMOD/half.mod": "MODULE half\n    PROC do_half(\n",
    }
    assert grouped(tmp_path, texts) == {
        "RAPID/TASK1": ["m.mod", "a.mod"],
        "RAPID/TASK1/PROGMOD/half.mod": ["half.mod"],
    }


def test_a_list_in_a_backup_leaves_out_what_it_does_not_name(tmp_path: Path) -> None:
    texts = {
        "RAPID/TASK1/PROGMOD/one.pgf": listed("m.mod"),
        "RAPID/TASK1/PROGMOD/m.mod": main("m"),
        "RAPID/TASK1/PROGMOD/old.mod": library("old"),
        "RAPID/TASK1/SYSMOD/user.sys": library("user"),
    }
    assert grouped(tmp_path, texts) == {
        "RAPID/TASK1/PROGMOD/one.pgf": ["one.pgf", "m.mod", "user.sys"],
        "RAPID/TASK1/PROGMOD/old.mod": ["old.mod"],
    }


RECORDS = (
    "MODULE records(SYSMODULE)\n    RECORD part\n        num size;\n    ENDRECORD\nENDMODULE\n"
)
GLOBALS = "MODULE globals\n    PERS part pNow;\n    VAR syncident met;\nENDMODULE\n"


def test_types_and_shared_data_are_read_from_another_task_of_a_backup(tmp_path: Path) -> None:
    """A backup may keep with one task what all of them load."""
    texts = {
        "RAPID/TASK1/PROGMOD/m.mod": main("m", "        do_a;\n"),
        "RAPID/TASK1/PROGMOD/globals.mod": GLOBALS,
        "RAPID/TASK1/PROGMOD/own.mod": "MODULE own\n    VAR num size:=1;\nENDMODULE\n",
        "RAPID/TASK1/SYSMOD/records.sys": RECORDS,
        "RAPID/TASK2/PROGMOD/m.mod": main("m", "        pNow.size:=size;\n        do_b;\n"),
        "RAPID/TASK2/PROGMOD/b.mod": library("b"),
    }
    assert grouped(tmp_path, texts)["RAPID/TASK2"] == [
        "m.mod",
        "b.mod",
        "globals.mod",
        "records.sys",
    ]
    files = [str(tmp_path / name) for name in texts]
    _, second = tasks_of(files)
    assert [f.code for f in second.findings if f.code == "CO049"] == ["CO049", "CO049"]
