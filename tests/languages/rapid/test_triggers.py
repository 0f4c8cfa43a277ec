"""Outputs that moves set on their way: what is read of them, written and found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

import assistant
from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.pseudo.statements import statement_text
from assistant.program.rewriting import rewrite
from tests.languages.rapid.test_rules import found
from tests.tables import every_row

UNUSED = "[9E9,9E9,9E9,9E9,9E9,9E9]"
HEAD = f"""MODULE m
CONST robtarget p1:=[[400,0,400],[0,0,1,0],[0,0,0,0],{UNUSED}];
CONST robtarget p2:=[[400,100,400],[0,0,1,0],[0,0,0,0],{UNUSED}];
CONST num nFar:=30;
VAR num n;
VAR triggdata a;
VAR triggdata b;
"""


def module(body: str, more: str = "") -> str:
    return f"{HEAD}PROC main()\n{body}\nENDPROC\n{more}\nENDMODULE\n"


def lifted(body: str, more: str = "") -> Program:
    return load_text(SourceText(module(body, more)), language="rapid").program


def on_way(program: Program) -> list[str]:
    """What moves set, as the text form says it."""
    lines = (statement_text(x) or "" for x in program.statements() if p.outputs(x))
    return [line.partition(" set ")[2] for line in lines]


def kept(program: Program) -> list[str]:
    return [x.text.partition(" ")[0] for x in program.statements() if isinstance(x, p.Opaque)]


L = "TriggL p2,v100,a,fine,tool0;"


@every_row(
    ("setup", "said"),
    [
        ("TriggIO a,20\\DOp:=do1,1;", "do1 = 1 at 20 mm before end"),
        ("TriggIO a,20\\Start\\DOp:=do1,0;", "do1 = 0 at 20 mm from start"),
        ("TriggIO a,0.2\\Time\\DOp:=do1,1;", "do1 = 1 at 0.2 s before end"),
        ("TriggIO a,nFar\\GOp:=go1,5;", "go1 = 5 at nFar mm before end"),
        ("TriggIO a,5\\AOp:=ao1,2.5;", "ao1 = 2.5 at 5 mm before end"),
        ("TriggEquip a,20,0.1\\DOp:=do1,1;", "do1 = 1 at 20 mm before end ahead 0.1 s"),
        ("TriggEquip a,20\\Start,-0.1\\DOp:=do1,1;", "do1 = 1 at 20 mm from start ahead -0.1 s"),
        ("TriggIO a,n\\DOp:=do1,n;", "do1 = n at n mm before end"),
    ],
)
def test_what_is_set_up_is_said_by_the_move(setup: str, said: str) -> None:
    program = lifted(f"{setup}\n{L}")
    assert on_way(program) == [said]
    assert kept(program) == []
    assert [d.text for d in program.declarations] == ["VAR triggdata b;"]  # another module's


def test_kinds_of_signals_are_known() -> None:
    program = lifted(
        "TriggIO a,1\\GOp:=g,5;\nTriggIO b,1\\AOp:=an,5;\nTriggJ p2,v100,a\\T2:=b,fine,tool0;"
    )
    assert {n: s.kind for n, s in program.signals.items()} == {"g": "group", "an": "analog"}


STAYS = {
    "an interrupt": "TriggInt a,5,i;\n" + L,
    "a copy": "TriggIO a,5\\DOp:=do1,1;\nTriggDataCopy a,b;\n" + L,
    "a port of a process": "TriggIO a,5\\ProcID:=1,1;\n" + L,
    "a delay of the output": "TriggIO a,5\\DOp:=do1,1\\DODelay:=1;\n" + L,
    "two ways to it": "IF n=1 THEN\nTriggIO a,5\\DOp:=do1,1;\nELSE\nTriggIO a,6\\DOp:=do1,1;\n"
    "ENDIF\n" + L,
    "a number that changes": "TriggIO a,n\\DOp:=do1,1;\nn:=n+1;\n" + L,
    "a label between": "TriggIO a,5\\DOp:=do1,1;\nx:\n" + L + "\nTriggIO a,6\\DOp:=do1,1;\n"
    "IF n=1 GOTO x;",
    "a turn of a loop": "TriggIO a,5\\DOp:=do1,1;\nWHILE n<3 DO\n" + L + "\n"
    "TriggIO a,6\\DOp:=do1,1;\nENDWHILE",
    "a routine that sets it up": "TriggIO a,5\\DOp:=do1,1;\nother;\n" + L,
    "a routine of another module": "TriggIO a,5\\DOp:=do1,1;\nfar;\n" + L,
    "what handles errors": "TriggIO a,5\\DOp:=do1,1;\n" + L + "\nERROR\nother;\nTRYNEXT;",
    "another option of the move": "TriggIO a,5\\DOp:=do1,1;\nTriggL p2,v100\\T:=3,a,fine,tool0;",
}
OTHER = "PROC other()\nTriggIO a,7\\DOp:=do1,1;\nENDPROC"


@every_row("case", list(STAYS))
def test_what_is_not_certain_stays_and_says_why(case: str) -> None:
    program = lifted(STAYS[case], OTHER if "other" in STAYS[case] else "")
    moves = [x for x in program.statements() if isinstance(x, p.Opaque) and "Trigg" in x.text]
    assert moves and on_way(program) == []
    takes = [x for x in moves if x.text.startswith("TriggL")]
    assert takes and all(x.reason is not None for x in takes)
    assert any("triggdata a" in d.text for d in program.declarations)


def test_one_that_stays_keeps_those_beside_it() -> None:
    program = lifted(
        "TriggIO a,5\\DOp:=do1,1;\nTriggInt b,5,i;\nTriggL p2,v100,a\\T2:=b,fine,tool0;\n"
        "TriggL p1,v100,a,fine,tool0;"
    )
    assert on_way(program) == []
    assert kept(program) == ["TriggIO", "TriggInt", "TriggL", "TriggL"]


def test_what_no_move_here_takes_may_be_another_module_s() -> None:
    program = lifted("TriggIO a,5\\DOp:=do1,1;")
    assert kept(program) == ["TriggIO"]
    assert [d.text for d in program.declarations] == ["VAR triggdata a;", "VAR triggdata b;"]


def test_what_is_set_up_once_holds_everywhere() -> None:
    program = lifted(f"init;\nFOR i FROM 1 TO 3 DO\n{L}\nENDFOR", OTHER.replace("other", "init"))
    assert on_way(program) == ["do1 = 1 at 7 mm before end"]


def test_a_call_of_what_sets_nothing_up_changes_nothing() -> None:
    program = lifted(
        f"TriggIO a,5\\DOp:=do1,1;\nplain;\n{L}\nTriggIO a,6\\DOp:=do1,0;\n{L}",
        "PROC plain()\nMoveJ p1,v100,fine,tool0;\nENDPROC",
    )
    assert on_way(program) == ["do1 = 1 at 5 mm before end", "do1 = 0 at 6 mm before end"]


def test_a_label_that_every_way_comes_to_with_the_same_changes_nothing() -> None:
    jumps = f"TriggIO a,5\\DOp:=do1,1;\nx:\n{L}\nIF n=1 GOTO x;\nTriggIO a,6\\DOp:=do1,0;\n{L}"
    assert on_way(lifted(jumps)) == ["do1 = 1 at 5 mm before end", "do1 = 0 at 6 mm before end"]


def test_what_handles_errors_keeps_only_what_it_may_set_up_anew() -> None:
    body = f"TriggIO b,5\\DOp:=do1,1;\nTriggIO b,6\\DOp:=do1,1;\n{L.replace(',a,', ',b,')}\n"
    program = lifted(
        f"{body}{L}\nERROR\nother;\nTRYNEXT;", f"{OTHER}\n{OTHER.replace('other', 'q')}"
    )
    assert on_way(program) == ["do1 = 1 at 6 mm before end"]
    assert kept(program) == ["TriggL", "ERROR\n", "TriggIO", "TriggIO"]


def test_a_variable_of_a_routine_of_its_own() -> None:
    program = lifted(f"VAR triggdata c;\nTriggIO c,5\\DOp:=do1,1;\n{L.replace(',a,', ',c,')}")
    assert on_way(program) == ["do1 = 1 at 5 mm before end"]


def test_moves_with_outputs_are_no_rows_of_a_path() -> None:
    targets = "".join(
        f"CONST robtarget s_{i}:=[[400,{i},400],[0,0,1,0],[0,0,0,0],{UNUSED}];\n" for i in (1, 2, 3)
    )
    program = load_text(
        SourceText(
            f"MODULE m\n{targets}VAR triggdata a;\nPROC main()\nTriggIO a,5\\DOp:=do1,1;\n"
            "MoveL s_1,v100,fine,tool0;\nTriggL s_2,v100,a,fine,tool0;\n"
            "MoveL s_3,v100,fine,tool0;\nENDPROC\nENDMODULE\n"
        ),
        language="rapid",
    ).program
    assert on_way(program) == ["do1 = 1 at 5 mm before end"]
    assert not [x for x in program.statements() if isinstance(x, p.Follow)]


def trigger(number: int, **changed: object) -> p.Trigger:
    given = {"amount": e.Number(number), "measure": "end", **changed}
    return p.Trigger(f"do{number}", e.Number(1), **given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("triggers", "what"),
    [
        ([trigger(1, pulse=e.Number(1))], "a pulse of `do1`"),
        ([trigger(1, measure="share")], "a share of a way"),
        ([trigger(1, measure="time")], "more than 0.5 s"),
        (
            [trigger(3, amount=e.Number(0.1), measure="time", ahead=e.Number(1))],
            "a delay of what `do3`",
        ),
        ([trigger(n) for n in range(9)], "more than 8 outputs"),
    ],
)
def test_what_rapid_cannot_say(triggers: list[p.Trigger], what: str) -> None:
    program = lifted("MoveJ p1,v100,fine,tool0;")
    (body,) = (q.body for q in program.procedures)
    assert isinstance(body[0], p.Move)
    moved = p.Move("joint", body[0].target, body[0].motion, tuple(triggers))
    changed = Program("m", (type(program.procedures[0])("main", (moved,)),), "main",
                      targets=program.targets)  # fmt: skip
    findings = languages.get("rapid").adapt(changed, None).findings
    assert any(f.code == "RA305" and what in f.message for f in findings)


PSEUDO = """program example
signal gun digital output 1
signal at_gun digital output 2
target far [400, 0, 400] [0, 0, 1, 0] front up noflip 0 0 0
variable at_gun_2 number = 5
procedure main
  variable at_gun_3 number = 7
  follow at_gun
    linear [400, 0, 300] [0, 0, 1, 0] speed 100 mm/s blend fine tool tool0 frame base
    linear [400, 9, 300] [0, 0, 1, 0]
  end
  for at_gun_4 from 1 to 3
    move linear far speed 100 mm/s blend fine set gun = 1 at at_gun_4 mm before end
  end
  move joint far speed 100 mm/s blend fine set gun = 1 at at_gun_3 mm before end
