"""Functions of RAPID that other languages lack, as functions of the program.

The library is `tables/library.txt` and `tables/bytes.txt`, written in functions that other
languages have. A program gets those that it calls: `VectMagn(v)` becomes `vector_length(v)`. A
`dnum` becomes a `num`, and its functions those of `num`: `PowDnum(2,n)` is `Pow(2,n)`, as no
language here rounds a number of another program to the 24 bits of a `num`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, reduce
from importlib.resources import files
from typing import Any, Final, Protocol

from assistant.base import rotations
from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.parser import parse
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.walk import called, mentions, nodes
from assistant.program.rewriting import rewrite

_SAME_CALLS: Final[Mapping[str, str]] = {
    "vectmagn": "vector_length", "dotprod": "dot_product", "posevect": "vector_in",
    "orientzyx": "turn_of_angles", "norient": "unit_turn", "bitlsh": "bits_left",
    "bitrsh": "bits_right", "bitcheck": "has_bit", "strmatch": "text_found",
    "strmemb": "is_one_of", "strmap": "exchanged", "bitset": "set_bit", "bitclear": "clear_bit",
    "testandset": "taken_if_free",
}  # fmt: skip
"""Functions and instructions of RAPID, and those here that take the same arguments."""
_ROUNDING: Final = {"round": "rounded_to", "trunc": "cut_to"}
r"""Those with `\Dec`."""
_BITS: Final = {"bitand": "BitAndDnum", "bitor": "BitOrDnum", "bitxor": "BitXOrDnum"}
"""Functions of bytes, and those of wider numbers that say the same."""
_ANGLE_FUNCTIONS: Final = {"x": "angle_about_x", "y": "angle_about_y", "z": "angle_about_z"}
"""By option of EulerZYX."""
_TEXT_READERS: Final = {"num": "number_of_text", "bool": "truth_of_text"}
"""Library function that reads a text as data of a type: StrToVal."""
_TIME_DIGITS: Final = {"hour": 1, "min": 4, "sec": 7}
"""By option of GetTime, where its two digits begin in the time of day."""
_BYTE_FORMATS: Final = {"hex": (16, 2), "okt": (8, 3), "bin": (2, 8)}
"""By option of ByteToStr and StrToByte: the base, and how many digits a byte has (manual)."""
_LARGEST_BYTE: Final = 255
_FRAME_FUNCTION: Final = "frame_through"
"""Library function in place of DefFrame."""
_LARGEST_EXACT: Final = 1 << 23
"""Up to here a number of 32 bits has every whole one."""
TEST_AND_SET: Final = _SAME_CALLS["testandset"]
"""Library function that tests and sets a truth."""
QUATERNION_PART: Final = "part_of_turn"
QUATERNION_PRODUCT: Final = "turn_by"
ORIENTATION: Final = "rot"
_ANGLE_DECIMALS: Final = 9
"""Decimals of angles that are worked out: finer than a quaternion of single precision."""
QUATERNION: Final = ("q1", "q2", "q3", "q4")
TEXT_WRITERS: Final[Mapping[str, str]] = {
    "bool": "text_of_truth", "pose": "text_of_pose", "jointtarget": "text_of_joints",
}  # fmt: skip
"""By type of a value, what ValToStr of it is here."""
WHOLE_TYPES: Final = frozenset(("robtarget", "pose"))
"""Types of data that other languages keep whole, with angles instead of quaternions."""
_LIBRARY_FUNCTIONS: Final = frozenset(
    (
        *_SAME_CALLS, *_ROUNDING, *_BITS, "bitneg", "eulerzyx", "strtoval", "strfind", "distance",
        "numtostr", "strtobyte", "bytetostr", "gettime", "dectohex", "hextodec",
        "defframe", "text_and_number", "valtostr",
    )
)  # fmt: skip


ARM_FUNCTIONS: Final[Mapping[str, str]] = {
    "calcrobt": "target_of_joints", "calcjointt": "joints_of_target",
}  # fmt: skip
"""Kinematics functions with a tool in a work object, and their library equivalents for the flange
in the base.
"""


class ExpressionTypes(Protocol):
    """Knows what expressions are."""

    def kind(self, node: Any) -> tuple[str, int] | None:
        """Type without aliases and dimensions, None if that is not known."""

    def whole_turn(self, node: Any) -> s.Expression | None:
        """The target or pose that a node is the orientation of, if other languages keep it."""

    def is_own(self, name: str) -> bool:
        """True if the program has a routine of that name."""


@cache
def library() -> tuple[s.Routine, ...]:
    """All of them, without places in a text."""
    tables = files("assistant.languages.rapid.tables")
    texts = [tables.joinpath(name).read_text("utf-8") for name in ("library.txt", "bytes.txt")]
    modules = [module for text in texts for module in parse(text, runs=False).modules]

    def unplaced(node: Any) -> Any:
        # Positions in the library are none of the user's source, so findings must not point to
        # them.
        return replace(node, span=None) if isinstance(node, s.Node) and node.span else node

    items = (item for module in modules for item in module.items)
    routines = tuple(item for item in items if isinstance(item, s.Routine))
    return rewrite(routines, unplaced, ())


def with_library(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules, the first of them with the whole library if any of it may be called."""
    if not modules or not any(map(_may_call_library, nodes(tuple(modules)))):
        return modules
    taken = {one.name.lower() for m in modules for one in m.items if isinstance(one, s.Routine)}
    # A routine of the program with the name of a library routine would be called in its place.
    if not taken.isdisjoint(one.name.lower() for one in library()):
        return modules
    first, *others = modules
    return (replace(first, items=(*first.items, *library())), *others)


