"""`/rw/rapid/symbol`: RAPID data that is read, written, searched for and checked."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, TypeVar

from assistant.virtual.irc5.cabinet import Cabinet
from assistant.virtual.irc5.programs import TASK, Programs
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Reason, Rejected
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.expressions import settled
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.scopes import Cell, Place
from assistant.virtual.rapid.types import Types
from assistant.virtual.rapid.values import Shape
from assistant.virtual.rapid.written import read_value, value_text

SYSTEM_MODULE: Final = "BASE"
"""The module of what every controller declares."""
SYMBOL_KINDS: Final = {"PERS": ("pers", "per"), "VAR": ("var", "var"), "CONST": ("const", "con")}
"""By storage: what the class of a symbol ends in, and its `symtyp`."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Symbol:
    """A piece of data. module: empty for what every module knows of the controller itself."""

    module: str
    name: str
    cell: Cell
    local: bool = False

    @property
    def url(self) -> str:
        return f"RAPID/{TASK}/{self.module}/{self.name}"


def _all_symbols(machine: Machine) -> Iterator[Symbol]:
    """Module data in the order of the modules; settled as far as it is simulated."""
    for unit in machine.modules.values():
        for name, meaning in unit.names.items():
            if isinstance(meaning, Cell):
                yield Symbol(unit.name, name, meaning, True)
        for name, meaning in machine.named.items():
            if isinstance(meaning, Cell) and _declaring_module(machine, name) == unit.name:
                yield Symbol(unit.name, name, meaning)


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


def _find_symbol(programs: Programs, module: str, name: str) -> tuple[Machine, Symbol] | None:
    machine = programs.machine
    if machine is None:
        return None
    key = name.lower()
    for one in machine.modules.values():
        if one.name.lower() == module.lower() and isinstance(cell := one.names.get(key), Cell):
            return machine, Symbol(one.name, name, cell, True)
    cell = machine.named.get(key)
    if isinstance(cell, Cell):
        home = _declaring_module(machine, key)
        if module.lower() in ("", home.lower()):
            return machine, Symbol(home, name, cell)
    known = machine.predefined.get(key)
    if isinstance(known, Cell) and module.upper() in ("", SYSTEM_MODULE):
        return machine, Symbol(SYSTEM_MODULE, name, known)
    return None


def _with_symbol(cabinet: Cabinet, request: Request, does: Callable[[Machine, Symbol], T]) -> T:
    """Does something to the symbol that a request names, in the thread of the programs."""
    return _at_symbol(cabinet, request.captures["symbol"], _unknown_symbol(request), does)


def symbol_value_at(cabinet: Cabinet, dialect: int, path: str) -> str:
    """The value of data by `T_ROB1/module/name`; raises Rejected."""
    unknown = reasons.NO_EVENTS if dialect == 1 else reasons.NO_SYMBOL_2
    return _at_symbol(cabinet, path, unknown, symbol_value)


def _at_symbol(
    cabinet: Cabinet, path: str, unknown: Reason, does: Callable[[Machine, Symbol], T]
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
            if symbol.cell.pending is not None:
                settled(machine, symbol.cell)
        except (Fault, NotSimulated) as wrong:
            raise Rejected(reasons.UNSPECIFIED, str(wrong)) from None
        return does(machine, symbol)

    return cabinet.do(act)


def _unknown_symbol(request: Request) -> Reason:
    one = reasons.NO_SYMBOL if request.method == "GET" else reasons.NO_SYMBOL_2
    return one if request.dialect == 1 else reasons.NO_SYMBOL_2


def symbol_value(machine: Machine, symbol: Symbol) -> str:
    """As RAPID writes it; raises Rejected for data that has no such text."""
    value = symbol.cell.value
    try:
        if value is None:
            raise ValueError("it has no value")
        return value_text(value, symbol.cell.shape, machine.types)
    except ValueError as wrong:
        raise Rejected(reasons.UNSPECIFIED, str(wrong)) from None


def read_symbol(cabinet: Cabinet, request: Request) -> Answer:
    title, value = _with_symbol(cabinet, request, lambda m, one: (one.url, symbol_value(m, one)))
    return Answer(items=[Item("rap-data", title, {"value": value})])


def write_symbol(cabinet: Cabinet, request: Request) -> Answer:
    text = request.given("value")

    def change(machine: Machine, symbol: Symbol) -> None:
        cell = symbol.cell
        if cell.storage not in ("VAR", "PERS"):
            raise Rejected(reasons.NOT_PERMITTED, "it is a constant")
        value = read_value(text, cell.shape, machine.types)
        if value is None:
            raise Rejected(reasons.BAD_ARGUMENT, f"no {cell.shape.type}")
        try:
            Place(cell, "", cell.shape, cell.storage).set(value)
        except Fault as wrong:
            raise Rejected(reasons.BAD_ARGUMENT, str(wrong)) from None
        machine.look()

    _with_symbol(cabinet, request, change)
    return DONE


def symbol_properties(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(items=[_with_symbol(cabinet, request, lambda _, one: _symbol_item(one, ""))])


def _symbol_item(symbol: Symbol, end: str) -> Item:
    kind, short = SYMBOL_KINDS.get(symbol.cell.storage, ("var", "var"))
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
        raise Rejected(reasons.NO_TASK, block[1])
    try:
        pattern = re.compile(stated.get("regexp", ""), re.IGNORECASE)
    except re.error:
        raise Rejected(reasons.BAD_ARGUMENT, "regexp") from None

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
    """Whether a text is a value of a type."""
    text, type = request.given("value"), request.given("datatype", "dattyp")

    def check(programs: Programs) -> bool:
        types = programs.machine.types if programs.machine is not None else Types()
        try:
            return read_value(text, Shape(types.name(type)), types) is not None
        except NotSimulated:
            return False

    if not cabinet.do(check):
        raise Rejected(reasons.BAD_ARGUMENT, f"no {type}")
    return DONE
