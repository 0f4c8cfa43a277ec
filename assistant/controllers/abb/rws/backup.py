"""Backup of a controller, and its restore, piece by piece.

The controller makes the backup on its disk; it is fetched and deleted there. The controller's own
restore would replace everything, safety and network settings included, and restart. So a restore
shows the differences, then writes files and loads modules and parameters instead.
"""

from __future__ import annotations

import difflib
import re
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from datetime import datetime
from fnmatch import fnmatchcase
from pathlib import Path as FilePath
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import check_sent, lines_of, visible
from assistant.controllers import backup_folder, rules
from assistant.controllers.abb.files import TEXTS
from assistant.controllers.abb.rws.files import Files
from assistant.controllers.abb.rws.rapid import Rapid
from assistant.controllers.abb.rws.session import Mastership, NotThere, Session
from assistant.controllers.abb.rws.system import Panel

_KIND: Final = "abb"
_VOLUME: Final = "BACKUP:"
_PATIENCE: Final = 600.0
"""Seconds that a controller is granted for writing its backup, unless the time-out is longer."""
_INFO_FILE: Final = "backinfo/backinfo.txt"
"""A file that every backup has."""
_FIRST_POLL: Final = 0.2
_SLOWEST_POLL: Final = 2.0
"""Seconds between two looks whether the backup is written: the first, and at most."""
_FAILED: Final = ("error", "invalid")
_UNDER_WAY: Final = ("progress", "pending", "init", "running", "none")
"""Parts of the words for the state of a backup: `Backup in Progress`, `Error during backup`, …"""


def back_up(session: Session, files: Files, folder: str | FilePath) -> tuple[str, ...]:
    """Writes a backup into a new folder, which appears whole or not at all; its files."""
    with backup_folder.appearing_folder(folder, _KIND) as place:
        name = f"assistant_{datetime.now():%Y%m%d_%H%M%S_%f}"
        path = f"{_VOLUME}/{name}"
        # The backup is deleted on the controller's disk, whatever becomes of this copy.
        try:
            _make(session, files, path)
            for found, size in files.tree(path):
                backup_folder.put_file(place, found, _read(session, files, f"{path}/{found}", size))
        finally:
            if session.connected:
                files.discard(path)
        written = backup_folder.backup_files(place)
        # A backup without its own description was read before the controller had finished it.
        if not any(one.lower() == _INFO_FILE for one in written):
            raise session.garbled("reading the backup", f"it has no `{_INFO_FILE}`")
        return written


def _make(session: Session, files: Files, path: str) -> None:
    doing = "making a backup"
    form = {"backup": f"/fileservice/{files.path(path)}"}
    answer = session.ask("back up", doing=doing, form=form)
    number = answer.location.rpartition("/progress/")[2]
    patience = max(_PATIENCE, session.timeout)
    until = time.monotonic() + patience
    pause = _FIRST_POLL
    while not _ready(session, number if number.isalnum() else ""):
        # Small backups are ready at once, large ones take minutes: look less and less often.
        if time.monotonic() + pause > until:
            state = "the backup may still be under way on the controller"
            place = str(session.address)
            raise Refused(rules.NOT_DONE(place=place, doing=doing, seconds=patience, state=state))
        time.sleep(pause)
        pause = min(2 * pause, _SLOWEST_POLL)


def _ready(session: Session, number: str) -> bool:
    """True if the backup is written, by its progress if it has a number, and by its state."""
    doing = "asking how far the backup is"
    told = [
        _state_word(session, "backup state", doing, {}, "backup-state", "backup state", "state")
    ]
    if number:
        told.append(_state_word(session, "progress", doing, {"path": number}, "state"))
    if not any(told):
        raise session.refusal(
            "make a backup", "it does not tell when one is whole", "make it on the FlexPendant"
        )
    for state in told:
        if any(word in state for word in _FAILED):
            raise session.refusal("make a backup", state, "look into its event log; free its disk")
    return not any(word in state for state in told for word in _UNDER_WAY)


def _state_word(
    session: Session, name: str, doing: str, at: Mapping[str, str], *values: str
) -> str:
    """A state in the controller's words, lower case; "" where it tells none."""
    try:
        rows = session.ask(name, doing=doing, at=at).rows
    except NotThere:
        return ""
    return next((row.get(*values).lower() for row in rows if row.get(*values)), "")


def _read(session: Session, files: Files, name: str, size: int | None) -> bytes:
    data = files.read(name)
    if data is None or (size is not None and len(data) != size):
        got = "nothing" if data is None else f"{len(data)} bytes"
        raise session.garbled(f"reading `{name}` of the backup", f"{got} instead of {size} bytes")
    return data


