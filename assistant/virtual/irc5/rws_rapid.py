"""`/rw/rapid`: execution, tasks, modules, the program pointer, and RAPID data (`/rw/rapid/symbol`).

Data is read, written, searched for and checked.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Final, Literal, TypeVar
from urllib.parse import quote
from xml.etree import ElementTree

from assistant.base.data_classes import dataclass
from assistant.base.file_access import read_file, write_whole
from assistant.virtual.irc5 import rws_messages
from assistant.virtual.irc5.cabinet import BackgroundTask, Cabinet
from assistant.virtual.irc5.programs import (
    MAIN,
    TASK,
    Cycle,
    Module,
    NotPossible,
    Programs,
    read_module,
)
from assistant.virtual.irc5.rws_files import path_of, unit_path
from assistant.virtual.irc5.rws_messages import DONE, Answer, Item, Reason, Rejected, Request
from assistant.virtual.rapid.control_flow import Fault, NotSimulated
from assistant.virtual.rapid.expressions import settled
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.scopes import Cell, Place, Types
from assistant.virtual.rapid.value_text import read_value, value_text
from assistant.virtual.rapid.values import Shape

_CYCLE_MODES: Final[dict[str, Cycle | None]] = {"once": "once", "forever": "forever", "asis": None}
_STOP_MODES: Final[dict[str, Literal["once", "cycle", "instruction"]]] = {
    "stop": "once",
    "qstop": "once",
    "cycle": "cycle",
    "instr": "instruction",
}


# ---------------------------------------------------------------------------- execution


def execution_state(cabinet: Cabinet, request: Request) -> Answer:
    fields = cabinet.do(
        lambda p: {"ctrlexecstate": "running" if p.running else "stopped", "cycle": p.cycle}
    )
    return Answer(items=[Item("rap-execution", "execution", fields)])


def start_execution(cabinet: Cabinet, request: Request) -> Answer:
    """Motors have to be on and the program pointer set."""
    for name, allowed in (
        ("execmode", ("continue",)),
        ("regain", ("continue", "clear", "enter_consume")),
        ("cycle", tuple(_CYCLE_MODES)),
    ):
        if request.form.get(name, allowed[0]) not in allowed:
            raise Rejected(rws_messages.BAD_ARGUMENT, f"{name} {request.form[name]}")
    if cabinet.panel.state != "motoron":
        raise Rejected(rws_messages.WRONG_STATE, f"the controller is in {cabinet.panel.state}")
    cycle = _CYCLE_MODES[request.form.get("cycle", "asis")]
    _command_programs(cabinet, lambda programs: programs.start(cycle))
    return DONE


def stop_execution(cabinet: Cabinet, request: Request) -> Answer:
    wanted = request.form.get("stopmode", "stop")
    if wanted not in _STOP_MODES:
        raise Rejected(rws_messages.BAD_ARGUMENT, f"stopmode {wanted}")
    _command_programs(cabinet, lambda programs: programs.stop(_STOP_MODES[wanted]))
    return DONE


def reset_pointer(cabinet: Cabinet, request: Request) -> Answer:
    _command_programs(cabinet, lambda programs: programs.reset())
    return DONE


def start_production(cabinet: Cabinet, request: Request) -> Answer:
    _command_programs(cabinet, lambda programs: programs.reset())
    return start_execution(cabinet, request)


def set_cycle(cabinet: Cabinet, request: Request) -> Answer:
    wanted = _CYCLE_MODES.get(request.given("cycle"))
    if wanted is None:
        raise Rejected(rws_messages.BAD_ARGUMENT, "cycle")

    def change(programs: Programs) -> None:
        programs.cycle = wanted

    _command_programs(cabinet, change)
    return DONE


def _command_programs(cabinet: Cabinet, command: object) -> None:
    assert callable(command)
    try:
        cabinet.do(command)
    except NotPossible as wrong:
        raise Rejected(rws_messages.WRONG_STATE, str(wrong)) from None


# -------------------------------------------------------------------------------- tasks


def list_tasks(cabinet: Cabinet, request: Request) -> Answer:
    own = Item("rap-task-li", TASK, cabinet.do(_task_fields), f"tasks/{TASK}")
    others = [
        Item("rap-task-li", name, _background_fields(name, one), f"tasks/{name}")
        for name, one in cabinet.behind.items()
    ]
    return Answer(listed=[own, *others])


def task_facts(cabinet: Cabinet, request: Request) -> Answer:
    name, one = _background_task(cabinet, request)
    if one is not None:
        return Answer(items=[Item("rap-task", name, _background_fields(name, one))])
    _check_task(request)
    return Answer(items=[Item("rap-task", TASK, cabinet.do(_task_fields))])


def _task_fields(programs: Programs) -> dict[str, str]:
    state = "started" if programs.running else "ready" if programs.ready else "stopped"
    return {
        "name": TASK,
        "type": "normal",
        "taskstate": "linked" if programs.ready else "loaded" if programs.modules else "empty",
        "excstate": state,
        "active": "On" if programs.active else "Off",
        "motiontask": "TRUE",
    }


def _background_fields(name: str, one: BackgroundTask) -> dict[str, str]:
    return {
        "name": name,
        "type": one.kind,
        "taskstate": "started" if one.running else "linked",
        "excstate": "started" if one.running else "ready",
        "active": "On",
        "motiontask": "FALSE",
    }


def _background_task(cabinet: Cabinet, request: Request) -> tuple[str, BackgroundTask | None]:
    """The task in the background that a request names, None for any other."""
    stated = request.captures.get("task") or request.query.get("task") or TASK
    found = (pair for pair in cabinet.behind.items() if pair[0].lower() == stated.lower())
    return next(found, (stated, None))


def _check_task(request: Request) -> None:
    """Raises Rejected for a task that there is not; one that nothing names is the only one."""
    stated = request.captures.get("task") or request.query.get("task") or TASK
    if stated.lower() != TASK.lower():
        raise Rejected(rws_messages.NO_TASK, stated)


def activate_task(cabinet: Cabinet, request: Request) -> Answer:
    return _set_active(cabinet, request, True)


def deactivate_task(cabinet: Cabinet, request: Request) -> Answer:
    return _set_active(cabinet, request, False)


def _set_active(cabinet: Cabinet, request: Request, active: bool) -> Answer:
    _check_task(request)

    def change(programs: Programs) -> None:
        if programs.running:
            raise NotPossible("the program runs")
        programs.active = active

    _command_programs(cabinet, change)
    return DONE


# ------------------------------------------------------------------------------ modules


def list_modules(cabinet: Cabinet, request: Request) -> Answer:
    task, behind = _background_task(cabinet, request)
    if behind is not None:
        kinds = {"type": "ProgMod"}
        rows = [
            Item("rap-module-info-li", f"{task}/{n}", {"name": n, **kinds}) for n in behind.modules
        ]
        return Answer(items=rows)
    _check_task(request)
    found = cabinet.do(lambda programs: list(programs.modules.values()))
    items = []
    for one in found:
        fields = {"name": one.name, "type": "SysMod" if one.system else "ProgMod"}
        items.append(Item("rap-module-info-li", f"{TASK}/{one.name}", fields))
    return Answer(items=items)


def _find_module(cabinet: Cabinet, request: Request) -> Module:
    _check_task(request)
    name = request.captures["module"]
    found = cabinet.do(lambda programs: programs.modules.get(name.lower()))
    if found is None:
        raise Rejected(rws_messages.NO_MODULE if request.dialect == 1 else rws_messages.NO_MODULE_2)
    return found


def module_facts(cabinet: Cabinet, request: Request) -> Answer:
    found = _find_module(cabinet, request)
    file = found.file.rpartition("/")[2] or f"{found.name}.mod"
    fields = {
        "modname": found.name,
        "filename": file,
        "attribute": "SysMod" if found.system else "ProgMod",
    }
    return Answer(items=[Item("rap-module", f"{TASK}/{found.name}", fields)])


def module_text(cabinet: Cabinet, request: Request) -> Answer:
    """RWS 1.0 has it percent-encoded."""
    _, behind = _background_task(cabinet, request)
    if behind is not None:
        said, count = _background_text(behind, request), 0
    else:
        found = _find_module(cabinet, request)
        if found.hidden:
            raise Rejected(rws_messages.NOT_PERMITTED, f"{found.name} is NOVIEW")
        said, count = cabinet.do(lambda programs: (programs.text(found), programs.changes))
    fields = {"change-count": str(count), "module-text": said}
    if request.dialect == 1:
        # RWS 1.0 escapes the complete text, line ends and blanks included.
        fields["module-text"] = quote(said, safe="")
    return Answer(items=[Item("rap-module-text", "moduletext", fields)])


def _background_text(behind: BackgroundTask, request: Request) -> str:
    name = request.captures["module"].lower()
    said = (text for module, text in behind.modules.items() if module.lower() == name)
    text = next(said, None)
    if text is None:
        raise Rejected(rws_messages.NO_MODULE if request.dialect == 1 else rws_messages.NO_MODULE_2)
    return text


def set_module_text(cabinet: Cabinet, request: Request) -> Answer:
    found = _find_module(cabinet, request)
    data = request.given("text").encode("utf-8")
    _load_modules(cabinet, [found.file or f"{found.name}.mod"], [data], replace=True)
    return DONE


def load_module(cabinet: Cabinet, request: Request) -> Answer:
    """Into a task in the background as well, where it takes the place of the one of its name."""
    _, behind = _background_task(cabinet, request)
    if behind is None:
        _check_task(request)
    path = path_of(cabinet, unit_path(request.given("modulepath")))
    try:
        data = read_file(path)
    except OSError:
        raise Rejected(rws_messages.NO_MODULE_FILE) from None
    if behind is not None:
        if behind.running:
            raise Rejected(rws_messages.WRONG_STATE, "the task runs")
        behind.modules.update(
            {one.name: _module_source(one) for one in _read_modules(cabinet, [path.name], [data])}
        )
        return DONE
    _load_modules(cabinet, [path.name], [data], request.form.get("replace", "").lower() == "true")
    return DONE


def _module_source(module: Module) -> str:
    return "" if module.tree.source is None else module.tree.source.text


def _read_modules(cabinet: Cabinet, files: list[str], datas: list[bytes]) -> list[Module]:
    try:
        return [one for f, d in zip(files, datas, strict=True) for one in read_module(f, d)]
    except NotPossible as wrong:
        cabinet.log.add(40160, str(wrong))
        raise Rejected(rws_messages.UNSPECIFIED, str(wrong)) from None


def _load_modules(cabinet: Cabinet, files: list[str], datas: list[bytes], replace: bool) -> None:
    read = _read_modules(cabinet, files, datas)
    _command_programs(cabinet, lambda programs: programs.load(read, replace))


def unload_module(cabinet: Cabinet, request: Request) -> Answer:
    name = request.given("module")
    _, behind = _background_task(cabinet, request)
    if behind is not None:
        raise Rejected(rws_messages.WRONG_STATE, "modules in the background stay loaded here")
    _check_task(request)
    try:
        _command_programs(cabinet, lambda programs: programs.unload(name))
    except KeyError:
        reason = (
            rws_messages.NO_MODULE_TO_UNLOAD if request.dialect == 1 else rws_messages.NO_MODULE_2
        )
        raise Rejected(reason) from None
    return DONE


def save_module(cabinet: Cabinet, request: Request) -> Answer:
    """Into a folder that the form names; RWS 1.0 ends the file in `.mod`, 2.0 in `.modx`."""
    found = _find_module(cabinet, request)
    folder = path_of(cabinet, unit_path(request.given("path")))
    file = folder / f"{request.form.get('name') or found.name}{request.either('.mod', '.modx')}"
    if file.parent != folder or not folder.is_dir():
        raise Rejected(rws_messages.NO_FILE if request.dialect == 1 else rws_messages.NO_PATH)
    said = cabinet.do(lambda programs: programs.text(found))
    try:
        write_whole(file, said.encode("latin-1" if request.dialect == 1 else "utf-8", "replace"))
    except OSError as wrong:
        raise Rejected(rws_messages.UNSPECIFIED, wrong.strerror or "") from None
    return DONE


def load_program(cabinet: Cabinet, request: Request) -> Answer:
    """A `.pgf` and the modules that it names, instead of all program modules that there are."""
    _check_task(request)
    path = path_of(cabinet, unit_path(request.given("progpath")))
    try:
        data = read_file(path)
        if b"<!" in data.replace(b"<!--", b""):  # no entity of a stranger is ever expanded
            raise ValueError
        root = ElementTree.fromstring(data)  # noqa: S314 - without document type, see above
        names = [(one.text or "").strip() for one in root.iter("Module")]
        if not names or any("/" in name or "\\" in name for name in names):
            raise ValueError
        datas = [read_file(path.parent / name) for name in names]
    except OSError:
        raise Rejected(rws_messages.NO_MODULE_FILE) from None
    except (ValueError, ElementTree.ParseError):
        raise Rejected(rws_messages.UNSPECIFIED, "no program file") from None
    # All modules were read above: a missing file leaves the old program loaded.
    if request.form.get("loadmode", "replace").lower() == "replace":
        _command_programs(cabinet, lambda programs: programs.unload_all())
    _load_modules(cabinet, names, datas, replace=True)
    return DONE


def program_facts(cabinet: Cabinet, request: Request) -> Answer:
    _check_task(request)
    there = cabinet.do(lambda programs: bool(programs.modules))
    if not there:
        return DONE
    return Answer(items=[Item("rap-program", "program", {"name": TASK, "entrypoint": MAIN})])


# ------------------------------------------------------------------------------ pointer


def read_pointer(cabinet: Cabinet, request: Request) -> Answer:
    """The names of the fields are the controller's own, `modulemame` among them."""
    if _background_task(cabinet, request)[1] is not None:
        return Answer(items=[])
    _check_task(request)
    found, count = cabinet.do(lambda programs: (programs.pointer(), programs.changes))
    if found is None:
        return Answer(items=[])
    place = f"{found.row},{found.column}"
    fields = {
        "modulemame": found.module,
        "routinename": found.routine,
        "beginposition": place,
        "endposition": place,
        "changecount": str(count),
        "executiontype": "Normal",
    }
    return Answer(items=[Item("pcp-info", "program-pointer", fields)])


