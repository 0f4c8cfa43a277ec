"""Client of a Mitsubishi CR controller by the controller link, over TCP or a serial line.

`watch` samples the state; it needs no operation right and changes nothing.
"""

from __future__ import annotations

import re
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Final, Self

from assistant.controllers.abilities import Held
from assistant.controllers.address import Address
from assistant.controllers.mitsubishi import arm_moves, backup, operation, programs, state, values
from assistant.controllers.mitsubishi import values as numbered
from assistant.controllers.mitsubishi.arm_moves import Check
from assistant.controllers.mitsubishi.backup import Restoring
from assistant.controllers.mitsubishi.programs import LANGUAGES, Entry
from assistant.controllers.mitsubishi.session import COMMAND_INTERVAL, About, Session
from assistant.controllers.mitsubishi.session import about as identity
from assistant.controllers.mitsubishi.state import controller_state, position
from assistant.controllers.states import Fault, Identity, Jog, Position, Sample, State

_SIGNAL_NAME: Final = re.compile(r"(?:(in|out|m_in|m_out)[: (]?)?(\d{1,5})\)?", re.IGNORECASE)
_ALL_SLOTS: Final = 20
"""Looks after which all slots are asked; else those that had a program."""


def watch(session: Session, interval: float, signals: Sequence[str]) -> Iterator[Sample]:
    """A sample each `interval` seconds, later ones where the controller answers slower.

    signals: `in:5`, `out:900`, or a number alone for an input.
    """
    wanted = {name: _parse_signal(name) for name in signals}
    began = time.monotonic()
    count = 0
    slots: Sequence[int] | None = None
    while True:
        seconds = time.monotonic() - began
        # Empty slots are asked about only once in a
        # while: each takes a command, and most are empty.
        told = controller_state(session, slots if count % _ALL_SLOTS else None)
        slots = [int(task.name) for task in told.tasks]
        yield Sample(seconds, told, position(session), _signal_values(session, wanted))
        count += 1
        # The interval counts from sample to sample, whatever the answers took.
        late = time.monotonic() - began - seconds
        time.sleep(max(0.0, interval - late))


def _parse_signal(name: str) -> tuple[bool, str]:
    """Return whether a signal is an output, and its number."""
    found = _SIGNAL_NAME.fullmatch(name)
    if found is None:
        raise values.bad_value(name, "a signal", "it names none", "`in:5`, `out:900` or `5`")
    numbered.number_of(found[2])
    return (found[1] or "in").lower().endswith("out"), found[2]


def _signal_values(session: Session, wanted: dict[str, tuple[bool, str]]) -> dict[str, float]:
    found: dict[str, float] = {}
    for is_output, read in ((False, numbered.inputs), (True, numbered.outputs)):
        names = {name: number for name, (out, number) in wanted.items() if out is is_output}
        if names:
            told = read(session, list(names.values()))
            found |= {name: told[number] for name, number in names.items()}
    return {name: found[name] for name in wanted}


__all__ = ["Cr", "identity"]

_EVERY_LANGUAGE: Final = tuple(name for names in LANGUAGES.values() for name in names)


