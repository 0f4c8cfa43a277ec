"""Outputs, waits, and tasks that wait for each other.

Instructions manual, SetDO and its kin, PulseDO, AliasIO; WaitTime, WaitUntil, WaitDI and its kin;
WaitSyncTask, WaitTestAndSet, TestAndSet, TaskRunRob, GetTaskName.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.events import Waited
from assistant.virtual.kernel.kernel import Instant
from assistant.virtual.rapid import records
from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import Fault, NotSimulated
from assistant.virtual.rapid.expressions import place
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.scopes import OUTPUT_TYPES, SIGNAL_TYPES, Signal
from assistant.virtual.rapid.values import Array, Handle, Record

_PULSE_LENGTH: Final = 0.2
_SHORTEST_PULSE: Final = 0.001
_LONGEST_PULSE: Final = 2000.0
"""Seconds of a pulse: without `PLength`, and with it (reference, 3)."""


def _set_output(given: Given) -> None:
    given.machine.signals.set(given.signal(0), 1.0)


def _reset_output(given: Given) -> None:
    given.machine.signals.set(given.signal(0), 0.0)


def _invert_output(given: Given) -> None:
    signal, signals = given.signal(0), given.machine.signals
    signals.set(signal, float(signals.read(signal) == 0.0))


def _pulse_output(given: Given) -> None:
    r"""Pulse an output; without \High the pulse is the inverse of the signal's present value.

    If motions take no time, both of its ends come at once: the program does not wait for the
    second. Else a new pulse of the same signal replaces one that is still on.
    """
    # The value before the pulse decides; it has to be read before the output changes.
    signal, signals = given.signal(0), given.machine.signals
    value = 1.0 if given.has("high") else float(signals.read(signal) == 0.0)
    length = given.optional_number("plength")
    length = _PULSE_LENGTH if length is None else length
    if not _SHORTEST_PULSE <= length <= _LONGEST_PULSE:
        raise Fault(
            f"a pulse of {length:g} s, which takes {_SHORTEST_PULSE:g} to {_LONGEST_PULSE:g} s"
        )
    signals.set(signal, value)
    if _has_time(given):
        signals.set_later(signal, 1.0 - value, length)
    else:
        signals.set(signal, 1.0 - value, after=length)


def _has_time(given: Given) -> bool:
    return not isinstance(given.machine.task.kernel.motion, Instant)


def _delayed_output(value: Callable[[Given], float]) -> Callable[[Given], None]:
    r"""SetDO and its kin: at once, or with \SDelay while the program goes on."""

    def does(given: Given) -> None:
        delay = given.optional_number("sdelay")
        signal, signals = given.signal(0), given.machine.signals
        # Motions without time leave no later: the delay goes into the record of the run instead.
        if delay is None or not _has_time(given):
            signals.set(signal, value(given), after=delay)
        else:
            signals.set_later(signal, value(given), delay)

    return does


def _alias_signal(given: Given) -> None:
    """Connect an alias to a signal, given as a text or as a signal; its configuration is
    assumed.
    """
    target, source = given.place(1).get(), given.required[0]
    if not isinstance(target, Handle) or target.type not in SIGNAL_TYPES:
        raise Fault("an alias of what is no data of a signal", "ERR_ALIASIO_DEF")
    name = given.signal(0) if _names_signal(given, source) else given.text(0).lower()
    if not name:
        raise Fault("an alias of a signal without a name", "ERR_ALIASIO_DEF")
    controller = given.machine.controller
    controller.known.add(name)
    if target.type in OUTPUT_TYPES:
        controller.outputs.add(name)
    target.inside = name


def _names_signal(given: Given, node: s.Expression) -> bool:
    if not isinstance(node, s.NameRef):
        return False
    meaning = given.machine.meaning(node.name)
    return meaning is None or isinstance(meaning, Signal)


def _end_alias(given: Given) -> None:
    target = given.place(0).get()
    if not isinstance(target, Handle) or target.type not in SIGNAL_TYPES:
        raise Fault("an alias of what is no data of a signal", "ERR_ALIASIO_DEF")
    target.inside = None


SIGNAL_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("AliasIO", 2, _alias_signal),
        table_row("AliasIOReset", 1, _end_alias),
        table_row("Set", 1, _set_output),
        table_row("Reset", 1, _reset_output),
        table_row(
            "SetDO", 2, _delayed_output(lambda given: float(given.number(1) != 0.0)), "sync sdelay"
        ),
        table_row("SetGO", 2, _delayed_output(lambda given: given.number(1)), "sdelay"),
        table_row("SetAO", 2, _delayed_output(lambda given: given.number(1))),
        table_row("InvertDO", 1, _invert_output),
        table_row("PulseDO", 1, _pulse_output, "high plength"),
    )
)


_LOOK_OPTIONS: Final = (
    "visualize header message msgarray wrap icon image visualizetime uiactivesignal"
)
"""Options that change only the display while the program waits."""
_COMPARISONS: Final = {"lt": operator.lt, "gt": operator.gt, "noteq": operator.ne}
_POLL_PERIOD: Final = 0.1
_LEAST_POLL_PERIOD: Final = 0.04
"""Seconds between checks of a condition: the first value without `PollRate`, the second at least
(manual, WaitUntil). A condition that only depends on data and signals of this run is checked
whenever they can change.
"""


def _wait_time(given: Given) -> None:
    seconds = given.number(0)
    if seconds < 0.0:
        raise Fault(f"a wait of {seconds:g} seconds")
    if given.has("inpos"):
        given.machine.settle()
    given.machine.task.delay(seconds)


def _wait_for(given: Given) -> None:
    """WaitDI and its kin: the signal is to have the value, or to be beyond it."""
    compare = next((_COMPARISONS[name] for name in _COMPARISONS if given.has(name)), operator.eq)
    signal, value = given.signal(0), given.number(1)
    read = given.machine.signals.read
    node = given.required[0]
    named = node.name if isinstance(node, s.NameRef) else signal
    what = f"`{named}` is {read(signal):g}, {value:g} is waited for"
    _wait_for_condition(given, lambda: bool(compare(read(signal), value)), what)


def _wait_until(given: Given) -> None:
    if given.has("inpos"):
        given.machine.settle()
    _wait_for_condition(
        given, lambda: given.truth(0), "the condition that is waited for is not met"
    )


def _wait_for_condition(given: Given, is_met: Callable[[], bool], what: str) -> None:
    r"""\MaxTime ends the wait, with an error or by the flag that \TimeFlag names."""
    machine, flag = given.machine, given.options.get("timeflag")

    # Each check finds out anew what the condition depends on.
    def asked() -> bool:
        machine.hangs_on.clear()
        return is_met()

    longest = given.optional_number("maxtime")
    met = asked() or _is_met_in_time(given, asked, math.inf if longest is None else longest, what)
    if flag is not None:
        place(machine, flag).set(not met)
    if met:
        machine.task.met(asked)
        return
    for node in (given.options[name] for name in _TIMEOUT_VALUES if name in given.options):
        assert node is not None
        place(machine, node).set(machine.signals.read(given.signal(0)))
    machine.task.tell(Waited(longest or 0.0, limit=True))
    if flag is None:
        raise Fault(f"{what}, and the longest time is over", "ERR_WAIT_MAXTIME")


def _is_met_in_time(given: Given, asked: Callable[[], bool], longest: float, what: str) -> bool:
    """True if a condition is met in time.

    It is evaluated again and again as long as it depends on time, or on changes outside the run.
    """
    hangs_on, task = given.machine.hangs_on, given.machine.task
    poll = max(given.optional_number("pollrate") or _POLL_PERIOD, _LEAST_POLL_PERIOD)
    since = task.kernel.now
    end = since + longest
    while task.kernel.now < end:
        left = end - task.kernel.now
        # No statement announces a change of time or of the outside: the condition is polled.
        if hangs_on:
            # Polls count as steps: a wait that time never ends has to stop the run.
            task.kernel.spend()
            came = task.wait(asked, min(poll, left), what, outside="outside" in hangs_on)
            if "time" in hangs_on:
                task.looked(since, over=came)
            if came:
                return True
        else:
            # Data and signals wake the task. The wait also ends when the condition
            # comes to depend on time or the outside, and goes on by polling.
            came = task.wait(
                lambda: asked() or bool(hangs_on), None if math.isinf(left) else left, what
            )
            if came and not hangs_on:
                return True
    return False


def _wait_row(
    name: str, does: Callable[[Given], None], count: int, more: str
) -> tuple[str, Function]:
    return table_row(name, count, does, f"maxtime timeflag {more} {_LOOK_OPTIONS}")


_TIMEOUT_VALUES: Final = ("valueattimeout", "dvalueattimeout")
"""Options that receive the value of the signal when the longest time is over."""
_WAITED_SIGNALS: Final = ("DI", "DO", "GI", "GO", "AI", "AO")

WAIT_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("WaitTime", 1, _wait_time, "inpos"),
        *(
            _wait_row(f"Wait{x}", _wait_for, 2, f"lt gt noteq {' '.join(_TIMEOUT_VALUES)}")
            for x in _WAITED_SIGNALS
        ),
        _wait_row("WaitUntil", _wait_until, 1, "inpos pollrate"),
    )
)


def _wait_for_tasks(given: Given) -> None:
    """Until every task of the list has come as often as this one to the point of that name."""
    machine = given.machine
    if given.has("inpos"):
        machine.settle()
    point = given.required[0]
    if not isinstance(point, s.NameRef):
        raise NotSimulated("a synchronization point that is no variable by its name")
    name, own = point.name.lower(), machine.task.name.lower()
    names = _task_names(given, 1)
    if own not in names:
        raise Fault(f"`{machine.task.name}` waits for tasks and is not in their list")
    come = machine.controller.come
    # The number of visits of this task distinguishes repeated meetings at one point.
    turn = come[name, own] = come.get((name, own), 0) + 1
    what = f"`{point.name}`, to which not all of {', '.join(names)} come"

    def all_there() -> bool:
        return all(come.get((name, task), 0) >= turn for task in names)

    if not machine.task.wait(all_there, given.optional_number("timeout"), what):
        # This meeting did not happen; others must not count on it.
        come[name, own] -= 1
        raise Fault(f"{what} in time", "ERR_WAITSYNCTASK")


def _task_names(given: Given, index: int) -> list[str]:
    listed = given.place(index).get()
    items = listed.items if isinstance(listed, Array) else ()
    tasks = [records.record(item, "tasks") for item in items if isinstance(item, Record)]
    return [records.text(task.parts["taskname"]).lower() for task in tasks]


def _test_and_set(given: Given) -> bool:
    """TestAndSet: whether it was free, which it now is not."""
    taken = given.place(0)
    was = records.truth(taken.get())
    taken.set(True)
    return not was


def _wait_test_and_set(given: Given) -> None:
    taken = given.place(0)
    if taken.storage != "PERS":
        raise Fault("WaitTestAndSet of what is no persistent")
    name = given.required[0]
    shown = name.name if isinstance(name, s.NameRef) else "it"
    what = f"`{shown}` is TRUE, and nobody sets it to FALSE"
    # Between the end of the wait and this line no other task runs.
    given.machine.task.wait(lambda: not records.truth(taken.get()), None, what)
    taken.set(True)


def _has_robot(given: Given) -> bool:
    moves = given.machine.moves
    if moves is None:
        raise NotSimulated("whether the task has a robot, which nothing states")
    return moves


def _task_name(given: Given) -> str:
    machine = given.machine
    number = given.options.get("taskno")
    if number is not None:
        place(machine, number).set(float(machine.controller.tasks.index(machine.task) + 1))
    return machine.task.name


TASK_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("WaitSyncTask", 2, _wait_for_tasks, "inpos timeout"),
        table_row("WaitTestAndSet", 1, _wait_test_and_set),
    )
)
TASK_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("TestAndSet", 1, _test_and_set),
        table_row("TaskRunRob", 0, _has_robot),
        table_row("TaskRunMec", 0, _has_robot),
        table_row("GetTaskName", 0, _task_name, "taskno"),
    )
)
