"""RAPID on a controller: tasks, what is loaded in them, where they are, starting and stopping."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Final
from urllib.parse import unquote_to_bytes

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.answers import Row
from assistant.controllers.abb.rws.files import Files
from assistant.controllers.abb.rws.mastership import Mastership
from assistant.controllers.abb.rws.session import NotNow, Session
from assistant.controllers.states import TaskState

IDENTIFIER: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,31}")
PROGRAM_SUFFIX: Final = ".pgf"
RUNNING_WORDS: Final = frozenset({"running", "started"})
"""Words of the two dialects for a task that runs."""


class Rapid:
    def __init__(self, session: Session, mastership: Mastership, files: Files) -> None:
        self._session = session
        self._mastership = mastership
        self._files = files
        self._known: dict[str, str] = {}

    def forget(self) -> None:
        """What was known of the tasks: a controller that was restarted may have others."""
        self._known.clear()

    def tasks(self) -> tuple[TaskState, ...]:
        """The tasks, each with the module and the line that its program pointer is at."""
        return tuple(self._task(row) for row in self._rows())

    def task(self, name: str) -> str:
        """The name of a task that there is, "" for the first one that moves the arm.

        Asked for once in a session.
        """
        if name.lower() not in self._known:
            self._known[name.lower()] = self._looked_up(name)
        return self._known[name.lower()]

    def _looked_up(self, name: str) -> str:
        rows = self._rows()
        if name:
            self.checked(name, "task")
            found = next((r for r in rows if self._name(r).lower() == name.lower()), None)
            if found is None:
                known = ", ".join(f"`{self._name(row)}`" for row in rows)
                raise self._session.refusal(
                    f"use the task `{name}`", "there is no such task", f"use {known}"
                )
            return self._name(found)
        moving = [row for row in rows if row.get("motiontask").lower() == "true"]
        if not rows:
            raise self._session.refusal(
                "use a task", "it has none, or is starting up", "wait until it has started"
            )
        return self._name((moving or list(rows))[0])

    def modules(self, task: str = "") -> tuple[str, ...]:
        """Names of the modules that are loaded in a task, system modules among them."""
        where = self.task(task)
        doing = f"listing the modules of `{where}`"
        if "{task}" in self._session.dialect.operations["modules"].path:
            answer = self._session.ask("modules", doing=doing, at={"task": where})
        else:
            answer = self._session.ask("modules", doing=doing, query={"task": where})
        return tuple(row.get("name") for row in answer.of("rap-module-info") if row.get("name"))

    def text(self, module: str, task: str = "") -> bytes:
        """The text of a loaded module, as it is in the controller's memory."""
        where = self.task(task)
        self.checked(module, "module")
        doing = f"reading the module `{module}` of `{where}`"
        apart = "{task}" not in self._session.dialect.operations["text"].path
        query = {"task": where} if apart else {}
        answer = self._session.ask(
            "text", doing=doing, query=query, at={"module": module, "task": where}
        )
        row = next(iter(answer.of("rap-module-text")), None)
        if row is None:
            raise self._session.garbled(doing, "there is no text in it")
        long = row.get("file-path")
        if long and not row.get("module-text"):  # it is laid down where files are
            data = self._files.read(long.replace("$", ""))
            if data is None:
                raise self._session.garbled(doing, f"the text is said to be in `{long}`")
            return data
        return _as_file(row.get("module-text"), quoted=self._session.dialect.quoted_text)

    def load(self, path: str, task: str = "") -> None:
        """Loads a module or program file into a task and moves the program pointer to main."""
        where = self.task(task)
        doing = f"loading `{path}` into `{where}`"
        self._stopped(doing)
        program = path.lower().endswith(PROGRAM_SUFFIX)
        with self._mastership.of("rapid", doing):
            if program:
                form = {"progpath": self._files.path(path), "loadmode": "replace"}
                state = f"`{where}` holds its old program, or a part of the new one"
                self._session.ask(
                    "load program", doing=doing, state=state, form=form, at={"task": where}
                )
            else:
                self._load_module(path, where, doing)
            self._session.ask(
                "to main",
                doing="moving the program pointer to main",
                state=f"`{path}` is loaded, the program pointer is where it was",
            )

    def load_module(self, path: str, task: str) -> None:
        """Loads a module in the place of the one of its name; nothing is moved to main."""
        self._load_module(path, task, f"loading `{path}` into `{task}`")

    def take_in(self, path: str, task: str) -> None:
        """The same for those who have not looked whether programs stand still."""
        where = self.task(task)
        self._stopped(f"loading `{path}` into `{where}`")
        self.load_module(path, where)

    def _load_module(self, path: str, task: str, doing: str) -> None:
        form = {"modulepath": self._files.path(path), "replace": "true"}
        state = f"`{task}` holds its old module"
        try:
            self._mastership.ask(
                "load module", doing=doing, state=state, form=form, at={"task": task}
            )
        except NotNow as error:  # most often two modules have a name in common, such as `main`
            loaded = ", ".join(f"`{name}`" for name in self.modules(task))
            if not loaded:
                raise
            cure = (
                f"loaded there: {loaded}; if one of them has a name in common with it, as `main`, "
                "start a program (.pgf) of its own instead, which replaces them, or take that "
                "module out first, on the FlexPendant or by `unload` of the session"
            )
            raise NotNow(*(replace(finding, cure=cure) for finding in error.findings)) from None

    def unload(self, module: str, task: str = "") -> None:
        where = self.task(task)
        self.checked(module, "module")
        doing = f"unloading the module `{module}` of `{where}`"
        self._stopped(doing)
        self._mastership.ask(
            "unload module",
            doing=doing,
            state=f"`{module}` is still loaded",
            form={"module": module},
            at={"task": where},
        )

    def start(self, task: str, *, forever: bool) -> None:
        """Starts all tasks that are selected on the controller, from their program pointers."""
        if task:
            self._only(self.task(task))
        self._mastership.ask(
            "start",
            doing="starting the programs",
            state="they stand as they did",
            form={"cycle": "forever" if forever else "once"},
        )

    def stop(self) -> None:
        self._session.ask(
            "stop", doing="stopping the programs", state="they may still run: use the stop button"
        )

    def checked(self, name: str, what: str) -> str:
        """The name, if RAPID can have it."""
        if not IDENTIFIER.fullmatch(name):
            reason = "it is no name of RAPID: a letter, then letters, digits and `_`, 32 at most"
            raise Refused(
                rules.BAD_VALUE(
                    place=name, value=name, what=f"a {what}", reason=reason, form="`main`"
                )
            )
        return name

    def _only(self, task: str) -> None:
        """Refuses to start one of several tasks: a start is for all that are selected."""
        others = [
            self._name(row)
            for row in self._rows()
            if row.get("active").lower() in ("on", "true") and self._name(row) != task
        ]
        if others:
            raise self._session.refusal(
                f"start `{task}` alone",
                f"a start is for all selected tasks, also {', '.join(f'`{o}`' for o in others)}",
                "deselect them in the task panel of the FlexPendant, or start without a task",
            )

    def _stopped(self, doing: str) -> None:
        """Loading is for programs that stand still."""
        rows = self._rows()
        running = [self._name(row) for row in rows if self._runs(row) and _foreground(row)]
        if running:
            raise self._session.refusal(
                f"do that: {doing}", f"`{running[0]}` runs", "stop the programs first"
            )

    def _rows(self) -> tuple[Row, ...]:
        return self._session.ask("tasks", doing="listing the tasks").of("rap-task")

    def _task(self, row: Row) -> TaskState:
        name = self._name(row)
        module, line = self._pointer(name)
        return TaskState(name, module, line, self._runs(row), not _foreground(row))

    def _pointer(self, task: str) -> tuple[str, int | None]:
        """Module and line of the program pointer; "" where a task has none."""
        doing = f"asking where `{task}` is"
        try:
            rows = self._session.ask("pointer", doing=doing, at={"task": task}).of("pcp-info")
        except rules.Lost:
            raise
        except Refused:  # an error, where there is nothing that could be pointed at
            return "", None
        if not rows:
            return "", None
        line = rows[0].get("beginposition").partition(",")[0].strip()
        # `modulemame` is what controllers do write.
        module = rows[0].get("modulename", "modulemame")
        return module, int(line) if line.isdecimal() and int(line) > 0 else None

    def _name(self, row: Row) -> str:
        return row.get("name") or row.title

    def _runs(self, row: Row) -> bool:
        return row.get("excstate").lower() in RUNNING_WORDS


def _as_file(text: str, *, quoted: bool) -> bytes:
    """A module's text in the bytes of a file, which are ISO 8859-1 as far as that goes."""
    data = unquote_to_bytes(text) if quoted else text.encode()
    try:
        return data.decode().encode("latin-1")
    except UnicodeError:
        return data


def _foreground(row: Row) -> bool:
    """Static and semistatic tasks run behind all others; loading does not mind them."""
    return row.get("type").lower() not in ("static", "semistatic", "semi", "stat")
