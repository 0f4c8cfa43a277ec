"""Valid RAPID: every row of the tables is called with arguments of its types."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random
from typing import Final

from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.signatures import Parameter, Signature, Slot
from tests.fuzz.valid.layout import odd
from tests.fuzz.valid.rapid_values import Data, Made, Values, calls

USUAL: Final = (
    *("MoveL", "MoveL", "MoveJ", "MoveAbsJ", "MoveC", "WaitTime", "SetDO", "Set", "Reset", "SetAO"),
    *("SetGO", "PulseDO", "WaitDI", "WaitDO", "WaitUntil", "TPWrite", "Incr", "Decr", "Add"),
    *("Clear", "Stop", "AccSet", "VelSet", "ConfL", "ConfJ", "SingArea", "TriggL", "TriggJ"),
    *("TriggIO", "TriggEquip", "MoveLDO", "MoveJDO", "MoveLAO", "SpeedRefresh", "GripLoad"),
    *("TPErase", "ClkReset", "ClkStart", "ClkStop", "IDelete", "ISignalDI", "SoftAct", "WaitAI"),
    *("WaitGI", "MoveLSync", "TriggC", "SearchL", "PDispOn", "PDispSet", "EOffsSet", "ActUnit"),
    *("TPReadNum", "TPReadFK", "InvertDO", "ITimer", "StopMove", "StorePath", "CallByVar"),
)
ERRORS: Final = ("ERR_WAIT_MAXTIME", "ERR_DIVZERO", "ERR_PATH_STOP", "101")


class Rapid(Values):
    """Draws one program."""

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
