"""Settings along every way through the lines of a small language that has nothing else."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import pytest

from assistant.languages.line_blocks import EXIT
from assistant.languages.settings_flow import (
    ELSEWHERE,
    INHERITED,
    UNKNOWN,
    Calls,
    Either,
    Flow,
    Held,
    LineEffects,
    LineSet,
    OrInherited,
    Sets,
    SettingText,
    State,
    Steps,
    UnknownSettings,
)
from assistant.languages.settings_forms import MOST_FORMS, CalledForms, PassLabels, divided_flow
from tests.tables import every_row

SPEED, TOOL = range(2)
INITIAL: State = (Held(10.0), Held("flange"))


def lines_of(*procedures: str) -> LineEffects:
    """Lines such as `speed 5`, `tool a`, `call 1`, `move`, `top:`, `jump top`.

    `perhaps` calls or does not, `ask` jumps or goes on below, `end` ends all.
    """
    texts = [line.strip() for text in procedures for line in text.split(";")]
    numbers = itertools.count()
    places = [[next(numbers) for _ in text.split(";")] for text in procedures]
    labels = {text[:-1]: at for at, text in enumerate(texts) if text.endswith(":")}
    steps = {at: made for at, text in enumerate(texts) if (made := steps_of(text.split()))}

    def after(at: int, last: int) -> list[int]:
        word, *given = texts[at].split()
        below = [EXIT if at == last else at + 1]
        to = [labels[label] for label in given] if word in ("jump", "ask") else []
        return to if word == "jump" else [] if word == "end" else to + below

    return LineEffects(
        2,
        places,
        [{at: after(at, inside[-1]) for at in inside} | {EXIT: []} for inside in places],
        steps,
        lambda at: frozenset({SPEED, TOOL} if texts[at] == "move" else ()),
        lambda at: not texts[at].startswith("jump"),
        frozenset(labels.values()),
        frozenset(),
        frozenset(),
    )


def steps_of(words: Sequence[str]) -> Steps:
    match words:
        case ["speed", "?"]:
            return (Sets(SPEED, UNKNOWN),)
        case ["speed", value]:
            return (Sets(SPEED, float(value)),)
        case ["either", value]:
            return (Either(((Sets(SPEED, float(value)),), ())),)
        case ["tool", value]:
            return (Sets(TOOL, value),)
        case ["call", *numbers]:
            return (Calls(tuple(map(int, numbers))),)
        case ["perhaps", number]:
            return (Either(((Calls((int(number),)),), ())),)
        case ["elsewhere"]:
            return (Calls((frozenset({TOOL}),)),)
    return ()


def values(state: State) -> tuple[object, ...]:
    return tuple(held.value for held in state)


@every_row(
    ("text", "speed"),
    [
        ("move", INHERITED),
        ("speed 5; move", 5.0),
        ("ask on; speed 5; on:; move", OrInherited(5.0)),
        ("speed 5; either 5; move", 5.0),
        ("speed 5; either 6; move", UNKNOWN),
        ("speed 5; top:; move; speed 6; ask top; move", 6.0),
        ("speed 5; top:; speed 6; ask top; move", 6.0),
        ("speed 5; jump on; move; on:; move", 5.0),
        ("speed 5; jump on; speed 6; on:; move", UNKNOWN),  # a line that never runs counts too
        ("speed ?; move", UNKNOWN),
        ("speed 5; end; move", 5.0),
    ],
)
def test_what_holds_at_the_last_line(text: str, speed: object) -> None:
    flow = Flow(lines_of(text))
    assert values(flow.before[len(flow.before) - 1]) == (speed, INHERITED)


def test_what_may_have_set_it_is_known() -> None:
    flow = Flow(lines_of("speed 5; ask on; speed 6; on:; move"))
    assert flow.before[4][SPEED] == Held(UNKNOWN, LineSet.of({0, 2}))


@pytest.mark.parametrize(
    ("called", "found"),
    [
        ("speed 5", (5.0, "a")),
        ("ask out; speed 5; out:; move", (UNKNOWN, "a")),
        ("ask out; speed 7; out:; move", (7.0, "a")),
        ("elsewhere", (7.0, UNKNOWN)),
        ("end", (7.0, "a")),  # no way leads below the call
    ],
)
def test_a_call_does_what_its_procedure_does(called: str, found: tuple[object, ...]) -> None:
    flow = Flow(lines_of("speed 7; tool a; call 1; move", called))
    assert values(flow.before[3]) == found


def test_a_call_that_may_be_left_out_keeps_what_held_before_too() -> None:
    flow = Flow(lines_of("speed 7; perhaps 1; move", "speed 5"))
    assert flow.before[2][SPEED].value is UNKNOWN


def test_procedures_have_a_form_for_each_way_of_calling_them() -> None:
    lines = lines_of("call 1; speed 5; call 1; tool a; call 1; call 2", "move", "call 1")
    forms = CalledForms(Flow(lines), INITIAL).forms
    assert [[values(form.state) for form in found.values()] for found in forms[:2]] == [
        [(10.0, "flange")],
        [(10.0, "flange"), (5.0, "flange"), (5.0, "a")],
    ]
    assert [form.number for form in forms[1].values()] == [1, 2, 3]


def test_calls_in_one_line_may_be_made_in_any_order() -> None:
    lines = lines_of("speed 7; call 1 2; move", "speed 5", "move")
    flow = Flow(lines)
    assert flow.before[2][SPEED].value is UNKNOWN
    made = CalledForms(flow, INITIAL)
    assert [values(form.state)[SPEED] for form in made.forms[2].values()] == [UNKNOWN]


def test_settings_that_a_procedure_does_not_use_make_no_form() -> None:
    lines = lines_of("call 1; tool a; call 1", "tool b; speed 5; move; speed 10")
    (form,) = CalledForms(Flow(lines), INITIAL).forms[1].values()
    assert values(form.state) == (10.0, UNKNOWN)


def test_too_many_forms_are_one_more_that_knows_nothing() -> None:
    calls = (f"speed {n}; call 1" for n in range(1, MOST_FORMS + 4))
    forms = CalledForms(Flow(lines_of("; ".join(calls), "move")), INITIAL).forms[1]
    assert len(forms) == MOST_FORMS + 1
    assert values([*forms.values()][-1].state) == (UNKNOWN, UNKNOWN)


def test_a_label_that_is_come_to_in_two_ways_divides_its_procedure() -> None:
    """`move` is read in two passes: below 5 mm/s, and below 6 mm/s."""
    lines = lines_of("speed 5; top:; move; speed 6; ask top; move")
    flow = divided_flow(Flow(lines), frozenset())
    assert flow.cuts == {1}
    (head,) = CalledForms(flow, INITIAL).forms[0].values()
    passes = head.in_order()
    assert [values(one.state)[SPEED] for one in passes] == [10.0, 5.0, 6.0]
    assert [one.falls for one in passes] == [passes[1], None, None]
    assert [one.goes.get(4, {}).get(1) for one in passes] == [None, passes[2], passes[2]]
    labels = PassLabels(passes, lambda one: {"TOP": "top"} if 1 in one.places else {})
    assert [labels.of(one) for one in passes] == [{}, {"TOP": "top"}, {"TOP": "top_2"}]


def test_a_procedure_that_is_to_stay_whole_is_not_divided() -> None:
    flow = Flow(lines_of("speed 5; top:; move; speed 6; ask top; move"))
    assert divided_flow(flow, frozenset({0})) is flow


def test_why_a_setting_is_not_known() -> None:
    lines = lines_of("speed 5; either 6; move; speed ?; move; call 1; move", "elsewhere; move")
    flow = Flow(lines)
    settings = SettingText("speed", "SPEED", "{:g}".format), SettingText("tool", "TOOL", str)
    told = UnknownSettings(lines, settings, lambda at: f"line {at}")

    def why(at: int) -> str:
        found = told.reason(flow.before[at], lines.uses(at))
        return "" if found is None else found.why

    assert why(2) == "the speed may be 5 or 6 here, by line 0 and line 1"
    assert why(4) == "the speed is worked out by the program, line 3"
    assert why(8) == "the tool is what the caller has set, or another program"
    assert told.reason(INITIAL, {SPEED, TOOL}) is None


def test_sets_of_lines_are_those_of_numbers() -> None:
    one, two = LineSet.of([0, 5, ELSEWHERE, 700]), LineSet.of([5, 64])
    assert [*one] == [ELSEWHERE, 0, 5, 700]
    assert [*(one | two)] == [ELSEWHERE, 0, 5, 64, 700]
    assert [*(one - two)] == [ELSEWHERE, 0, 700]
    assert (one | LineSet.of([5])) is one
    assert not LineSet.of([])