def without_uncalled(modules: Sequence[s.Module], read: Sequence[s.Module]) -> list[s.Module]:
    """The modules without what of the library nothing calls. read: before it was added."""
    own = {one.name.lower() for m in read for one in m.items if isinstance(one, s.Routine)}
    names = {one.name.lower() for one in library()} - own
    there = {
        item.name.lower(): item
        for m in modules
        for item in m.items
        if isinstance(item, s.Routine) and item.name.lower() in names
    }
    wanted: set[str] = set()
    others = [[i for i in m.items if id(i) not in set(map(id, there.values()))] for m in modules]
    pending: list[Any] = [tuple(items) for items in others]
    while pending:
        # A library routine may call others of the library.
        found = set(_called_functions(pending.pop())) & there.keys() - wanted
        wanted |= found
        pending += [there[name] for name in found]
    gone = {name for name in names if name not in wanted}

    def stays(item: s.Item) -> bool:
        match item:
            case s.Routine(name=name):
                return name.lower() not in gone
            case s.Data(name=name):
                # Data for the results of such a function is named after it.
                return not any(name.lower().startswith(f"{routine}_q") for routine in gone)
        return True

    made = []
    for module, before in zip(modules, read, strict=True):
        items = tuple(filter(stays, module.items))
        same = len(items) == len(before.items)
        same = same and all(a is b for a, b in zip(items, before.items, strict=True))
        made.append(before if same else replace(module, items=items))
    return made


def _called_functions(value: Any) -> Iterable[str]:
    for node in nodes(value):
        if isinstance(node, s.FunctionCall | s.ProcedureCall) and isinstance(node.name, str):
            yield node.name.lower()


def _may_call_library(node: Any) -> bool:
    match node:
        case s.FunctionCall(str(name)) | s.ProcedureCall(str(name)):
            return name.lower() in _LIBRARY_FUNCTIONS or name.lower() in ARM_FUNCTIONS
        case s.Component(name=name):
            return name.lower() == ORIENTATION or name.lower() in QUATERNION
        case s.Data(type=type) | s.ParameterNode(type=type):
            return type.lower() == "orient"
        case s.AggregateNode((_, s.AggregateNode(turn), *_)):  # a target that is worked out
            return len(turn) == len(QUATERNION) and not is_written_out(s.AggregateNode(turn))
        case s.Infix("=" | "<>", left, right):  # a pose with numbers, see `comparing`
            return isinstance(left, s.AggregateNode) or isinstance(right, s.AggregateNode)
    return False


