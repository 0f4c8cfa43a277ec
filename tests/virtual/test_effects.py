"""What kept text of RAPID is said to do, against an interpreter that runs it.

Each statement of random programs is run as the only one. What happens then (motions, waits, other
values of variables, seen by a move behind it) its effect has to tell, with those of the routines
that it calls.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest

from assistant import languages
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program.expressions import Effect, combined_effect
from assistant.virtual import rapid
from assistant.virtual.events import Moved, Run, Waited
from tests.virtual.random_rapid import program
from tests.virtual.translating import START

RAPID = languages.get("rapid")
SEEN = (
    "MoveL Offs([[350,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],{},0,0),v50,fine,tool0;"
)
"""A move to a place that a variable tells."""


def statements(text: str) -> tuple[s.Module, s.Routine, list[s.StatementNode]]:
    """The module of a program, its main, and the statements of all routines but declarations."""
    (module,) = RAPID.parse(text).modules
    routines = [item for item in module.items if isinstance(item, s.Routine)]
    (main,) = (one for one in routines if one.name == "main")
    return module, main, [node for node in main.body if not isinstance(node, s.Data)]


def run_with(module: s.Module, main: s.Routine, body: tuple[s.StatementNode, ...]) -> Run:
    """What a program does whose main has these statements behind its declarations."""
    data = tuple(node for node in main.body if isinstance(node, s.Data))
    other = replace(main, body=(*data, *body))
    items = tuple(other if item is main else item for item in module.items)
    text = RAPID.render(s.File((replace(module, items=items),)))
    return rapid.run(RAPID.parse(text), inputs={}, start=START, most_steps=20_000)


def whole(effect: Effect, routines: dict[str, Effect]) -> Effect:
    """An effect with those of the routines that it calls; a function's name is only read."""
    done: set[str] = set()
    pending = set(effect.names & routines.keys())
    while pending:
        name = pending.pop()
        done.add(name)
        pending |= (routines[name].names & routines.keys()) - done
    return combined_effect((effect, *(routines[name] for name in done)))


def contradictions(seed: int, counted: Counter[str]) -> list[str]:
    """Statements of a random program that do more than their effects say."""
    module, main, nodes = statements(program(seed).text)
    routines = {
        item.name.lower(): RAPID.effect(verbatim.of_node(item, "items"), "declaration")
        for item in module.items
        if isinstance(item, s.Routine)
    }
    numbers = [
        item.name
        for item in module.items
        if isinstance(item, s.Data) and item.type == "num" and item.storage != "CONST"
        if not item.dimensions
    ]
    found = []
    for node in nodes:
        text = verbatim.of_node(node, "statements")
        effect = whole(RAPID.effect(text, "statement"), routines)
        done = run_with(module, main, (node,))
        if done.ended in ("unknown", "error"):
            continue
        counted["run"] += 1
        moved = any(isinstance(event, Moved) for event in done.events)
        waited = any(isinstance(event, Waited) for event in done.events) or done.ended == "stopped"
        found += [f"{seed}: moves: {text}"] if moved and not effect.moves else []
        found += [f"{seed}: waits: {text}"] if waited and not (effect.waits or effect.jumps) else []
        counted["still"] += not effect.moves
        for name in numbers if done.ended == "end" else ():
            (seen,) = verbatim.statements(SEEN.format(name))
            before = run_with(module, main, (seen,))
            after = run_with(module, main, (node, seen))
            if {before.ended, after.ended} != {"end"} or effect.jumps:
                continue
            changed = before.events[-1] != after.events[-1]
            counted["changed"] += changed
            if changed and name.lower() not in effect.writes:
                found.append(f"{seed}: {name} is changed: {text}")
    return found


@pytest.mark.one_in(6)
@pytest.mark.parametrize("seed", range(6))
def test_statements_do_no_more_than_their_effects_say(seed: int) -> None:
    counted = Counter[str]()
    assert contradictions(seed, counted) == []
    assert counted["run"] > 0


@pytest.mark.slow
def test_many_statements_do_no_more_than_their_effects_say() -> None:
    counted = Counter[str]()
    found = [one for seed in range(300) for one in contradictions(seed, counted)]
    print(dict(counted))  # noqa: T201
    assert found == []
    assert min(counted["run"], counted["still"], counted["changed"]) > 100
