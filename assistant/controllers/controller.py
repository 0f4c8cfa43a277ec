"""Common interface of all controller clients, and the client for an address."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Final, Protocol, Self, runtime_checkable

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.address import SCHEMES, Address, Credentials, Question, find_credentials
from assistant.controllers.named import Named, named
from assistant.controllers.states import Fault, Identity, Jog, Position, Sample, State


class Programs(Protocol):
    """A session with a controller that keeps programs; a context manager.

    Entering connects. All methods raise Refused with a finding that says what state the
    controller is in, and `rules.Lost` (a Refused) if there is no connection any more.
    Nothing here ever starts motion.
    """

    @property
    def address(self) -> Address: ...

    languages: tuple[str, ...]
    """Names of the languages whose programs it takes."""
    lists: tuple[str, ...]
    """Suffixes of files that name the files of a program; they go last, when those are there."""
    memory_apart: bool
    """True if the running program was loaded from a file, and teaching changes only the loaded
    copy.
    """

    def __enter__(self) -> Self: ...

    def __exit__(self, *error: object) -> None: ...

    def names(self) -> tuple[str, ...]:
        """The programs on it, sorted."""

    def read(self, name: str) -> bytes | None:
        """Return a program in the controller's form, None if no program has that name."""

    def check_text(self, name: str, data: bytes) -> None:
        """Raises Refused for a program of which the controller may see other lines than we do."""

    def write(self, name: str, data: bytes, *, as_it_was: bool = False) -> None:
        """Puts a program there, whole or not at all; replaces one of that name.

        as_it_was: it was there before, and goes back whatever its lines are; see `check_text`.
        """

    def remove(self, name: str) -> None:
        """Delete a program; do nothing if it is missing."""

    def name_for(self, file_name: str | FilePath) -> str:
        """The name that a local file gets there; raises Refused if it can have none."""

    def stored(self, data: bytes) -> bytes:
        """The form in which two versions of a program are compared."""


@runtime_checkable
class Controller(Programs, Protocol):
    """A controller that can be looked at and operated, beside the programs that it keeps.

    Those who call `start`, `jog`, `hand` and `motors` have asked the user by name; everything
    else never moves anything. What a controller cannot do raises Refused with rules.NOT_HERE.
    """

    def identify(self) -> Identity: ...

    def state(self) -> State: ...

    def position(self) -> Position: ...

    def log(self, most: int = 50) -> tuple[Fault, ...]:
        """The latest errors and events, the newest first."""

    def reset(self) -> None:
        """Acknowledges errors, so that programs can be started again."""

    def inputs(self, names: Sequence[str]) -> dict[str, float]:
        """Return the values of signals by name, or by number as text where they have numbers."""

    def outputs(self, names: Sequence[str]) -> dict[str, float]: ...

    def set_output(self, name: str, value: float) -> None: ...

    def parameters(self, names: Sequence[str] = ()) -> dict[str, str]:
        """Values by name, as the controller writes them; without names, of changed ones."""

    def set_parameter(self, name: str, value: str) -> None: ...

    def variable(self, name: str, program: str = "", task: str = "") -> str:
        """A variable's value as the controller's language writes it."""

    def set_variable(self, name: str, value: str, program: str = "", task: str = "") -> None: ...

    def load(self, name: str, task: str = "") -> None:
        """Selects a program that is there, to begin at its top; task "" for the first one."""

    def motors(self, on: bool) -> None:
        """Switches the servos on or off."""

    def start(self, task: str = "", *, forever: bool = False) -> None:
        """Starts what is loaded, once or again and again."""

    def stop(self) -> None:
        """Stops all programs where they are; may be asked for at any time."""

    def set_override(self, percent: int) -> None: ...

    def jog(self, jog: Jog) -> None:
        """Moves one axis by hand, and comes back when it stands."""

    def hand(self, number: int, *, open: bool) -> None: ...

    def backup(self, folder: FilePath) -> tuple[str, ...]:
        """Writes programs, parameters and variables into a new folder; its files, relative to it.

        The folder appears whole or not at all.
        """

    def restore(self, folder: FilePath, *, only: Sequence[str] = ()) -> Restoring:
        """Compare a backup with the controller; `Restoring.apply` restores the differences.

        only: files or parameters to restore, including the origin, safety and network settings,
        which are left out otherwise.
        """

    def watch(self, interval: float, signals: Sequence[str] = ()) -> Iterator[Sample]:
        """Looks at the controller again and again, each `interval` seconds; needs no right."""


