"""Valid RAPID: every row of the tables is called with arguments of its types.

What a program needs is declared when it is needed, so each argument is there and fits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from random import Random
from typing import Final

from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.signatures import rows, signature
from assistant.languages.signatures import Parameter, Signature, Slot
from tests.fuzz.valid.layout import odd

DEEPEST: Final = 2
UNUSED: Final = "[9E9,9E9,9E9,9E9,9E9,9E9]"
ORIENTATIONS: Final = ("[1,0,0,0]", "[0,0,1,0]", "[0,0.707106781,0.707106781,0]", "[0,1,0,0]")
LEFT_OUT: Final = frozenset(
    ("argname", "present", "connect", "dim", "retry", "trynext", "isvar", "ispers")
)
"""Routines whose arguments are no data: a parameter, an array, names alone."""
USUAL: Final = (
    *("MoveL", "MoveL", "MoveJ", "MoveAbsJ", "MoveC", "WaitTime", "SetDO", "Set", "Reset", "SetAO"),
    *("SetGO", "PulseDO", "WaitDI", "WaitDO", "WaitUntil", "TPWrite", "Incr", "Decr", "Add"),
    *("Clear", "Stop", "AccSet", "VelSet", "ConfL", "ConfJ", "SingArea", "TriggL", "TriggJ"),
    *("TriggIO", "TriggEquip", "MoveLDO", "MoveJDO", "MoveLAO", "SpeedRefresh", "GripLoad"),
    *("TPErase", "ClkReset", "ClkStart", "ClkStop", "IDelete", "ISignalDI", "SoftAct", "WaitAI"),
    *("WaitGI", "MoveLSync", "TriggC", "SearchL", "PDispOn", "PDispSet", "EOffsSet", "ActUnit"),
    *("TPReadNum", "TPReadFK", "InvertDO", "ITimer", "StopMove", "StorePath", "CallByVar"),
)
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
ERRORS: Final = ("ERR_WAIT_MAXTIME", "ERR_DIVZERO", "ERR_PATH_STOP", "101")


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


class Rapid:
    """Draws one program. reached: rows of the tables that it calls, in lower case."""

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

    # ------------------------------------------------------------------------- the whole

    def program(self) -> str:
        rng = self.rng
        names = ["Cell", *rng.sample(["Tools", "Points", "Work"], rng.choice((0, 0, 0, 1)))]
        self.modules = [Made(name) for name in names]
        self.types()
        heads = [self.head() for _ in range(rng.choice((0, 1, 1, 2)))]
        for _ in range(rng.choice((0, 0, 0, 1))):
            self.traps.append(self.name("trap"))
        self.routine("PROC", "main", Signature("main", "PROC"))
        for kind, name, one in heads:
            self.routine(kind, name, one)
        for name in self.traps:
            self.routine("TRAP", name, Signature(name, "TRAP"))
        if rng.random() < 0.12:
            self.table()
        texts = [self.module(one, at) for at, one in enumerate(self.modules)]
        return odd("\n".join(texts), rng)

    def module(self, made: Made, at: int) -> str:
        rng = self.rng
        attributes = rng.choice(("", "", "", "(NOSTEPIN)", "(SYSMODULE)", "(VIEWONLY,SYSMODULE)"))
        lines = [f"MODULE {made.name}{attributes if at else ''}"]
        for line in made.declared:
            lines.append(f"  {line}")
            if rng.random() < 0.05:
                lines.append(rng.choice(("  ! data; of the cell", '!* [1,2] "x"', "  !")))
        return "\n".join([*lines, *made.routines, "ENDMODULE", ""])

    def types(self) -> None:
        rng = self.rng
        if rng.random() < 0.15:
            name = self.name("rec")
            parts = {
                f"c{n}": rng.choice(("num", "bool", "string", "pos", "robtarget"))
                for n in range(rng.randint(1, 3))
            }
            self.records[name] = parts
            text = " ".join(f"{type} {part};" for part, type in parts.items())
            self.modules[0].declared.insert(0, f"RECORD {name} {text} ENDRECORD")
        if rng.random() < 0.05:
            self.modules[0].declared.append(f"ALIAS num {self.name('ali')};")

    def head(self) -> tuple[str, str, Signature]:
        """A routine that others may call before it is drawn."""
        rng = self.rng
        kind = rng.choice(("PROC", "PROC", "FUNC"))
        name = self.name(rng.choice(("rPick", "Glue", "home", "f")))
        slots = []
        for n in range(rng.choice((0, 0, 1, 2))):
            type = rng.choice(("num", "num", "bool", "string", "robtarget", "tooldata", "pos"))
            mode = rng.choice(("", "", "VAR", "PERS", "INOUT"))
            array = -1 if rng.random() < 0.1 else 0
            optional = rng.random() < 0.2
            one = Parameter(f"a{n}", type, mode, array)
            options: tuple[Parameter, ...] = (one,)
            if optional:
                options = rng.choice(((one,), (one, Parameter(f"s{n}", "switch"))))
            slots.append(Slot(options, optional))
        result = rng.choice(("num", "bool", "robtarget", "string")) if kind == "FUNC" else ""
        one = Signature(name, kind, tuple(slots), result)
        (self.funcs if kind == "FUNC" else self.procs).append((name, one))
        return kind, name, one

    def routine(self, kind: str, name: str, one: Signature) -> None:
        rng = self.rng
        made = rng.choice(self.modules)
        if name == "main":
            made = self.modules[0]
        before, self.own, self.lines, self.labels = self.data, [], [], []
        self.loops, self.optional, self.result = [], [], one.result
        locals: list[str] = []
        for slot in one.slots:
            for parameter in slot.alternatives:
                if parameter.type != "switch" and not slot.optional:
                    storage = parameter.mode or "VAR"
                    storage = "INOUT" if storage == "INOUT" else storage
                    size = (1,) if parameter.dimensions else ()
                    self.own.append(Data(parameter.name, parameter.type, storage, size))
                if slot.optional:
                    self.optional.append(parameter.name)
        for n in range(rng.choice((0, 0, 1))):
            type = rng.choice(("num", "bool", "robtarget", "string"))
            locals.append(f"    VAR {type} loc{n};")
            self.own.append(Data(f"loc{n}", type, "VAR"))
        for _ in range(rng.choice((1, 2, 3, 5)) if name != "main" else rng.choice((2, 4, 7))):
            self.statement(2)
        for label in self.labels:
            self.lines.append(f"    {label}:")
        if kind == "FUNC":
            self.say(2, f"RETURN {self.expression(one.result)};")
        elif kind == "PROC" and rng.random() < 0.1:
            self.say(2, "RETURN;")
        body, self.lines, self.labels = self.lines, [], []
        handlers = self.handlers(kind)
        header = {
            "PROC": f"PROC {name}({self.parameters(one)})",
            "FUNC": f"FUNC {one.result} {name}({self.parameters(one)})",
            "TRAP": f"TRAP {name}",
        }[kind]
        scope = (
            "LOCAL " if made is self.modules[0] and rng.random() < 0.1 and name != "main" else ""
        )
        if scope and len(self.modules) > 1:
            scope = ""
        made.routines += [f"  {scope}{header}", *locals, *body, *handlers, f"  END{kind}"]
        self.own, self.data = [], [*before, *self.data[len(before) :]]

    def parameters(self, one: Signature) -> str:
        texts = []
        for slot in one.slots:
            options = []
            for parameter in slot.alternatives:
                array = "{*}" if parameter.dimensions else ""
                text = f"{parameter.mode} {parameter.type} {parameter.name}{array}".strip()
                options.append(text)
            texts.append("\\" * slot.optional + "|".join(options))
        return ",".join(texts)

    def handlers(self, kind: str) -> list[str]:
        rng, made = self.rng, list[str]()
        if rng.random() < 0.04 and kind == "PROC":
            self.lines = []
            self.say(2, self.call(signature("movel")))
            made += ["  BACKWARD", *self.lines]
        if rng.random() < 0.12 and kind != "TRAP":
            self.lines = []
            numbers = rng.choice(("", "", f" ({','.join(rng.sample(ERRORS, 2))})"))
            self.statement(3)
            last = rng.choice(("RETRY;", "TRYNEXT;", "RAISE;", "EXIT;", "STOP;"))
            if kind == "PROC":
                last = rng.choice((last, "RETURN;"))
            self.lines += [f"    {label}:" for label in self.labels]
            made += [f"  ERROR{numbers}", *self.lines, f"    {last}"]
            self.labels = []
        if rng.random() < 0.04 and kind == "PROC":
            self.lines = []
            self.statement(3)
            made += ["  UNDO", *self.lines, *(f"    {label}:" for label in self.labels)]
        return made

    def table(self) -> None:
        """Many like targets and the moves to them, which are read as columns."""
        rng = self.rng
        count = rng.randint(3, 12)
        first = rng.choice((1, 10, 100))
        names = [f"q{first + n * 10}" for n in range(count)]
        for name in names:
            self.modules[-1].declared.append(f"CONST robtarget {name}:={self.target()};")
        word = rng.choice(("MoveL", "MoveJ"))
        lines = [f"    {word} {name},v100,z10,tool0;" for name in names]
        self.modules[0].routines += [f"  PROC {self.name('path')}()", *lines, "  ENDPROC"]

    # ------------------------------------------------------------------------ statements

    def say(self, depth: int, text: str) -> None:
        self.lines.append("  " * depth + text)

    def statement(self, depth: int) -> None:
        kinds = STATEMENTS if depth < 4 else PLAIN
        draw = self.rng.choices([k for k, _ in kinds], [w for _, w in kinds])[0]
        draw(self, depth)

    def block(self, depth: int) -> None:
        for _ in range(self.rng.choice((0, 1, 1, 2))):
            self.statement(depth + 1)

    def usual(self, depth: int) -> None:
        one = signature(self.rng.choice(USUAL))
        if one is not None:
            self.say(depth, self.call(one))

    def any(self, depth: int) -> None:
        one = signature(self.rng.choice(calls("PROC")))
        self.say(depth, self.call(one))

    def own_call(self, depth: int) -> None:
        if not self.procs:
            return
        name, one = self.rng.choice(self.procs)
        if self.rng.random() < 0.1 and not one.slots:
            name = f'%"{name}"%'
        self.say(depth, self.call(one, name))

    def assign(self, depth: int) -> None:
        type = self.rng.choice(
            (
                "num",
                "num",
                "num",
                "bool",
                "string",
                "robtarget",
                "pos",
                "pose",
                "dnum",
                "jointtarget",
                "wobjdata",
                "speeddata",
                *self.records,
            )
        )
        self.say(depth, f"{self.variable(type, 'INOUT')}:={self.expression(type)};")

    def if_(self, depth: int) -> None:
        rng = self.rng
        if rng.random() < 0.3:
            lines, self.lines = self.lines, []
            PLAIN_DRAW[rng.randrange(len(PLAIN_DRAW))](self, 0)
            simple, self.lines = self.lines, lines
            if len(simple) == 1:
                self.say(depth, f"IF {self.expression('bool')} {simple[0].strip()}")
            return
        self.say(depth, f"IF {self.expression('bool')} THEN")
        self.block(depth)
        while rng.random() < 0.25:
            self.say(depth, f"ELSEIF {self.expression('bool')} THEN")
            self.block(depth)
        if rng.random() < 0.4:
            self.say(depth, "ELSE")
            self.block(depth)
        self.say(depth, "ENDIF")

    def for_(self, depth: int) -> None:
        rng, name = self.rng, f"i{len(self.loops) + 1}"
        step = rng.choice(("", "", " STEP 2", " STEP -1", f" STEP {self.expression('num', 2)}"))
        self.say(
            depth,
            f"FOR {name} FROM {self.expression('num', 1)} TO {self.expression('num', 1)}{step} DO",
        )
        self.loops.append(name)
        self.block(depth)
        self.loops.pop()
        self.say(depth, "ENDFOR")

    def while_(self, depth: int) -> None:
        self.say(depth, f"WHILE {self.expression('bool')} DO")
        self.block(depth)
        self.say(depth, "ENDWHILE")

    def test(self, depth: int) -> None:
        rng = self.rng
        type = rng.choice(("num", "num", "string"))
        self.say(depth, f"TEST {self.expression(type, 1)}")
        for at in range(rng.choice((1, 2, 3))):
            values = [
                f'"t{at}{n}"' if type == "string" else str(10 * at + n)
                for n in range(rng.choice((1, 1, 2)))
            ]
            self.say(depth, f"CASE {','.join(values)}:")
            self.block(depth)
        if rng.random() < 0.5:
            self.say(depth, "DEFAULT:")
            self.block(depth)
        self.say(depth, "ENDTEST")

    def jump(self, depth: int) -> None:
        """Forward, to a label at the end of the routine, or back in a loop of its own."""
        rng, name = self.rng, self.name("lab")
        if depth > 2 and not self.lines:
            return
        if rng.random() < 0.6:
            self.labels.append(name)
            self.say(depth, f"IF {self.expression('bool', 1)} GOTO {name};")
        elif depth == 2:
            self.say(depth, f"{name}:")
            self.block(depth)
            self.say(depth, f"IF {self.expression('bool', 1)} GOTO {name};")

    def connect(self, depth: int) -> None:
        if self.traps:
            number = self.variable("intnum", "VAR")
            self.say(depth, f"CONNECT {number} WITH {self.rng.choice(self.traps)};")

    def comment(self, depth: int) -> None:
        self.say(depth, self.rng.choice(("! move on", "!", '! "a" ; ENDIF', "!!! {x} \\y")))

    def give_up(self, depth: int) -> None:
        rng = self.rng
        end = "RETURN;" if not self.result else f"RETURN {self.expression(self.result, 1)};"
        self.say(depth, f"IF {self.expression('bool', 1)} {rng.choice((end, 'EXIT;', 'Stop;'))}")

    def arc(self, depth: int) -> None:
        start = self.variable("robtarget", "VAR")
        self.say(depth, f"MoveL {start},v100,fine,tool0;")
        self.say(
            depth,
            f"MoveC Offs({start},10,10,0),Offs({start},20,0,0),v100,"
            f"{self.rng.choice(('fine', 'z10'))},tool0;",
        )

    def moves(self, depth: int) -> None:
        tool = self.variable("tooldata", "PERS")
        frame = self.rng.choice(("", "\\WObj:=" + self.variable("wobjdata", "PERS")))
        for _ in range(self.rng.randint(2, 5)):
            zone = self.rng.choice(("fine", "z5", "z50"))
            self.say(depth, f"MoveL {self.target()},v100,{zone},{tool}{frame};")

    def trigger(self, depth: int) -> None:
        rng, one = self.rng, self.variable("triggdata", "VAR")
        place = rng.choice(("0", "20", "-5")) + rng.choice(("", "\\Start", "\\Time"))
        self.say(depth, f"TriggIO {one},{place.replace('-5', '5')}\\DOp:=do1,{rng.choice('01')};")
        self.say(
            depth,
            f"Trigg{rng.choice('LJ')} {self.expression('robtarget', 1)},v100,{one},fine,tool0;",
        )

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
        return "[" + ",".join(map(self.literal, known.components.values())) + "]"

    def counted(self, type: str, parts: Mapping[str, str]) -> str:
        """A record whose numbers are not negative."""
        values = [
            self.rng.choice(("5", "50", "0.5", "100")) if part == "num" else self.literal(part)
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


Draw = Callable[[Rapid, int], None]
PLAIN: Final[Sequence[tuple[Draw, int]]] = (
    (Rapid.usual, 12),
    (Rapid.any, 8),
    (Rapid.own_call, 4),
    (Rapid.assign, 8),
    (Rapid.moves, 3),
    (Rapid.arc, 1),
    (Rapid.trigger, 1),
    (Rapid.comment, 2),
    (Rapid.connect, 1),
    (Rapid.give_up, 1),
)
PLAIN_DRAW: Final = (Rapid.usual, Rapid.any, Rapid.own_call, Rapid.assign)
STATEMENTS: Final = (
    *PLAIN,
    (Rapid.if_, 4),
    (Rapid.for_, 2),
    (Rapid.while_, 2),
    (Rapid.test, 2),
    (Rapid.jump, 2),
)


def program(rng: Random) -> tuple[str, set[str]]:
    """A program, and the rows of the tables that it calls."""
    made = Rapid(rng)
    return made.program(), made.reached
