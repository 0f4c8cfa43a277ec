"""A small cell in MELFA-BASIC, and what programs in it do."""

from __future__ import annotations

from assistant import languages
from assistant.program.geometry import Pose
from assistant.virtual import melfa
from assistant.virtual.events import Moved, Run, Switched

DOWN = (0.0, 0.0, 1.0, 0.0)
START = Pose((400.0, 0.0, 600.0), DOWN)

POSITIONS = """
P1=(+400.00,+0.00,+500.00,+180.00,+0.00,+180.00)(7,0)
P2=(+450.00,+50.00,+500.00,+180.00,+0.00,+180.00)(7,0)
P3=(+400.00,+100.00,+500.00,+180.00,+0.00,+180.00)(7,0)
PT=(+0.00,+0.00,+100.00,+0.00,+0.00,+0.00)(0,0)
"""


def run(text: str, level: int = 5, **options: object) -> Run:
    tree = languages.get(f"melfa-basic-{level}").parse(text.strip() + POSITIONS)
    return melfa.run(tree, **{"start": START, **options})  # type: ignore[arg-type]


def moves(done: Run) -> list[Moved]:
    return [event for event in done.events if isinstance(event, Moved)]


def shown(done: Run) -> list[tuple[float, ...]]:
    """Where the tip of the tool ends each motion."""
    flanges = [(one.flange, one.tool) for one in moves(done)]
    ends = [flange @ tool for flange, tool in flanges if flange is not None]
    return [tuple(round(v, 3) + 0.0 for v in end.position) for end in ends]


def outputs(done: Run) -> list[tuple[str, float]]:
    return [(e.signal, e.value) for e in done.events if isinstance(e, Switched)]


def value(expression: str, before: str = "", level: int = 5) -> float:
    """What an expression comes to, seen as the height of a position."""
    done = run(f"{before}\nP9=P1\nP9.Z={expression}\nMvs P9\nEnd", level)
    assert done.ended == "end", done.message
    return shown(done)[-1][2]
