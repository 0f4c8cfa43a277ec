"""From samples to proven programs in every language, and what happens when a printer lies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path as FilePath

import numpy as np
import pytest

import assistant
from assistant import languages
from assistant.base import rotations
from assistant.base.diagnostics import Refused, Severity
from assistant.compiler import Compiled
from assistant.compiler.loader import load
from assistant.languages.rapid.text import printer as rapid_printer
from assistant.program.comparison import Tolerance, compare
from assistant.program.motion import Blend, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Call, Follow

SAMPLES = FilePath(__file__).parents[2] / "samples"
ROBOTS = {
    "rapid": "irb1200-7-0.7",
    "melfa-basic-4": "rv-2aj",
    "melfa-basic-5": "rv-2aj",
    "melfa-basic-6": "rv-4frl",
}
PRECISION = {"rapid": (0.001, 0.0001)}
TWO_DECIMALS = (0.005 * 3**0.5 + 1e-6, 0.02)
"""Half of 0.01 mm in each of three directions; the same for three angles, in degrees."""


def followed(program: Program, name: str) -> Iterator[Path]:
    for statement in program.procedure(name).body:
        if isinstance(statement, Follow):
            yield statement.path
        elif isinstance(statement, Call):
            yield from followed(program, statement.procedure)


def path_of(program: Program) -> Path:
    """The rows of all paths of a program, one after the other as they are followed."""
    found = list(followed(program, program.entry))
    assert found
    positions = np.concatenate([p.positions for p in found])
    quaternions = np.concatenate([p.quaternions for p in found])
    return replace(found[0], positions=positions, quaternions=quaternions)


@pytest.mark.parametrize("language", languages.names())
def test_the_35_poses_come_back(language, tmp_path):
    source = SAMPLES / "positioning.csv"
    compiled = assistant.compile(source, language=language, robot=ROBOTS[language])
    assert compiled.ok, compiled.findings
    assert compiled.proof.comparison.targets >= 35
    (name,) = compiled.files
    (tmp_path / name).write_bytes(compiled.files[name])
    wanted, got = path_of(load(source).program), path_of(load(tmp_path / name).program)
    assert len(got.positions) == 35
    most, turn = PRECISION.get(language, TWO_DECIMALS)
    assert np.abs(wanted.positions - got.positions).max() <= most
    assert rotations.angle_between(wanted.quaternions, got.quaternions).max() <= turn


@cache
def compiled_plate(language: str) -> Compiled:
    return assistant.compile(SAMPLES / "plate.dxf", language=language, robot=ROBOTS[language])


@pytest.mark.parametrize("language", languages.names())
def test_a_program_read_back_from_its_files_is_the_one_that_was_compiled(language, tmp_path):
    compiled = compiled_plate(language)
    assert compiled.ok, compiled.findings
    for name, data in compiled.files.items():
        (tmp_path / name).write_bytes(data)
    main = next(iter(compiled.files))
    lifted = load(tmp_path / main).program
    precision = languages.get(language).precision
    tolerance = Tolerance(precision.position, precision.angle, precision.number)
    comparison = compare(compiled.program, lifted, tolerance)
    assert comparison.same, comparison.mismatches


def test_the_experiment_of_the_paper_is_linear_moves_at_v150_with_z100():
    compiled = assistant.compile(
        SAMPLES / "positioning.csv", language="rapid", robot="irb1200-7-0.7"
    )
    text = compiled.files["positioning.mod"].decode("ascii")
    assert text.count(",v150,z100,GRIPPER;") == 35
    assert text.count("MoveJ positioning_1,") == 1  # to the start, from wherever the arm stands
    assert text.count("MoveL ") == 34
    assert text.count("\r\n") == text.count("\n")


def test_the_same_input_gives_the_same_bytes():
    once = compiled_plate("melfa-basic-4").files
    again = assistant.compile(SAMPLES / "plate.dxf", language="melfa-basic-4", robot="rv-2aj")
    assert once == again.files


def test_a_printer_that_lies_is_found_out(monkeypatch):
    """One digit of one number in the text is enough."""
    honest = rapid_printer.print_file

    def lying(*arguments):
        return honest(*arguments).replace("275,0,270", "275,0,271")

    assert "275,0,270" in honest(rapid_tree())
    monkeypatch.setattr(rapid_printer, "print_file", lying)
    compiled = assistant.compile(
        SAMPLES / "positioning.csv", language="rapid", robot="irb1200-7-0.7"
    )
    assert not compiled.ok
    assert compiled.files == {}
    (finding,) = [f for f in compiled.findings if f.code == "CO102"]
    assert finding.severity is Severity.ERROR
    assert "row 18" in finding.place
    assert "1 mm" in finding.message
    assert compiled.proof.line() == "not proven"


def rapid_tree():
    rapid = languages.get("rapid")
    return rapid.lower(load(SAMPLES / "positioning.csv").program)


@pytest.mark.parametrize(
    ("honest", "lie"), [(b"MVS", b"MOV"), (b"SPD 150", b"SPD 250"), (b"CNT 1,100,100", b"CNT 0")]
)
def test_a_melfa_printer_that_lies_is_found_out(monkeypatch, honest, lie):
    melfa = languages.get("melfa-basic-4")
    encode = type(melfa).encode
    monkeypatch.setattr(
        type(melfa), "encode", lambda self, tree: encode(self, tree).replace(honest, lie)
    )
    compiled = assistant.compile(
        SAMPLES / "positioning.csv", language="melfa-basic-4", robot="rv-2aj"
    )
    assert not compiled.ok
    assert compiled.files == {}
    assert "CO102" in {f.code for f in compiled.findings}


def test_a_printer_that_writes_no_program_is_found_out(monkeypatch):
    rapid = languages.get("rapid")
    encode = type(rapid).encode
    monkeypatch.setattr(
        type(rapid), "encode", lambda self, tree: encode(self, tree).replace(b"ENDPROC", b"END")
    )
    compiled = assistant.compile(SAMPLES / "taught.toml", language="rapid", robot="irb1200-7-0.7")
    assert not compiled.ok
    assert "CO101" in {f.code for f in compiled.findings}


def long_program(n: int) -> Program:
    """n rows on a spiral, every fourth move an arc."""
    turn, wide = 0.06 * np.arange(n), np.linspace(20.0, 80.0, n)
    positions = np.stack([300 + wide * np.cos(turn), wide * np.sin(turn), 280 + wide], axis=1)
    kinds = np.resize([Kind.LINEAR, Kind.LINEAR, Kind.VIA, Kind.END], n)
    kinds[n - n % 4 :] = Kind.LINEAR
    quaternions = np.broadcast_to([0.0, 1.0, 0.0, 0.0], (n, 4))
    path = Path.of(
        "spiral", positions, quaternions, kinds=kinds, speeds=[Speed(80.0)], blends=[Blend(1.0)]
    )
    return Program("spiral", (Procedure("main", (Follow(path),)),))


ROWS = 333


@pytest.mark.one_in(4)
@pytest.mark.parametrize("language", languages.names())
@pytest.mark.parametrize("most", [10, 111])
def test_a_long_program_is_spread_over_files_that_call_each_other(language, most, tmp_path):
    program = long_program(ROWS)
    compiled = assistant.compile(
        program, language=language, robot="irb1200-7-0.7", most_targets=most
    )
    assert compiled.ok, compiled.findings
    assert len(compiled.files) >= ROWS / most
    units = {p.unit for p in compiled.program.procedures} - {None}
    assert {s.unit for s in compiled.program.statements() if isinstance(s, Call)} >= units
    for name, data in compiled.files.items():
        (tmp_path / name).write_bytes(data)
    main = languages.get(language).file_name(compiled.program)
    lifted = path_of(load(tmp_path / main).program)
    assert np.abs(lifted.positions - path_of(program).positions).max() <= 0.01


def test_units_that_hold_nothing_are_refused():
    with pytest.raises(Refused) as refused:
        assistant.compile(long_program(50), language="rapid", most_targets=3)
    assert refused.value.findings[0].code == "CO004"
    assert refused.value.exit_status == 2


def test_unknown_names_of_languages_and_robots_tell_the_known_ones():
    for options in ({"language": "karel"}, {"language": "rapid", "robot": "r2d2"}):
        with pytest.raises(Refused) as refused:
            assistant.compile(SAMPLES / "positioning.csv", **options)
        assert refused.value.exit_status == 2
        assert (
            "rapid" in refused.value.findings[0].cure or "rv-2aj" in refused.value.findings[0].cure
        )


def test_targets_out_of_reach_write_nothing():
    compiled = assistant.compile(SAMPLES / "taught.toml", language="melfa-basic-4", robot="rv-2aj")
    assert not compiled.ok
    assert compiled.files == {}
    assert any(f.code == "RB102" and f.severity is Severity.ERROR for f in compiled.findings)


def test_a_language_that_the_controller_does_not_run_is_said():
    compiled = assistant.compile(SAMPLES / "positioning.csv", language="rapid", robot="rv-2aj")
    assert "CO003" in {f.code for f in compiled.findings}


def test_from_rapid_to_melfa_basic_for_another_arm(tmp_path):
    rapid = assistant.compile(SAMPLES / "positioning.csv", language="rapid", robot="irb1200-7-0.7")
    (tmp_path / "positioning.mod").write_bytes(rapid.files["positioning.mod"])
    melfa = assistant.translate(tmp_path / "positioning.mod", to="melfa-basic-6", robot="rv-4frl")
    assert melfa.ok, melfa.findings
    (tmp_path / "POSITIONING.prg").write_bytes(melfa.files["POSITIONING.prg"])
    wanted = path_of(load(SAMPLES / "positioning.csv").program)
    got = path_of(load(tmp_path / "POSITIONING.prg").program)
    assert np.abs(wanted.positions - got.positions).max() <= 0.0051


def test_a_million_poses_are_no_python_objects():
    """Reading back keeps at most a handful of objects a thousand rows."""
    import gc

    compiled = assistant.compile(long_program(4_000), language="rapid", robot="irb1200-7-0.7")
    assert compiled.ok
    rapid = languages.get("rapid")
    gc.collect()
    before = len(gc.get_objects())
    trees = [rapid.parse(rapid.decode(data, name)) for name, data in compiled.files.items()]
    lifted = rapid.lift(trees)
    gc.collect()
    kept = len(gc.get_objects()) - before
    assert lifted.procedures
    assert kept < 800, f"{kept} objects for 4,000 targets"


def test_findings_of_a_vendor_program_stand_at_its_lines(tmp_path):
    source = tmp_path / "m.mod"
    source.write_text('MODULE m\n  PROC main()\n    TPWrite "go";\n  ENDPROC\nENDMODULE\n')
    compiled = assistant.compile(source, language="melfa-basic-5")
    (finding,) = [f for f in compiled.findings if f.code == "MB211"]
    assert (finding.path, finding.line, finding.column) == (str(source), 3, 5)
    assert finding.excerpt == '    TPWrite "go";'