_LEFT_OUT: Final = {
    "SYSPAR/MOC.cfg": "calibration offsets and other data of this very arm",
    "SYSPAR/*calib*": "calibration of this very arm",
    "SYSPAR/SIO.cfg": "addresses of the network",
    "SYSPAR/EIO.cfg": "addresses of field networks, and signals that safety may hang on",
    "*safety*": "safety settings, which are to be validated after a change",
    "*.sxml": "safety settings, which are to be validated after a change",
    "*psc_*": "safety settings, which are to be validated after a change",
    "RAPID/TASK0/*": "modules that all tasks share, which the system installs",
}
"""Files that are restored only if they are named, with why; patterns ignore case."""
_INFO_PATTERNS: Final = ("BACKINFO/*", "backinfo.txt", "system.xml", "*/version.xml")
"""Files that describe the backup itself."""
_TASK_LINE: Final = re.compile(r"^>>(TASK\d+):\s*\(([A-Za-z]\w*)", re.MULTILINE)
"""Which folder is of which task, in `BACKINFO/backinfo.txt`: `>>TASK1: (T_ROB1,,)`."""
_MODULE_FILE: Final = re.compile(r"RAPID/(TASK\d+)/(?:PROGMOD|SYSMOD)/([^/]+\.(?:mod|sys)x?)", re.I)
_PARAMETER_FILE: Final = re.compile(r"SYSPAR/([A-Za-z0-9_]+\.cfg)", re.I)
_DOMAIN_HEAD: Final = re.compile(rb"\s*(\w+):CFG_", re.ASCII)
"""Beginning of a parameter file: this, and not its name, determines which domain it replaces."""
_LOADING_VOLUME: Final = "TEMP:"
"""Volume that modules and parameters are loaded from."""


@dataclass(frozen=True, slots=True)
class RestoreParts:
    """Parts of a controller that a restore uses."""

    session: Session
    mastership: Mastership
    files: Files
    panel: Panel
    rapid: Rapid
    home: str = "HOME:"


class Restore:
    """See `Restoring`. now: files as the controller has them; then: as the backup has them."""

    def __init__(
        self,
        parts: RestoreParts,
        now: Mapping[str, bytes],
        then: Mapping[str, bytes],
        wanted: Sequence[str],
    ) -> None:
        self._parts = parts
        self._now = now
        self._then = then
        self._tasks = dict(_TASK_LINE.findall(_backinfo(then)))
        # The files that describe a backup differ in each one.
        differing = [
            n for n in sorted(then) if now.get(n) != then[n] and not _matches(n, _INFO_PATTERNS)
        ]
        self.left_out: Mapping[str, str] = {
            name: why for name in differing if (why := self._why_not(name, wanted)) is not None
        }
        taken = [name for name in differing if name not in self.left_out]
        for name in taken:
            if name.lower().endswith(TEXTS):
                check_sent(then[name], name)
        self.changes: Mapping[str, str] = {name: self._difference(name) for name in taken}

    @property
    def needs_restart(self) -> bool:
        """True if the controller applies some of it only after a restart."""
        return any(_PARAMETER_FILE.fullmatch(name) for name in self.changes)

    def apply(self) -> None:
        """Restore all changes, or put back the previous state."""
        if self.changes and self._parts.panel.running():
            raise self._parts.session.refusal(
                "restore", "programs run on it", "stop the programs first"
            )
        done: list[str] = []
        try:
            for name in self.changes:
                self._put(name, self._then[name])
                done.append(name)
        # Without a connection nothing can be put back.
        except rules.Lost as error:
            raise rules.Lost(*error.findings, self._partly(name, done)) from None
        except Refused as error:
            kept = list(self._not_taken_back(done))
            raise Refused(*error.findings, *([self._partly(name, kept)] if kept else [])) from None

    def _not_taken_back(self, done: Sequence[str]) -> Iterator[str]:
        """Put back the previous state; yield the names of the files that stay restored."""
        for name in reversed(done):
            before = self._now.get(name)
            try:
                if before is not None:
                    self._put(name, before)
                elif name.startswith("HOME/"):
                    self._parts.files.remove(self._home(name))
                else:
                    yield name  # a module or parameters that were not there
            except Refused:
                yield name

    def _partly(self, name: str, done: Sequence[str]) -> Diagnostic:
        said = ", ".join(f"`{one}`" for one in done) or "nothing"
        return rules.RESTORED_PARTLY(
            place=str(self._parts.session.address),
            name=name,
            done=said,
            kept="a backup made before",
        )

    def _why_not(self, name: str, wanted: Sequence[str]) -> str | None:
        if wanted and not any(_is_meant(name, one) for one in wanted):
            return "it was not named"
        why = self._kept_back(name, wanted)
        return why or (None if self._known(name) else "nothing that could be restored")

    def _kept_back(self, name: str, wanted: Sequence[str]) -> str | None:
        """Return why the user must name a file, None if it is named or need not be.

        A folder that holds other files does not name it. A parameter file also counts as the domain
        in its text.
        """
        # The head of the text decides which parameters a file replaces, whatever its name is.
        domain = _DOMAIN_HEAD.match(self._then[name]) if _PARAMETER_FILE.fullmatch(name) else None
        names = [name, *([f"SYSPAR/{domain[1].decode('ascii')}.cfg"] if domain is not None else [])]
        # A folder such as `SYSPAR` names too much: a file that is left out has to be named closer.
        unnamed = [
            n for n in names if not any(_is_meant(n, asked, tuple(_LEFT_OUT)) for asked in wanted)
        ]
        return next(
            (why for n in unnamed for one, why in _LEFT_OUT.items() if _matches(n, (one,))), None
        )

    def _known(self, name: str) -> bool:
        module = _MODULE_FILE.fullmatch(name)
        task = module is not None and module[1].upper() in self._tasks
        return name.startswith("HOME/") or task or _PARAMETER_FILE.fullmatch(name) is not None

    def _difference(self, name: str) -> str:
        before, after = self._now.get(name, b""), self._then[name]
        if b"\0" in before + after:
            return f"{name}: {len(before)} bytes there, {len(after)} in the backup\n"
        left, right = (
            [visible(line) for line in lines_of(data.decode("latin-1"))] for data in (before, after)
        )
        lines = difflib.unified_diff(
            left, right, f"{name} (there)", f"{name} (backup)", lineterm=""
        )
        return "".join(f"{line}\n" for line in lines) or f"{name}: other line ends\n"

    def _put(self, name: str, data: bytes) -> None:
        """Brings one file to where it belongs."""
        module, settings = _MODULE_FILE.fullmatch(name), _PARAMETER_FILE.fullmatch(name)
        if name.startswith("HOME/"):
            folder, _, last = self._home(name).rpartition("/")
            self._parts.files.make_folder(folder)
            self._parts.files.write(folder, last, data)
        elif module is not None:
            with _laid_down(self._parts.files, module[2], data) as path:
                self._parts.rapid.load_module(path, self._tasks[module[1].upper()])
        elif settings is not None:
            with _laid_down(self._parts.files, settings[1], data) as path:
                self._load_settings(name, path)

    def _home(self, name: str) -> str:
        return f"{self._parts.home}/{name.removeprefix('HOME/')}"

    def _load_settings(self, name: str, path: str) -> None:
        """Puts all parameters of a domain into the place of those that are there."""
        session = self._parts.session
        form = {"filepath": self._parts.files.path(path), "action-type": "replace"}
        # Checked before loading: half of a wrong file could take effect.
        if "check settings" in session.dialect.operations:
            with suppress(NotThere):  # an older system looks when it loads
                session.ask("check settings", doing=f"checking `{name}`", form=form)
        doing, state = f"loading the parameters of `{name}`", f"those of `{name}` are as they were"
        self._parts.mastership.ask("load settings", doing=doing, state=state, form=form)


