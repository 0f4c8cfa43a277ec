"""What a process file says of a signal, and what the statements of the program say."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.compiler import load, translate
from assistant.compiler.cell_defaults import cell_text, with_values_of_file
from assistant.compiler.motion_proof import Proving
from assistant.sources.cell_values import NO_CELL, with_entries

RAPID = """MODULE M
CONST robtarget p1:=[[400,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
  MoveL p1,v100,fine,tool0;
  {statement}
ENDPROC
ENDMODULE
"""
MELFA = """Mvs P1
Wait M_In(3)=1
M_Out(4)=1
P1=(+400.00,+0.00,+500.00,+180.00,+0.00,+180.00)(7,0)
"""


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("with_cell_file", [False, True])
@pytest.mark.parametrize(
    ("statement", "stated"),
    [
        ("WaitDI part,1;", 'direction = "output"\nnumber = 5'),
        ("IF DInput(part)=1 Stop;", 'direction = "output"\nnumber = 5'),
        ("SetDO part,1;", 'direction = "input"\nnumber = 5'),
        ("SetGO part,3;", "number = 5"),
        ("SetAO part,3;", "number = 6000"),
        ("WaitGI part,3;", 'direction = "input"\nnumber = 5'),
    ],
)
def test_a_signal_is_what_statements_use_it_as(
    tmp_path: Path, statement: str, stated: str, with_cell_file: bool
) -> None:
    program = written(tmp_path, "m.mod", RAPID.format(statement=statement))
    process = written(tmp_path, "m.process.toml", f"[signals.part]\n{stated}\n")
    with pytest.raises(Refused, match="CO010") as refused:
        if with_cell_file:
            with_values_of_file(load(program), process)
        else:
            load(program, process=process)
    (finding,) = refused.value.findings
    assert finding.place == "signals.part"
    added = finding.cure.partition("write ")[2].partition(", or")[0].replace(" and ", "\n")
    number = stated.splitlines()[-1]
    process.write_text(f"[signals.part]\n{number}\n{added}\n", encoding="utf-8")
    load(program, process=process)


def test_so_is_one_that_a_program_addresses_by_its_number(tmp_path: Path) -> None:
    program = written(tmp_path, "M.prg", MELFA)
    process = written(
        tmp_path, "m.process.toml", '[signals.di_3]\ndirection = "output"\nnumber = 3\n'
    )
    with pytest.raises(Refused, match="CO010"):
        load(program, process=process, language="melfa-basic-5")


def test_one_that_only_expressions_read_is_what_the_file_says(tmp_path: Path) -> None:
    program = written(tmp_path, "m.mod", RAPID.format(statement="IF part=1 Stop;"))
    for direction, word in (("input", "M_In"), ("output", "M_Out")):
        stated = f'[signals.part]\ndirection = "{direction}"\nnumber = 5\n'
        process = written(tmp_path, "m.process.toml", stated)
        done = translate(load(program, process=process), to="melfa-basic-5")
        assert done.ok and f"{word}(5)".encode() in b"".join(done.files.values())


@pytest.mark.parametrize("with_cell_file", [False, True])
@pytest.mark.parametrize(
    ("statement", "said"),
    [("WaitDI part,1;", "M_In(5)"), ("IF DInput(part)=1 Stop;", "M_In(5)"),
     ("SetDO part,1;", "M_Out(5)")],
)  # fmt: skip
def test_one_without_a_stated_direction_has_that_of_its_use(
    tmp_path: Path, statement: str, said: str, with_cell_file: bool
) -> None:
    program = written(tmp_path, "m.mod", RAPID.format(statement=statement))
    file = written(tmp_path, "m.toml", "[signals.part]\nnumber = 5\n")
    loaded = with_values_of_file(load(program), file) if with_cell_file else None
    done = translate(loaded or load(program, process=file), to="melfa-basic-5")
    assert done.ok and said.encode() in b"".join(done.files.values())


def test_so_has_one_whose_name_and_comparison_tell_it_in_a_cell_file(tmp_path: Path) -> None:
    program = written(tmp_path, "m.mod", RAPID.format(statement="IF diPart=1 Stop;"))
    file = written(tmp_path, "m.toml", "[signals.diPart]\nnumber = 5\n")
    done = translate(program, to="melfa-basic-5", cell=file)
    assert done.ok and b"M_In(5)" in b"".join(done.files.values())


@pytest.mark.parametrize(
    ("stated", "left"),
    [
        ("[signals.doOne]\nnumber = 30\n", "1 signal"),
        ("[signals.doOne]\nnumber = 30\n[signals.DOTWO]\nnumber = 6\n", ""),
        ("[tools.gun]\ntip = [0, 0, 10]\n", "2 signal"),
    ],
)
@pytest.mark.parametrize("with_cell_file", [False, True])
def test_numbers_of_the_controller_are_told_of_where_no_file_gives_others(
    tmp_path: Path, stated: str, left: str, with_cell_file: bool
) -> None:
    rows = [f'      -Name "do{name}" -SignalType "DO" -DeviceMap "{bit}"\n'
            for name, bit in (("One", 5), ("Two", 6))]  # fmt: skip
    (tmp_path / "SYSPAR").mkdir()
    written(tmp_path, "SYSPAR/EIO.cfg", "EIO:CFG_1.0:6:1::\n#\nEIO_SIGNAL:\n" + "".join(rows))
    program = written(tmp_path, "m.mod", RAPID.format(statement="SetDO doOne,1;SetDO doTwo,1;"))
    file = written(tmp_path, "m.toml", stated)
    if with_cell_file:
        loaded = with_values_of_file(load(program), file)
    else:
        loaded = load(program, process=file)
    told = [one.message for one in loaded.findings if one.code == "CO043"]
    assert len(told) == bool(left) and all(one.startswith(left) for one in told)


@pytest.mark.parametrize(
    ("statement", "stated", "told"),
    [
        ("WaitDI part,1;", "number = 3", True),
        ("WaitDI part,1;", "number = 5", True),
        ("WaitDI part,1;", "number = 6", False),
        ("SetDO part,1;", "number = 0", True),
        ("SetDO part,1;", "number = 4", False),
        ("SetDO part,1;", "number = 902", True),
        ("SetGO part,1;", 'kind = "group"\nnumber = 2\nbits = 8', True),
        ("SetGO part,1;", 'kind = "group"\nnumber = 8\nbits = 8', False),
        ("SetAO part,1;", 'kind = "analog"\nnumber = 6000', False),
    ],
)
def test_numbers_that_a_new_controller_uses_itself_are_told(
    tmp_path: Path, statement: str, stated: str, told: bool
) -> None:
    program = written(tmp_path, "m.mod", RAPID.format(statement=statement))
    direction = "input" if "Wait" in statement else "output"
    kind = "" if "kind" in stated else 'kind = "digital"\n'
    text = f'[signals.part]\n{kind}direction = "{direction}"\n{stated}\n'
    cell = written(tmp_path, "cell.toml", text)
    for to in ("melfa-basic-5", "melfa-basic-6"):
        found = translate(program, to=to, cell=cell).whole
        assert ("CO081" in [f.code for f in found]) is told


def test_free_numbers_are_none_that_a_new_controller_uses_itself(tmp_path: Path) -> None:
    statements = [f"WaitDI in{n},1;SetDO out{n},1;SetGO go{n},1;" for n in range(9)]
    program = written(tmp_path, "m.mod", RAPID.format(statement="\n  ".join(statements)))
    done = translate(program, to="melfa-basic-6", cell=tmp_path / "cell.toml")
    assert "CO081" not in [f.code for f in done.whole]
    signals = [one.signal for one in done.wanting if one.signal is not None]
    inputs = {one.number for one in signals if one.direction == "input"}
    assert len(signals) == 27 and inputs == set(range(6, 15))
    assert min(one.number or 0 for one in signals if one.direction == "output") == 4


def test_a_cell_file_has_the_numbers_that_the_controller_knows(tmp_path: Path) -> None:
    program = written(tmp_path, "m.mod", RAPID.format(statement="SetDO part,1;"))
    loaded = with_values_of_file(
        load(program), tmp_path / "cell.toml", to=languages.get("melfa-basic-5")
    )
    text = cell_text(NO_CELL, loaded.wanting)
    assert 'number = "?"  # as wired: 0 to 255 parallel' in text
    stated = with_entries("", [(one, None) for one in loaded.wanting])
    assert "as wired" not in stated


def test_a_cell_file_says_which_registers_hold_analog_signals(tmp_path: Path) -> None:
    program = written(tmp_path, "m.mod", RAPID.format(statement="SetAO part,1;"))
    to = languages.get("melfa-basic-5")
    loaded = with_values_of_file(load(program), tmp_path / "cell.toml", to=to)
    assert "from 6000 on (CC-Link)" in cell_text(NO_CELL, loaded.wanting)


def test_numbers_of_a_program_in_the_language_of_the_controller_are_its_own(tmp_path: Path) -> None:
    program = written(tmp_path, "A.prg", MELFA)
    cell = written(tmp_path, "cell.toml", "# none\n")
    found = translate(program, to="melfa-basic-6", cell=cell, language="melfa-basic-5").whole
    assert "CO081" not in [f.code for f in found]


HAND = MELFA.replace("M_Out(4)=1", "HOpen 1\nHClose 1")
OUTPUT = "[signals.hand1_open]\nnumber = 5\n"


def test_the_output_of_a_hand_is_asked_for_like_any_other_signal(tmp_path: Path) -> None:
    program, cell = written(tmp_path, "M.prg", HAND), tmp_path / "cell.toml"
    done = translate(program, to="rapid", language="melfa-basic-5", cell=cell)
    (one,) = done.wanting
    assert (one.name, one.kind, one.uses) == ("hand1_open", "signal", ("M.prg:3", "M.prg:4"))
    assert [f.place for f in done.whole if f.code == "CO071"] == ["hand1_open"]
    # A language with hands has no question.
    assert not translate(program, to="melfa-basic-6", language="melfa-basic-5", cell=cell).wanting


@pytest.mark.parametrize("table", ["process", "cell"])
def test_a_stated_output_of_a_hand_is_in_the_heading(tmp_path: Path, table: str) -> None:
    program = written(tmp_path, "M.prg", HAND)
    files = {"cell": tmp_path / "cell.toml"}
    files[table] = written(tmp_path, "stated.toml", OUTPUT)
    done = translate(
        program, to="rapid", language="melfa-basic-5", proving=Proving(),
        process=files.get("process"), cell=files["cell"],
    )  # fmt: skip
    assert done.ok and done.motion is not None and done.motion.holds
    (data,) = done.files.values()
    assert b"! signal: hand1_open digital output 5\r\n" in data


@pytest.mark.parametrize("stated", ["", "! signal: hand1_open digital output 1\n"])
def test_a_hand_that_only_opens_and_closes_needs_no_signal_of_its_own(
    tmp_path: Path, stated: str
) -> None:
    text = RAPID.format(statement="SetDO hand1_open,1;")
    head = f"MODULE M\n! program: M\n{stated or '! signal: hand1_open digital output'}\n"
    program = written(tmp_path, "m.mod", text.replace("MODULE M\n", head, 1))
    done = translate(program, to="melfa-basic-5", cell=tmp_path / "cell.toml")
    (data,) = done.files.values()
    assert done.ok and b"HOpen 1" in data and b"hand1_open" not in data
    read = RAPID.format(statement="SetDO hand1_open,1;\n  IF DOutput(hand1_open)=1 Stop;")
    again = translate(
        written(tmp_path, "n.mod", read), to="melfa-basic-5", cell=tmp_path / "cell.toml"
    )
    assert [one.name for one in again.wanting] == ["hand1_open"]


@pytest.mark.parametrize(
    "other", ["SetDO hand1_open,nState;", "IF DOutput(hand1_open)=1 Stop;", "WaitDO hand1_open,1;"]
)
def test_a_hand_that_is_read_or_set_otherwise_too_is_one_output(tmp_path: Path, other: str) -> None:
    """`HOpen 1` beside `M_Out(5)` would be two outputs."""
    text = RAPID.format(statement=f"SetDO hand1_open,1;\n  SetDO hand2_open,1;\n  {other}")
    text = text.replace("MODULE M\n", "MODULE M\nVAR dionum nState:=0;\n", 1)
    program, cell = written(tmp_path, "m.mod", text), written(tmp_path, "cell.toml", OUTPUT)
    done = translate(program, to="melfa-basic-5", cell=cell, proving=Proving())
    (data,) = done.files.values()
    assert b"M_Out(5)=1" in data and b"HOpen 2" in data and b"HOpen 1" not in data
    assert done.ok and done.motion is not None and done.motion.holds


NUMBERED = """Mvs P1
M_Out(12)=1
Wait M_In(5)=1
If M_In(5)=1 Then M_Out8(16)=3
P1=(+400.00,+0.00,+500.00,+180.00,+0.00,+180.00)(7,0)
"""
NAMES = """[signals.gripper]
direction = "output"
number = 12
[signals.partHere]
direction = "input"
number = 5
[signals.goJob]
kind = "group"
direction = "output"
number = 16
bits = 8
"""


@pytest.mark.parametrize("with_process", [False, True])
@pytest.mark.parametrize("with_cell", [False, True])
def test_numbers_get_the_names_that_a_file_gives_them(
    tmp_path: Path, with_process: bool, with_cell: bool
) -> None:
    program = written(tmp_path, "M.prg", NUMBERED)
    file = written(tmp_path, "m.toml", NAMES)
    done = translate(
        program,
        to="rapid",
        process=file if with_process else None,
        cell=file if with_cell else None,
        language="melfa-basic-5",
        proving=Proving(),
    )
    text = b"".join(done.files.values()).decode()
    names = ("gripper", "partHere", "goJob")
    if not (with_process or with_cell):
        names = ("do_12", "di_5", "go_8_16")
    gripper, part, job = names
    assert done.motion is not None and done.motion.holds
    assert f"SetDO {gripper},1;" in text and f"WaitDI {part},1;" in text
    assert f"IF {part}=1" in text and f"SetGO {job},3;" in text


@pytest.mark.parametrize(
    ("entries", "reason"),
    [
        ("[signals.valve]\nnumber = 12\n", "no direction of `valve`"),
        (
            '[signals.valve]\nnumber = 12\ndirection = "output"\n'
            '[signals.gun]\nnumber = 12\ndirection = "output"\n',
            "the names `valve`, `gun`",
        ),
        ('[signals.P1]\nnumber = 12\ndirection = "output"\n', "something else with the name `P1`"),
        ('[signals.valve]\nnumber = 12\ndirection = "input"\n', ""),
    ],
)
def test_a_number_whose_name_is_in_doubt_keeps_its_number(
    tmp_path: Path, entries: str, reason: str
) -> None:
    file = written(tmp_path, "m.toml", entries)
    program = written(tmp_path, "M.prg", NUMBERED)
    loaded = load(program, process=file, language="melfa-basic-5")
    told = [one.message for one in loaded.findings if one.code == "CO084"]
    assert "do_12" in loaded.program.signals
    assert len(told) == bool(reason) and all(reason in one for one in told)
