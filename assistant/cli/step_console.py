"""A console for stepping through a run that is held at statements.

Commands are typed in full, abbreviated, or by their key; see `_HELP`. Apart from `virtual_runs`, as
it loads the debugger of the interpreters.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from assistant.cli.presentation import say
from assistant.virtual.debugging.break_points import Holding, Step, Stride
from assistant.virtual.events import Place
from assistant.virtual.kernel import Ending, Kernel, Signals, Task
from assistant.virtual.run_log import short_place

if TYPE_CHECKING:
    from assistant.base.source_text import SourceText
    from assistant.virtual.tasks import SignalNames


_HELP: Final = (
    ("next", "n", "to the next statement of this routine; calls run through"),
    ("step", "s", "to the next statement, also into a call"),
    ("out", "o", "until this routine has come to its end"),
    ("continue", "c", "to the next break point, or to the end"),
    ("variables", "v", "what is known here; `v NAME …` shows some"),
    ("signals", "i", "inputs and outputs; `i NAME VALUE` sets an input"),
    ("stack", "k", "the calls that run, the innermost first"),
    ("quit", "q", "end the run"),
    ("help", "h", "print this"),
)
"""Commands, their short names, and what they do."""
_STEP_COMMANDS: Final[dict[str, Stride]] = {"next": "over", "step": "in", "out": "out"}
_WIDEST_VALUE: Final = 200
"""Characters of a value that are shown."""


class StepConsole:
    """Holds a run and asks what to do. names: of signals. flush: prints what happened until now."""

    def __init__(
        self,
        kernel: Kernel,
        sources: Sequence[SourceText],
        names: SignalNames,
        flush: Callable[[], None],
    ) -> None:
        self.kernel, self.sources, self.names, self.flush = kernel, sources, names, flush
        self.holding = Holding()
        self.last = "next"

    def begin(self, points: Sequence[Place], at_once: bool) -> None:
        """points: where the run is held. at_once: also at its first statement."""
        for path in dict.fromkeys(path for path, _ in points):
            self.holding.set_points(path, [line for p, line in points if p == path])
        self.holding.pause = "entry" if at_once else None

    def watch(self, task: Task) -> None:
        """Before each statement."""
        if self.holding.reason(task) is None:
            return
        now = self.kernel.now
        self.flush()
        say(f"{now:>10.3f}  {task.name}  {short_place(task.where())}  {self._line(task.where())}")
        while not self._done(task):
            pass

    def _line(self, place: Place | None) -> str:
        if place is None:
            return ""
        source = next((one for one in self.sources if (one.path or "") == place[0]), None)
        return "" if source is None else source.line_text(place[1]).strip()

    def _done(self, task: Task) -> bool:
        """Asks once; whether the run goes on. The end of the input lets it run to its end."""
        sys.stdout.write("> ")
        sys.stdout.flush()
        line = sys.stdin.readline()
        if not line:
            say("")
            self.holding.points.clear()
            self.holding.go()
            return True
        word, *rest = line.split() or [self.last]
        command = _full_command(word)
        if command is None:
            say(f"`{word}` is no command; h prints them")
            return False
        self.last = command
        if command in _STEP_COMMANDS:
            self.holding.go(Step(task, _STEP_COMMANDS[command], len(task.levels())))
            return True
        if command == "continue":
            self.holding.go()
            return True
        if command == "quit":
            self.kernel.halt(task, Ending("until"))
        for said in self._answer(command, rest, task):
            say(said)
        return False

    def _answer(self, command: str, rest: Sequence[str], task: Task) -> Iterator[str]:
        if command == "variables":
            yield from _visible_variables(task, {name.lower() for name in rest})
        elif command == "signals":
            yield from self._signals(rest)
        elif command == "stack":
            for level in task.levels():
                yield f"{level.name}  {short_place(level.place)}  {self._line(level.place)}"
        else:
            yield from (f"{name:<10} {key}  {meaning}" for name, key, meaning in _HELP)

    def _signals(self, rest: Sequence[str]) -> Iterator[str]:
        board = self.kernel.board
        if len(rest) == 2:
            try:
                value = float(rest[1])
            except ValueError:
                yield f"`{rest[1]}` is no number"
                return
            board.inputs.set(self.names.input_key(rest[0]), value)
        elif rest:
            yield "name an input and its value, or nothing"
            return
        for title, signals, names in (
            ("input", board.inputs, self.names.inputs),
            ("output", board.outputs, self.names.outputs),
        ):
            for key in sorted(_call_names(signals)):
                yield f"{title} {names.get(key, key)} = {signals.read(key):g}"


def _full_command(word: str) -> str | None:
    """The command that a word is, whole, cut short, or by its key."""
    given = word.lower()
    by_key = next((name for name, key, _ in _HELP if given == key), None)
    begun = [name for name, _, _ in _HELP if name.startswith(given)]
    return by_key or (begun[0] if len(begun) == 1 else None)


def _visible_variables(task: Task, wanted: set[str]) -> Iterator[str]:
    """Yield the variables of the innermost call: its local data, then those of its module and of
    all.
    """
    levels = task.levels()
    shown = False
    for title, data in levels[0].groups.items() if levels else ():
        for one in data():
            if not wanted or one.name.lower() in wanted:
                shown = True
                value = one.value if one.value else "no value"
                cut = value if len(value) <= _WIDEST_VALUE else value[: _WIDEST_VALUE - 1] + "…"
                kind = f"{one.type} " if one.type else ""
                yield f"{title}: {kind}{one.name} = {cut}"
    if not shown:
        yield "there is no data of that name here" if wanted else "there is no data here"


def _call_names(signals: Signals) -> set[str]:
    source = signals.source
    return set(signals.values) | (set() if callable(source) else set(source))