def set_pointer(cabinet: Cabinet, request: Request) -> Answer:
    _check_task(request)
    routine, module = request.given("routine"), request.form.get("module", "")
    _command_programs(cabinet, lambda programs: programs.reset(routine, module))
    return DONE


_SYSTEM_MODULE: Final = "BASE"
"""The module of what every controller declares."""
_SYMBOL_KINDS: Final = {"PERS": ("pers", "per"), "VAR": ("var", "var"), "CONST": ("const", "con")}
"""By storage: what the class of a symbol ends in, and its `symtyp`."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class _Symbol:
    """A piece of data. module: empty for what every module knows of the controller itself."""

    module: str
    name: str
    cell: Cell
    local: bool = False

    @property
    def url(self) -> str:
        return f"RAPID/{TASK}/{self.module}/{self.name}"


def _all_symbols(machine: Machine) -> Iterator[_Symbol]:
    """Module data in the order of the modules; settled as far as it is simulated."""
    for unit in machine.modules.values():
        for name, meaning in unit.names.items():
            if isinstance(meaning, Cell):
                yield _Symbol(unit.name, name, meaning, True)
        for name, meaning in machine.named.items():
            # Data that all modules share is listed under the module that declares it.
            if isinstance(meaning, Cell) and _declaring_module(machine, name) == unit.name:
                yield _Symbol(unit.name, name, meaning)


def _declaring_module(machine: Machine, name: str) -> str:
    """The module that declares what all modules know."""
    for loaded, _ in machine.controller.programs:
        for file in loaded.files:
            for module in file.modules:
                for item in module.items:
                    if getattr(item, "name", "").lower() == name and not _is_local(item):
                        return module.name
    return ""


def _is_local(item: object) -> bool:
    return getattr(item, "scope", "") == "LOCAL" or bool(getattr(item, "local", False))


def _find_symbol(programs: Programs, module: str, name: str) -> tuple[Machine, _Symbol] | None:
    machine = programs.machine
    if machine is None:
        return None
    key = name.lower()
    # Local data hides shared data of the same name.
    for one in machine.modules.values():
        if one.name.lower() == module.lower() and isinstance(cell := one.names.get(key), Cell):
            return machine, _Symbol(one.name, name, cell, True)
    cell = machine.named.get(key)
    if isinstance(cell, Cell):
        home = _declaring_module(machine, key)
        if module.lower() in ("", home.lower()):
            return machine, _Symbol(home, name, cell)
    known = machine.predefined.get(key)
    if isinstance(known, Cell) and module.upper() in ("", _SYSTEM_MODULE):
        return machine, _Symbol(_SYSTEM_MODULE, name, known)
    return None


def _with_symbol(cabinet: Cabinet, request: Request, does: Callable[[Machine, _Symbol], T]) -> T:
    """Does something to the symbol that a request names, in the thread of the programs."""
    return _at_symbol(cabinet, request.captures["symbol"], _unknown_symbol(request), does)


def symbol_value_at(cabinet: Cabinet, dialect: int, path: str) -> str:
    """The value of data by `T_ROB1/module/name`; raises Rejected."""
    unknown = rws_messages.NO_EVENTS if dialect == 1 else rws_messages.NO_SYMBOL_2
    return _at_symbol(cabinet, path, unknown, _symbol_value)


def _at_symbol(
    cabinet: Cabinet, path: str, unknown: Reason, does: Callable[[Machine, _Symbol], T]
) -> T:
    parts = path.split("/")
    if parts[0].lower() != TASK.lower() or len(parts) not in (2, 3):
        raise Rejected(unknown)
    module, name = (parts[1], parts[2]) if len(parts) == 3 else ("", parts[1])

    def act(programs: Programs) -> T:
        found = _find_symbol(programs, module, name)
        if found is None:
            raise Rejected(unknown)
        machine, symbol = found
        try:
            # Data is evaluated on first use; a client may be the first to ask.
            if symbol.cell.pending is not None:
                settled(machine, symbol.cell)
        except (Fault, NotSimulated) as wrong:
            raise Rejected(rws_messages.UNSPECIFIED, str(wrong)) from None
        return does(machine, symbol)

    return cabinet.do(act)


def _unknown_symbol(request: Request) -> Reason:
    one = rws_messages.NO_SYMBOL if request.method == "GET" else rws_messages.NO_SYMBOL_2
    return one if request.dialect == 1 else rws_messages.NO_SYMBOL_2


def _symbol_value(machine: Machine, symbol: _Symbol) -> str:
    """Return the value of a symbol as RAPID writes it; raises Rejected for data without such a
    text.
    """
    value = symbol.cell.value
    try:
        if value is None:
            raise ValueError("it has no value")
        return value_text(value, symbol.cell.shape, machine.types)
    except ValueError as wrong:
        raise Rejected(rws_messages.UNSPECIFIED, str(wrong)) from None


def read_symbol(cabinet: Cabinet, request: Request) -> Answer:
    title, value = _with_symbol(cabinet, request, lambda m, one: (one.url, _symbol_value(m, one)))
    return Answer(items=[Item("rap-data", title, {"value": value})])


def write_symbol(cabinet: Cabinet, request: Request) -> Answer:
    text = request.given("value")

    def change(machine: Machine, symbol: _Symbol) -> None:
        cell = symbol.cell
        if cell.storage not in ("VAR", "PERS"):
            raise Rejected(rws_messages.NOT_PERMITTED, "it is a constant")
        value = read_value(text, cell.shape, machine.types)
        if value is None:
            raise Rejected(rws_messages.BAD_ARGUMENT, f"no {cell.shape.type}")
        try:
            Place(cell, "", cell.shape, cell.storage).set(value)
        except Fault as wrong:
            raise Rejected(rws_messages.BAD_ARGUMENT, str(wrong)) from None
        # Tasks that watch the data (IPers) see the change of a client as well.
        machine.look()

    _with_symbol(cabinet, request, change)
    return DONE


def symbol_properties(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(items=[_with_symbol(cabinet, request, lambda _, one: _symbol_item(one, ""))])


def _symbol_item(symbol: _Symbol, end: str) -> Item:
    kind, short = _SYMBOL_KINDS.get(symbol.cell.storage, ("var", "var"))
    shape = symbol.cell.shape
    fields = {
        "symburl": symbol.url,
        "name": symbol.name,
        "symtyp": short,
        "named": "true",
        "dattyp": shape.type,
        "ndim": str(len(shape.sizes)),
        "dim": " ".join(map(str, shape.sizes)),
        "local": str(symbol.local).lower(),
        "rdonly": str(symbol.cell.storage == "CONST").lower(),
        "taskvar": "false",
        "typurl": f"RAPID/{shape.type}",
    }
    return Item(f"rap-symprop{kind}{end}", symbol.url, fields)


def search_symbols(cabinet: Cabinet, request: Request) -> Answer:
    """Module data; of what one may state, `blockurl`, `symtyp`, `dattyp` and `regexp` count."""
    stated = request.form
    block = stated.get("blockurl", "RAPID").split("/")
    module = block[2].lower() if len(block) > 2 else ""
    if len(block) > 1 and block[1].lower() != TASK.lower():
        raise Rejected(rws_messages.NO_TASK, block[1])
    try:
        pattern = re.compile(stated.get("regexp", ""), re.IGNORECASE)
    except re.error:
        raise Rejected(rws_messages.BAD_ARGUMENT, "regexp") from None

    def find(programs: Programs) -> list[Item]:
        machine, items = programs.machine, []
        for one in () if machine is None else _all_symbols(machine):
            try:
                assert machine is not None
                settled(machine, one.cell)
            except (Fault, NotSimulated):
                continue  # Its type is not known here.
            if module in ("", one.module.lower()) and pattern.search(one.name):
                items.append(_symbol_item(one, "-li"))
        return items

    kind, type = stated.get("symtyp", "any"), stated.get("dattyp", "")
    return Answer(
        items=[
            one
            for one in cabinet.do(find)
            if kind in ("any", one.fields["symtyp"]) and type in ("", one.fields["dattyp"])
        ]
    )


def validate_value(cabinet: Cabinet, request: Request) -> Answer:
    """Check that a text is a value of a type."""
    text, type = request.given("value"), request.given("datatype", "dattyp")

    def check(programs: Programs) -> bool:
        types = programs.machine.types if programs.machine is not None else Types()
        try:
            return read_value(text, Shape(types.name(type)), types) is not None
        except NotSimulated:
            return False

    if not cabinet.do(check):
        raise Rejected(rws_messages.BAD_ARGUMENT, f"no {type}")
    return DONE
