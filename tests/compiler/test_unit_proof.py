"""Long paths are proven unit by unit: the same files and figures, and no lie passes."""

from __future__ import annotations

import pickle
import re
from typing import Any

import numpy as np
import pytest

import assistant
from assistant import languages
from assistant.compiler import unit_proof
from assistant.compiler.read_back_proof import prove_read_back
from assistant.compiler.unit_proof import ProvenFiles
from assistant.languages import lark_parsing
from assistant.languages.language_types import Adapted
from assistant.languages.rapid import Rapid
from assistant.program.motion import Blend, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow

ROWS = 130


@pytest.fixture(autouse=True)
def _short_programs_count_as_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unit_proof, "WHOLE", 100)
    monkeypatch.setattr(lark_parsing, "WHOLE", 100)
    monkeypatch.setattr(lark_parsing, "SAMPLED", 40)


def program(rows: int = ROWS) -> Program:
    turn = np.linspace(0, 6, rows)
    positions = np.c_[500 + 50 * np.cos(turn), 50 * np.sin(turn), np.full(rows, 300.0)]
    speeds, blends = (Speed(100.0), Speed(50.0)), (Blend(1.0),)
    path = Path.of(
        "bead", positions, [[0, 1, 0, 0]] * rows, speeds=speeds, blends=blends, speed=turn > 3
    )
    return Program("weld", (Procedure("main", (Follow(path),)),))


def adapted() -> Adapted:
    return Rapid().adapt(program(), most_targets=20)


def proven(language: Rapid, wanted: Adapted) -> ProvenFiles | None:
    return unit_proof.prove_by_unit(language, wanted, None, 1)


def all_files(language: Rapid, wanted: Adapted) -> dict[str, bytes]:
    units = dict.fromkeys(q.unit for q in wanted.program.procedures)
    return {
        language.file_name(wanted.program, unit): language.encode(
            language.built(wanted, None, unit)
        )
        for unit in units
    }


def test_the_units_are_proven_as_all_of_them_together_are() -> None:
    language, wanted = Rapid(), adapted()
    made = proven(language, wanted)
    assert made is not None
    files, proof = made.files, made.proof
    assert len(files) == 8
    assert files == all_files(language, wanted)
    together = prove_read_back(language, wanted.program, files)
    assert proof.holds
    assert proof.record() == together.record()
    assert proof.line() == together.line()
    assert proof.lifted == together.lifted
    assert proof.findings == together.findings == ()


def test_the_proof_of_units_reaches_another_process() -> None:
    compiled = assistant.compile(program(), language="rapid", most_targets=20)
    assert compiled.ok
    again = pickle.loads(pickle.dumps(compiled))
    assert again.proof.lifted == compiled.proof.lifted


LIES = {
    "another number": (r":=\[\[4", ":=[[5"),
    "a declaration less": (r" *CONST robtarget \w+_5:=.*\r\n", ""),
    "a move less": (r" *MoveL \w+_5,.*\r\n", ""),
    "a move twice": (r"( *MoveL \w+_5,.*\r\n)", r"\1\1"),
    "two moves changed places": (r"( *MoveL \w+_5,.*\r\n)( *MoveL \w+_6,.*\r\n)", r"\2\1"),
    "another speed": ("v100", "v150"),
    "another zone": ("z1,", "z5,"),
    "another tool": ("tool0", "tool1"),
    "the names of another unit": ("part3_p_", "part2_p_"),
    "the procedure of another unit": (r"PROC (\w+)_part3", r"PROC \1_part2"),
    "the name of another unit": (r"MODULE (\w+)_unit3", r"MODULE \1_unit2"),
    "the heading of no unit": (r" *! unit of.*\r\n", ""),
    "a target that nothing uses": (
        r"( *CONST robtarget )(\w+)_part3_p_5(:=.*\r\n)",
        r"\1\2_part3_p_5\3\1spare\3",
    ),
    "a tool": ("    CONST", "    PERS tooldata t:=[TRUE,[[0,0,1],[1,0,0,0]],[1,[0,0,1],"
               "[1,0,0,0],0,0,0]];\r\n    CONST"),
    "an output": (r"( *MoveL \w+_5,)", r"        SetDO doGlue,1;\r\n\1"),
    "a call": (r"( *MoveL \w+_5,)", r"        main;\r\n\1"),
    "another procedure": ("ENDMODULE", "    PROC more()\r\n    ENDPROC\r\nENDMODULE"),
    "a comment": ("    CONST", "    ! seam\r\n    CONST"),
    "no end": ("ENDPROC", ""),
    "a load less": (r' *Load\\Dynamic,"HOME:/\w+unit3.mod";\r\n', ""),
    "a call less": (r' *%"\w+_part3"%;\r\n', ""),
    "a call of another unit": ('%"bead_part3"%', '%"bead_part2"%'),
    "a start at another place": ("entry: main", "entry: follow"),
}  # fmt: skip