_Arguments = tuple[s.Expression, ...]


def library_call(typed: ExpressionTypes, node: Any) -> Any:
    """A call of a function of RAPID as one of the library's; any other node as it is."""
    match node:
        case s.FunctionCall(str(name)) | s.ProcedureCall(str(name)):
            key = name.lower()
        case _:
            return node
    if key not in _LIBRARY_FUNCTIONS:
        return node
    call = called(node)
    if call is None or typed.is_own(name) or None in call.given:
        return node
    given = tuple(one for one in call.given if one is not None)
    options = {word.lower(): value for word, value in call.options.items()}
    if options:
        return _with_options(typed, key, given, options) or node
    if key in _SAME_CALLS:
        return _with_function(node, _SAME_CALLS[key], given)
    made = _POSITIONAL[key](typed, given) if key in _POSITIONAL else None
    return node if made is None else made


def _with_function(node: Any, name: str, given: tuple[s.Expression, ...]) -> Any:
    return replace(node, name=name, arguments=tuple(map(s.Positional, given)))


def function_call(name: str, *given: s.Expression) -> s.FunctionCall:
    return s.FunctionCall(name, tuple(map(s.Positional, given)))


def _with_options(
    typed: ExpressionTypes, key: str, given: _Arguments, options: Mapping[str, s.Expression | None]
) -> s.Expression | None:
    match key, given, dict(options):
        case (("round" | "trunc"), (value,), {"dec": s.Node() as places, **rest}) if not rest:
            return function_call(_ROUNDING[key], value, places)
        case "eulerzyx", (turn,), one if len(one) == 1 and typed.whole_turn(turn) is None:
            (axis,) = one
            return function_call(_ANGLE_FUNCTIONS[axis], turn) if axis in _ANGLE_FUNCTIONS else None
        case "defframe", (a, b, c), {"origin": s.Node() as origin, **rest} if not rest:
            return function_call(_FRAME_FUNCTION, a, b, c, origin)
        case "gettime", (), one if len(one) == 1 and (first := _TIME_DIGITS.get(*one)) is not None:
            return function_call(
                "two_digits", s.FunctionCall("CTime", ()), s.NumberLiteral(str(first))
            )
        case "strtobyte", (text,), {"char": None, **rest} if not rest:
            return None if _is_first_character(text) else _character_code(text)
        case "strtobyte", (text,), _ if (form := _byte_format(options)) is not None:
            return _from_digits(text, form[0], _LARGEST_BYTE)
        case "bytetostr", (value,), _ if (form := _byte_format(options)) is not None:
            return _to_digits(value, *form)
        case "strfind", (text, first, characters), {"notinset": None, **rest} if not rest:
            return function_call("one_found", text, first, characters, s.BoolLiteral(True))
    return None


def _byte_format(options: Mapping[str, s.Expression | None]) -> tuple[int, int] | None:
    """Base and digits of a byte that is written as an option says."""
    words = [_BYTE_FORMATS.get(word) for word, value in options.items() if value is None]
    return words[0] if len(words) == len(options) == 1 else None


def _from_digits(text: s.Expression, base: int, most: int) -> s.Expression:
    return function_call("number_of_digits", text, _number_literal(base), _number_literal(most))


def _to_digits(value: s.Expression, base: int, places: int) -> s.Expression:
    return function_call("digits_of_number", value, _number_literal(base), _number_literal(places))


def _is_first_character(text: s.Expression) -> bool:
    """True if a text is the first character of another one."""
    match text:
        case s.FunctionCall(name, (_, s.Positional(s.NumberLiteral("1")), last)):
            return name.lower() == "strpart" and last == s.Positional(s.NumberLiteral("1"))
    return False