end
"""


def test_names_of_data_are_hidden_nowhere() -> None:
    compiled = assistant.compile(load_text(SourceText(PSEUDO)), language="rapid")
    assert compiled.ok, compiled.findings


RULES = {
    "nothing sets it up": ("", L, [("RA465", 9)]),
    "it is set up": ("", f"TriggIO a,5\\DOp:=do1,1;{L}", []),
    "another instruction sets it up": ("", f"TriggInt a,5,i;{L}", []),
    "another routine sets it up": (OTHER, L, []),
    "a parameter": (f"PROC q(VAR triggdata c)\n{L.replace(',a,', ',c,')}\nENDPROC", "", []),
    "too long a time": ("", f"TriggIO a,0.6\\Time\\DOp:=do1,1;{L}", [("RA466", 9)]),
}


@pytest.mark.parametrize("case", RULES)
def test_rules(case: str) -> None:
    more, body, expected = RULES[case]
    codes = [(code, line) for code, line in found(module(body, more)) if code in ("RA465", "RA466")]
    assert codes == expected


# -------------------------------------------------------------------- changes of a program

TEXT = f"""MODULE Seam
  CONST robtarget p1:=[[400,0,400],[0,0,1,0],[0,0,0,0],{UNUSED}];
  VAR triggdata gunon;  ! spray
  VAR triggdata gunoff;
  PROC main()   ! one move
    TriggIO gunon, 20\\DOp:=do1, 1;
    TriggIO gunoff, 10\\DOp:=do1, 0;
    MoveJ p1 , v500, fine,  tool0;
    TriggL Offs(p1,0,0,50), v150, gunon \\T2:=gunoff, fine, tool0;
    WaitTime  1;
  ENDPROC
ENDMODULE
"""


def changed(change: Callable[[Any], Any]) -> str:
    """The text once a change was made to what it says."""
    rapid = languages.get("rapid")
    program = rapid.lift(rapid.parse(TEXT))
    assert rapid.render(rapid.lower(program)) == TEXT
    made = replace(program, procedures=rewrite(program.procedures, change))
    return str(rapid.render(rapid.lower(made)))


def test_another_statement_is_changed_in_place() -> None:
    def longer(x: Any) -> Any:
        return replace(x, seconds=e.Number(2)) if isinstance(x, p.Wait) else x

    assert changed(longer) == TEXT.replace("WaitTime  1", "WaitTime  2")


@pytest.mark.parametrize("value", [0, 1])
def test_a_place_that_is_changed_is_the_one_that_is_said(value: int) -> None:
    def moved(x: Any) -> Any:
        is_it = isinstance(x, p.Trigger) and x.value == e.Number(value)
        return replace(x, amount=e.Number(25)) if is_it else x

    text = changed(moved)
    program = load_text(SourceText(text), language="rapid").program
    places = {1: 20, 0: 10, value: 25}
    assert on_way(program) == [
        f"do1 = 1 at {places[1]} mm before end set do1 = 0 at {places[0]} mm before end"
    ]