@pytest.mark.parametrize("lie", LIES)
def test_a_unit_that_is_printed_wrongly_is_found_out(lie: str) -> None:
    wanted = adapted()
    found, instead = LIES[lie]
    lies = []

    class Lying(Rapid):
        def encode(self, tree: Any) -> bytes:
            text = super().encode(tree).decode("ascii")
            name = text.split("\r\n", 1)[0]
            if name.endswith("unit3") or not name[-1].isdigit():
                every = 0 if "names" in lie else 1
                text, count = re.subn(found, instead, text, count=every)
                lies.append(count)
            return text.encode("ascii")

    made = proven(Lying(), wanted)
    assert any(lies)
    assert made is None
    # All units together are refused as well, or have something to report.
    together = prove_read_back(Rapid(), wanted.program, all_files(Lying(), wanted))
    assert together.findings or not together.holds


def test_findings_read_as_those_of_all_units_together(monkeypatch: pytest.MonkeyPatch) -> None:
    encode = Rapid.encode

    def lying(self: Rapid, tree: Any) -> bytes:
        return encode(self, tree).replace(b"part3_p_5,v100", b"part3_p_5,v150")

    monkeypatch.setattr(Rapid, "encode", lying)
    compiled = assistant.compile(program(), language="rapid", most_targets=20, jobs=1)
    assert not compiled.files
    together = prove_read_back(Rapid(), compiled.program, all_files(Rapid(), adapted()))
    assert [one.code for one in together.findings] == ["CO102"]
    assert set(together.findings) <= set(compiled.findings)


@pytest.mark.parametrize("change", ["short", "alike"])
def test_other_programs_are_proven_as_one(change: str) -> None:
    wanted = adapted() if change == "alike" else Rapid().adapt(program(90), most_targets=20)
    if change == "alike":
        procedures = list(wanted.program.procedures)
        units = [at for at, one in enumerate(procedures) if one.unit is not None]
        first, second = (procedures[at].body[0] for at in units[:2])
        assert isinstance(first, Follow)
        assert isinstance(second, Follow)
        assert first.path.name != second.path.name
        wanted = Adapted(
            Program("weld", (*procedures[: units[1]], procedures[units[0]])), (), wanted.trees
        )
    assert proven(Rapid(), wanted) is None


@pytest.mark.slow
def test_two_processes_write_what_one_writes() -> None:
    alone = assistant.compile(program(500), language="rapid", most_targets=20, jobs=1)
    shared = assistant.compile(program(500), language="rapid", most_targets=20, jobs=2)
    assert len(alone.files) > 20
    assert list(shared.files.items()) == list(alone.files.items())
    assert shared.findings == alone.findings
    assert shared.proof.record() == alone.proof.record()


def test_a_language_without_shells_is_proven_as_one() -> None:
    melfa = languages.get("melfa-basic-5")
    compiled = assistant.compile(program(), language="melfa-basic-5", most_targets=20)
    assert melfa.shell(melfa.parse("10 End\n"), data=True) is None
    assert compiled.ok