def _character_code(text: s.Expression) -> s.Expression:
    """The code of a character as the one of the first of its text."""
    one = s.NumberLiteral("1")
    first = s.Positional(function_call("StrPart", text, one, one))
    return s.FunctionCall("StrToByte", (first, s.Option("Char")))


def _read_text(typed: ExpressionTypes, given: _Arguments) -> s.Expression | None:
    kind = typed.kind(given[1]) if len(given) == 2 else None
    place: Any = given[-1]
    if kind == ("pos", 0):
        return function_call(
            "position_of_text", given[0], *(s.Component(place, axis) for axis in "xyz")
        )
    name = _TEXT_READERS.get(kind[0]) if kind is not None and not kind[1] else None
    return None if name is None else function_call(name, *given)


_DECIMALS: Final = range(1, 7)
"""Decimals of a text that tell something of a number; for none there is a function."""


def _fixed_decimals(_: ExpressionTypes, given: _Arguments) -> s.Expression | None:
    # Computed decimals may be any number, so the library decides as the program runs.
    places = literal_number(given[1]) if len(given) == 2 else 0
    if places is not None and places not in _DECIMALS:
        return None
    return function_call("fixed_text", *given)


def _distance(typed: ExpressionTypes, given: _Arguments) -> s.Expression | None:
    both = [isinstance(one, s.Component) and one.name.lower() == "trans" for one in given]
    whole = [
        isinstance(one, s.Component) and typed.whole_turn(_orientation_beside(one)) for one in given
    ]
    # Distances between targets have a row of their own in `tables.equivalents`.
    return None if all(both) and all(whole) else function_call("distance_between", *given)


def _orientation_beside(node: s.Component) -> s.Component:
    """The orientation of what a node is the position of."""
    return s.Component(node.value, ORIENTATION)


def _bit_function(name: str) -> Callable[[ExpressionTypes, _Arguments], s.Expression | None]:
    def made(_: ExpressionTypes, given: _Arguments) -> s.Expression:
        wide = (function_call("NumToDnum", one) for one in given)
        return function_call("DnumToNum", function_call(_BITS[name], *wide))

    return made


_POSITIONAL: Final[Mapping[str, Callable[[ExpressionTypes, _Arguments], s.Expression | None]]] = {
    "strtoval": _read_text,
    "numtostr": _fixed_decimals,
    "distance": _distance,
    "strtobyte": lambda _, given: _from_digits(given[0], 10, _LARGEST_BYTE),
    "bytetostr": lambda _, given: _to_digits(given[0], 10, 1),
    "dectohex": lambda _, given: _to_digits(_from_digits(given[0], 10, _LARGEST_EXACT), 16, 1),
    "hextodec": lambda _, given: _to_digits(_from_digits(given[0], 16, _LARGEST_EXACT), 10, 1),
    "defframe": lambda _, given: function_call(_FRAME_FUNCTION, *given, s.NumberLiteral("1")),
    "strfind": lambda _, given: function_call("one_found", *given, s.BoolLiteral(False)),
    "bitneg": lambda _, given: s.Group(s.Infix("-", s.NumberLiteral("255"), s.Group(given[0]))),
    **{name: _bit_function(name) for name in _BITS},
}


# ----------------------------------------------------------------------------- quaternions


def quaternion_parts(place: s.Expression) -> Mapping[tuple[str, ...], s.Expression]:
    """The quaternion of a target or pose that has angles."""
    return {
        (name,): function_call(QUATERNION_PART, place, s.NumberLiteral(str(at)))
        for at, name in enumerate(QUATERNION, 1)
    }


