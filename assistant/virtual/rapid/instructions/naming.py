"""Procedures and data whose names are put together while the program runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.expressions import place_named
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.precision import digits
from assistant.virtual.rapid.scopes import Cell, Place
from assistant.virtual.rapid.statements import call_late


def _call_by_name(given: Given) -> None:
    """CallByVar: the name of a procedure, and the number at its end."""
    number = whole(given.number(1), "the number of a procedure")
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