def restore(parts: RestoreParts, folder: str | FilePath, only: Sequence[str]) -> Restore:
    """Compare a backup with a new backup of the controller; return the differences."""
    then = backup_folder.backup_contents(folder, _KIND)
    for one in only:
        if not any(_is_meant(name, one) for name in then):
            known = ", ".join(f"`{name}`" for name in sorted(then)[:10])
            raise Refused(rules.NOT_IN_BACKUP(name=one, known=known, place=str(folder)))
    with tempfile.TemporaryDirectory(prefix="robot-assistant-") as place:
        current = FilePath(place) / "now"
        # Compared with a fresh backup: the controller may have changed since the last one.
        back_up(parts.session, parts.files, current)
        return Restore(parts, backup_folder.backup_contents(current, _KIND), then, only)


@contextmanager
def _laid_down(files: Files, name: str, data: bytes) -> Iterator[str]:
    """The path of a file on the controller, for as long as something is loaded from it."""
    path = f"{_LOADING_VOLUME}/{name}"
    try:
        files.put(path, data, "nothing of it is loaded")
        yield path
    except rules.Lost:
        raise
    except BaseException:
        files.discard(path)
        raise
    else:
        files.discard(path)


def _backinfo(files: Mapping[str, bytes]) -> str:
    found = next((d for n, d in files.items() if n.lower() == "backinfo/backinfo.txt"), b"")
    return found.decode("latin-1").replace("\r", "")


def _matches(name: str, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(name.lower(), pattern.lower()) for pattern in patterns)


def _is_meant(name: str, wanted: str, patterns: Sequence[str] = ("*",)) -> bool:
    """True if a name selects a file: by its complete name, a folder above it, or its last part.

    patterns: such a folder must match one.
    """
    lower, asked = name.lower(), wanted.replace("\\", "/").strip("/").lower()
    above = lower.startswith(f"{asked}/") and _matches(f"{asked}/", patterns)
    return lower == asked or above or lower.rpartition("/")[2] == asked
