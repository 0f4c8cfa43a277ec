"""Data classes of `base.data_classes` behave as those of `dataclasses` do."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base import data_classes

DECORATORS: dict[str, Callable[..., Any]] = {
    "theirs": dataclasses.dataclass,
    "ours": data_classes.dataclass,
}

CLASSES = [
    "@dataclass\nclass Plain:\n    a: int\n    b: str = 'x'\n",
    "@dataclass(slots=True)\nclass Empty:\n    pass\n",
    "@dataclass(frozen=True, slots=True)\nclass Point:\n    x: float\n    y: float = 2.0\n",
    "@dataclass(frozen=True, slots=True)\nclass One:\n    x: float\n",
    "@dataclass(frozen=True)\nclass Wide:\n    x: int\n    y: int = field(default=1, repr=False)\n",
    "@dataclass(slots=True, kw_only=True)\nclass Named:\n    a: int = 1\n    b: int\n",
    "@dataclass(frozen=True, slots=True)\nclass Mixed:\n"
    "    a: int\n    b: list[int] = field(default_factory=list, kw_only=True)\n",
    "@dataclass(frozen=True, slots=True)\nclass Hidden:\n"
    "    a: int\n    b: int = field(default=3, compare=False)\n"
    "    c: int = field(default=3, hash=False)\n",
    "@dataclass(slots=True)\nclass Late:\n    a: int\n    b: int = field(init=False)\n"
    "    def __post_init__(self): self.b = self.a + 1\n",
    "@dataclass(frozen=True, slots=True)\nclass Settled:\n    a: int\n"
    "    b: int = field(init=False, default=4)\n"
    "    c: list[int] = field(init=False, default_factory=list)\n",
    "@dataclass(frozen=True, slots=True, eq=False)\nclass Single:\n    a: int\n",
    "@dataclass(frozen=True, eq=False, repr=False)\nclass Silent:\n    a: int\n",
    "@dataclass(frozen=True, slots=True, order=True)\nclass Ranked:\n    a: int\n    b: int = 0\n",
    "@dataclass(unsafe_hash=True)\nclass Unsafe:\n    a: int\n",
    "@dataclass(frozen=True, slots=True, weakref_slot=True)\nclass Watched:\n    a: int\n",
    "@dataclass(frozen=True, slots=True)\nclass Own:\n    a: int\n"
    "    def __eq__(self, other): return True\n    def __hash__(self): return 7\n"
    "    def __repr__(self): return 'own'\n",
    "@dataclass(frozen=True, slots=True)\nclass Alike:\n    a: int\n"
    "    def __eq__(self, other): return True\n",
    "@dataclass(slots=True)\nclass Built:\n    a: int\n    def __init__(self, b): self.a = b * 2\n",
    "@dataclass\nclass Counted:\n    count: ClassVar[int] = 3\n    a: int\n    __hash__ = None\n",
    "@dataclass(frozen=True, slots=True)\nclass Base:\n    a: int\n    b: int = 1\n"
    "@dataclass(frozen=True, slots=True)\nclass Derived(Base):\n    c: int = 2\n    a: int = 5\n",
    "@dataclass(frozen=True)\nclass Root:\n    a: int\nclass Leaf(Root):\n    pass\n",
]


def build(text: str, source: str) -> type:
    """Return the last class of a text, decorated by one of the two, in a module of its own."""
    module = ModuleType(f"{__name__}_{source}")
    sys.modules[module.__name__] = module
    vars(module)["dataclass"] = DECORATORS[source]
    heading = "from __future__ import annotations\nfrom dataclasses import field\n"
    exec(heading + "from typing import ClassVar\n" + text, vars(module))
    kinds = [kind for kind in vars(module).values() if isinstance(kind, type)]
    return kinds[-1]


def outcome(action: Callable[[], Any]) -> Any:
    """Return what an action gives, or the kind of its error."""
    try:
        return action()
    except Exception as error:  # noqa: BLE001 - the kind of any error is compared
        return type(error)


def is_refused(action: Callable[[], None]) -> bool:
    """True if an action fails; `dataclasses` raises TypeError from frozen slots by mistake."""
    return outcome(action) is not None


def observe(kind: type) -> dict[str, Any]:
    """Use a class in every way that a record is used."""
    seen: dict[str, Any] = {
        "signature": str(inspect.signature(kind)),
        "annotations": dict(kind.__init__.__annotations__),
        "fields": [(f.name, f.type, f.repr, f.compare) for f in dataclasses.fields(kind)],
        "match": kind.__match_args__,
        "slots": getattr(kind, "__slots__", None),
    }
    arguments = [(), (1,), (1, 2), (2, 1), (1, 2, 3), (1, 2, 3, 4)]
    made = [outcome(lambda given=given: kind(*given)) for given in arguments]
    made += [
        outcome(lambda: kind(a=1, b=2)),
        outcome(lambda: kind(x=1)),
        outcome(lambda: kind(z=1)),
    ]
    seen["made"] = [
        value if isinstance(value, type) else dataclasses.asdict(value) for value in made
    ]
    made = [value for value in made if not isinstance(value, type)]
    seen["equal"] = [[a == b for b in made] for a in made]
    seen["other"] = [value == 1 or value != 1 for value in made]
    seen["less"] = [outcome(lambda a=a, b=b: a < b) for a in made for b in made]
    for index, value in enumerate(made):
        own_hash = type(value).__hash__ is object.__hash__
        name = next((field.name for field in dataclasses.fields(kind)), "unknown")
        silent = type(value).__repr__ is object.__repr__
        seen[f"use {index}"] = [
            None if own_hash else outcome(lambda v=value: hash(v)),
            None if silent else repr(value),
            outcome(lambda v=value: dataclasses.asdict(copy.copy(v))),
            outcome(lambda v=value: dataclasses.asdict(copy.deepcopy(v))),
            outcome(lambda v=value: dataclasses.asdict(pickle.loads(pickle.dumps(v)))),
            outcome(lambda v=value, n=name: dataclasses.asdict(dataclasses.replace(v, **{n: 9}))),
            name == "unknown" or outcome(lambda v=value, n=name: setattr(v, n, 8)),
            is_refused(lambda v=value: setattr(v, "unknown", 8)),
            name == "unknown" or outcome(lambda v=value, n=name: delattr(v, n)),
            is_refused(lambda v=value: delattr(v, "unknown")),
            outcome(lambda v=value: dataclasses.asdict(v)),
        ]
    return seen


@pytest.mark.parametrize("text", CLASSES, ids=lambda text: text.split("class ")[-1].split(":")[0])
def test_a_class_behaves_as_one_of_dataclasses(text: str) -> None:
    assert observe(build(text, "ours")) == observe(build(text, "theirs"))


@st.composite
def class_texts(draw: st.DrawFn) -> str:
    options = {name: draw(st.booleans()) for name in ("frozen", "slots", "eq", "repr", "kw_only")}
    lines = []
    has_default = False
    for name in draw(st.lists(st.sampled_from("abxyz"), unique=True, max_size=5)):
        given = draw(st.sampled_from(["", "= 5", "repr", "compare", "factory", "init", "kw_only"]))
        match given:
            case "":
                line = "" if not has_default or options["kw_only"] else "= 1"
            case "= 5":
                line = given
            case "factory":
                line = "= field(default_factory=list)"
            case "init":
                line = "= field(init=False, default=3)"
            case "kw_only":
                line = "= field(kw_only=True)"
            case _:
                line = f"= field(default=2, {given}=False)"
        has_default |= line not in ("", "= field(kw_only=True)")
        lines.append(f"    {name}: int {line}\n")
    chosen = ", ".join(f"{name}={value}" for name, value in options.items())
    return f"@dataclass({chosen})\nclass Drawn:\n" + ("".join(lines) or "    pass\n")


@given(class_texts())
def test_any_class_behaves_as_one_of_dataclasses(text: str) -> None:
    assert observe(build(text, "ours")) == observe(build(text, "theirs"))


def test_a_record_in_itself_is_described() -> None:
    kind = build("@dataclass(slots=True)\nclass Loop:\n    a: object\n", "ours")
    loop = kind(1)
    loop.a = loop
    assert repr(loop) == "Loop(a=...)"


@pytest.mark.parametrize("base", ["ours", "theirs"])
@pytest.mark.parametrize("derived", ["ours", "theirs"])
@pytest.mark.parametrize("frozen", [(True, True), (False, False), (True, False), (False, True)])
def test_classes_of_both_kinds_inherit_from_each_other(
    base: str, derived: str, frozen: tuple[bool, bool]
) -> None:
    def use(base: str, derived: str) -> Any:
        module = ModuleType(f"{__name__}_both_{base}_{derived}")
        sys.modules[module.__name__] = module
        vars(module).update(base=DECORATORS[base], derived=DECORATORS[derived])
        exec(
            f"@base(frozen={frozen[0]}, slots=True)\nclass Base:\n    a: int\n    b: int = 1\n"
            f"@derived(frozen={frozen[1]}, slots=True)\nclass Derived(Base):\n    c: int = 2\n",
            vars(module),
        )
        return observe(module.Derived)

    plain = outcome(lambda: use("theirs", "theirs"))
    assert (plain is TypeError) == (frozen[0] != frozen[1])
    assert outcome(lambda: use(base, derived)) == plain


def test_the_options_of_a_class_can_be_read() -> None:
    text = "@dataclass(frozen=True, repr=False)\nclass Fixed:\n    a: int\n"
    ours, theirs = (vars(build(text, source))["__dataclass_params__"] for source in DECORATORS)
    assert repr(ours) == repr(theirs)


def test_an_argument_for_post_init_alone_is_refused() -> None:
    text = (
        "from dataclasses import InitVar\n"
        "@dataclass\nclass Given:\n    a: int\n    b: InitVar[int]\n"
        "    def __post_init__(self, b): self.a += b\n"
    )
    with pytest.raises(TypeError, match="InitVar"):
        build(text, "ours")


def test_a_frozen_class_with_its_own_protection_is_refused() -> None:
    text = (
        "@dataclass(frozen=True)\nclass Open:\n    a: int\n"
        "    def __setattr__(self, name, value): pass\n"
    )
    for source in DECORATORS:
        with pytest.raises(TypeError, match="__setattr__"):
            build(text, source)
