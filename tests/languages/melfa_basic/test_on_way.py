"""`Wth` and `WthIf`: what is read of them, and how changes are written."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from assistant import languages
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.pseudo.statements import statement_text
from assistant.program.rewriting import rewrite
from tests.tables import every_row

MELFA = languages.get("melfa-basic-5")
TEXT = """10 Spd 100
20   Mvs  P1
30   Mvs P2  {append}  ' spray
40   Dly 0.50   ' settle
P1=(+500.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
P2=(+500.00,+100.00,+400.00,+180.00,+0.00,+180.00)(7,0)
"""


def on_way(text: str) -> list[str]:
    """What moves set, as the text form says it."""
    program = MELFA.lift(MELFA.parse(text))
    lines = (statement_text(x) or "" for x in program.statements() if p.outputs(x))
    return [line.partition(" set ")[2] for line in lines]


@every_row(
    ("append", "said"),
    [
        ("Wth M_Out(5)=1", "do_5 = 1 at 0 mm from start"),
        ("Wth M_Out(5)=1 Dly 0.5", "do_5 = 1 pulse 0.5 s at 0 mm from start"),
        ("Wth M_Outb(8)=17", "go_8_8 = 17 at 0 mm from start"),
        ("WthIf M_RDst<20,M_Out(5)=1", "do_5 = 1 at 20 mm before end"),
        ("WthIf M_RDst<=2*10,M_Out(5)=1", "do_5 = 1 at 2 * 10 mm before end"),
        ("WthIf M_RDst<=M_In(1)*10,M_Out(5)=1", None),
        ("WthIf M_RDst<=M_Timer(1),M_Out(5)=1", None),
        ("WthIf 20>=M_RDst,M_Out(5)=1", "do_5 = 1 at 20 mm before end"),
        ("WthIf M_Ratio>80,M_Out(5)=0", "do_5 = 0 at 80 %"),
        ("WthIf M_RDst(2)<20,M_Out(5)=1", None),
        ("WthIf M_RDst=20,M_Out(5)=1", None),
        ("WthIf M_RDst>20,M_Out(5)=1", None),
        ("WthIf M_RDst<20 And M_In(1)=1,M_Out(5)=1", None),
        ("WthIf M_RDst<20,M_Out(5)=1 Dly 0.5", None),
        ("WthIf M1<M2,M_Out(5)=1", None),
        ("WthIf M_RDst<=M_RDst,M_Out(5)=1", None),
        ("WthIf M_Ratio>M_RDst,M_Out(5)=1", None),
        ("Wth M_Out(5)=0.4", "do_5 = 0 at 0 mm from start"),
        ("Wth M_Outb(8)=3.6", "go_8_8 = 4 at 0 mm from start"),
        ("Wth M_Out(5)=0.5", None),
        ("Wth M_Out(5)=2", None),
        ("WthIf M_In(1)=1,Skip", None),
        ("Wth Hlt", None),
        ("Wth M_Out(5)=M1", None),
        ("Wth M1=5", None),
    ],
)
def test_what_is_read(append: str, said: str | None) -> None:
    text = TEXT.format(append=append)
    assert on_way(text) == ([] if said is None else [said])
    tree = MELFA.parse(text)
    assert MELFA.render(MELFA.lower(MELFA.lift(tree))) == text


@pytest.mark.parametrize("kind", [p.Wait, p.Trigger])
def test_what_is_changed_is_what_is_said(kind: type) -> None:
    text = TEXT.format(append="WthIf M_RDst<20,M_Out(5)=1")

    def change(x: Any) -> Any:
        field = "seconds" if kind is p.Wait else "amount"
        return replace(x, **{field: e.Number(2)}) if isinstance(x, kind) else x

    program = MELFA.lift(MELFA.parse(text))
    made = replace(program, procedures=rewrite(program.procedures, change))
    written = MELFA.render(MELFA.lower(made))
    again = MELFA.lift(MELFA.parse(written))
    assert [x for q in again.procedures for x in q.body if not isinstance(x, p.Comment)] == [
        x for q in made.procedures for x in q.body if not isinstance(x, p.Comment)
    ]


@pytest.mark.parametrize(
    ("define", "value", "said"),
    [
        ("Bit,5", "0.4", ["0 at 0 mm from start"]),
        ("Byte,8", "300", ["44 at 0 mm from start"]),
        ("Bit,5", "2", []),
    ],
)
def test_what_a_named_output_takes(define: str, value: str, said: list[str]) -> None:
    text = TEXT.format(append=f"Wth PORT={value}").replace(
        "10 Spd", f"5 Def Io PORT={define}\n10 Spd"
    )
    assert [one.partition(" = ")[2] for one in on_way(text)] == said


def test_a_row_of_a_table_has_no_outputs() -> None:
    lines = "".join(f"Mvs P{n}{' Wth M_Out(5)=1' if n == 2 else ''}\n" for n in (1, 2, 3))
    places = "".join(f"P{n}=(+500.00,+{n}0.00,+400.00,+180,+0,+180)(7,0)\n" for n in (1, 2, 3))
    program = MELFA.lift(MELFA.parse(f"Spd 100\n{lines}End\n{places}"))
    assert not any(isinstance(x, p.Follow) for x in program.statements())
    assert on_way(f"Spd 100\n{lines}End\n{places}") == ["do_5 = 1 at 0 mm from start"]
