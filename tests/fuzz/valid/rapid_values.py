"""Valid RAPID: calls, data and expressions, whatever a statement needs.

What a program needs is declared when it is needed, so each argument is there and fits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from random import Random
from typing import Final

from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.predefined import rows, signature
from assistant.languages.signatures import Parameter, Signature

DEEPEST: Final = 2
UNUSED: Final = "[9E9,9E9,9E9,9E9,9E9,9E9]"
ORIENTATIONS: Final = ("[1,0,0,0]", "[0,0,1,0]", "[0,0.707106781,0.707106781,0]", "[0,1,0,0]")
LEFT_OUT: Final = frozenset(
    ("argname", "present", "connect", "dim", "retry", "trynext", "isvar", "ispers")
)
"""Routines whose arguments are no data: a parameter, an array, names alone."""
OPERATORS: Final = {
    "num": ("+", "-", "*", "/", " DIV ", " MOD "),
    "dnum": ("+", "-", "*", "/"),
    "bool": (" AND ", " OR ", " XOR "),
    "string": ("+",),
    "pos": ("+", "-"),
    "orient": ("*",),
}
RELATIONS: Final = ("=", "<>", "<", ">", "<=", ">=")
SOURCES: Final = {"signaldi": "di1", "signaldo": "do1", "signalai": "ai1", "signalao": "ao1"}
DEVICES: Final = {
    **SOURCES,
    "signalgi": "gi1",
    "signalgo": "go1",
    "mecunit": "ROB_1",
    "taskid": "T_ROB1Id",
    "cameradev": "mycamera",
}


@dataclass(frozen=True, slots=True)
class Data:
    name: str
    type: str
    storage: str
    size: tuple[int, ...] = ()


@dataclass(slots=True)
class Made:
    """A module: its declarations and its routines, and what it has reached of the tables."""

    name: str
    declared: list[str] = field(default_factory=list)
    routines: list[str] = field(default_factory=list)


@cache
def calls(kind: str) -> tuple[str, ...]:
    """Standard routines of a kind."""
    return tuple(
        name
        for name, (line, _) in rows().items()
        if line.startswith(kind + " ") and name not in LEFT_OUT
    )


@cache
def functions(type: str) -> tuple[str, ...]:
    """Standard functions whose value is of a type."""
    found = (signature(name) for name in calls("FUNC"))
    return tuple(one.name.lower() for one in found if one is not None and one.result == type)


@cache
def constants(type: str) -> tuple[str, ...]:
    return tuple(d.name for d in predefined.data().values() if d.type == type)


class Values:
    """Draws values of a program, and keeps what of it is declared.

    reached: rows of the tables that it calls, in lower case.
    """

    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.reached: set[str] = set()
        self.data: list[Data] = []
        self.count = 0
        self.modules: list[Made] = []
        self.procs: list[tuple[str, Signature]] = []
        self.funcs: list[tuple[str, Signature]] = []
        self.traps: list[str] = []
        self.lines: list[str] = []
        self.labels: list[str] = []
        self.loops: list[str] = []
        self.records: dict[str, dict[str, str]] = {}
        self.own: list[Data] = []
        self.optional: list[str] = []
        self.result = ""

    # ----------------------------------------------------------------------------- calls

    def call(self, one: Signature | None, name: str = "") -> str:
        assert one is not None
        given = self.arguments(one, 0)
        return f"{name or one.name} {given};".replace(" ;", ";")

    def arguments(self, one: Signature, depth: int) -> str:
        self.reached.add(one.name.lower())
        rng, made, chosen = self.rng, "", rng_index(self.rng)
        for slot in one.slots:
            options = slot.alternatives
            if slot.optional:
                if rng.random() < 0.75:
                    continue
                parameter = rng.choice(options)
                value = self.value(parameter, depth)
                made += f"\\{parameter.name}" + (f":={value}" if value else "")
                continue
            parameter = options[chosen % len(options)]
            value = self.value(parameter, depth)
            made += ("," if made else "") + value
        return made

    def value(self, parameter: Parameter, depth: int) -> str:
        """Empty for a switch."""
        type, mode = parameter.type or "num", parameter.mode
        if type == "switch":
            return ""
        if parameter.dimensions:
            return self.array(type, mode or "VAR")
        if type == "anytype":
            type = self.rng.choice(("num", "string", "bool", "robtarget"))
            return self.variable(type, mode if mode in ("VAR", "PERS", "INOUT") else "INOUT")
        if type in DEVICES:
            return self.rng.choice((DEVICES[type], DEVICES[type].replace("1", "2")))
        if mode == "REF":
            return self.variable("num", "VAR")
        if mode:
            return self.variable(type, mode)
        return self.expression(type, depth + 1)

    # ------------------------------------------------------------------------------ data

    def name(self, stem: str) -> str:
        self.count += 1
        return f"{stem}{self.count}"

    def variable(self, type: str, mode: str) -> str:
        """Data that is there, or is declared now; an element or component at times."""
        rng = self.rng
        fits = {"VAR": ("VAR",), "PERS": ("PERS",)}.get(mode, ("VAR", "PERS", "INOUT"))
        found = [d for d in (*self.own, *self.data) if d.type == type and d.storage in fits]
        if type in ("tooldata", "wobjdata", "loaddata") and mode == "PERS" and rng.random() < 0.4:
            return {"tooldata": "tool0", "wobjdata": "wobj0", "loaddata": "load0"}[type]
        if found and rng.random() < 0.7:
            one = rng.choice(found)
            if one.size:
                return f"{one.name}{{{','.join(self.index(n) for n in one.size)}}}"
            return one.name
        if rng.random() < 0.1 and type == "num" and mode != "PERS":
            return f"{self.variable('robtarget', mode)}.trans.{rng.choice('xyz')}"
        return self.declared(type, "PERS" if mode == "PERS" else "VAR")

    def index(self, size: int) -> str:
        return self.rng.choice((str(size), "1", *self.loops[-1:]))

    def array(self, type: str, mode: str) -> str:
        found = [
            d
            for d in self.data
            if d.type == type
            and len(d.size) == 1
            and d.storage == ("PERS" if mode == "PERS" else "VAR")
        ]
        if found:
            return self.rng.choice(found).name
        name = self.name("arr")
        storage = "PERS" if mode == "PERS" else "VAR"
        first = "" if storage == "VAR" else f":=[{self.literal(type)},{self.literal(type)}]"
        self.declare(f"{storage} {type} {name}{{2}}{first};")
        self.data.append(Data(name, type, storage, (2,)))
        return name

    def declared(self, type: str, storage: str) -> str:
        rng, name, size = self.rng, self.name(type[:4]), tuple[int, ...]()
        if predefined.is_handle(type):
            self.declare(f"VAR {type} {name};")
            self.data.append(Data(name, type, "VAR"))
            return name
        if rng.random() < 0.1 and type not in self.records:
            size = rng.choice(((2,), (3,), (2, 2), (1, 2, 2)))
        first = f":={self.initial(type, size)}" if storage != "VAR" or rng.random() < 0.6 else ""
        if not self.complete(type):
            first = ""
        scope = rng.choice(("TASK ", "", "", "", "")) if storage == "PERS" else ""
        shape = f"{{{','.join(map(str, size))}}}" if size else ""
        self.declare(f"{scope}{storage} {type} {name}{shape}{first};")
        self.data.append(Data(name, type, storage, size))
        return f"{name}{{{','.join('1' for _ in size)}}}" if size else name

    def declare(self, line: str) -> None:
        self.rng.choice(self.modules).declared.append(line)

    def complete(self, type: str) -> bool:
        if type in self.records:
            return True
        known = predefined.types().get(type)
        return known is not None and not (known.kind == "RECORD" and known.components is None)

    def initial(self, type: str, size: tuple[int, ...]) -> str:
        if not size:
            return self.literal(type)
        return "[" + ",".join(self.initial(type, size[1:]) for _ in range(size[0])) + "]"

    def target(self) -> str:
        rng = self.rng
        x, y, z = rng.randint(250, 450), rng.randint(-150, 150), rng.choice((200, 300.5, 444.25))
        axes = UNUSED if rng.random() < 0.95 else "[100,9E9,9E9,9E9,9E9,9E9]"
        turns = rng.choice(("[0,0,0,0]", "[0,0,0,0]", "[-1,0,-1,0]", "[0,1,0,1]"))
        return f"[[{x},{y},{z}],{rng.choice(ORIENTATIONS)},{turns},{axes}]"

    def literal(self, type: str) -> str:
        """A value of literals alone."""
        rng = self.rng
        if type == "robtarget":
            return self.target()
        if type == "orient":
            return rng.choice(ORIENTATIONS)
        if type == "extjoint":
            return UNUSED
        if type in self.records:
            return "[" + ",".join(map(self.literal, self.records[type].values())) + "]"
        known = predefined.types().get(type)
        plain = known.of if known is not None and known.kind == "ALIAS" else type
        if plain in ("num", "dnum", ""):
            sign = rng.choice(("", "", "", "-"))
            return sign + rng.choice(("0", "1", "2", "10", "0.5", "12.75", "100", "1E3", "3."))
        if plain == "bool":
            return rng.choice(("TRUE", "FALSE"))
        if plain == "string":
            return rng.choice(('"part"', '""', '"a ""b"" \\\\c"', '"di1"', '"\\0D"', '"x y,z;!"'))
        if known is None or known.components is None:
            return "0"
        if type in ("speeddata", "zonedata", "loaddata", "tooldata", "inposdata"):
            return self.counted(type, known.components)
        if type == "wobjdata":  # nothing moves it, and the robot does not hold it
            return f'[FALSE,TRUE,"",{self.literal("pose")},{self.literal("pose")}]'
        return "[" + ",".join(map(self.literal, known.components.values())) + "]"

    def counted(self, type: str, parts: Mapping[str, str]) -> str:
        """A record whose numbers are not negative; the robot holds its tools."""
        values = [
            self.rng.choice(("5", "50", "0.5", "100"))
            if part == "num"
            else "TRUE"
            if type == "tooldata" and part == "bool"
            else self.literal(part)
            for part in parts.values()
        ]
        return f"[{','.join(values)}]"

    # ----------------------------------------------------------------------- expressions

    def expression(self, type: str, depth: int = 0) -> str:
        rng = self.rng
        if type in DEVICES:
            return DEVICES[type]
        if predefined.is_handle(type):
            return self.variable(type, "VAR")
        draw = rng.random()
        if depth >= DEEPEST or draw < 0.35:
            return self.leaf(type)
        if type == "bool" and draw < 0.7:
            return self.condition(depth)
        if type in OPERATORS and draw < 0.55:
            left, right = (self.term(type, depth) for _ in range(2))
            sign = rng.choice(OPERATORS[type])
            if sign in (" DIV ", " MOD "):
                right = rng.choice(("2", "7", "3"))
            return f"{left}{sign}{right}"
        if draw < 0.62:
            own = [pair for pair in self.funcs if pair[1].result == type]
            if own:
                name, one = rng.choice(own)
                return f"{name}({self.arguments(one, depth + 1)})"
        if draw < 0.9 and functions(type):
            one = signature(rng.choice(functions(type)))
            assert one is not None
            return f"{one.name}({self.arguments(one, depth + 1)})"
        if type == "robtarget":
            shift = ",".join(self.expression("num", 2) for _ in range(3))
            word = rng.choice(("Offs", "Offs", "RelTool"))
            turn = rng.choice(("", "\\Rz:=10", "\\Rx:=5\\Rz:=3")) if word == "RelTool" else ""
            return f"{word}({self.variable(type, 'VAR')},{shift}{turn})"
        known = predefined.types().get(type)
        if known is not None and known.components:
            if type in ("speeddata", "zonedata", "loaddata", "tooldata", "inposdata"):
                return self.counted(type, known.components)
            return "[" + ",".join(self.expression(t, 2) for t in known.components.values()) + "]"
        return self.leaf(type)

    def term(self, type: str, depth: int) -> str:
        text = self.expression(type, depth + 1)
        return text if text.isalnum() or text.endswith("}") or text[0] in '["' else f"({text})"

    def leaf(self, type: str) -> str:
        rng = self.rng
        if type == "num" and self.loops and rng.random() < 0.3:
            return rng.choice(self.loops)
        if constants(type) and rng.random() < 0.4:
            return rng.choice(constants(type))
        if rng.random() < 0.5 or not self.complete(type):
            return self.variable(type, "INOUT")
        if type == "num" and rng.random() < 0.1:
            return rng.choice(("0x1F", "0b101", "0o17", "1e-3", ".5"))
        return self.literal(type)

    def condition(self, depth: int) -> str:
        rng = self.rng
        draw = rng.random()
        if draw < 0.5:
            sign = rng.choice(RELATIONS)
            return f"{self.term('num', depth)}{sign}{self.term('num', depth)}"
        if draw < 0.6:
            return f"{self.term('string', depth)}{rng.choice(('=', '<>'))}{self.leaf('string')}"
        if draw < 0.75:
            signal = rng.choice(("di1", "do1", "di2"))
            return rng.choice((f"{signal}=1", f"{signal}=high", f"DOutput({signal})=0", "ai1>0.5"))
        if draw < 0.85:
            return f"NOT ({self.expression('bool', depth + 1)})"
        if self.optional and draw < 0.95:
            return f"Present({rng.choice(self.optional)})"
        return f"({self.expression('bool', depth + 1)})"


def rng_index(rng: Random) -> int:
    return rng.randrange(6)
