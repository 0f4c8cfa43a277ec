"""Client of an ABB controller by Robot Web Services, 1.0 (IRC5) and 2.0 (OmniCore).

with connect("rws://engineer@192.168.125.1", ask=getpass) as controller:
    print(controller.state())
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path as FilePath
from typing import Final, Self

from assistant.base.diagnostics import Refused
from assistant.base.source_text import lines_of
from assistant.controllers import rules
from assistant.controllers.abb.files import RapidFiles, checked_name, only_module
from assistant.controllers.abb.rws import session, subscriptions, system
from assistant.controllers.abb.rws.backup import Restore, RestoreParts, back_up, restore
from assistant.controllers.abb.rws.files import Files
from assistant.controllers.abb.rws.protocol import Answer, Domain
from assistant.controllers.abb.rws.rapid import Data, Rapid
from assistant.controllers.abb.rws.session import Mastership, NotThere, Session
from assistant.controllers.abb.rws.subscriptions import Events, subscribed
from assistant.controllers.abb.rws.system import INPUTS, OUTPUTS, Configuration, Panel, Signals
from assistant.controllers.abilities import Rests
from assistant.controllers.address import Address, Credentials
from assistant.controllers.states import Fault, Identity, Jog, Position, Sample, State

_UNIT: Final = "ROB_1"
"""The arm of a controller that has one."""
_STANDING: Final = ("motoron", "motoroff")
"""Controller states from which programs can be started, at most after switching the motors on."""


class Rws(RapidFiles):
    """Session with an ABB controller; see `Controller`.

    Programs are files in the folder of the address. timeout: seconds for an answer; a backup gets
    more. certificate: file with the certificate to trust (`rwss`), None for those of the system.
    unit: the mechanical unit whose position is reported.
    """

    def __init__(
        self,
        address: Address,
        credentials: Credentials,
        *,
        timeout: float = 30.0,
        certificate: str | FilePath | None = None,
        unit: str = _UNIT,
    ) -> None:
        self.address = address
        self._session = Session(address, credentials, timeout=timeout, certificate=certificate)
        self._system = Answer(0)
        self._mastership = Mastership(self._session)
        self._files = Files(self._session)
        self._panel = Panel(self._session, self._mastership, unit)
        self._rapid = Rapid(self._session, self._mastership, self._files)
        self._data = Data(self._session, self._mastership, self._rapid)
        self._signals = Signals(self._session, self._mastership)
        self._configuration = Configuration(self._session, self._mastership)

    def __repr__(self) -> str:
        return f"Rws({str(self.address)!r})"

    def __enter__(self) -> Self:
        """Connects, logs in and looks for the folder of the address."""
        self._system = self._session.open()
        self._rapid.forget()
        try:
            self._look_for_folder()
        except BaseException:
            self._session.close()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        self._session.close()

    def names(self) -> tuple[str, ...]:
        """The files in the folder of the address."""
        found = self._files.listing(self.address.folder)
        return tuple(one.name for one in found if not one.folder)

    def read(self, name: str) -> bytes | None:
        return self._files.read(self._path(name))

    def write(self, name: str, data: bytes, *, as_it_was: bool = False) -> None:
        if not as_it_was:
            self.check_text(name, data)
        self._files.write(self.address.folder, checked_name(name), data)

    def remove(self, name: str) -> None:
        self._files.remove(self._path(name))

    def claim(self, name: str) -> bool:
        """Makes a folder; False if there is one. Of many clients the controller lets one do it."""
        return self._files.claim(self.address.folder, checked_name(name))

    def release(self, name: str) -> None:
        self.remove(name)

    def is_folder(self, name: str) -> bool:
        """True if there is a folder of that name."""
        found = self._files.listing(self.address.folder)
        return any(one.folder and one.name.lower() == name.lower() for one in found)

    def clear_rests(self, known: Rests) -> None:
        self._files.clear_rests(self.address.folder, known)

    def loaded(self, data: bytes, task: str = "") -> bytes | None:
        """The module of a file's text as it is in memory; see `abilities.Memory`."""
        name = self.module(data)
        there = self.modules(task) if name is not None else ()
        found = next((one for one in there if name is not None and one.lower() == name.lower()), "")
        return self.module_text(found, task) if found else None

    def module(self, data: bytes) -> str | None:
        return only_module(data)

    def task_named(self, task: str) -> str:
        return self._rapid.task(task)

    def homes(self, module: str) -> tuple[str, ...]:
        """Names of the tasks in which a module of that name is loaded."""
        return tuple(
            task.name
            for task in self._rapid.tasks()
            if module.lower() in map(str.lower, self.modules(task.name))
        )

    def take_in(self, name: str, task: str = "") -> None:
        self._rapid.take_in(self._path(name), task)

    def put_out(self, data: bytes, task: str = "") -> None:
        name = self.module(data)
        if name is not None and self.loaded(data, task) is not None:
            self.unload(name, task)

    def stored_in_memory(self, text: bytes) -> bytes:
        """Lines without the blanks at their ends, which controllers do not keep."""
        # Controllers drop blanks at the ends of lines when they load a module.
        lines = lines_of(text.strip().decode("latin-1"))
        return b"\n".join(line.encode("latin-1").rstrip() for line in lines)

    def identify(self) -> Identity:
        return self._panel.identify(self._system)

    def state(self) -> State:
        return self._panel.state(self._rapid.tasks())

    def position(self) -> Position:
        return self._panel.position()

    def log(self, most: int = 50) -> tuple[Fault, ...]:
        return system.latest_events(self._session, most)

    def reset(self) -> None:
        """Looks whether programs can be started; what stops them is reset at the controller.

        Over Robot Web Services there is nothing to acknowledge: an error of a program needs
        none, and an emergency stop or guard stop is reset where it was set.
        """
        motors = self._panel.motors()
        if motors not in _STANDING:
            raise self._session.refusal(
                "reset that from here",
                f"its state is `{motors}`",
                "release the button or close the guard, then press motors on at the controller",
            )

    def inputs(self, names: Sequence[str]) -> dict[str, float]:
        """Return the values of signals by name; all inputs without names."""
        return self._signals.values(names, INPUTS)

    def outputs(self, names: Sequence[str]) -> dict[str, float]:
        return self._signals.values(names, OUTPUTS)

    def set_output(self, name: str, value: float) -> None:
        self._signals.set(name, value)

    def parameters(self, names: Sequence[str] = ()) -> dict[str, str]:
        """Attributes by `DOMAIN/TYPE/INSTANCE/ATTRIBUTE`; a name may leave off its last parts."""
        return self._configuration.values(names)

    def set_parameter(self, name: str, value: str) -> None:
        """Most parameters take hold after the controller has been restarted."""
        self._configuration.set(name, value)

    def variable(self, name: str, program: str = "", task: str = "") -> str:
        """A value as RAPID writes it. program: its module; looked for if it is not named."""
        return self._data.value(name, program, task)

    def set_variable(self, name: str, value: str, program: str = "", task: str = "") -> None:
        self._data.set_value(name, value, program, task)

    def load(self, name: str, task: str = "") -> None:
        """Loads a module or a program file, and moves the program pointers of all tasks to main."""
        self._rapid.load(self._path(name), task)

    def unload(self, module: str, task: str = "") -> None:
        """Takes a module out of a task; its file stays."""
        self._rapid.unload(module, task)

    def modules(self, task: str = "") -> tuple[str, ...]:
        """Names of the modules that are loaded in a task."""
        return self._rapid.modules(task)

    def module_text(self, module: str, task: str = "") -> bytes:
        """The text of a loaded module, with the values that its persistent data have now."""
        return self._rapid.text(module, task)

    def motors(self, on: bool) -> None:
        self._panel.set_motors(on)

    def start(self, task: str = "", *, forever: bool = False) -> None:
        """Starts all selected tasks; a task may be named if it is the only one."""
        self._rapid.start(task, forever=forever)

    def stop(self) -> None:
        self._rapid.stop()

    def set_override(self, percent: int) -> None:
        """The speed ratio, which controllers let be set in automatic mode only."""
        if not 0 <= percent <= 100:
            raise Refused(
                rules.BAD_VALUE(
                    place=str(self.address), value=percent, what="the speed ratio",
                    reason="it is percent", form="a number from 0 to 100",
                )
            )  # fmt: skip
        self._panel.set_override(percent)

    def jog(self, jog: Jog) -> None:
        raise self._session.refusal(
            f"jog {jog.axis}",
            "Robot Web Services jog while the enabling device is held, not by a distance",
            "jog on the FlexPendant",
        )

    def hand(self, number: int, *, open: bool) -> None:
        raise self._session.refusal(
            f"{'open' if open else 'close'} the hand {number}",
            "a hand of this controller is what its signals make of it",
            "set the output that moves it, as in `set_output('doGripper', 1)`",
        )

    def backup(self, folder: FilePath) -> tuple[str, ...]:
        """The controller's own backup, brought here whole or not at all; see `Controller`."""
        return back_up(self._session, self._files, folder)

    def restore(self, folder: FilePath, *, only: Sequence[str] = ()) -> Restore:
        """See `Controller`. Nothing is deleted that the backup has not.

        Files of HOME are written, modules loaded, and parameters loaded, which take hold after a
        restart. MOC.cfg, SIO.cfg, EIO.cfg and safety settings are left out unless they are named.
        """
        parts = RestoreParts(self._session, self._mastership, self._files, self._panel, self._rapid)
        return restore(parts, folder, only)

    def watch(self, interval: float, signals: Sequence[str] = ()) -> Iterator[Sample]:
        return subscriptions.watch(
            self._session, self._panel, self._rapid, self._signals, interval, signals
        )

    def subscribe(self, resources: Sequence[str]) -> AbstractContextManager[Events]:
        """Events of `motors`, `mode`, `override`, `execution`, `log`, `signal:NAME`, …

        with controller.subscribe(["execution", "signal:diStart"]) as events:
            print(events.next(timeout=10))
        """
        return subscribed(self._session, self._signals, resources)

    def mastership(self, domain: Domain = "rapid") -> AbstractContextManager[None]:
        """Holds the mastership for several acts, which take and give it back one by one else."""
        return self._mastership.of(domain, "holding the mastership")

    def remote_access(self, wait: float = 60.0) -> None:
        """Asks for leave to write in manual mode; somebody confirms it on the pendant."""
        session.ask_remote_access(self._session, wait)

    def _path(self, name: str) -> str:
        return f"{self.address.folder}/{checked_name(name)}"

    def _look_for_folder(self) -> None:
        folder = self.address.folder
        try:
            self._files.listing(folder)
        except NotThere as error:
            reply = error.findings[0].message
            finding = rules.NO_FOLDER(
                place=str(self.address), address=self.address, folder=folder, reply=reply
            )
            raise Refused(finding, exit_status=2) from None