@runtime_checkable
class JogsJoints(Protocol):
    """A controller that jogs several joints at once."""

    def position(self) -> Position: ...

    def jog_joints(self, joints: Mapping[str, float], speed: float) -> None:
        """Moves joints by hand, and comes back when they stand; speed: percent of the override.

        joints: J1 … with the degrees (mm) to go to; the others stay.
        """


class Restoring(Protocol):
    """A restore that has not happened yet.

    changes: unified differences by what they are of. left_out: what is never restored unless it
    is named, with why.
    """

    @property
    def changes(self) -> Mapping[str, str]: ...

    @property
    def left_out(self) -> Mapping[str, str]: ...

    @property
    def needs_restart(self) -> bool:
        """True if the controller may apply some of it only after a restart."""

    def apply(self) -> None:
        """Restores; raises Refused with what has been restored by then."""


_CLIENTS: Final = {
    "ftp": ("assistant.controllers.abb.ftp", "Ftp"),
    "ftps": ("assistant.controllers.abb.ftp", "Ftp"),
    "sftp": ("assistant.controllers.abb.sftp", "Sftp"),
    "rws": ("assistant.controllers.abb.rws.client", "Rws"),
    "rwss": ("assistant.controllers.abb.rws.client", "Rws"),
    "melfa": ("assistant.controllers.mitsubishi.cr", "Cr"),
    "melfa-serial": ("assistant.controllers.mitsubishi.cr", "Cr"),
}
"""Scheme of an address → module and class of its client."""


LANGUAGES: Final[Mapping[str, tuple[str, ...]]] = {
    **dict.fromkeys(("ftp", "ftps", "sftp", "rws", "rwss"), ("rapid",)),
    **dict.fromkeys(("melfa", "melfa-serial"), ("melfa-basic-4", "melfa-basic-5", "melfa-basic-6")),
}
"""Scheme of an address → languages of the programs that a controller at such an address accepts."""


TIMEOUT: Final = 30.0
"""Seconds to wait for an answer where nobody says how long."""


def require_lasting(one: Named) -> None:
    """Raise Refused for a virtual controller of the project, which runs only during a command."""
    if one.virtual is not None:
        finding = rules.ONLY_DEPLOYED(place=one.name, name=one.name, kind=one.virtual)
        raise Refused(finding, exit_status=2)


def connect(
    address: str | Address | Named,
    *,
    user: str | None = None,
    password: str | None = None,
    ask: Question | None = None,
    credentials: Credentials | None = None,
    timeout: float | None = None,
    certificate: str | FilePath | None = None,
) -> Programs:
    """The client for an address, or for a name of this project; use it in a `with`, which connects.

    user, password, ask: see `address.find_credentials`. timeout: seconds to wait for an answer.
    certificate: file of the certificate that a controller is trusted by over TLS.
    Raises Refused if there is no such controller or no password can be found.
    """
    one = named(address) if isinstance(address, str) else address
    if isinstance(one, Address):
        one = Named(str(one), one)
    require_lasting(one)
    place, waiting = one.address, timeout or one.timeout or TIMEOUT
    module, name = _CLIENTS[place.scheme]
    client = getattr(importlib.import_module(module), name)
    if not SCHEMES[place.scheme].login:
        return client(place, timeout=waiting)  # type: ignore[no-any-return]
    found = credentials or find_credentials(
        place, controller=one.variables, user=user, password=password, ask=ask
    )
    trusted = certificate or one.certificate
    return client(place, found, timeout=waiting, certificate=trusted)  # type: ignore[no-any-return]
