"""Values of RAPID data on a controller."""

from __future__ import annotations

import re
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.mastership import Mastership
from assistant.controllers.abb.rws.rapid import Rapid
from assistant.controllers.abb.rws.session import NotThere, Session

SYMBOL_PROPERTIES: Final = tuple(
    f"rap-symprop{kind}" for kind in ("var", "pers", "const", "per", "con")
)
DATA_KINDS: Final = frozenset({"var", "per", "con", "pers", "const", "any", ""})
CONSTANT_KINDS: Final = frozenset({"con", "const"})


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
        ).of(*SYMBOL_PROPERTIES)
        if not rows:
            return ""
        constant = rows[0].get("symtyp").lower() in CONSTANT_KINDS
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
            if row.get("symtyp").lower() in DATA_KINDS and len(parts) == 4:
                if parts[3].lower() == name.lower():
                    modules.append(parts[2])
        return sorted(set(modules))


def _shown(fields: dict[str, str]) -> str:
    return f"`{fields['task']}/{fields['module']}/{fields['name']}`"
