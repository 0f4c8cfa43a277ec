"""Programs of MELFA-BASIC as they are lifted, and parts of them."""

from __future__ import annotations

from assistant import languages
from assistant.program import statements as p
from assistant.program.program import Procedure, Program
from assistant.program.pseudo import parse as parse_pseudo
from assistant.program.pseudo import print_program

POSITIONS = "".join(f"P{i}=({i}00,0,300,180,0,180)(7,0)\n" for i in range(1, 6))
AGAIN = "P1=(100,0,300,180,0,180)(7,0)\n"


def lifted(text: str, level: int = 6, positions: str = POSITIONS) -> Program:
    """The program, after the ways back from it: to its tree, and through the pseudo-program."""
    language = languages.get(f"melfa-basic-{level}")
    tree = language.parse(text + positions)
    assert not tree.findings
    program = language.lift(tree)
    assert language.lower(program) == tree
    assert parse_pseudo(print_program(program).text) == program
    return program


def body(text: str, level: int = 6) -> tuple[p.Statement, ...]:
    return lifted(text, level).procedures[0].body


def opaque(program: Program) -> list[str]:
    return [node.text for node in program.statements() if isinstance(node, p.Opaque)]


def moves(procedure: Procedure) -> list[p.Move]:
    return [node for node in procedure.body if isinstance(node, p.Move)]
