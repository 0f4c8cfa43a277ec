"""Loops over variables that something else uses, and names that nothing declares."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.base.diagnostics import Severity
from assistant.program import expressions as e
from assistant.program import pseudo
from assistant.program import statements as p
from assistant.program.program import Parameter, Procedure, Program, Variable
from assistant.program.vendor_statements import with_effects
from tests.languages.rapid.test_translation import codes, proved, text

RAPID = languages.get("rapid")
N, M = e.Name("n"), e.Name("m")
THREE = e.Number(3)
NUMBER = Variable("number", e.Number(0))


def loop(*body: p.Statement, last: e.Expression = THREE, step: float = 1) -> p.For:
    return p.For("n", e.Number(1), last, body, e.Number(step))


def program(*body: p.Statement, others: tuple[Procedure, ...] = ()) -> Program:
    main = Procedure("main", body)
    return Program("cell", (main, *others), variables={"n": NUMBER, "m": NUMBER})


SHOW = p.Message((N,))


def test_a_variable_that_only_the_loop_uses_keeps_its_name() -> None:
    given = program(loop(SHOW), loop(SHOW, step=2))
    proved(given)
    shown = text(given)
    assert shown.count("FOR n FROM 1 TO 3") == 2
    assert "n_2" not in shown


@pytest.mark.parametrize(
    "given",
    [
        program(loop(SHOW), SHOW),
        program(loop(p.Assign(N, e.Binary("+", N, e.Number(1))))),
        program(loop(SHOW), p.Call("sub"), others=(Procedure("sub", (SHOW,)),)),
        program(loop(p.Call("sub")), others=(Procedure("sub", (loop(),)),)),
        program(loop(loop())),
        program(
            loop(p.Call("sub", (N,))),
            others=(Procedure("sub", (), (Parameter("x", "number", "inout"),)),),
        ),
    ],
)
def test_a_variable_that_is_used_elsewhere_is_counted_by_a_while(given: Program) -> None:
    proved(given)
    shown = text(given)
    assert "n:=1;\n        WHILE n<=3 DO" in shown.replace("\r\n", "\n")
    assert "n:=n+1;" in shown
    assert "n_2" not in shown
    assert "RA306" in codes(given)


@pytest.mark.parametrize(
    ("said", "counts"),
    [
        ("SetAO ao1,n;", "FOR n FROM 1 TO 3 DO"),
        ("Incr n;", "WHILE n<=3 DO"),
        ("fetch n\\fast;", "WHILE n<=3 DO"),
        ('SetDataVal "n",5;', "WHILE n<=3 DO"),
    ],
)
def test_a_variable_that_kept_text_may_change_is_counted_by_a_while(said: str, counts: str) -> None:
    read = with_effects(program(loop(p.Opaque("rapid", said))), languages.effect)
    assert counts in text(read)


def test_counting_down_is_kept() -> None:
    given = program(p.For("n", e.Number(3), e.Number(1), (SHOW,), e.Number(-1)), SHOW)
    proved(given)
    shown = text(given)
    assert "WHILE n>=1 DO" in shown
    assert "n:=n-1;" in shown


def test_an_end_that_changes_is_worked_out_once() -> None:
    given = program(loop(p.Assign(M, N), last=M), SHOW)
    proved(given)
    shown = text(given).replace("\r\n", "\n")
    assert "n_last:=m;\n        n:=1;\n        WHILE n<=n_last DO" in shown
    assert "VAR num n_last;" in shown


@pytest.mark.parametrize(
    "given",
    [
        program(p.For("n", e.Number(1), e.Number(3), (), M), SHOW),
        Program("cell", (Procedure("main", (loop(), SHOW)),)),
        Program("cell", (Procedure("main", (loop(p.Assign(N, e.Number(1))),)),)),
    ],
)
def test_what_cannot_be_counted_otherwise_is_refused(given: Program) -> None:
    assert "RA310" in codes(given)


def test_a_counter_is_renamed_inside_its_loop_only() -> None:
    given = Program(
        "cell",
        (
            Procedure(
                "main",
                (
                    p.For("sub", e.Number(1), e.Number(2), (p.Message((e.Name("sub"),)),)),
                    p.Call("sub"),
                ),
            ),
            Procedure("sub", (p.Label("n"), p.Assign(N, e.Number(2)), p.Goto("n"))),
        ),
        variables={"n": NUMBER},
    )
    proved(given)
    shown = text(given)
    assert "FOR sub_2 FROM" in shown
    assert "    sub;" in shown
    assert "n_2:" in shown
    assert "n:=2;" in shown


def test_a_loop_of_rapid_that_hides_a_variable_gets_a_name_of_its_own() -> None:
    tree = RAPID.parse(
        "MODULE m\nVAR num n:=7;\nPROC main()\nFOR n FROM 1 TO 3 DO\nTPWrite ValToStr(n);\n"
        "ENDFOR\nTPWrite ValToStr(n);\nENDPROC\nENDMODULE\n"
    )
    lifted = RAPID.lift(tree)
    counted, shown = lifted.procedures[0].body
    assert counted == p.For("n_2", e.Number(1), e.Number(3), (p.Message((e.Name("n_2"),)),))
    assert shown == SHOW
    proved(lifted)


BODY = "VAR num n;\nPROC main()\nFOR i FROM 1 TO 2 DO\nn:=i;\nENDFOR\n{line}\nENDPROC\nENDMODULE\n"


@pytest.mark.parametrize("line", ["n:=i;", "TPWrite ValToStr(n_2);", "WaitUntil ready=1;"])
def test_a_name_that_nothing_declares_is_an_error_in_what_was_compiled(line: str) -> None:
    compiled = RAPID.parse("MODULE m\n! program: m\n" + BODY.format(line=line))
    errors = [f for f in RAPID.check([compiled]) if f.severity is Severity.ERROR]
    assert [(f.code, f.line) for f in errors] == [("RA211", 8)]
    by_hand = RAPID.check([RAPID.parse("MODULE m\n" + BODY.format(line=line))])
    assert not [f for f in by_hand if f.severity is not Severity.INFO]


def test_a_signal_of_the_header_is_declared() -> None:
    header = "MODULE m\n! program: m\n! signal: ready digital input 3\n"
    assert not RAPID.check([RAPID.parse(header + BODY.format(line="WaitUntil ready=1;"))])


@pytest.mark.parametrize(
    ("first", "last", "written"),
    [
        ("1", "3", "FROM 1 TO 3 DO"),
        ("5", "1", "FROM 5 TO 1 STEP 1 DO"),
        ("1", "count", "FROM 1 TO count STEP 1 DO"),
    ],
)
def test_a_loop_upwards_never_turns_round(first: str, last: str, written: str) -> None:
    """RAPID counts downwards by itself where the last value is below the first."""
    source = (
        "program p\n\nvariable count number = 0\n\nprocedure main\n"
        f"  for i from {first} to {last}\n    wait 1 s\n  end\nend\n"
    )
    program = pseudo.parse(source)
    shown = RAPID.render(RAPID.lower(program))
    assert written in shown
    assert RAPID.lift(RAPID.parse(shown)).procedures == RAPID.adapt(program).program.procedures


def test_a_loop_that_counts_down_by_itself_is_read_so() -> None:
    text = "MODULE m\nPROC main()\nFOR i FROM 3 TO 1 DO\nWaitTime 1;\nENDFOR\nENDPROC\nENDMODULE\n"
    (loop,) = RAPID.lift(RAPID.parse(text)).procedures[0].body
    assert isinstance(loop, p.For)
    assert loop.step == e.Number(-1)


def test_a_loop_between_constants_counts_in_the_direction_that_they_say() -> None:
    text = """MODULE m
    CONST num nRows:=3;
    CONST num nNone:=0;
    PROC main()
        FOR i FROM 1 TO nRows DO
            TPWrite "up";
        ENDFOR
        FOR i FROM nRows TO nNone DO
            TPWrite "down";
        ENDFOR
    ENDPROC
    PROC another(num nRows)
        FOR i FROM 1 TO nRows DO
            TPWrite "who knows";
        ENDFOR
    ENDPROC
ENDMODULE
"""
    fixed = text.replace("num nRows)", "num nCount)").replace(
        '1 TO nRows DO\n            TPWrite "w', '1 TO nCount DO\n            TPWrite "w'
    )
    assert steps(fixed) == [p.ONE, e.Number(-1), None]
    assert steps(text) == [None, None, None]


def steps(text: str) -> list[e.Expression | None]:
    """How each loop of a module counts."""
    found = RAPID.lift(RAPID.parse(text)).statements()
    return [x.step for x in found if isinstance(x, p.For)]
