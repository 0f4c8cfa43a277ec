"""Scripts: what happens outside of a controller while it runs.

Inputs change by time, by what the programs do, or by each other; a person answers questions. Where
a cell has keys instead of a dialog, a `Panel` reads the answers from inputs: a key counts from when
it is pressed anew, and so does the input that says that a number is there (as in `passes.asking`).
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from typing import TYPE_CHECKING

from assistant.base.data_classes import dataclass
from assistant.program.passes.operator_texts import ENTERED, KEY, NUMBER
from assistant.virtual.events import Logged, Moved

if TYPE_CHECKING:
    from assistant.base.source_text import SourceText
    from assistant.virtual.kernel.kernel import Kernel
    from assistant.virtual.kernel.task import Task


def words_of(line: str) -> set[str]:
    """Words of a line of a program that may be names, in lower case; none of a text or comment."""
    # A name within a text or comment is no place that the motion visits.
    code = re.split(r"[!']", re.sub(r'"[^"]*"', "", line), maxsplit=1)[0]
    return set(re.findall(r"[a-z_]\w*", code.lower()))


@dataclass(frozen=True, slots=True)
class When:
    """A signal that gets a value: an output, or an input. name: in lower case, or a number."""

    name: str
    value: float
    is_input: bool = False


@dataclass(frozen=True, slots=True)
class Visit:
    """A motion that starts. place: a name in the line of its statement, in lower case; empty for
    any motion. number: which of these motions, counted from 1; None for each.
    """

    place: str = ""
    number: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """An input that gets a value: at a time, each time that a signal changes, or with a motion.

    name: in lower case, or a number as text. at, after: seconds, from the start or from `when`.
    lasts: seconds after which it returns to its value before; None to stay. every: seconds from one
    time to the next; None for once.
    """

    name: str
    value: float
    at: float = 0.0
    when: When | Visit | None = None
    after: float = 0.0
    lasts: float | None = None
    every: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """Answer of a person to a question. to: a part of its text, in any case; empty for any.

    after: seconds that it takes. always: to each such question, not only to the next one.
    """

    value: str
    to: str = ""
    after: float = 0.0
    always: bool = False


@dataclass(frozen=True, slots=True)
class Script:
    """options: of the language whose program runs, as they are written."""

    changes: tuple[Change, ...] = ()
    answers: tuple[Answer, ...] = ()
    options: Mapping[str, object] = field(default_factory=dict)


@dataclass(slots=True, eq=False)
class Person:
    """Answers questions of programs. answers: those that are left, in their order.

    console: asks the user for answers that are missing; None without a user. panel: inputs that
    answer instead; None without such inputs.
    """

    answers: list[Answer] = field(default_factory=list)
    console: Callable[[str], str | None] | None = None
    panel: Panel | None = None

    def find(self, question: str) -> Answer | None:
        """Return the next answer to a question; None if it never gets one."""
        asked = question.casefold()
        found = next((one for one in self.answers if one.to.casefold() in asked), None)
        if found is None:
            value = None if self.console is None else self.console(question)
            return None if value is None else Answer(value=value)
        if not found.always:
            self.answers.remove(found)
        return found

    def answer(self, task: Task, question: str) -> str | None:
        """Waits as long as the person takes; None at once if nobody will ever answer."""
        found = self.find(question)
        if found is None:
            return None
        task.wait(None, found.after)
        return found.value


@dataclass(frozen=True, slots=True)
class InputChange:
    """An input that got a value. time: simulated seconds. row: rows of the log before it."""

    time: float
    name: str
    value: float
    row: int


def follow(kernel: Kernel, script: Script, sources: Sequence[SourceText]) -> list[InputChange]:
    """Has a kernel do what a script says; gives the inputs that are changed, as the run goes on.

    sources: texts of the programs, which tell what the motions visit.
    """
    given: list[InputChange] = []
    inputs = kernel.board.inputs

    def put(name: str, value: float) -> None:
        # Inputs that change each other would otherwise run on without end in no time.
        kernel.spend()
        if inputs.read(name) != value:
            given.append(InputChange(kernel.now, name, value, len(kernel.log)))
            inputs.set(name, value)

    def change(one: Change) -> None:
        before = inputs.read(one.name)
        put(one.name, one.value)
        if one.lasts is not None:
            kernel.at(kernel.now + one.lasts, partial(put, one.name, before))
        if one.every is not None:
            kernel.at(kernel.now + one.every, partial(change, one))

    for one in script.changes:
        if one.when is None:
            kernel.at(one.at, partial(change, one))
    for is_input, signals in ((False, kernel.board.outputs), (True, inputs)):
        awaited: dict[tuple[str, float], list[Change]] = defaultdict(list)
        for one in script.changes:
            if isinstance(one.when, When) and one.when.is_input is is_input:
                awaited[one.when.name, one.when.value].append(one)
        if awaited:
            signals.listeners.append(_listener(kernel, awaited, change))
    counts = [
        (one, _Count(one.when, sources)) for one in script.changes if isinstance(one.when, Visit)
    ]

    def hear(row: Logged) -> None:
        for one in [one for one, count in counts if count.meets(row)]:
            kernel.at(row.time + one.after, partial(change, one))

    if counts:
        # A program that runs ahead of its arm would be
        # past the motion when the script reacts to it.
        kernel.reacts = True
        kernel.told.append(hear)
    kernel.person.answers.extend(script.answers)
    return given


def by_numbers(script: Script, log: Iterable[Logged], sources: Sequence[SourceText]) -> Script:
    """A script whose visits are the numbers of the motions of a run, so that they are the same for
    a program that calls its places otherwise.
    """
    moves = [row for row in log if isinstance(row.what, Moved)]
    changes: list[Change] = []
    for one in script.changes:
        if not isinstance(one.when, Visit):
            changes.append(one)
            continue
        count = _Count(one.when, sources)
        met = [number for number, row in enumerate(moves, 1) if count.meets(row)]
        changes += [replace(one, when=Visit(number=number)) for number in met]
    return replace(script, changes=tuple(changes))


@dataclass(slots=True)
class _Count:
    """Counts motions until the one that a script means."""

    visit: Visit
    sources: Sequence[SourceText]
    count: int = 0

    def meets(self, row: Logged) -> bool:
        """Count an event, and return whether it is the motion; call it once for each, in order."""
        if not isinstance(row.what, Moved):
            return False
        if self.visit.place and self.visit.place not in self._names(row):
            return False
        self.count += 1
        return self.visit.number in (None, self.count)

    def _names(self, row: Logged) -> set[str]:
        """Names in the line of a motion, in lower case."""
        path, line = row.place or ("", 0)
        found = next((one for one in self.sources if (one.path or "") == path), None)
        return set() if found is None else words_of(found.line_text(line))


def _listener(
    kernel: Kernel,
    awaited: dict[tuple[str, float], list[Change]],
    change: Callable[[Change], None],
) -> Callable[[str, float, float], None]:
    def heard(name: str, before: float, now: float) -> None:  # noqa: ARG001
        for one in awaited.get((name, now), ()):
            kernel.at(kernel.now + one.after, partial(change, one))

    return heard


@dataclass(frozen=True, slots=True)
class Panel:
    """read: what an input is now, by its name."""

    read: Callable[[str], float]

    def key(self, task: Task, keys: Sequence[int]) -> int:
        """Waits for one of some keys, counted from 1: the first one that is pressed."""
        names = {key: KEY.format(key) for key in keys}
        # A key that is still pressed from the last question is no answer: let go first.
        task.wait(lambda: all(self.read(n) == 0.0 for n in names.values()), what="keys let go")
        while True:
            task.wait(lambda: any(self.read(n) == 1.0 for n in names.values()), what="a key")
            for key, name in names.items():
                if self.read(name) == 1.0:
                    return key

    def number(self, task: Task) -> float:
        """Waits for a number that is entered."""
        task.wait(lambda: self.read(ENTERED) == 0.0, what="the end of the number before")
        task.wait(lambda: self.read(ENTERED) == 1.0, what="a number")
        return self.read(NUMBER)
