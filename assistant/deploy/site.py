"""Controller as deployments see it: its programs, how they are changed, and how versions differ.

A controller prints a module from its memory in its own layout, and data with their present values.
So modules in memory are compared declaration by declaration and statement by statement: another
layout is no difference, another value is.
"""

from __future__ import annotations

import difflib
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import lru_cache, partial
from typing import Final, Self, TypeVar

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import decode, lines_of, visible
from assistant.base.text_merge import difference
from assistant.controllers import Address, Controller, Programs
from assistant.controllers.abilities import Disk, Memory, Rests
from assistant.controllers.rules import Lost, Taken
from assistant.controllers.states import Identity
from assistant.deploy import rules
from assistant.deploy.record import NOTHING_INSTALLED, Digests, Held, digest


def _module_form(data: bytes, language: str) -> bytes:
    """Return the content of a module without its layout, one line per declaration or statement."""
    return "\r\n".join(form for form, _ in _module_pieces(data, language)).encode()


def module_difference(
    before: bytes, after: bytes, language: str, labels: tuple[str, str], around: int = 3
) -> str:
    """Return a unified diff of two states of a module, "" if their content is the same.

    Equal content is shown in the layout of the first. around: lines of context.
    """
    written: dict[str, str] = {}
    left, right = (
        [written.setdefault(form, text) for form, text in _module_pieces(data, language)]
        for data in (before, after)
    )
    lines = difflib.unified_diff(
        _visible_lines(left), _visible_lines(right), *labels, n=around, lineterm=""
    )
    return "".join(f"{line}\n" for line in lines)


@lru_cache(maxsize=32)
def _module_pieces(data: bytes, language: str) -> tuple[tuple[str, str], ...]:
    spoken = languages.get(language)
    # Latin-1 decodes any bytes: a controller's text is compared even if it is misspelt.
    return tuple(spoken.said(decode(data, None, (*spoken.encodings, "latin-1")).text))


def _visible_lines(texts: Sequence[str]) -> list[str]:
    """With no character in them that a terminal would obey."""
    lines = (line for text in texts for line in lines_of(text))
    return [visible(line.rstrip()) for line in lines if line.strip()]


RECORD: Final = "robot-assistant.json"
"""Beside the programs on a disk: what the last deployment left there."""
UNDER_WAY: Final = "robot-assistant.zip"
"""The last deployment itself, with the previous programs."""
CLAIM: Final = "robot-assistant.lock"
"""A folder that is there while somebody deploys."""
CLAIMANT: Final = "robot-assistant.claim.json"
"""Who that is."""
_WAITING: Final = 5.0
"""Seconds to wait for a program that another user has open."""
BETWEEN: Final = 0.5
"""Seconds between two tries."""
_OURS: Final = frozenset({RECORD, UNDER_WAY, CLAIM, CLAIMANT})
"""Files that deployments store on a disk next to the programs."""


Answer = TypeVar("Answer")


def of_deployments(name: str) -> bool:
    """True if a file is not a program, but a file of deployments, or the rest of a transfer."""
    return name.lower().strip("~") in _OURS or name.startswith("~") or name.endswith("~")