class Cr:
    """A session with a CR controller; see `Controller`. Tasks are slots, by their numbers.

    timeout: seconds for an answer. terminator: what ends a command, None for what the address
    says. pace: seconds between commands while a program runs. check: is asked before a jog.
    """

    lists: tuple[str, ...] = ()
    memory_apart: bool = False

    def __init__(
        self,
        address: Address,
        *,
        timeout: float = 10.0,
        terminator: bytes | None = None,
        pace: float = COMMAND_INTERVAL,
        check: Check | None = None,
    ) -> None:
        self.address = address
        self.languages: tuple[str, ...] = _EVERY_LANGUAGE
        self.session = Session(address, timeout=timeout, terminator=terminator, pace=pace)
        self.check = check
        self._kinds: dict[str, values.ParameterKind] = {}

    def __repr__(self) -> str:
        return f"Cr({str(self.address)!r})"

    def __enter__(self) -> Self:
        """Connects and opens a session."""
        self.session.open()
        self.languages = LANGUAGES.get(self.identity.suffix, _EVERY_LANGUAGE)
        return self

    def __exit__(self, *error: object) -> None:
        self.session.close()

    @property
    def identity(self) -> About:
        """Identity that the controller reported when the session was opened."""
        return self.session.about

    def names(self) -> tuple[str, ...]:
        """Names without suffix."""
        return programs.names(self.session)

    def read(self, name: str) -> bytes | None:
        """The listing: steps, then variables, each line with CR LF."""
        return programs.read(self.session, name)

    def check_text(self, name: str, data: bytes) -> None:
        """Raises Refused for lines that the link cannot carry, or that others see elsewhere."""
        programs.check_text(self.session, name, data)

    def write(self, name: str, data: bytes, *, as_it_was: bool = False) -> None:
        """Replaces the program; its lines are all looked at before the first is sent."""
        if not as_it_was:
            self.check_text(name, data)
        programs.write(self.session, name, data)

    def remove(self, name: str) -> None:
        programs.remove(self.session, name)

    def name_for(self, file_name: str | FilePath) -> str:
        """The file's name without suffix, in capitals."""
        return programs.checked_name(FilePath(file_name).stem.upper())

    def stored(self, data: bytes) -> bytes:
        """Return the listed form: steps in order, variables by name with two decimals."""
        return programs.listed_form(data)

    def entries(self) -> tuple[Entry, ...]:
        """The programs with size, time and protection."""
        return programs.entries(self.session)

    def copy(self, name: str, new: str) -> None:
        programs.copy(self.session, name, new)

    def rename(self, name: str, new: str) -> None:
        programs.rename(self.session, name, new)

    def protect(
        self, name: str, *, lines: bool | None = None, variables: bool | None = None
    ) -> None:
        """Protects a program against changes, or allows them; None leaves it as it is."""
        programs.protect(self.session, name, lines=lines, variables=variables)

    def identify(self) -> Identity:
        return state.identify(self.session)

    def state(self) -> State:
        return state.controller_state(self.session)

    def position(self) -> Position:
        return state.position(self.session)

    def log(self, most: int = 50) -> tuple[Fault, ...]:
        """The latest errors, the newest first."""
        return state.error_history(self.session, most)

    def reset(self) -> None:
        """Acknowledges the error; raises Refused if it is still there then."""
        state.reset(self.session)

    def inputs(self, names: Sequence[str]) -> dict[str, float]:
        """By their numbers as text."""
        return values.inputs(self.session, names)

    def outputs(self, names: Sequence[str]) -> dict[str, float]:
        return values.outputs(self.session, names)

    def set_output(self, name: str, value: float) -> None:
        values.set_output(self.session, name, value)

    def parameters(self, names: Sequence[str] = ()) -> dict[str, str]:
        return values.read_parameters(self.session, names)

    def set_parameter(self, name: str, value: str) -> None:
        """Most take effect when the power comes on again."""
        values.write_parameter(self.session, name, value, self._kinds)

    def learn_kinds(self, files: Iterable[str | FilePath]) -> None:
        """Has `set_parameter` look at values as parameter files of RT ToolBox tell their kinds."""
        self._kinds |= values.parameter_kinds(files)

    def variable(self, name: str, program: str = "", task: str = "") -> str:
        slot = operation.slot_of(self.session, task)
        return values.read_variable(self.session, name, program, slot)

    def set_variable(self, name: str, value: str, program: str = "", task: str = "") -> None:
        """While its program runs, numbers only."""
        slot = operation.slot_of(self.session, task)
        values.write_variable(self.session, name, value, program, slot)

    def load(self, name: str, task: str = "") -> None:
        operation.load(self.session, name, operation.slot_of(self.session, task))

    def motors(self, on: bool) -> None:
        """Switches the servos, and comes back when they are on or off."""
        operation.motors(self.session, on=on)

    def start(self, task: str = "", *, forever: bool = False) -> None:
        operation.start(self.session, operation.slot_of(self.session, task), forever=forever)

    def stop(self) -> None:
        operation.stop(self.session)

    def set_override(self, percent: int) -> None:
        operation.override(self.session, percent)

    def jog(self, jog: Jog) -> None:
        arm_moves.jog(self.session, jog, self.check)

    def jog_while(self, jog: Jog, held: Held) -> None:
        arm_moves.jog(self.session, jog, self.check, held)

    def jog_joints(self, joints: Mapping[str, float], speed: float) -> None:
        arm_moves.jog_joints(self.session, joints, speed, self.check)

    def hand(self, number: int, *, open: bool) -> None:
        values.hand(self.session, number, is_open=open)

    def execute(self, statement: str, *, wait: bool = False, task: str = "") -> None:
        """Has the controller execute one statement, which may move the arm."""
        slot = operation.slot_of(self.session, task, edit=True)
        operation.execute(self.session, statement, wait_for_end=wait, slot=slot)

    def execute_while(
        self, statement: str, goal: arm_moves.Goal, held: Held, task: str = ""
    ) -> None:
        """Has it execute one that moves the arm to a goal; stops it once that is not held."""
        slot = operation.slot_of(self.session, task, edit=True)
        arm_moves.execute_while(self.session, statement, goal, held, slot)

    @contextmanager
    def scratch(self) -> Iterator[str]:
        """Yield a task in which the variables of statements vanish afterwards; see `execute`."""
        with operation.scratch(self.session, "executing statements") as slot:
            yield str(slot)

    def backup(self, folder: FilePath) -> tuple[str, ...]:
        return backup.backup(self.session, folder)

    def restore(self, folder: FilePath, *, only: Sequence[str] = ()) -> Restoring:
        return backup.restoring(self.session, folder, only, self._kinds)

    def watch(self, interval: float, signals: Sequence[str] = ()) -> Iterator[Sample]:
        """signals: `in:5`, `out:900`, or a number alone for an input."""
        return watch(self.session, interval, signals)
