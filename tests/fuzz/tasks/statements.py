"""Statements of a drawn task."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from random import Random
from typing import Final

from tests.fuzz.tasks.values import UNUSED, Routine, Values

SPEEDS: Final = ("v50", "v100", "v200", "v500", "vSlow", "[150,90,5000,1000]")
ZONES: Final = ("fine", "fine", "z1", "z5", "z10", "zOwn")
TOOLS: Final = ("tGrip", "tGrip", "tool0", "tSpike")
FRAMES: Final = ("", "", "\\WObj:=wTable", "\\WObj:=wShelf", "\\WObj:=wobj0")
UNDECLARED: Final = ("tMissing", "\\WObj:=wMissing", "vMissing", "zMissing")
DEEPEST: Final = 4
STATEMENT: Final = "\x01"
"""Before each statement, until the text is put together."""


class Statements(Values):
    """lines: of the routine that is drawn. odd: the share of statements that few languages say.

    lacks: whether the task may use what nobody declares. oddly: whether it does such a thing.
    """

    def __init__(self, rng: Random, odd: float, *, lacks: bool) -> None:
        super().__init__(rng)
        self.odd, self.lacks = odd, lacks
        self.oddly = False
        self.lines: list[str] = []

    def say(self, depth: int, text: str) -> None:
        self.lines.append(f"{STATEMENT}{'  ' * depth}{text}")

    def end(self, depth: int, text: str) -> None:
        """A line that belongs to the statement above it."""
        self.lines.append(f"{'  ' * depth}{text}")

    def statement(self, depth: int) -> None:
        rng = self.rng
        if rng.random() < self.odd:
            self.oddly = True
            self.say(depth, rng.choice(ODD).replace("#", str(self.mark())))
            return
        if rng.random() < 0.04:
            self.end(depth, f"! about {rng.choice(('this', 'that'))}")
        blocks = BLOCKS if depth < DEEPEST else {}
        kinds = {**PLAIN, **blocks}
        draw = rng.choices(list(kinds), list(kinds.values()))[0]
        before = len(self.lines)
        draw(self, depth)
        if len(self.lines) == before:
            self.say(depth, f"WaitTime {rng.randint(1, 9)}/10;")

    def block(self, depth: int) -> None:
        for _ in range(self.rng.choice((1, 1, 2))):
            self.statement(depth + 1)

    # ------------------------------------------------------------------------------ data

    def assign(self, depth: int) -> None:
        kind = self.rng.choice(("int", "int", "num", "bool", "string", "robtarget", "pos"))
        name = self.any(kind, written=True)
        if name is not None:
            self.say(depth, f"{name}:={self.value(kind)};")

    def count_up(self, depth: int) -> None:
        name = self.any("int", written=True)
        form = self.rng.choice(("Incr {};", "Decr {};", "Add {},2;", "Clear {};", "{}:={}+1;"))
        if name is not None:
            self.say(depth, form.replace("{}", name))

    def marked(self, depth: int) -> None:
        """One that is found again wherever it went."""
        name = self.any("num", written=True)
        if name is not None:
            self.say(depth, f"{name}:={self.mark()};")

    def part(self, depth: int) -> None:
        """A component or an element."""
        rng = self.rng
        match rng.randint(0, 5):
            case 0 if self.any("robtarget", written=True):
                name = self.any("robtarget", written=True)
                self.say(depth, f"{name}.trans.{rng.choice('xyz')}:={100 + rng.randint(0, 90)};")
            case 1 if self.any("pos"):
                self.say(depth, f"{self.any('pos')}.{rng.choice('xyz')}:={self.small()};")
            case 2 if self.any("record"):
                name, value = self.any("record"), self.small()
                said = (f"number:={value}", f"good:={self.condition()}", f"size.y:={value}")
                self.say(depth, f"{name}.{rng.choice(said)};")
            case 3 if self.any("record"):
                one, other = self.any("record"), self.any("record")
                whole = f"[{self.small()},TRUE,[1,2,3]]"
                self.say(depth, f"{one}:={other if one != other else whole};")
            case _ if self.rows:
                name, size = rng.choice(self.rows)
                self.say(depth, f"{name}{{{rng.randint(1, size)}}}:={self.small()};")

    # ------------------------------------------------------------------------------ motion

    def how(self) -> str:
        rng = self.rng
        speed, zone = rng.choice(SPEEDS), rng.choice(ZONES)
        tool, frame = rng.choice(TOOLS), rng.choice(FRAMES)
        if self.lacks and rng.random() < 0.15:
            which = rng.randint(0, 3)
            tool = UNDECLARED[0] if which == 0 else tool
            frame = UNDECLARED[1] if which == 1 else frame
            speed = UNDECLARED[2] if which == 2 else speed
            zone = UNDECLARED[3] if which == 3 else zone
        return f"{speed},{zone},{tool}{frame}"

    def move(self, depth: int) -> None:
        word = self.rng.choice(("MoveL", "MoveL", "MoveJ"))
        self.say(depth, f"{word} {self.value('robtarget')},{self.how()};")

    def other_move(self, depth: int) -> None:
        rng = self.rng
        match rng.randint(0, 3):
            case 0 if self.any("jointtarget"):
                self.say(depth, f"MoveAbsJ {self.any('jointtarget')},{self.how()};")
            case 1:
                one = self.any("robtarget")
                self.say(depth, f"MoveJ {one},v100,fine,tGrip;")
                about = f"Offs({one},20,0,{self.mark() % 10}),Offs({one},40,20,0)"
                self.say(depth, f"MoveC {about},v100,fine,tGrip;")
            case 2:
                at = f"[[{rng.randint(200, 400)},{rng.randint(-90, 90)},300],[0,0,1,0],[0,0,0,0]"
                self.say(depth, f"MoveL [{at[1:]},{UNUSED}],{self.how()};")
            case 3:
                self.say(depth, f"MoveLDO {self.value('robtarget')},v100,fine,tGrip,doLamp,1;")

    def settings(self, depth: int) -> None:
        rng = self.rng
        said = (
            *(f"AccSet {rng.randint(2, 10) * 10},100;", "ConfL\\Off;", "ConfJ\\On;"),
            *("SingArea\\Wrist;", "SingArea\\Off;", f"VelSet {rng.randint(4, 10) * 10},1000;"),
        )
        self.say(depth, rng.choice(said))

    # ----------------------------------------------------------------------------- signals

    def output(self, depth: int) -> None:
        rng, lamp = self.rng, self.rng.choice(("doLamp", "doGrip"))
        said = (
            *(f"SetDO {lamp},{rng.randint(0, 1)};", f"Set {lamp};", f"Reset {lamp};"),
            *(f"SetGO goSlot,{self.small()};", f"SetGO goSlot,{self.small()};"),
            *("InvertDO doLamp;", "PulseDO\\PLength:=0.3,doLamp;"),
        )
        self.say(depth, rng.choice(said))

    def wait(self, depth: int) -> None:
        rng, late = self.rng, self.any("bool", written=True)
        said = (
            *(f"WaitTime {rng.randint(1, 9)}/10;", f"WaitDI diReady,{rng.randint(0, 1)};"),
            f"WaitDI diPart,{rng.randint(0, 1)}\\MaxTime:=2\\TimeFlag:={late};",
            f"WaitUntil diReady={rng.randint(0, 1)};",
        )
        self.say(depth, rng.choice(said))

    def clock(self, depth: int) -> None:
        name = self.any("clock")
        if name is not None:
            word = self.rng.choice(("ClkReset {};", "ClkStart {};", "ClkStop {};"))
            self.say(depth, word.replace("{}", name))

    def shown(self, depth: int) -> None:
        said = (f'TPWrite "step {self.mark()}";', f'TPWrite "n"\\Num:={self.small()};', "TPErase;")
        self.say(depth, self.rng.choice(said))

    # ------------------------------------------------------------------------------ blocks

    def if_(self, depth: int) -> None:
        rng = self.rng
        if rng.random() < 0.2:
            both = f"IF {self.condition()} {STATEMENT}SetGO goSlot,{self.small()};"
            self.say(depth, both)
            return
        self.say(depth, f"IF {self.condition()} THEN")
        self.block(depth)
        if rng.random() < 0.3:
            self.end(depth, f"ELSEIF {self.condition()} THEN")
            self.block(depth)
        if rng.random() < 0.4:
            self.end(depth, "ELSE")
            self.block(depth)
        self.end(depth, "ENDIF")

    def for_(self, depth: int) -> None:
        rng, name = self.rng, self.name("i")
        step = rng.choice(("", "", " STEP 2"))
        self.say(depth, f"FOR {name} FROM {rng.randint(0, 1)} TO {rng.randint(1, 3)}{step} DO")
        self.known.setdefault("int", []).append(name)
        self.block(depth)
        self.known["int"].remove(name)
        self.end(depth, "ENDFOR")

    def while_(self, depth: int) -> None:
        name = self.any("loop")
        if name is not None:
            self.known["loop"].remove(name)
            self.say(depth, f"{name}:=0;")
            self.say(depth, f"WHILE {name}<{self.rng.randint(1, 3)} DO")
            self.block(depth)
            self.say(depth + 1, f"{name}:={name}+1;")
            self.end(depth, "ENDWHILE")

    def test(self, depth: int) -> None:
        rng = self.rng
        self.say(depth, f"TEST {self.small()}")
        values = rng.sample(range(8), 5)
        for case in (f"{values[0]}", f"{values[1]},{values[2]}")[: rng.randint(1, 2)]:
            self.end(depth, f"CASE {case}:")
            self.block(depth)
        if rng.random() < 0.5:
            self.end(depth, "DEFAULT:")
            self.block(depth)
        self.end(depth, "ENDTEST")

    def call(self, depth: int, one: Routine | None = None) -> None:
        found = [routine for routine in self.routines if not routine.result]
        if one is None and found:
            one = self.rng.choice(found)
        if one is not None and not one.result:
            values = ",".join(self.value(kind) for kind in one.types)
            self.say(depth, f"{one.name} {values}".strip() + ";")


Draw = Callable[[Statements, int], None]
PLAIN: Final[Mapping[Draw, int]] = {
    Statements.assign: 8,
    Statements.count_up: 3,
    Statements.marked: 3,
    Statements.part: 3,
    Statements.move: 8,
    Statements.other_move: 2,
    Statements.settings: 1,
    Statements.output: 4,
    Statements.wait: 3,
    Statements.clock: 1,
    Statements.shown: 2,
    Statements.call: 2,
}
BLOCKS: Final[Mapping[Draw, int]] = {
    Statements.if_: 4,
    Statements.for_: 2,
    Statements.while_: 2,
    Statements.test: 2,
}
ODD: Final = (
    "EGMReset egmID1;",
    'Load\\Dynamic,"HOME:/part#.mod";',
    "SetSysData tGrip;",
    "WorldAccLim\\On:=#/1000;",
    "SoftAct 1,#/1000;",
    "ActUnit STN_1;",
    "SpeedRefresh #/10;",
    "MotionSup\\On;",
    "GripLoad load0;",
    "MechUnitLoad STN_1,1,load0;",
    'UIMsgBox "part #";',
    'ErrWrite "part","#";',
    'rMissing# "text";',
    "StorePath;",
    "BookErrNo ERR_OWN;",
    "PathAccLim TRUE\\AccMax:=4,FALSE;",
)
"""Statements that are kept or only told in most languages; `#` is a mark."""
