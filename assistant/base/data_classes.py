"""Data classes that share their methods, so that a command starts sooner.

`dataclasses.dataclass` compiles up to seven functions for each class at each start of Python,
which took half the time of `check` on a small file. Here, `__eq__`, `__hash__`, `__repr__` and the
protection of frozen instances are closures over the field names, and classes with fields of the
same kinds share the code of `__init__`. Fields, slots, `replace`, `asdict` and `match` are those
of `dataclasses`, whose own decorator may be used on classes that inherit from these.
"""

from __future__ import annotations

import dataclasses
import reprlib
import sys
from collections.abc import Callable
from dataclasses import MISSING, Field, FrozenInstanceError, fields
from functools import cache
from operator import attrgetter
from types import FunctionType, MemberDescriptorType
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(cls=None, /, **options):
        """Add the methods of a data class; the options are those of `dataclasses.dataclass`.

        Raises TypeError for an `InitVar`.
        """
        if cls is None:
            return lambda undecorated: _build(undecorated, **options)
        return _build(cls, **options)


class _Absent:
    """Default of a field with a factory in signatures, shown as `dataclasses` shows it."""

    def __repr__(self) -> str:
        return "<factory>"


_ABSENT: Final = _Absent()


def _build(
    cls: type,
    *,
    frozen: bool = False,
    eq: bool = True,
    repr: bool = True,
    order: bool = False,
    **options: Any,
) -> type:
    """Return a data class; `dataclasses` builds the few with an order or an unsafe hash."""
    if order or options.get("unsafe_hash", False):
        options |= {"frozen": frozen, "eq": eq, "repr": repr, "order": order}
        return dataclasses.dataclass(**options)(cls)
    # A class that defines `__eq__` alone has a `__hash__` of None, which Python put there.
    defines_hash = "__hash__" in cls.__dict__ and not (
        cls.__hash__ is None and "__eq__" in cls.__dict__
    )
    # Without a docstring, `dataclasses` writes one of the signature, at the cost of all the rest.
    cls.__doc__ = cls.__doc__ or cls.__qualname__
    # Only `dataclasses` compares the protection of a class with that of its bases.
    inherits = any(dataclasses.is_dataclass(base) for base in cls.__bases__)
    protected = frozen and inherits
    built: type = dataclasses.dataclass(
        init=False, repr=False, eq=False, frozen=protected, **options
    )(cls)
    own = fields(built)
    for field in vars(built)["__dataclass_fields__"].values():
        if field not in own and "InitVar" in str(field.type):
            raise TypeError(f"{cls.__qualname__}.{field.name}: data classes here take no InitVar")
    methods: dict[str, Any] = {}
    if "__init__" not in built.__dict__:
        methods["__init__"] = _initializer(built, own, frozen, options.get("slots", False))
    if repr:
        methods["__repr__"] = _describe
    if eq:
        methods["__eq__"] = _comparison([field.name for field in own if field.compare])
        if not defines_hash:
            built.__hash__ = _hash(own) if frozen else None  # type: ignore[assignment]
    if frozen and not protected:
        methods |= {"__setattr__": _refuse_change, "__delattr__": _refuse_removal}
        if options.get("slots", False):
            methods |= {"__getstate__": _read_state, "__setstate__": _write_state}
    for name, method in methods.items():
        if name not in built.__dict__:
            setattr(built, name, method)
        elif name in ("__setattr__", "__delattr__"):
            raise TypeError(f"cannot overwrite {name} of frozen {cls.__qualname__}")
    parameters = vars(built)["__dataclass_params__"]
    parameters.init, parameters.repr, parameters.eq, parameters.frozen = True, repr, eq, frozen
    return built


