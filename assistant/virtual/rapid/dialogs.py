"""Questions to a person: on the teach pendant, and in dialog boxes.

Instructions and functions manual, TPReadFK, TPReadNum, UIMsgBox and their kin. The script of the
run gives the answers; a question without an answer waits until its `MaxTime`, a signal or a
persistent ends it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final, TypeVar, cast

from assistant.virtual.events import Said
from assistant.virtual.kernel.script import Panel
from assistant.virtual.kernel.task import Task
from assistant.virtual.rapid import records
from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import ERROR_NUMBERS, Fault, NotSimulated
from assistant.virtual.rapid.expressions import evaluate, place, signal, whole
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.values import Array, Record, Shape, Value

T = TypeVar("T")
_Read = Callable[[str], T | None]
"""Function that returns the value of an answer; None for an invalid answer."""

_LONGEST: Final = 80
_PRESSED: Final = ("", "OK", "Abort", "Retry", "Ignore", "Cancel", "Yes", "No")
"""By btnres from 0."""
_BUTTONS: Final[Mapping[int, tuple[int, ...]]] = {
    -1: (),
    0: (1,),
    1: (2, 3, 4),
    2: (1, 5),
    3: (3, 5),
    4: (6, 7),
    5: (6, 7, 5),
}
"""By buttondata: the btnres of each (manual, data type buttondata)."""


def _ask(
    given: Given, question: str, read: _Read[T], choices: Sequence[str] = (), numbers: bool = False
) -> T | None:
    """The answer; None where the question is broken off and a BreakFlag tells it.

    choices: what can be pressed, of which the answer is the place from 1. numbers: a number is
    asked for.
    """
    machine, task = given.machine, given.machine.task
    flag = given.options.get("breakflag")
    if flag is not None:
        place(machine, flag).set(0.0)
    task.tell(Said(question))
    broken = _breaks(given)
    longest = given.optional_number("maxtime")
    # Keys know no time limit: with one the script answers, or the question ends by itself.
    if (panel := task.kernel.person.panel) is not None and longest is None:
        return _at_panel(panel, task, read, choices, numbers)
    answer = task.kernel.person.find(question)
    after = math.inf if answer is None else answer.after
    named = ", ".join(filter(None, choices))
    shown = f"`{question}`" + (f" ({named})" if named else "")
    # The earlier of the two ends the wait: the answer, or the time limit.
    most = min(after, math.inf if longest is None else longest)
    error = "ERR_TP_MAXTIME"
    if task.wait(
        lambda: bool(broken()), None if math.isinf(most) else most, f"nobody answers {shown}"
    ):
        error = broken()
    elif answer is not None and after <= most:
        found = read(answer.value.strip())
        if found is None:
            raise NotSimulated(f"the answer `{answer.value}` to {shown}, which cannot be given")
        return found
    if flag is None:
        raise Fault(f"nobody answers {shown} in time", error)
    # With a BreakFlag the program goes on and finds the error there.
    place(machine, flag).set(float(ERROR_NUMBERS[error.lower()]))
    return None


def _at_panel(
    panel: Panel, task: Task, read: _Read[T], choices: Sequence[str], numbers: bool
) -> T | None:
    """Return the answer that inputs give; asks again while it is invalid."""
    keys = [place for place, name in enumerate(choices, 1) if name]
    if numbers:
        # A pendant keeps the question until the number is one that it takes.
        while (found := read(f"{panel.number(task):g}")) is None:
            pass
        return found
    if not keys:
        raise NotSimulated("a question that keys do not answer")
    return cast("T", panel.key(task, keys))


def _breaks(given: Given) -> Callable[[], str]:
    """The name of the error that breaks a question off now, empty as long as none does."""
    machine, found = given.machine, []
    for option, passive in (("dibreak", "dipassive"), ("dobreak", "dopassive")):
        if (node := given.options.get(option)) is not None:
            name, wanted = signal(machine, node), 0.0 if given.has(passive) else 1.0
            found.append((f"ERR_TP_{option.upper()}", name, wanted))
    node = given.options.get("persboolbreak")
    watched = None if node is None else place(machine, node)
    value = not given.has("persboolpassive")

    def broken() -> str:
        for error, name, wanted in found:
            if machine.signals.read(name) == wanted:
                return error
        if watched is not None and records.truth(watched.get()) is value:
            return "ERR_TP_PERSBOOLBREAK"
        return ""

    return broken


# --------------------------------------------------------------------- what an answer means


def _number(answer: str) -> float | None:
    try:
        found = float(answer)
    except ValueError:
        return None
    return found if math.isfinite(found) else None


def _choice(names: Sequence[str]) -> _Read[int]:
    """One of several, by its name or its number from 1; those without a name cannot be chosen."""

    def read(answer: str) -> int | None:
        for i, name in enumerate(names, 1):
            # A key without a name is not shown, but counts.
            if name and answer.casefold() in (name.casefold(), str(i)):
                return i
        return None

    return read


def _text(answer: str) -> str | None:
    return answer if len(answer) <= _LONGEST else None


# ------------------------------------------------------------------------------- questions


def _texts(given: Given, option: str) -> list[str] | None:
    """An array of strings, None if it is not given."""
    node = given.options.get(option)
    if node is None:
        return None
    array = evaluate(given.machine, node, Shape("string", (-1,)))
    assert isinstance(array, Array)
    return [records.text(item) for item in array.items]


def _question(given: Given, *more: str) -> str:
    named = [given.optional(name) for name in ("header", "message")]
    lines = [records.text(line) for line in named if line is not None]
    lines += [*(_texts(given, "msgarray") or ()), *more]
    for i in range(2, 6):
        if (line := given.optional(f"msgline{i}")) is not None:
            lines.append(records.text(line))
    return "\n".join(lines)


def _keys(given: Given) -> None:
    names = [given.text(i) for i in range(2, 7)]
    found = _ask(given, given.text(1), _choice(names), names)
    if found is not None:
        given.place(0).set(float(found))


def _read_number(given: Given) -> None:
    found = _ask(given, given.text(1), _number, numbers=True)
    if found is not None:
        given.place(0).set(found)


def _press(given: Given, question: str) -> float | None:
    """Return the pressed button: its position in an array of buttons, or its btnres."""
    own = _texts(given, "btnarray")
    if own is not None:
        found = _ask(given, question, _choice(own), own)
        return None if found is None else float(found)
    stated = given.optional_number("buttons")
    shown = _BUTTONS.get(whole(0.0 if stated is None else stated, "the buttons of a dialog"))
    if shown is None:
        raise Fault(f"the buttons {stated:g} of a dialog")
    names = [_PRESSED[one] for one in shown]
    found = _ask(given, question, _choice(names), names)
    return None if found is None else float(shown[found - 1])


def _box(given: Given) -> None:
    pressed = _press(given, _question(given, given.text(0)))
    if (node := given.options.get("result")) is not None:
        place(given.machine, node).set(pressed or 0.0)


def _message_box(given: Given) -> float:
    pressed = _press(given, _question(given))
    if pressed is not None:
        return pressed
    return given.optional_number("defaultbtn") or 0.0


def _entry(given: Given) -> float:
    initial = given.optional_number("initvalue")
    return _enter(given, initial, given.has("asinteger"))


def _tune(given: Given) -> float:
    if given.number(1) <= 0.0:
        raise Fault(f"an increment of {given.number(1):g}")
    return _enter(given, given.number(0), integer=False)


def _enter(given: Given, initial: float | None, integer: bool) -> float:
    least, most = given.optional_number("minvalue"), given.optional_number("maxvalue")
    low = -math.inf if least is None else least
    high = math.inf if most is None else most
    if low > high:
        raise Fault(f"a number from {low:g} to {high:g}", "ERR_UI_MAXMIN")
    if initial is not None and not low <= initial <= high:
        raise Fault(f"{initial:g} is not from {low:g} to {high:g}", "ERR_UI_INITVALUE")
    if integer and initial is not None and initial != round(initial):
        raise Fault(f"{initial:g} is no integer", "ERR_UI_NOTINT")

    def read(answer: str) -> float | None:
        found = _number(answer)
        if found is None or not low <= found <= high or (integer and found != round(found)):
            return None
        return found

    found = _ask(given, _question(given), read, numbers=True)
    return (initial or 0.0) if found is None else found


def _write_text(given: Given) -> str:
    initial = given.optional("initstring", "string")
    found = _ask(given, _question(given), _text)
    return (records.text(initial) if initial is not None else "") if found is None else found


def _list(given: Given) -> float:
    """The place of what is chosen. An answer may tell the button behind a bar: `Part A|Cancel`."""
    array = evaluate(given.machine, given.required[0], Shape("listitem", (-1,)))
    items = array.items if isinstance(array, Array) else ()
    names = [records.text(item.parts["text"]) for item in items if isinstance(item, Record)]
    own, stated = _texts(given, "btnarray"), given.optional_number("buttons")
    shown = _BUTTONS.get(0 if stated is None else int(stated), ())
    buttons = own or [_PRESSED[one] for one in shown]
    choose, press = _choice(names), _choice(buttons)

    def read(answer: str) -> tuple[int, int] | None:
        item, bar, button = answer.partition("|")
        # Without a bar the first button is meant.
        chosen, pressed = choose(item.strip()), press(button.strip()) if bar else 1
        return None if chosen is None or pressed is None else (chosen, pressed)

    if given.machine.task.kernel.person.panel is not None:
        raise NotSimulated("a list that keys do not answer")
    found = _ask(given, _question(given), read, names)
    if (node := given.options.get("result")) is not None and found is not None:
        number = found[1] if own else shown[found[1] - 1] if shown else 0
        place(given.machine, node).set(float(number))
    return given.optional_number("defaultindex") or 0.0 if found is None else float(found[0])


def _there(_: Given) -> Value:
    return True


_BREAKS: Final = (
    "maxtime dibreak dipassive dobreak dopassive persboolbreak persboolpassive breakflag"
)
_LOOKS: Final = "header message msgarray wrap icon image uiactivesignal"
LINES: Final = "msgline2 msgline3 msgline4 msgline5"
_LIMITS: Final = "minvalue maxvalue"

DIALOG_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("TPReadFK", 7, _keys, _BREAKS),
        table_row("TPReadNum", 2, _read_number, _BREAKS),
        table_row("TPReadDnum", 2, _read_number, _BREAKS),
        table_row("UIMsgBox", 1, _box, f"buttons result {LINES} {_LOOKS} {_BREAKS}"),
    )
)
DIALOG_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row(
            "UIMessageBox", 0, _message_box, f"buttons btnarray defaultbtn {_LOOKS} {_BREAKS}"
        ),
        table_row("UINumEntry", 0, _entry, f"initvalue asinteger {_LIMITS} {_LOOKS} {_BREAKS}"),
        table_row("UIDnumEntry", 0, _entry, f"initvalue asinteger {_LIMITS} {_LOOKS} {_BREAKS}"),
        table_row("UINumTune", 2, _tune, f"{_LIMITS} {_LOOKS} {_BREAKS}"),
        table_row("UIDnumTune", 2, _tune, f"{_LIMITS} {_LOOKS} {_BREAKS}"),
        table_row("UIAlphaEntry", 0, _write_text, f"initstring {_LOOKS} {_BREAKS}"),
        table_row(
            "UIListView", 1, _list, f"result buttons btnarray defaultindex {_LOOKS} {_BREAKS}"
        ),
        table_row("UIClientExist", 0, _there),
    )
)
