"""Local data of modules that have the same names: each module means its own."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, walk

RAPID = languages.get("rapid")
REST = "[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]"


def lifted(*modules: str) -> Program:
    trees = [RAPID.parse(text) for text in modules]
    assert not any(tree.findings for tree in trees)
    return RAPID.lift(trees)


def module(name: str, data: str, routine: str, body: str) -> str:
    return f"MODULE {name}\n{data}\nPROC {routine}()\n{body}\nENDPROC\nENDMODULE\n"


def targets(scope: str, x: int, count: int) -> str:
    head = f"{scope} CONST robtarget".strip()
    return "\n".join(f"{head} p{k}0:=[[{x},{k},0],{REST}];" for k in range(1, count + 1))


def places(program: Program) -> list[list[float]]:
    """The x of the targets of each procedure's moves, in mm."""
    found = []
    for procedure in program.procedures:
        moves = [node for node in procedure.body if isinstance(node, p.Move)]
        names = [move.target.name for move in moves if isinstance(move.target, e.Name)]
        assert len(names) == len(moves)
        found.append([program.targets[name].pose.position[0] for name in names])
    return found


@pytest.mark.parametrize("count", [1, 30])
@pytest.mark.parametrize(("one", "other"), [("LOCAL", "LOCAL"), ("LOCAL", ""), ("", "LOCAL")])
def test_moves_go_to_the_targets_of_their_own_module(one: str, other: str, count: int) -> None:
    moves = "\n".join(f"MoveL p{k}0,v100,fine,tool0;" for k in range(1, count + 1))
    program = lifted(
        module("A", targets(one, 100, count), "main", moves + "\nsub;"),
        module("B", targets(other, 200, count), "sub", moves),
    )
    assert places(program) == [[100.0] * count, [200.0] * count]
    assert not program.declarations


def test_a_name_of_a_routine_hides_that_of_its_module() -> None:
    body = "VAR num n;\nn:=1;\nm:=n;"
    program = lifted(
        module("A", "LOCAL VAR num n:=1;\nLOCAL VAR num m;", "main", "n:=2;\nsub;"),
        module("B", "LOCAL VAR num n:=5;\nLOCAL VAR num m;", "sub", body),
    )
    assert program.variables["B_n"].initial == e.Number(5)
    main, sub = program.procedures
    assert main.body[0] == p.Assign(e.Name("n"), e.Number(2))
    assert list(sub.variables) == ["n"]
    assert sub.body[-1] == p.Assign(e.Name("B_m"), e.Name("n"))


@pytest.mark.parametrize("count", [1, 30])
def test_speeds_and_tools_are_those_of_the_module_too(count: int) -> None:
    tool = "[TRUE,[[0,0,{}],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]]"
    programs = [
        module(
            name,
            f"LOCAL CONST speeddata own:=[{size},500,5000,1000];\n"
            f"LOCAL PERS tooldata tip:={tool.format(size)};",
            routine,
            f"MoveL [[1,2,3],{REST}],own,fine,tip;\n" * count,
        )
        for name, routine, size in (("A", "main", 100), ("B", "sub", 200))
    ]
    program = lifted(*programs)
    motions = [q.body[0].motion for q in program.procedures if isinstance(q.body[0], p.Move)]
    assert [program.tools[motion.tool].tip.position[2] for motion in motions] == [100, 200]
    named = [motion.speed.name for motion in motions if isinstance(motion.speed, e.Name)]
    assert [program.speeds[name].tcp for name in named] == [100.0, 200.0]


def test_names_that_only_one_module_has_stay() -> None:
    move = "MoveL p10,v100,fine,tool0;"
    program = lifted(
        module("A", targets("LOCAL", 100, 12), "main", move),
        module("B", targets("LOCAL", 200, 1) + "\nLOCAL CONST num limit:=5;", "sub", move),
    )
    assert list(program.variables) == ["limit"]
    assert set(program.targets) == {*(f"p{k}0" for k in range(1, 13)), "B_p10"}


@pytest.mark.parametrize(
    ("body", "variables"),
    [
        ("VAR num B_n:=7;\nr:=n;", ["B_n"]),
        ("FOR B_n FROM 1 TO 3 DO\nr:=n;\nENDFOR", []),
        ("SetDO B_n,1;\nr:=n;", []),
    ],
)
def test_another_name_is_none_that_a_routine_has(body: str, variables: list[str]) -> None:
    program = lifted(
        module("A", "LOCAL VAR num n:=1;\nVAR num r;", "main", "n:=2;\nsub;"),
        module("B", "LOCAL VAR num n:=5;", "sub", body),
    )
    (sub,) = (q for q in program.procedures if q.name == "sub")
    (assigned,) = (x for x in walk(sub.body) if isinstance(x, p.Assign))
    assert assigned.value == e.Name("B_n_2")
    assert program.variables["B_n_2"].initial == e.Number(5)
    assert list(sub.variables) == variables
