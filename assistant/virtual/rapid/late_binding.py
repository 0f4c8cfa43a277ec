"""Late binding: modules that are loaded while the program runs, and names that are put together.

Manual, Save, Load, UnLoad, EraseModule, ModExist: a module that Load is to replace has to be
unloaded first. CallByVar, GetDataVal and SetDataVal find routines and data by name.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from assistant.base.diagnostics import Refused, has_errors
from assistant.base.file_access import write_whole
from assistant.base.source_text import SourceText
from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.controller import Loaded, load_modules, used_signals
from assistant.virtual.rapid.expressions import place_named, settled, whole
from assistant.virtual.rapid.machine import Function, Machine
from assistant.virtual.rapid.scopes import Cell, Place
from assistant.virtual.rapid.statements import call_late
from assistant.virtual.rapid.value_text import saved
from assistant.virtual.rapid.values import digits


def _module_path(given: Given, stated: str) -> Path:
    file = given.optional("file", "string")
    return given.machine.controller.disk.path(stated, file if isinstance(file, str) else "")


def _load_module(given: Given) -> None:
    machine, path = given.machine, _module_path(given, given.text(0))
    if not path.is_file():
        raise Fault(f"there is no file `{path.name}`", "ERR_FILNOTFND")
    file = _parsed_modules(path)
    # Checked before anything is declared.
    if any(module.name.lower() in machine.modules for module in file.modules):
        raise Fault(f"a module of `{path.name}` is loaded already", "ERR_LOADED")
    controller = machine.controller
    loaded = load_modules([file], machine.types, controller.persistents)
    # A shared persistent may be declared by any number of modules.
    twice = [
        name for name in loaded.named if name in machine.named and not _is_module(loaded, name)
    ]
    if twice:
        raise Fault(f"two meanings of the name `{twice[0]}`", UNSURE)
    # The module may use signals that no other one names.
    outputs, known = used_signals([file])
    controller.outputs |= outputs
    controller.known |= known
    controller.programs.append((loaded, machine.types))
    machine.named.update(loaded.named)
    machine.modules.update(loaded.units)
    machine.loaded[path] = loaded
    # The first values may use data of the other modules, so only now.
    for cell in loaded.cells:
        settled(machine, cell)


def _parsed_modules(path: Path) -> s.File:
    from assistant import languages

    rapid = languages.get("rapid")
    try:
        file = rapid.parse(rapid.read(path))
    except Refused as refused:
        raise Fault(f"`{path.name}` is not read: {refused}", "ERR_FILEACC") from None
    assert isinstance(file, s.File)
    if has_errors(file.findings):
        raise Fault(f"`{path.name}` has errors: {file.findings[0].message}", "ERR_SYNTAX")
    return file


def _is_module(loaded: Loaded, name: str) -> bool:
    """True if a name is that of a persistent that all modules share."""
    cell = loaded.named[name]
    return isinstance(cell, Cell) and cell.storage == "PERS"


def _unload_module(given: Given) -> None:
    machine, path = given.machine, _module_path(given, given.text(0))
    loaded = machine.loaded.get(path)
    if loaded is None:
        raise Fault(f"`{path.name}`, which was not loaded", "ERR_UNLOAD")
    # Before the removal: `saved` needs the values.
    text, source = saved(machine.controller, loaded.files[0]), loaded.files[0].source
    if given.has("save"):
        _keep_module(path, text, source)
    elif given.has("errifchanged") and source is not None and text != source.text:
        raise Fault(f"`{path.name}` has changed and is not saved", "ERR_NOTSAVED")
    _remove_module(machine, loaded)
    del machine.loaded[path]


def _erase_module(given: Given) -> None:
    """Erase a module that was loaded as a separate file."""
    machine, name = given.machine, given.text(0)
    unit = machine.modules.get(name.lower())
    if unit is None:
        raise Fault(f"there is no module `{name}`", "ERR_MODULE")
    for loaded, _ in machine.controller.programs:
        if len(loaded.units) == 1 and loaded.units.get(name.lower()) is unit:
            _remove_module(machine, loaded)
            machine.loaded = {p: one for p, one in machine.loaded.items() if one is not loaded}
            return
    raise NotSimulated(f"EraseModule of `{name}`, which was not loaded by itself")


def _remove_module(machine: Machine, loaded: Loaded) -> None:
    units = list(loaded.units.values())
    # The callers on the stack run as well.
    if any(frame.unit in units for frame in machine.frames):
        raise Fault("a module that runs is unloaded", "ERR_UNLOAD")
    controller = machine.controller
    controller.programs = [one for one in controller.programs if one[0] is not loaded]
    for name, meaning in loaded.named.items():
        # A shared persistent lives as long as a module declares it.
        elsewhere = any(one.named.get(name) is meaning for one, _ in controller.programs)
        if not elsewhere:
            machine.named.pop(name, None)
            if controller.persistents.get(name) is meaning:
                del controller.persistents[name]
    for name in loaded.units:
        machine.modules.pop(name, None)
    for file in loaded.files:
        for module in file.modules:
            for item in module.items:
                if isinstance(item, s.Record | s.Alias):
                    machine.types.records.pop(item.name.lower(), None)
                    machine.types.aliases.pop(item.name.lower(), None)


def _save_module(given: Given) -> None:
    r"""To where \FilePath tells, else to where the module was loaded from."""
    machine, name = given.machine, given.text(0)
    file = _module_file(machine, name)
    stated = given.optional("filepath", "string")
    if isinstance(stated, str):
        path = _module_path(given, stated)
    else:
        paths = (path for path, one in machine.loaded.items() if file in one.files)
        found = next(paths, None)
        if found is None:
            raise NotSimulated(f"Save of `{name}` without a path, which no Load has read")
        path = found
    _keep_module(path, saved(machine.controller, file), file.source)


def _module_file(machine: Machine, name: str) -> s.File:
    unit = machine.modules.get(name.lower())
    for loaded, _ in machine.controller.programs:
        if unit is not None and loaded.units.get(name.lower()) is unit:
            for file in loaded.files:
                if any(module.name.lower() == name.lower() for module in file.modules):
                    return file
    raise Fault(f"there is no module `{name}`", "ERR_MODULE")


def _keep_module(path: Path, text: str, source: SourceText | None) -> None:
    encoding = "latin-1" if source is None else source.encoding
    try:
        write_whole(path, text.encode(encoding, "replace"))
    except OSError as error:
        raise Fault(f"`{path.name}` is not saved: {error.strerror}", "ERR_PATH") from None


def _module_exists(given: Given) -> bool:
    return given.text(0).lower() in given.machine.modules


MODULE_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("Load", 1, _load_module, "dynamic file checkref"),
        table_row("UnLoad", 1, _unload_module, "file save errifchanged"),
        table_row("EraseModule", 1, _erase_module),
        table_row("Save", 1, _save_module, "filepath file"),
    )
)
MODULE_FUNCTIONS: Final[Mapping[str, Function]] = dict((table_row("ModExist", 1, _module_exists),))


def _call_by_name(given: Given) -> None:
    """CallByVar: the name of a procedure, and the number at its end."""
    number = whole(given.number(1), "the number of a procedure")
    # A procedure called so has no parameters.
    call_late(given.machine, f"{given.text(0)}{number}", ())


def _named_data(given: Given) -> Place:
    name = given.text(0)
    if not isinstance(given.machine.meaning(name), Cell):
        raise Fault(f"there is no data `{name}`", "ERR_SYM_ACCESS")
    return place_named(given.machine, name)


def _get_data(given: Given) -> None:
    source, target = _named_data(given), given.place(1)
    _same_type(source, target)
    target.set(source.get())


def _set_data(given: Given) -> None:
    target, source = _named_data(given), given.place(1)
    _same_type(source, target)
    if target.storage == "CONST":
        raise Fault(f"`{given.text(0)}` is a constant", "ERR_SYM_ACCESS")
    target.set(source.get())


def _same_type(one: Place, other: Place) -> None:
    if one.shape != other.shape:
        message = f"data of type {one.shape.type} and of type {other.shape.type}"
        raise Fault(message, "ERR_SYMBOL_TYPE")


def _check_names(given: Given) -> None:
    """TryInt: whether a number is whole, and not too large to be so exactly."""
    value = given.number(0)
    if not value.is_integer():
        raise Fault(f"{value:g}, which is no whole number", "ERR_INT_NOTVAL")
    # Within these a num and a dnum count as integers (reference, data types num and dnum).
    if abs(value) > (1 << 23 if digits(value) == 6 else 1 << 52):
        raise Fault(f"{value:g}, which is too large", "ERR_INT_MAXVAL")


NAME_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("CallByVar", 2, _call_by_name),
        table_row("GetDataVal", 2, _get_data),
        table_row("SetDataVal", 2, _set_data),
        table_row("TryInt", 1, _check_names),
    )
)
