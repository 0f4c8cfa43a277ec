"""RAPID on a controller: tasks, loaded modules, program pointers, start and stop, data."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Final
from urllib.parse import unquote_to_bytes

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.files import Files
from assistant.controllers.abb.rws.protocol import Row
from assistant.controllers.abb.rws.session import Mastership, NotNow, NotThere, Session
from assistant.controllers.states import TaskState

_IDENTIFIER: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,31}")
_PROGRAM_SUFFIX: Final = ".pgf"
_RUNNING_WORDS: Final = frozenset({"running", "started"})
"""Words of the two dialects for a task that runs."""


class Rapid:
    def __init__(self, session: Session, mastership: Mastership, files: Files) -> None:
        self._session = session
        self._mastership = mastership
        self._files = files
        self._known: dict[str, str] = {}

    def forget(self) -> None:
        """Discard the known tasks: a controller that was restarted may have others."""
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
        # Without a name, the first task that moves an arm;
        # a controller without one uses its first task.
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
        # RWS 1.0 takes the task in the query, RWS 2.0 in the path.
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
        program = path.lower().endswith(_PROGRAM_SUFFIX)
        # Loading and the move to main under one mastership: no other client comes in between.
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
        if not _IDENTIFIER.fullmatch(name):
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
        return row.get("excstate").lower() in _RUNNING_WORDS


def _as_file(text: str, *, quoted: bool) -> bytes:
    """A module's text in the bytes of a file, which are ISO 8859-1 as far as that goes."""
    # The answer is UTF-8; files on the disk of a controller are ISO 8859-1.
    data = unquote_to_bytes(text) if quoted else text.encode()
    try:
        return data.decode().encode("latin-1")
    except UnicodeError:
        return data


def _foreground(row: Row) -> bool:
    """Static and semistatic tasks run behind all others; loading does not mind them."""
    return row.get("type").lower() not in ("static", "semistatic", "semi", "stat")


_SYMBOL_PROPERTIES: Final = tuple(
    f"rap-symprop{kind}" for kind in ("var", "pers", "const", "per", "con")
)
_DATA_KINDS: Final = frozenset({"var", "per", "con", "pers", "const", "any", ""})
_CONSTANT_KINDS: Final = frozenset({"con", "const"})


class Data:
    def __init__(self, session: Session, mastership: Mastership, rapid: Rapid) -> None:
        self._session = session
        self._mastership = mastership
        self._rapid = rapid

    def value(self, name: str, module: str, task: str) -> str:
        fields = self._place(name, module, task)
        doing = f"reading {_shown(fields)}"
        rows = self._session.ask("value", doing=doing, at=fields).of("rap-data")
        row = next((row for row in rows if "value" in row.values), None)
        if row is None:
            raise self._session.garbled(doing, "there is no value in it")
        return row.get("value")

    def set_value(self, name: str, value: str, module: str, task: str) -> None:
        """Sets a value that the controller has found to be one of the data's type."""
        fields = self._place(name, module, task)
        shown = _shown(fields)
        if re.search(r"[\x00-\x1f\x7f]", value) or not value.strip():
            reason = "it is empty or holds a control character"
            raise Refused(
                rules.BAD_VALUE(
                    place=shown, value=value.strip(), what=f"the value of {shown}", reason=reason,
                    form="RAPID writes it, as in `[[1,0,0],TRUE]`",
                )
            )  # fmt: skip
        kind = self._kind(fields)
        if kind:
            self._check(fields["task"], value, kind, shown)
        doing = f"setting {shown}"
        state = f"{shown} is as it was"
        self._mastership.ask(
            "set value", doing=doing, state=state, form={"value": value}, at=fields
        )

    def _kind(self, fields: dict[str, str]) -> str:
        """The type of the data, "" of arrays and where the controller does not tell it."""
        shown = _shown(fields)
        rows = self._session.ask(
            "properties", doing=f"asking for the type of {shown}", at=fields
        ).of(*_SYMBOL_PROPERTIES)
        if not rows:
            return ""
        constant = rows[0].get("symtyp").lower() in _CONSTANT_KINDS
        if constant or rows[0].get("ro", "rdonly").lower() == "true":
            raise self._session.refusal(
                f"set {shown}",
                "it is a constant or read-only",
                "change it in the text of its module",
            )
        # The controller's check is for single values; arrays it looks at when they are set.
        return rows[0].get("dattyp") if rows[0].get("ndim") in ("", "0") else ""

    def _check(self, task: str, value: str, kind: str, shown: str) -> None:
        """Asks the controller whether a text is a value of a type."""
        two = "{task}" in self._session.dialect.operations["check value"].path
        form = {"value": value, "dattyp": kind} if two else {}
        form = form or {"task": task, "value": value, "datatype": kind}
        doing = f"looking whether `{value}` is a `{kind}` for {shown}"
        try:
            self._session.ask("check value", doing=doing, form=form, at={"task": task})
        except NotThere:
            return  # the controller has no such check, and looks when the value is set

    def _place(self, name: str, module: str, task: str) -> dict[str, str]:
        """Task, module and name; looks for the module where none is named."""
        where = self._rapid.task(task)
        self._rapid.checked(name, "name of data")
        if module:
            self._rapid.checked(module, "module")
            return {"task": where, "module": module, "name": name}
        found = self._modules(name, where)
        if len(found) != 1:
            # Data of one name may be in several modules: a guess could write to the wrong one.
            reason = f"it is in {', '.join(found)}" if found else "there is no such data"
            raise self._session.refusal(
                f"tell which `{name}` of `{where}` is meant", reason, "name the module as well"
            )
        return {"task": where, "module": found[0], "name": name}

    def _modules(self, name: str, task: str) -> list[str]:
        """Modules of a task that declare data of a name, from `RAPID/task/module/name`."""
        answer = self._session.ask(
            "find symbol",
            doing=f"looking for `{name}` in `{task}`",
            form={"blockurl": f"RAPID/{task}", "regexp": f"^{name}$"},
        )
        modules = []
        for row in answer.rows:
            parts = (row.get("symburl") or row.title).strip("/").split("/")
            if row.get("symtyp").lower() in _DATA_KINDS and len(parts) == 4:
                if parts[3].lower() == name.lower():
                    modules.append(parts[2])
        return sorted(set(modules))


def _shown(fields: dict[str, str]) -> str:
    return f"`{fields['task']}/{fields['module']}/{fields['name']}`"