def quaternion_angles(turn: Mapping[tuple[str, ...], s.Expression]) -> Sequence[s.Expression]:
    """The angles about z, y and x of a quaternion."""
    parts = [turn[(name,)] for name in QUATERNION]
    numbers = [float(n) for n in map(literal_number, parts) if n is not None]
    # A zero quaternion has no angles.
    if len(numbers) == len(parts) and any(numbers):
        angles = rotations.to_euler(rotations.canonical(numbers), "ZYX")
        return [_number_literal(round(float(angle), _ANGLE_DECIMALS)) for angle in angles]
    return [function_call(_ANGLE_FUNCTIONS[axis], s.AggregateNode(tuple(parts))) for axis in "zyx"]


def _number_literal(value: float) -> s.Expression:
    literal = s.NumberLiteral(repr(abs(value)))
    return s.Prefix("-", literal) if value < 0 else literal


def is_written_out(value: Any) -> bool:
    """True if a value consists only of literal numbers."""
    match value:
        case s.AggregateNode(items):
            return all(map(is_written_out, items))
    return literal_number(value) is not None


def sum_of_texts(parts: Sequence[s.Expression]) -> s.Expression:
    return reduce(lambda one, two: s.Infix("+", one, two), parts)


LONG: Final = "dnum"
_SHORT: Final = "num"
_CONVERSIONS: Final = frozenset(("numtodnum", "dnumtonum"))
"""Functions that give the same number as the other type."""
_RENAMED: Final = {"dnumtostr": "NumToStr"}
_BIT_FUNCTIONS: Final = frozenset(
    ("bitanddnum", "bitordnum", "bitxordnum", "bitnegdnum", "bitlshdnum")
)
"""Functions of more bits than those of a byte, which do something else there."""


def with_long_numbers(
    modules: Sequence[s.Module], files: Sequence[s.File]
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules of some files without such numbers, and the findings of each."""
    if not mentions(files, (LONG,)):
        return modules, [[] for _ in modules]
    items = (item for module in modules for item in module.items)
    own = {item.name.lower() for item in items if isinstance(item, s.Routine)}

    def short(node: Any) -> Any:
        match node:
            case s.Data(type=type) | s.ParameterNode(type=type) | s.Routine(type=type):
                return replace(node, type=_SHORT) if type.lower() == LONG else node
            case s.Alias(type=type):
                return replace(node, type=_SHORT) if type.lower() == LONG else node
            case s.Record(components=parts):
                made = tuple((_SHORT if of.lower() == LONG else of, name) for of, name in parts)
                return node if made == parts else replace(node, components=made)
            case s.Option(word, value) if word.lower() == LONG:
                return s.Option("Num", value)
            case s.FunctionCall(str(word), arguments) if word.lower() not in own:
                return _num_function(node, word.lower(), arguments)
        return node

    made = [rewrite(module, short, ()) for module in modules]
    return made, [list(_long_number_findings(module)) for module in modules]


def _num_function(node: s.FunctionCall, word: str, arguments: Sequence[s.Argument]) -> s.Expression:
    """A function of long numbers as that of others, if there is one that does the same."""
    match arguments:
        case (s.Positional(value), *_) if word in _CONVERSIONS:
            return s.Group(value)
    plain = _RENAMED.get(word) or node.name[: -len(LONG)]
    # These work on more bits than their namesakes of a byte.
    if (not word.endswith(LONG) and word not in _RENAMED) or word in _BIT_FUNCTIONS:
        return node
    return replace(node, name=plain) if signature(plain) is not None else node


def _long_number_findings(module: s.Module) -> Iterator[Diagnostic]:
    """A finding for each declaration of such a number."""
    for node in nodes(module):
        match node:
            case s.Data(type=type, name=name) | s.ParameterNode(type=type, name=name):
                if type.lower() == LONG:
                    yield rules.LONG_NUMBER(name=name, span=node.span)
            case s.Routine(type=type, name=name) if type.lower() == LONG:
                yield rules.LONG_NUMBER(name=name, span=node.span)
            case s.Record(name=name, components=parts):
                if any(of.lower() == LONG for of, _ in parts):
                    yield rules.LONG_NUMBER(name=name, span=node.span)
