"""`/rw/rapid`: execution, tasks, modules, and the program pointer."""

from __future__ import annotations

from typing import Final, Literal
from urllib.parse import quote
from xml.etree import ElementTree

from assistant.base.file_access import read_file, write_whole
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
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.irc5.rws.resources.files import path_of, unit_path

CYCLE_MODES: Final[dict[str, Cycle | None]] = {"once": "once", "forever": "forever", "asis": None}
STOP_MODES: Final[dict[str, Literal["once", "cycle", "instruction"]]] = {
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
        ("cycle", tuple(CYCLE_MODES)),
    ):
        if request.form.get(name, allowed[0]) not in allowed:
            raise Rejected(reasons.BAD_ARGUMENT, f"{name} {request.form[name]}")
    if cabinet.panel.state != "motoron":
        raise Rejected(reasons.WRONG_STATE, f"the controller is in {cabinet.panel.state}")
    cycle = CYCLE_MODES[request.form.get("cycle", "asis")]
    _command_programs(cabinet, lambda programs: programs.start(cycle))
    return DONE


def stop_execution(cabinet: Cabinet, request: Request) -> Answer:
    wanted = request.form.get("stopmode", "stop")
    if wanted not in STOP_MODES:
        raise Rejected(reasons.BAD_ARGUMENT, f"stopmode {wanted}")
    _command_programs(cabinet, lambda programs: programs.stop(STOP_MODES[wanted]))
    return DONE


def reset_pointer(cabinet: Cabinet, request: Request) -> Answer:
    _command_programs(cabinet, lambda programs: programs.reset())
    return DONE


def start_production(cabinet: Cabinet, request: Request) -> Answer:
    _command_programs(cabinet, lambda programs: programs.reset())
    return start_execution(cabinet, request)


def set_cycle(cabinet: Cabinet, request: Request) -> Answer:
    wanted = CYCLE_MODES.get(request.given("cycle"))
    if wanted is None:
        raise Rejected(reasons.BAD_ARGUMENT, "cycle")

    def change(programs: Programs) -> None:
        programs.cycle = wanted

    _command_programs(cabinet, change)
    return DONE


def _command_programs(cabinet: Cabinet, command: object) -> None:
    assert callable(command)
    try:
        cabinet.do(command)
    except NotPossible as wrong:
        raise Rejected(reasons.WRONG_STATE, str(wrong)) from None


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
        raise Rejected(reasons.NO_TASK, stated)


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
        raise Rejected(reasons.NO_MODULE if request.dialect == 1 else reasons.NO_MODULE_2)
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
            raise Rejected(reasons.NOT_PERMITTED, f"{found.name} is NOVIEW")
        said, count = cabinet.do(lambda programs: (programs.text(found), programs.changes))
    fields = {"change-count": str(count), "module-text": said}
    if request.dialect == 1:
        fields["module-text"] = quote(said, safe="")
    return Answer(items=[Item("rap-module-text", "moduletext", fields)])


def _background_text(behind: BackgroundTask, request: Request) -> str:
    name = request.captures["module"].lower()
    said = (text for module, text in behind.modules.items() if module.lower() == name)
    text = next(said, None)
    if text is None:
        raise Rejected(reasons.NO_MODULE if request.dialect == 1 else reasons.NO_MODULE_2)
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
        raise Rejected(reasons.NO_MODULE_FILE) from None
    if behind is not None:
        if behind.running:
            raise Rejected(reasons.WRONG_STATE, "the task runs")
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
        raise Rejected(reasons.UNSPECIFIED, str(wrong)) from None


def _load_modules(cabinet: Cabinet, files: list[str], datas: list[bytes], replace: bool) -> None:
    read = _read_modules(cabinet, files, datas)
    _command_programs(cabinet, lambda programs: programs.load(read, replace))


def unload_module(cabinet: Cabinet, request: Request) -> Answer:
    name = request.given("module")
    _, behind = _background_task(cabinet, request)
    if behind is not None:
        raise Rejected(reasons.WRONG_STATE, "modules in the background stay loaded here")
    _check_task(request)
    try:
        _command_programs(cabinet, lambda programs: programs.unload(name))
    except KeyError:
        reason = reasons.NO_MODULE_TO_UNLOAD if request.dialect == 1 else reasons.NO_MODULE_2
        raise Rejected(reason) from None
    return DONE


def save_module(cabinet: Cabinet, request: Request) -> Answer:
    """Into a folder that the form names; RWS 1.0 ends the file in `.mod`, 2.0 in `.modx`."""
    found = _find_module(cabinet, request)
    folder = path_of(cabinet, unit_path(request.given("path")))
    file = folder / f"{request.form.get('name') or found.name}{request.either('.mod', '.modx')}"
    if file.parent != folder or not folder.is_dir():
        raise Rejected(reasons.NO_FILE if request.dialect == 1 else reasons.NO_PATH)
    said = cabinet.do(lambda programs: programs.text(found))
    try:
        write_whole(file, said.encode("latin-1" if request.dialect == 1 else "utf-8", "replace"))
    except OSError as wrong:
        raise Rejected(reasons.UNSPECIFIED, wrong.strerror or "") from None
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
        raise Rejected(reasons.NO_MODULE_FILE) from None
    except (ValueError, ElementTree.ParseError):
        raise Rejected(reasons.UNSPECIFIED, "no program file") from None
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