class Site:
    """A controller with the operations of a deployment; a context manager, which connects.

    task: the task whose memory counts, "" for the first one, whose name it holds once connected.
    patience: seconds to wait for a program that another user has open.
    """

    def __init__(self, controller: Programs, task: str = "", patience: float = _WAITING) -> None:
        self.controller = controller
        self.task = task
        self.patience = patience
        self.memory = controller if isinstance(controller, Memory) else None
        self.disk = controller if isinstance(controller, Disk) else None
        self.tell: Callable[[Diagnostic], None] = lambda _: None
        """Called at once with what a user has to know before everything is over."""
        self.waiting: Callable[[], AbstractContextManager[object]] = nullcontext
        """Entered while a lost line is tried again: what may interrupt that raises in it."""
        self._silent: float | None = None
        self._unreachable: Lost | None = None

    def __enter__(self) -> Self:
        self.controller.__enter__()
        try:
            if self.memory is not None:
                self.task = self.memory.task_named(self.task)
        except BaseException:
            self.controller.__exit__(None, None, None)
            raise
        return self

    def __exit__(self, *error: object) -> None:
        self.controller.__exit__(*error)

    def reconnect(self) -> None:
        """A new session in place of one that is lost or out of step."""
        self.controller.__exit__(None, None, None)
        self.controller.__enter__()

    def insist(
        self,
        act: Callable[[], Answer],
        patience: float,
        *,
        connected: bool = True,
        only: type[Refused] = Refused,
    ) -> Answer:
        """Repeat an action, over a new session if the present one is lost, until it is not refused.

        connected: whether the present session can be used. only: the error after which it tries
        again. Raises the last error. For a lost line one patience covers all actions.
        """
        end = time.monotonic() + patience
        while True:
            try:
                if not connected:
                    self._connect_anew(patience)
                    connected = True
                done = act()
            except only as refusal:
                if isinstance(refusal, Lost):
                    end = min(end, self.lost(refusal, patience))
                if time.monotonic() + BETWEEN > end:
                    raise
                connected = connected and not isinstance(refusal, Lost)
                # Only while the line is lost may the wait be
                # interrupted: otherwise a step is in progress.
                with self.waiting() if not connected else nullcontext():
                    time.sleep(BETWEEN)
            else:
                self._silent = self._unreachable = None
                return done

    def lost(self, refusal: Lost, patience: float) -> float:
        """Reports a lost line, once; until when it is tried again."""
        if self._silent is None:
            self._silent = time.monotonic()
            reason = refusal.findings[0].message if refusal.findings else "it does not answer"
            place = str(self.address)
            self.tell(rules.LINE_LOST(place=place, reason=reason, patience=patience))
        return self._silent + patience

    @property
    def reachable(self) -> bool:
        """False while a lost line could not be had back."""
        return self._unreachable is None

    def _connect_anew(self, patience: float) -> None:
        """Raises Lost at once where that was tried in vain for as long as the patience lasts."""
        silent, unreachable = self._silent, self._unreachable
        # The next action does not wait again for a controller that never answered.
        if silent is not None and unreachable is not None:
            if time.monotonic() > silent + patience:
                raise unreachable
        try:
            with self.waiting() if silent is not None else nullcontext():
                self.reconnect()
        except Lost as refusal:
            self._unreachable = refusal
            raise

    @property
    def address(self) -> Address:
        return self.controller.address

    @property
    def blind(self) -> bool:
        """True if taught points are in a memory that this session cannot see."""
        return self.controller.memory_apart and self.memory is None

    @property
    def language(self) -> str:
        """Name of the language of its programs; only a session knows which version that is."""
        return self.controller.languages[0]

    def identity(self) -> Identity | None:
        """Which controller it is, None where the session cannot tell."""
        return self.controller.identify() if isinstance(self.controller, Controller) else None

    def held(self, name: str, data: bytes | None = None) -> Held:
        """Return a program's present content. data: of its file, if loaded without one."""
        file = self._waited_for(partial(self.controller.read, name))
        text = file if file is not None else data
        if self.memory is None or text is None or self.is_list(name):
            return Held(file)
        return Held(file, self.memory.loaded(text, self.task))

    def is_list(self, name: str) -> bool:
        """True if it is a file that only lists others."""
        return name.lower().endswith(self.controller.lists)

    def forms(self, held: Held) -> Held:
        """The forms in which it is compared."""
        file = None if held.file is None else self.controller.stored(held.file)
        loaded = held.loaded
        if self.memory is not None and loaded is not None:
            loaded = _module_form(loaded, self.language)
        return Held(file, loaded)

    def in_memory(self, data: bytes) -> bytes:
        """The text of a module, or a line of it, without what a memory does not keep."""
        return data if self.memory is None else self.memory.stored_in_memory(data)

    def same(self, one: Held, other: Held) -> bool:
        return self.forms(one) == self.forms(other)

    def digests(self, held: Held, task: str = "") -> Digests:
        """task: whose memory that was, "" for the one that counts now."""
        forms = self.forms(held)
        task = "" if forms.loaded is None else task or self.task
        return Digests(digest(forms.file), digest(forms.loaded), task)

    def put(self, name: str, wanted: Held, instead: Held = NOTHING_INSTALLED) -> None:
        """Write a program to the controller; repeated after an interruption, it ends the same.

        Content for the memory is loaded from a file first, and the file that is to stay is written
        last. instead: the content it replaces, whose module may have another name: that one leaves
        the memory before anything else. A plan has checked the text of new content.
        """
        now = self.held(name, wanted.file or wanted.loaded)
        if self.memory is not None and not self.is_list(name):
            # Other modules first: both would be loaded for a moment otherwise, with the same names.
            self._put_out_others(self.memory, wanted, instead)
            self._put_in_memory(self.memory, name, now, wanted)
            now = self.held(name, wanted.file or wanted.loaded)
        if self.forms(Held(now.file)) == self.forms(Held(wanted.file)):
            return
        if wanted.file is None:
            self._waited_for(partial(self.controller.remove, name))
        else:
            self._waited_for(partial(self.controller.write, name, wanted.file, as_it_was=True))

    def clear_rests(self, known: Rests) -> None:
        """Deletes what transfers that were cut left beside programs; see `abilities.Disk`."""
        if self.disk is not None:
            self.disk.clear_rests({**known, **dict.fromkeys((RECORD, UNDER_WAY, CLAIMANT))})

    def _waited_for(self, act: Callable[[], Answer]) -> Answer:
        return self.insist(act, self.patience, only=Taken)

    def _put_out_others(self, memory: Memory, wanted: Held, instead: Held) -> None:
        """Two modules of one file would be loaded side by side if their names differ."""
        if instead.loaded is None or wanted.loaded is None:
            return
        old, new = memory.module(instead.loaded), memory.module(wanted.loaded)
        if (old or "").lower() != (new or "").lower():
            memory.put_out(instead.loaded, self.task)

    def _put_in_memory(self, memory: Memory, name: str, now: Held, wanted: Held) -> None:
        if wanted.loaded is None:
            if now.loaded is not None:
                memory.put_out(now.loaded, self.task)
            return
        before = None if now.loaded is None else memory.stored_in_memory(now.loaded)
        # Loaded only if it differs: loading resets program pointers and taught values.
        if before != memory.stored_in_memory(wanted.loaded):
            self.controller.write(name, wanted.loaded, as_it_was=True)
            memory.take_in(name, self.task)


def difference_since(site: Site, name: str, left: Held | None, now: Held) -> str:
    """Return a unified difference from the last deployment to the present content, "" if
    unknown.
    """
    if left is None:
        return ""
    one, other = site.forms(left), site.forms(now)
    here = f"{name} (on the controller)"
    text = difference(one.file, other.file, f"{name} (as it was left)", here)
    labels = (f"{name} (loaded, as it was left)", f"{name} (in memory)")
    if left.loaded is not None and now.loaded is not None:
        text += module_difference(left.loaded, now.loaded, site.language, labels)
    elif left.loaded is not None or now.loaded is not None:
        text += difference(left.loaded, now.loaded, *labels)
    return text
