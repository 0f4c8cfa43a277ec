"""Abilities of some controllers in addition to `Programs`; test for them with isinstance.

`Disk`: programs are files, and other files may be next to them. `Memory`: the running modules were
loaded from files, and teaching changes them there, not in the file. `JogsHeld`: a jog can be
interrupted.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Protocol, runtime_checkable

from assistant.controllers.states import Jog

Rests = Mapping[str, Collection[bytes] | None]
"""Files next to which transfers may have left remains, each with its possible contents: a file set
aside is deleted only if it has one of these, because another user may have chosen the same name.
None: it is deleted.
"""

Held = Callable[[], bool]
"""Returns True while the user still holds the motion."""


@runtime_checkable
class JogsHeld(Protocol):
    """A controller that breaks a jog off on the session that asked for it."""

    def jog_while(self, jog: Jog, held: Held) -> None:
        """Jogs, and asks meanwhile; stops the arm and raises Refused once it is not held."""


@runtime_checkable
class Disk(Protocol):
    """A controller that keeps any file beside its programs; `read` and `write` take its name."""

    def claim(self, name: str) -> bool:
        """Makes a folder of that name; False if there is one: of many, only one succeeds."""

    def release(self, name: str) -> None:
        """Remove an empty folder; do nothing if it is missing."""

    def is_folder(self, name: str) -> bool:
        """True if there is a folder of that name beside the programs."""

    def clear_rests(self, known: Rests) -> None:
        """Deletes what transfers that were cut left beside files."""


@runtime_checkable
class Memory(Protocol):
    """A controller whose tasks hold modules that were loaded from files.

    task: its name, "" for the first one. data: text of a module's file, which names the module.
    """

    def loaded(self, data: bytes, task: str = "") -> bytes | None:
        """The module of a file as it is in memory, with the values that its data have now.

        None if no module of that name is loaded.
        """

    def module(self, data: bytes) -> str | None:
        """Return the name of the module in a file's text, None without a module or with several."""

    def modules(self, task: str = "") -> tuple[str, ...]:
        """Names of all modules that are loaded in a task."""

    def module_text(self, module: str, task: str = "") -> bytes:
        """Return a loaded module's text, as `loaded` does; raises Refused if it is secret."""

    def task_named(self, task: str) -> str:
        """The name of a task as the controller has it, that of the first one if none is named."""

    def homes(self, module: str) -> tuple[str, ...]:
        """Names of the tasks in which a module of that name is loaded."""

    def take_in(self, name: str, task: str = "") -> None:
        """Loads the file in place of its module, or beside the others; nothing is started."""

    def put_out(self, data: bytes, task: str = "") -> None:
        """Takes the module of a file out of memory; nothing happens if it is not loaded."""

    def stored_in_memory(self, text: bytes) -> bytes:
        """The form in which it is seen whether a text would have to be loaded anew."""
