"""Programs go to text and come back as they were adapted, in every dialect."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath
from typing import get_args

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base import rotations
from assistant.base.diagnostics import Severity
from assistant.compiler import load, translate
from assistant.compiler.cell_defaults import with_neutral_cell
from assistant.languages.language_types import Frames
from assistant.program import statements as p
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import FINE, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import map_bodies
from tests.examples import drawn

from .programs import differences, programs

DIALECTS = ["melfa-basic-4", "melfa-basic-5", "melfa-basic-6"]


def stopping(program: Program) -> Program:
    """The program without corners, in which no arc may start."""

    def stop(node: p.Statement) -> p.Statement:
        match node:
            case p.Move() | p.MoveCircular() | p.MoveJoints():
                return replace(node, motion=replace(node.motion, blend=FINE))
            case p.Follow(path):
                return replace(node, path=replace(path, blends=(FINE,) * len(path.blends)))
        return map_bodies(node, lambda body: tuple(map(stop, body)))

    procedures = (replace(q, body=tuple(map(stop, q.body))) for q in program.procedures)
    return replace(program, procedures=tuple(procedures))


def there_and_back(program: Program, name: str, robot=None, **options):  # type: ignore[no-untyped-def]
    """The adapted program, what came back of it, and its texts."""
    frames = options.pop("frames", "base")
    language = languages.get(name).with_frames(frames)
    any_length = options.pop("any_length", False)
    adapted = language.adapt(program, robot, **options)
    errors = [f for f in adapted.findings if f.severity is Severity.ERROR]
    if any_length and any("an arc whose start is not known" in f.message for f in errors):
        again = {"any_length": True, "frames": frames, **options}
        return there_and_back(stopping(program), name, robot, **again)
    if any_length:  # conditions of any length are made, and procedures that call themselves
        assume(not {"MB107", "MB224"} & {f.code for f in errors})
    assert not errors, errors
    units = dict.fromkeys([None, *(q.unit for q in adapted.program.procedures)])
    trees = [language.build(adapted.program, robot, unit) for unit in units]
    texts = [language.render(tree) for tree in trees]
    parsed = [language.parse(text) for text in texts]
    for tree, again, text in zip(trees, parsed, texts, strict=True):
        assert not again.findings
        assert again.items == tree.items
        assert language.render(again) == text
        assert language.format(again) == text
    found = [f for f in language.check(parsed) if f.severity is Severity.ERROR]
    assert {f.code for f in found} <= {"MB702"}, found  # the branches of targets are at random
    return adapted.program, language.lift(parsed, robot), texts


def comes_back(program: Program, name: str, frames: Frames) -> None:
    adapted, lifted, _ = there_and_back(program, name, any_length=True, frames=frames)
    assert differences(lifted, adapted) == []
    assert languages.get(name).with_frames(frames).adapt(adapted).program == adapted


assert settings.default is not None
random_programs = settings(
    max_examples=5 if settings.default.derandomize else 12,
    deadline=None,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
)


@pytest.mark.parametrize("name", DIALECTS)
@given(program=programs, frames=st.sampled_from(get_args(Frames)))
@random_programs
def test_random_programs_come_back(name: str, program: Program, frames: Frames) -> None:
    comes_back(program, name, frames)


@pytest.mark.slow
@pytest.mark.parametrize("name", DIALECTS)
@given(program=programs, frames=st.sampled_from(get_args(Frames)))
@settings(random_programs, max_examples=drawn(150))
def test_many_random_programs_come_back(name: str, program: Program, frames: Frames) -> None:
    comes_back(program, name, frames)


@pytest.mark.parametrize("name", DIALECTS)
@pytest.mark.parametrize("most", [2, 7, 25])
def test_long_paths_are_split(name: str, most: int) -> None:
    rng = np.random.default_rng(3)
    kinds = [k for k in rng.integers(0, 3, 30) for k in ([0], [1], [2, 3])[k]]
    n = len(kinds)
    path = Path.of(
        "seam", rng.uniform(-500, 500, (n, 3)), rotations.canonical(rng.normal(size=(n, 4))),
        kinds=kinds, speeds=[Speed(100.0, joint=10.0)], blends=[FINE],
        configurations=np.zeros((n, 6)),
    )  # fmt: skip
    program = Program("job", (Procedure("main", (p.Comment("go"), p.Follow(path))),))
    adapted, lifted, texts = there_and_back(program, name, most_targets=most)
    assert differences(lifted, adapted) == []
    parts = [s.path for q in adapted.procedures for s in q.body if isinstance(s, p.Follow)]
    assert sum(len(part) for part in parts) == n
    assert all(len(part) <= max(most, 3) for part in parts)
    assert all(part.kinds[0] != Kind.END and part.kinds[-1] != Kind.VIA for part in parts)
    assert np.array_equal(np.concatenate([part.positions for part in parts]), path.positions)
    assert len(texts) == len(parts) + 1
    again = languages.get(name).adapt(adapted, most_targets=most)
    assert again.program == adapted


@pytest.mark.parametrize("name", DIALECTS)
def test_five_axes(name: str) -> None:
    from assistant import robots
    from assistant.robots.arms import closed_form

    robot = robots.get("rv-2aj")
    rng = np.random.default_rng(5)
    n = 40
    azimuth, reach = rng.uniform(-120, 120, n), rng.uniform(250, 380, n)
    position = np.column_stack([
        reach * np.cos(np.radians(azimuth)), reach * np.sin(np.radians(azimuth)),
        rng.uniform(250, 500, n),
    ])  # fmt: skip
    ab = np.column_stack([rng.uniform(-90, 90, n), rng.uniform(60, 180, n)])
    in_base = closed_form.from_ab(position, ab)
    table = Pose((200.0, 50.0, 10.0), tuple(rotations.about((0, 0, 1), 30.0)))  # type: ignore[arg-type]
    back = table.inverse()
    local = rotations.rotate(back.quaternion, position) + back.position
    turned = rotations.multiply(back.quaternion, in_base)
    path = Path.of(
        "seam", local, turned, speeds=[Speed(100.0)], tools=["pen"], frames=["table"],
        configurations=np.zeros((n, 6)),
    )  # fmt: skip
    program = Program(
        "job", (Procedure("main", (p.Follow(path),)),),
        tools={"pen": Tool(Pose((0.0, 0.0, 50.0)))}, frames={"table": Frame(table)},
    )  # fmt: skip
    adapted, lifted, texts = there_and_back(program, name, robot)
    assert differences(lifted, adapted) == []
    (follow,) = adapted.procedures[0].body
    assert isinstance(follow, p.Follow)
    assert follow.path.frames == ("base",)
    assert np.allclose(follow.path.positions, position, atol=1e-9)
    assert rotations.angle_between(follow.path.quaternions, in_base).max() < 1e-6
    lines = [line for line in texts[0].splitlines() if line.startswith("P1=")]
    assert lines[0].endswith(",+0.00)(6,0)")
    alone = languages.get(name).lift(languages.get(name).parse(texts[0]))
    assert differences(alone, adapted) == []


def test_out_of_reach_of_five_axes() -> None:
    from assistant import robots

    path = Path.of("seam", [[300, 0, 300]], [rotations.about((1, 0, 0), 30.0)], speeds=[Speed(9.0)])
    program = Program("job", (Procedure("main", (p.Follow(path),)),))
    found = languages.get("melfa-basic-4").adapt(program, robots.get("rv-2aj")).findings
    (finding,) = [f for f in found if f.severity is Severity.ERROR]
    assert finding.code == "MB213"
    assert "30.00 degrees" in finding.message


def test_lines_with_columns_and_a_close_of_all(tmp_path: FilePath) -> None:
    file = tmp_path / "TALK.mb5"
    file.write_text(
        'Close\nC_Com(2)="ETH:10.0.0.7, 3000"\nOpen "COM2:" As #1\n'
        'Print #1,"AB","C",M1,"D"\nClose\nEnd\nM1=+3\n'
    )
    made = translate(with_neutral_cell(load(file)), to="rapid")
    assert made.ok
    (module,) = made.files.values()
    text = module.decode()
    assert text.count("SocketClose channel_1;") == 2
    assert 'SocketConnect channel_1,"10.0.0.7",3000' in text
    assert "in_next_column(" in text and "AB        C" in text


def test_a_file_of_its_suffix_needs_no_other_mark(tmp_path: FilePath) -> None:
    file = tmp_path / "PLAIN.mb5"
    file.write_text('M1=3\nOpen "COM2:" As #1\nC1$="a"\nEnd\n')
    assert load(file).program.procedures


def test_the_safe_point_is_asked_of_the_cell(tmp_path: FilePath) -> None:
    file = tmp_path / "SAFE.mb5"
    file.write_text("Mov P_Safe\nSpd 100\nMvs P1\nMov P_Safe\nEnd\nP1=(400,0,450,180,0,180)(7,0)\n")
    assert not translate(file, to="rapid").ok
    made = translate(with_neutral_cell(load(file)), to="rapid")
    assert made.ok
    assert b"P_Safe" in next(iter(made.files.values()))


def test_mo_triggers_are_conditions_of_interrupts(tmp_path: FilePath) -> None:
    file = tmp_path / "TRIGGER.mb5"
    file.write_text(
        "Spd 100\nDef MoTrg 1,M_In(3)=1 And M_In(4)=0\nDef Act 1,M_MoTrg(1)=1 GoTo *S,F\n"
        "SetMoTrg 1\nAct 1=1\nMvs P1\nSetMoTrg 0\nEnd\n*S\nM_Out(1)=1\nEnd\n"
        "P1=(400,0,450,180,0,180)(7,0)\n"
    )
    made = translate(file, to="rapid")
    assert made.ok
    text = next(iter(made.files.values())).decode()
    assert "mo_trigger_1=1 AND (di_3=1 AND di_4=0)" in text
    assert text.index("mo_trigger_1:=1;") < text.index("MoveL") < text.rindex("mo_trigger_1:=0;")


def test_an_interrupt_costs_no_subroutine(tmp_path: FilePath) -> None:
    file = tmp_path / "LINE.mb5"
    file.write_text(
        "GoSub *INIT\nSpd 100\nMvs P1\nEnd\n*INIT\nOn Com(1) GoSub *HEARD\nM1=2\nReturn\n"
        "*HEARD\nM_Out(1)=1\nReturn 1\nP1=(400,0,450,180,0,180)(7,0)\n"
    )
    rows = translate(file, to="rapid").rows
    assert [row.text for row in rows if row.level == "not"] == [
        "On Com(1) GoSub *HEARD",
        "Return 1",
    ]


@pytest.mark.parametrize("value", ["P1/P2", "P1*(P2/2)", "(P1+P2)/P1", "P1-P2/P1"])
def test_a_quotient_of_positions_is_refused(value: str, tmp_path: FilePath) -> None:
    file = tmp_path / "QUOTIENT.mb5"
    file.write_text(
        f"Spd 100\nP9={value}\nMvs P1\nEnd\nP1=(400,0,450,180,0,180)(7,0)\n"
        "P2=(380,10,450,180,0,180)(7,0)\n"
    )
    assert [row.text for row in translate(file, to="rapid").rows if row.level == "not"] == [
        f"P9={value}"
    ]