def _initializer(cls: type, own: tuple[Field[Any], ...], frozen: bool, slots: bool) -> FunctionType:
    """Return `__init__`, a closure over the defaults and, if frozen, over the slots.

    The text has numbers for names, so that classes with fields of the same kinds share its code.
    own: fields of the class, inherited ones too.
    """
    closure: dict[str, Any] = {"absent": _ABSENT, "assign": object.__setattr__}
    positional = ["self"]
    by_name: list[str] = []
    body: list[str] = []
    for number, field in enumerate(own):
        name = value = f"_{number}"
        default = f"default{number}"
        has_factory = field.default_factory is not MISSING
        closure[default] = field.default_factory if has_factory else field.default
        if field.init:
            if has_factory:
                parameter = f"{name}=absent"
                value = f"{default}() if {name} is absent else {name}"
            else:
                parameter = name if field.default is MISSING else f"{name}={default}"
            (by_name if field.kw_only else positional).append(parameter)
        elif has_factory:
            value = f"{default}()"
        elif slots and field.default is not MISSING:
            value = default
        else:
            continue
        slot = getattr(cls, field.name, None)
        if not frozen:
            body.append(f"self.{name} = {value}")
        elif isinstance(slot, MemberDescriptorType):
            closure[f"assign{number}"] = slot.__set__
            body.append(f"assign{number}(self, {value})")
        else:
            closure[f"name{number}"] = field.name
            body.append(f"assign(self, name{number}, {value})")
    if hasattr(cls, "__post_init__"):
        body.append("self.__post_init__()")
    if by_name:
        by_name.insert(0, "*")
    create = _compile(", ".join(closure), ", ".join(positional + by_name), "; ".join(body))
    return _with_field_names(create(**closure), cls, own)


def _with_field_names(
    template: FunctionType, cls: type, own: tuple[Field[Any], ...]
) -> FunctionType:
    """Return the `__init__` of a class, made of one that has numbers for the names of fields."""
    names = {f"_{number}": field.name for number, field in enumerate(own)}
    code = template.__code__
    code = code.replace(
        co_names=tuple(names.get(name, name) for name in code.co_names),
        co_varnames=tuple(names.get(name, name) for name in code.co_varnames),
    )
    initializer = FunctionType(
        code,
        vars(sys.modules[cls.__module__]),
        "__init__",
        template.__defaults__,
        template.__closure__,
    )
    by_name_only = template.__kwdefaults__ or {}
    initializer.__kwdefaults__ = {names[name]: value for name, value in by_name_only.items()}
    initializer.__annotations__ = {field.name: field.type for field in own if field.init}
    initializer.__annotations__["return"] = None
    initializer.__qualname__ = f"{cls.__qualname__}.__init__"
    return initializer


@cache
def _compile(closure: str, parameters: str, body: str) -> Callable[..., FunctionType]:
    """Return a function that takes the variables of the closure and returns `__init__`."""
    namespace: dict[str, Any] = {}
    exec(  # noqa: S102 - the text holds numbers only, no name of a field
        f"def create({closure}):\n def __init__({parameters}): {body or 'pass'}\n return __init__",
        namespace,
    )
    create: Callable[..., FunctionType] = namespace["create"]
    return create


def _reader(names: list[str]) -> Callable[[Any], tuple[Any, ...]]:
    """Return a function that reads the fields of a record as a tuple."""
    if len(names) > 1:
        return attrgetter(*names)
    if names:
        read = attrgetter(*names)
        return lambda record: (read(record),)
    return lambda _: ()


def _comparison(names: list[str]) -> Callable[[Any, Any], bool]:
    read = _reader(names)

    def compare(self: Any, other: Any) -> bool:
        return read(self) == read(other) if other.__class__ is self.__class__ else NotImplemented

    return compare


def _hash(own: tuple[Field[Any], ...]) -> Callable[[Any], int]:
    read = _reader([f.name for f in own if (f.compare if f.hash is None else f.hash)])

    def compute(self: Any) -> int:
        return hash(read(self))

    return compute


@reprlib.recursive_repr()
def _describe(self: Any) -> str:
    shown = ", ".join(f"{f.name}={getattr(self, f.name)!r}" for f in fields(self) if f.repr)
    return f"{self.__class__.__qualname__}({shown})"


def _refuse_change(self: Any, name: str, value: object) -> None:
    _refuse(self, name, "assign to")
    object.__setattr__(self, name, value)


def _refuse_removal(self: Any, name: str) -> None:
    _refuse(self, name, "delete")
    object.__delattr__(self, name)


def _refuse(record: Any, name: str, action: str) -> None:
    """Raise FrozenInstanceError for any attribute of a data class, and for the fields alone of a
    plain class that inherits from one.
    """
    if "__dataclass_fields__" in type(record).__dict__ or name in record.__dataclass_fields__:
        raise FrozenInstanceError(f"cannot {action} field {name!r}")


def _read_state(self: Any) -> list[Any]:
    return [getattr(self, field.name) for field in fields(self)]


def _write_state(self: Any, state: list[Any]) -> None:
    for field, value in zip(fields(self), state, strict=True):
        object.__setattr__(self, field.name, value)
