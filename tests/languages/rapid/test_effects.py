"""What RAPID does that a program keeps as its text."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.program.expressions import Effect, unknown_effect
from tests.tables import every_row

RAPID = languages.get("rapid")


def does(*flags: str, reads: str = "", writes: str = "", calls: str = "") -> Effect:
    named = (frozenset(names.split()) for names in (reads, writes, calls))
    return Effect(*named, "moves" in flags, "jumps" in flags, "waits" in flags)


@every_row(
    ("text", "expected"),
    [
        ("a.x:=B{i}+c.trans.y;", does(reads="a b i c", writes="a")),
        ("IF n>0 m:=1;", does(reads="n m", writes="m")),
        ("FOR i FROM 1 TO n DO a{i}:=0; ENDFOR", does(reads="n a i", writes="a i")),
        ("SetAO ao1,level;", does(reads="setao ao1 level", writes="ao1")),
        ("Incr count;", does(reads="incr count", writes="count")),
        (
            r"MoveL p1,v100\T:=t,fine,grip;",
            does("moves", reads="movel p1 v100 t fine grip", writes="grip"),
        ),
        (
            r"SearchL\Stop,di1,found,p2,v50,tool0;",
            does("moves", reads="searchl di1 found p2 v50 tool0", writes="di1 found tool0"),
        ),
        ("NutL p1,gun;", does("moves", reads="nutl p1 gun", writes="p1 gun")),
        (
            r"TriggIO gun,0.2\DOp:=do1,1;",
            does(reads="triggio gun do1", writes="gun do1"),
        ),
        (r"WaitTime\InPos,pause;", does("waits", reads="waittime pause")),
        (
            r"RMQReadWait message\TimeOut:=limit;",
            does("waits", reads="rmqreadwait message limit", writes="message"),
        ),
        ("Stop;", does("waits", reads="stop")),
        ("ExitCycle;", does("jumps", reads="exitcycle")),
        ("RETURN total;", does("jumps", reads="total")),
        ("RAISE;", does("jumps")),
        ("TRYNEXT;", does("jumps")),
        ("GOTO again;", does("jumps", reads="again")),
        (
            r"fetch part\fast\at?place,2;",
            does(reads="fetch part place", writes="part place", calls="fetch"),
        ),
        ("n:=area(part)+Abs(m);", does(reads="n area part abs m", writes="n part", calls="area")),
        ('SetDataVal "count",5;', does(reads="setdataval count", writes="count")),
        ("CONNECT alarm WITH onalarm;", does(reads="alarm onalarm", writes="alarm")),
        (
            "ISignalDI di1,1,alarm;",
            does(reads="isignaldi di1 alarm", writes="di1 alarm"),
        ),
        ("ERROR\n  MoveJ home,v100,fine,tool0;\n  fix;\n  RETRY;", does("jumps", reads="movej home "
         "v100 fine tool0 fix", writes="tool0")),
    ],
)  # fmt: skip
def test_statements(text: str, expected: Effect) -> None:
    assert RAPID.effect(text, "statement") == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("ORobT(p1)", does(reads="orobt p1")),
        ("best(parts,n)", does(reads="best parts n", writes="parts n", calls="best")),
        ("UIMessageBox(\\MaxTime:=5)", does("waits", reads="uimessagebox")),
    ],
)
def test_expressions(text: str, expected: Effect) -> None:
    assert RAPID.effect(text, "expression") == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("VAR intnum alarm;", does(reads="intnum alarm", writes="intnum alarm")),
        (
            "PROC fetch(\\switch fast)\n  MoveJ p1,v100,fine,tool0;\nERROR\n  RETRY;\nENDPROC",
            does("moves", "jumps", reads="fetch switch fast movej p1 v100 fine tool0",
                 writes="fetch switch fast tool0"),
        ),
        ("TRAP onalarm\n  stopall;\nENDTRAP", does(reads="onalarm stopall", writes="onalarm",
                                                   calls="stopall")),
    ],
)  # fmt: skip
def test_declarations(text: str, expected: Effect) -> None:
    assert RAPID.effect(text, "declaration") == expected


def test_many_moves_in_a_routine_name_each_target() -> None:
    moves = "\n".join(f"  MoveL p{n},v100,z5,grip;" for n in range(1, 20))
    effect = RAPID.effect(f"PROC seam(\\num n)\n{moves}\nENDPROC", "declaration")
    assert effect.moves
    assert {f"p{n}" for n in range(1, 20)} | {"grip", "seam", "n"} <= effect.names


@pytest.mark.parametrize(
    "text",
    [
        "MoveL p1 v100;",
        "IF a THEN",
        "<SMT>",
        "30 MVS P3",
        '%"fill"+kind% 2;',
        'CallByVar "fill",2;',
    ],
)
def test_what_does_not_tell_what_it_does_may_do_anything(text: str) -> None:
    for kind in ("statement", "expression", "declaration"):
        assert RAPID.effect(text, kind) == unknown_effect(text)  # type: ignore[arg-type]
    assert unknown_effect(text).moves and unknown_effect(text).jumps and unknown_effect(text).waits
