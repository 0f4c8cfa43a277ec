"""Procedures with parameters, results and variables, in dialects with and without them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Severity
from assistant.compiler.read_back_proof import prove_read_back
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Parameter, Procedure, Program, Signal, ValueType, Variable
from assistant.program.pseudo import parse as parse_pseudo
from assistant.program.pseudo import print_program
from tests.examples import drawn

from .programs import fitting
from .test_lower import DIALECTS, program, written

SUM = """\
 FUNC num larger(num a,num b)
  IF a>b RETURN a;
  RETURN b;
 ENDFUNC
"""
SWAP = """\
 PROC swap(INOUT num a,INOUT num b)
  VAR num keep;
  keep:=a;
  a:=b;
  b:=keep;
 ENDPROC
"""
NUMBERS = " VAR num n:=1;\n VAR num m:=2;\n"


@pytest.mark.parametrize("name", ["melfa-basic-4", "melfa-basic-5"])
def test_parameters_and_results_are_variables(name: str) -> None:
    text = written(program("n:=larger(n,m+1);", SUM, NUMBERS), name).upper()
    result = "MLARRESU" if name.endswith("4") else "MLARGERRESULT"
    assert f"MA=MN\nMB=MM+1\nGOSUB *LARGER\nMN={result}\n" in text
    assert text.count(result) >= 3
    codes = {f.code for f in languages.get(name).adapt(program("", SUM)).findings}
    assert "MB223" in codes


@pytest.mark.parametrize(
    ("more", "data", "expected"),
    [
        ("", "", "MA=MN\n"),
        (SWAP, "", "MLARGERA=MN\n"),  # which has an `a` as well
        ("", " VAR num a:=3;\n", "MLARGERA=MN\n"),
        (" PROC other()\n  n:=a;\n ENDPROC\n", "VAR num a;\n", "MLARGERA=MN\n"),
        (" PROC other()\n  FOR a FROM 1 TO 3 DO n:=a; ENDFOR\n ENDPROC\n", "", "MLARGERA=MN\n"),
        (" PROC other()\n  VAR num a;\n  a:=2;\n  n:=a;\n ENDPROC\n", "", "MLARGERA=MN\n"),
        (" PROC a()\n  n:=3;\n ENDPROC\n", "", "MLARGERA=MN\n"),
    ],
)
def test_a_parameter_has_its_routine_in_its_name_if_another_thing_has_its_name(
    more: str, data: str, expected: str
) -> None:
    text = written(program("n:=larger(n,1);", SUM + more, NUMBERS + data), "melfa-basic-5")
    assert expected in text.upper()


def test_a_name_that_nothing_declares_is_not_a_parameter() -> None:
    """Another module may declare it: it must not become the parameter of a routine here."""
    adapted = languages.get("melfa-basic-5").adapt(program("n:=larger(n,a);", SUM, NUMBERS))
    assert "larger_a" in adapted.program.variables and "a" not in adapted.program.variables


def test_in_six_they_are_functions() -> None:
    text = written(program("n:=larger(n,m+1)+larger(1,2);\nswap n,m;", SUM + SWAP, NUMBERS),
                   "melfa-basic-6")  # fmt: skip
    assert text.startswith("Def Float Mn,Mm\n' n, m: kept from cycle to cycle;")
    assert "\nFunction V Main()\nMn=1\nMm=2\n" in text
    assert "Mn=larger(Mn,Mm+1)+larger(1,2)\nswap(Mn,Mm)\nFEnd\n" in text
    assert "Function M larger(ByVal Ma,ByVal Mb)\n" in text
    assert "larger=Ma\nExit Function\nEndIf\nlarger=Mb\nFEnd\n" in text
    assert "Function V swap(ByRef Ma2,ByRef Mb2)\n" in text


def test_in_six_without_any_they_stay_subroutines() -> None:
    text = written(program("part;", " PROC part()\n  n:=2;\n ENDPROC", NUMBERS), "melfa-basic-6")
    assert "GoSub *part\nEnd\n*part\nMn=2\nReturn\n" in text


@pytest.mark.parametrize("name", ["melfa-basic-4", "melfa-basic-5"])
def test_what_a_call_changes_is_copied_back(name: str) -> None:
    text = written(program("swap n,m;", SWAP, NUMBERS), name).upper()
    assert "MA=MN\nMB=MM\nGOSUB *SWAP\nMN=MA\nMM=MB\nRETURN\n" in text


@pytest.mark.parametrize("name", ["melfa-basic-4", "melfa-basic-5"])
def test_a_function_that_is_called_twice_keeps_its_results(name: str) -> None:
    text = written(program("n:=larger(n,m)-larger(larger(1,2),m);", SUM, NUMBERS), name).upper()
    assert text.count("GOSUB *LARGER") == 3
    subtraction = next(x for x in text.splitlines() if x.startswith("MN=") and "-" in x)
    left, right = subtraction.removeprefix("MN=").split("-")
    assert left != right


@pytest.mark.parametrize("name", ["melfa-basic-4", "melfa-basic-5"])
def test_conditions_with_calls_are_worked_out_where_they_count(name: str) -> None:
    loop = written(program("WHILE larger(n,2)<5 DO\nn:=n+1;\nENDWHILE", SUM, NUMBERS), name)
    assert loop.upper().count("GOSUB *LARGER") == 2
    chain = "IF n=1 THEN\nn:=2;\nELSEIF larger(n,m)=3 THEN\nn:=3;\nELSE\nn:=4;\nENDIF"
    text = written(program(chain, SUM, NUMBERS), name).upper()
    assert text.index("=1 THEN") < text.index("GOSUB *LARGER") < text.index("MN=3")
    wait = written(program("WaitUntil larger(n,m)>4;", SUM, NUMBERS), name).upper()
    assert wait.count("GOSUB *LARGER") == 2 and "DLY 0.01" in wait


def test_variables_of_a_procedure_begin_anew_with_each_call() -> None:
    counting = " PROC part()\n  VAR num sum;\n  VAR num k:=3;\n  sum:=sum+k;\n  n:=sum;\n ENDPROC"
    text = written(program("part;\npart;", counting, NUMBERS), "melfa-basic-5")
    assert "*PART\nMSUM=0\nMK=3\nMSUM=MSUM+MK\n" in text
    first = " PROC part()\n  VAR num sum;\n  sum:=n;\n  n:=sum+1;\n ENDPROC"
    assert "*PART\nMSUM=MN\n" in written(program("part;", first, NUMBERS), "melfa-basic-5")


@pytest.mark.parametrize("name", ["melfa-basic-4", "melfa-basic-5"])
def test_what_calls_itself_is_refused(name: str) -> None:
    again = " FUNC num down(num k)\n  IF k<1 RETURN 0;\n  RETURN down(k-1)+1;\n ENDFUNC"
    found = languages.get(name).adapt(program("n:=down(3);", again, NUMBERS)).findings
    assert [f.code for f in found if f.severity is Severity.ERROR] == ["MB224"]


@pytest.mark.parametrize("name", DIALECTS)
@pytest.mark.parametrize(
    "body", ["VAR num k;\nk:=n;\nIF n>0 part;\nn:=k;", "FOR i FROM 1 TO 3 DO\npart;\nENDFOR"]
)
def test_a_subroutine_with_data_of_its_own_does_not_call_itself(name: str, body: str) -> None:
    part = f" PROC part()\n{body}\n ENDPROC"
    language = languages.get(name)
    found = language.adapt(program("part;", part, NUMBERS)).findings
    assert [f.code for f in found if f.severity is Severity.ERROR] == ["MB224"]
    shared = " PROC part()\n  n:=n-1;\n  IF n>0 part;\n ENDPROC"
    assert "MN=MN-1" in written(program("part;", shared, NUMBERS), name).upper()


@pytest.mark.parametrize("name", DIALECTS)
def test_bounds_that_were_kept_once_are_not_kept_again(name: str) -> None:
    part = " PROC part()\n  n:=n-1;\n ENDPROC"
    language = languages.get(name)
    adapted = language.adapt(program("FOR i FROM 1 TO n DO\npart;\nENDFOR", part, NUMBERS)).program
    assert "i_last" in adapted.procedures[1].variables  # `part` changes the bound itself
    assert replace(language.adapt(adapted).program, origin=None) == adapted


@pytest.mark.parametrize("name", DIALECTS)
def test_a_program_of_its_own_is_called_with_arguments(name: str) -> None:
    language = languages.get(name)
    far = Procedure(
        "far", (p.Wait(e.Name("pause")),), (Parameter("pause", "number"),), unit="far_away"
    )
    main = Procedure("main", (p.Call("far", (e.Number(2),), "far_away"),))
    adapted = language.adapt(Program("job", (main, far)))
    assert not [f for f in adapted.findings if f.severity is Severity.ERROR]
    files = {
        language.file_name(adapted.program, unit): language.encode(
            language.build(adapted.program, unit=unit)
        )
        for unit in (None, "far_away")
    }
    assert prove_read_back(language, adapted.program, files).holds
    texts = b"".join(files.values()).upper()
    assert b'CALLP "FARAWAY",2' in texts and b"FPRM MPAUSE" in texts


# ------------------------------------------------------------------------ random programs

numbers = st.integers(-9, 9).map(e.Number)
seconds = st.sampled_from([e.Number(2), e.Number(0.25), e.Name("n")])
names = st.sampled_from(["n", "m", "ok"]).map(e.Name)
elements = st.sampled_from([e.Number(1), e.Number(2), e.Name("m")])


def _calls(inner: st.SearchStrategy[e.Expression]) -> st.SearchStrategy[e.Expression]:
    return st.one_of(
        st.builds(e.Binary, st.sampled_from(["+", "-", "*"]), inner, inner),
        st.builds(lambda a, b: e.Apply("larger", (a, b)), inner, inner),
        st.builds(lambda a: e.Apply("abs", (a,)), inner),
        st.builds(lambda a: e.Index(e.Name("row"), (a,)), elements),
    )


values = st.recursive(st.one_of(numbers, names), _calls, max_leaves=4)
conditions = st.builds(e.Binary, st.sampled_from(["=", "<", ">="]), values, values)
simple = st.one_of(
    st.builds(p.Assign, st.sampled_from([e.Name("n"), e.Name("m")]), values),
    st.builds(lambda v: p.Assign(e.Index(e.Name("row"), (e.Number(2),)), v), values),
    st.builds(lambda v: p.Call("show", (v, e.Name("m"))), values),
    st.builds(p.WaitUntil, conditions),
    st.builds(p.WaitUntil, conditions.filter(lambda c: "larger" not in repr(c)), seconds),
    st.builds(p.SetSignal, st.just("answer"), values.map(fitting)),
    st.just(p.Return()),
)


def _no_loop(body: tuple[p.Statement, ...]) -> bool:
    return "For(" not in repr(body)


def _nested(inner: st.SearchStrategy[p.Statement]) -> st.SearchStrategy[p.Statement]:
    bodies = st.lists(inner, max_size=2).map(tuple)
    branches = st.lists(st.builds(p.Branch, conditions, bodies), min_size=1, max_size=3)
    return st.one_of(
        st.builds(p.If, branches.map(tuple), bodies),
        st.builds(p.While, conditions, bodies),
        st.builds(p.For, st.just("i"), values, values, bodies.filter(_no_loop)),
    )


bodies = st.lists(st.recursive(simple, _nested, max_leaves=4), max_size=4).map(tuple)
larger = Procedure(
    "larger",
    (
        p.If((p.Branch(e.Binary(">", e.Name("a"), e.Name("b")), (p.Return(e.Name("a")),)),)),
        p.Return(e.Name("b")),
    ),
    (Parameter("a", "number"), Parameter("b", "number")),
    result="number",
)


def _program(main: tuple[p.Statement, ...], show: tuple[p.Statement, ...]) -> Program:
    parameters = (Parameter("v", "number"), Parameter("kept", "number", "inout"))
    return Program(
        "job",
        (
            Procedure("main", main),
            Procedure("show", show, parameters, {"own": Variable("number", e.Number(1))}),
            larger,
        ),
        signals={"ok": Signal("digital", "input", 7), "answer": Signal("group", "output", 48, 12)},
        variables={
            "n": Variable("number", e.Number(1)),
            "m": Variable("integer"),
            "row": Variable("number", e.Aggregate((e.Number(4), e.Number(5))), (2,)),
        },
    )


not_itself = bodies.map(lambda body: tuple(s for s in body if "show" not in repr(s)))


@pytest.mark.parametrize("name", DIALECTS)
@given(job=st.builds(_program, bodies, not_itself))
@settings(
    max_examples=drawn(12),
    deadline=None,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
)
def test_random_procedures_come_back(name: str, job: Program) -> None:
    language = languages.get(name)
    adapted = language.adapt(job)
    errors = [f for f in adapted.findings if f.severity is Severity.ERROR]
    if any(f.code == "MB107" for f in errors):  # a condition that no line holds
        return
    assert not errors
    files = {"JOB.prg": language.encode(language.build(adapted.program))}
    proof = prove_read_back(language, adapted.program, files)
    assert proof.holds, [f.message[:300] for f in proof.findings]
    again = language.adapt(adapted.program).program
    assert replace(again, origin=None) == adapted.program


places = st.one_of(elements, st.builds(lambda a: e.Index(e.Name("given"), (a,)), elements))
cells = st.builds(lambda row, a: e.Index(e.Name(row), (a,)), st.sampled_from(["given", "kept"]),
                  places)  # fmt: skip
inner_lines = st.one_of(
    st.builds(p.Assign, cells, st.one_of(numbers, cells)),
    st.just(p.Call("rows", (e.Name("given"), e.Name("kept")))),
    st.just(p.Call("rows", (e.Name("kept"), e.Name("given")))),
)
rows = st.sampled_from([e.Name("one"), e.Name("two")])


@pytest.mark.parametrize("name", ["melfa-basic-6", "rapid"])
@given(
    calls=st.lists(st.builds(lambda *r: p.Call("rows", r), rows, rows), max_size=3).map(tuple),
    body=st.lists(inner_lines, max_size=4).map(tuple),
    type=st.sampled_from(["number", "integer"]),
)
@settings(max_examples=drawn(12), deadline=None)
def test_random_arrays_are_handed_over(
    name: str, calls: tuple[p.Call, ...], body: tuple[p.Statement, ...], type: ValueType
) -> None:
    taken = (Parameter("given", type, "in", 1), Parameter("kept", type, "inout", 1))
    own = {"m": Variable("number", e.Number(1))}
    values = e.Aggregate((e.Number(1), e.Number(2)))
    variables = {row: Variable(type, values, (2,)) for row in ("one", "two")}
    job = Program(
        "job", (Procedure("main", calls), Procedure("rows", body, taken, own)), variables=variables
    )
    assert parse_pseudo(print_program(job).text) == job
    language = languages.get(name)
    adapted = language.adapt(job)
    assert not [f for f in adapted.findings if f.severity is Severity.ERROR]
    tree = language.build(adapted.program)
    files = {language.file_name(adapted.program, None): language.encode(tree)}
    proof = prove_read_back(language, adapted.program, files)
    assert proof.holds, [f.message[:300] for f in proof.findings]
    assert not [
        f
        for f in language.check([language.parse(language.decode(next(iter(files.values())), "a"))])
        if f.severity is Severity.ERROR
    ]


@pytest.mark.parametrize(
    ("name", "parameter", "cure"),
    [
        ("melfa-basic-4", "num a{*}", "use an array of the program"),
        ("melfa-basic-5", "INOUT num a{*}", "use an array of the program"),
        ("melfa-basic-6", "num a{*,*}", "give it one dimension"),
    ],
)
def test_arrays_that_a_dialect_cannot_hand_over(name: str, parameter: str, cure: str) -> None:
    job = program("", f" PROC part({parameter})\n ENDPROC\n")
    found = languages.get(name).adapt(job).findings
    (one,) = [f for f in found if f.severity is Severity.ERROR]
    assert "the array parameter `a` of `part`" in one.message and one.cure == cure


@pytest.mark.parametrize("line", ["pen.tframe.trans.z:=120;", "tray.uframe.trans.x:=5;"])
def test_a_tool_or_frame_that_changes_is_declared_all_the_same(line: str) -> None:
    found = languages.get("melfa-basic-5").adapt(program(line)).findings
    (told,) = [f for f in found if f.severity is Severity.ERROR]
    assert told.code == "MB209"


@pytest.mark.slow
def test_the_steps_of_a_long_condition_are_not_divided_again() -> None:
    language = languages.get("melfa-basic-6")
    asked = " AND ".join(f"(Abs(n-{k}.5)>=2.25 OR Abs(m*{k})<n+{k})" for k in range(12))
    for length in range(40):
        more = f"m={'7' * (length % 7 + 1)}{'+n' * (length // 7)}"
        whole = program(f"b:={asked} AND (n<m+0.75 OR {more});", "", NUMBERS + " VAR bool b;\n")
        adapted = language.adapt(whole).program
        body = adapted.procedures[0].body
        assert len(body) > 1
        assert language.adapt(adapted).program.procedures[0].body == body, length
