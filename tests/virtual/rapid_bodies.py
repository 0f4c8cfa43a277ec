"""Statements of random RAPID programs."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from random import Random
from typing import Final

from tests.virtual import rapid_words as w
from tests.virtual.rapid_names import Data, Routine, Scope
from tests.virtual.rapid_terms import Terms

DEEPEST: Final = 3


class Body:
    """Draws the body of one routine. later: routines that it may call.

    lines: what was drawn. tries, labels: how many counters and labels it has.
    """

    def __init__(self, rng: Random, scope: Scope, later: Sequence[Routine]) -> None:
        self.rng = rng
        self.scope = scope
        self.later = later
        self.terms = Terms(rng, scope, later)
        self.lines: list[str] = []
        self.declared: list[str] = []
        self.labels = 0
        self.counters = 0
        self.routine = Routine("", "PROC")

    def text(self, routine: Routine) -> str:
        self.routine = routine
        self._locals()
        for _ in range(self.rng.randint(2, 4) if routine.pure else self.rng.randint(3, 8)):
            self.statement(1)
        if routine.kind == "FUNC":
            self.lines.append(f"  RETURN {self.terms.whole()};")
        end = "ENDFUNC" if routine.kind == "FUNC" else "ENDPROC"
        declared = [f"  {line}" for line in self.declared]
        return "\n".join(["", routine.head, *declared, *self.lines, end])

    def _locals(self) -> None:
        """Local data, which may hide what has the same name outside."""
        rng, taken = self.rng, {p.name.lower() for p in self.routine.parameters}
        shadows = self.scope.has("shadows")
        names = [*(("total", "nLocal") if not shadows else (*w.NUMBERS, "total", "nLocal"))]
        for name in rng.sample(names, rng.randint(0, 2)):
            if name.lower() in taken:
                continue
            first = rng.choice(["", f":={rng.randint(0, 9)}"])
            self.declared.append(f"VAR num {name}{first};")
            self.scope.add(Data(name, "whole", "VAR"))
        if self.scope.has("arrays") and rng.random() < 0.3:
            size = rng.randint(2, 3)
            first = rng.choice(["", f":=[{','.join('123'[:size])}]"])
            self.declared.append(f"VAR num tmp{{{size}}}{first};")
            self.scope.add(Data("tmp", "whole", "VAR", size))
        if rng.random() < 0.2:
            self.declared.append("VAR robtarget pLocal;")
            self.lines.append(f"  pLocal:={self.terms.pick('target') or 'p10'};")
            self.scope.add(Data("pLocal", "target", "VAR"))

    # ------------------------------------------------------------------------------ statements

    def statement(self, depth: int) -> None:
        table = PURE if self.routine.pure else STATEMENTS
        kinds = [
            (draw, weight)
            for draw, weight, feature, nests in table
            if (not feature or self.scope.has(feature)) and (not nests or depth < DEEPEST)
        ]
        draw = self.rng.choices([k for k, _ in kinds], [weight for _, weight in kinds])[0]
        draw(self, depth)

    def say(self, depth: int, text: str) -> None:
        self.lines.append("  " * depth + text)

    def block(self, depth: int, least: int = 1, most: int = 3) -> None:
        """Statements that may or may not run; what is declared stays known behind them."""
        for _ in range(self.rng.randint(least, most)):
            self.statement(depth)

    def number(self, depth: int) -> None:
        rng = self.rng
        name = self._mine("whole")
        if name is None:
            return
        draw = rng.random()
        effects = [r for r in self.later if r.kind == "FUNC" and self.terms.can_call(r)]
        if draw < 0.2 and effects and not self.routine.pure and "{" not in name:
            self.say(depth, f"{name}:={self.terms.called(rng.choice(effects))};")
        elif draw < 0.35 and not self.routine.pure:
            self.say(depth, rng.choice([f"Incr {name};", f"Decr {name};", f"Add {name},3;"]))
        elif draw < 0.5:
            self.say(depth, f"{name}:={name}+{rng.randint(1, 9)};")
        else:
            self.say(depth, f"{name}:=Abs({self.terms.whole()}) MOD {rng.randint(5, 60)};")

    def _mine(self, kind: str) -> str | None:
        """Data that may be changed here: of a function without effects its own only."""
        if not self.routine.pure:
            return self.terms.pick(kind, True)
        own = [line.split()[2].split("{")[0].split(":")[0].rstrip(";") for line in self.declared]
        own += [one.name for one in self.routine.parameters]
        found = self.scope.those(lambda d: d.kind == kind and d.changes and d.name in own)
        return self.terms.variable(self.rng.choice(found)) if found else None

    def real(self, depth: int) -> None:
        name = self._mine("real")
        if name is not None:
            self.say(depth, f"{name}:={self.terms.real()};")

    def truth(self, depth: int) -> None:
        name = self._mine("truth")
        if name is not None:
            self.say(depth, f"{name}:={self.terms.truth()};")

    def target(self, depth: int) -> None:
        name = self._mine("target")
        if name is None:
            return
        if self.scope.has("components") and self.rng.random() < 0.4 and "{" not in name:
            part = f"{name}.trans.{self.rng.choice('xyz')}"
            self.say(depth, f"{part}:={part}+({self.terms.real(1)});")
        else:
            self.say(depth, f"{name}:={self.terms.target()};")

    def here(self, depth: int) -> None:
        name = self._mine("target")
        if name is None:
            return
        rng, options = self.rng, ""
        if rng.random() < 0.7:
            self.move(depth, "MoveL", "fine")
        if rng.random() < 0.6:
            options = f"\\Tool:={rng.choice([*self.scope.tools, 'tool0'])}"
            options += f"\\WObj:={rng.choice([*self.scope.frames, 'wobj0'])}"
        self.say(depth, f"{name}:=CRobT({options});")

    def move(self, depth: int, kind: str = "", zone: str = "") -> None:
        rng = self.rng
        kind = kind or rng.choice(["MoveL", "MoveL", "MoveL", "MoveJ"])
        tool = rng.choice(self.scope.tools)
        if self.scope.tables and rng.random() < 0.3:
            tool = f"tTable{{{rng.randint(1, self.scope.tables)}}}"
        frame = (
            f"\\WObj:={rng.choice(self.scope.frames)}"
            if self.scope.frames and rng.random() < 0.5
            else ""
        )
        zone = zone or rng.choice(w.ZONES)
        if zone == "fine" and self.scope.has("settings") and rng.random() < 0.3:
            zone = f"fine\\Inpos:={rng.choice(['inpos20', 'inpos50'])}"
        self.say(
            depth, f"{kind} {self.terms.target()},{rng.choice(w.SPEEDS)},{zone},{tool}{frame};"
        )

    def angle(self, depth: int) -> None:
        """Angles of a target, read, compared, and set one by one or by another rotation."""
        name = self._mine("target")
        if name is None or "{" in name:
            return
        rng, axis = self.rng, self.rng.choice("XYZ")
        angles = {one: f"EulerZYX(\\{one},{name}.rot)" for one in "ZYX"}
        other = self.terms.pick("target", storage="CONST") or "p10"
        step, kind = rng.choice([10, 30, 75, -40, 120, 170]), rng.randrange(5)
        if kind == 0:
            changed = angles | {axis: f"{angles[axis]}+({step})"}
            self.say(depth, f"{name}.rot:=OrientZYX({','.join(changed.values())});")
        elif kind == 1:
            # no angle that a target has: what of two equal ones is larger hangs on their rounding
            self.say(depth, f"IF {angles[axis]}{rng.choice('<>')}{step}.7 THEN")
            self.output(depth + 1)
            self.say(depth, "ENDIF")
        elif kind == 2:
            self.say(depth, f"{name}:=RelTool({other},0,0,0\\R{axis.lower()}:={angles[axis]}/2);")
        elif kind == 3:
            number = self._mine("real")
            if number is not None:
                self.say(depth, f"{number}:={angles[axis]};")
        else:
            self.say(depth, f"{name}.rot:=OrientZYX({step},{rng.choice([0, 25, -60])},180);")

    def speed_limit(self, depth: int) -> None:
        share = self.rng.choice(["100", "100", "50"])
        most = self.rng.choice(["80", "150", "5000", f"60+Abs({self.terms.whole(2)}) MOD 90"])
        self.say(depth, f"VelSet {share},{most};")

    def constant_tool(self, depth: int) -> None:
        """A tool that is made of constants, and a move with it."""
        self.say(depth, self.rng.choice(["tWork.tframe:=poWork;", "tWork.tframe.trans:=[0,0,75];"]))
        self.say(depth, f"MoveL {self.terms.target()},v100,fine,tWork;")

    def arc(self, depth: int) -> None:
        rng, tool = self.rng, self.rng.choice(self.scope.tools)
        start = self.terms.pick("target", storage="CONST") or "p10"
        x, y = rng.randint(20, 60), rng.randint(20, 60)
        self.say(depth, f"MoveL {start},v200,fine,{tool};")
        self.say(
            depth, f"MoveC Offs({start},{x},{y},0),Offs({start},{2 * x},0,0),v100,fine,{tool};"
        )

    def trigger(self, depth: int) -> None:
        """What sets triggdata up, and mostly a move that takes it."""
        rng, names = self.rng, self.rng.sample(w.TRIGGERS, self.rng.choice([1, 1, 1, 2]))
        for name in names:
            self._set_up(depth, name)
        if rng.random() < 0.15:
            self.statement(depth)
        if rng.random() < 0.9:
            taken = names[0] + "".join(f"\\T{n}:={x}" for n, x in enumerate(names[1:], 2))
            self.move(depth, rng.choice(["MoveL", "MoveL", "MoveJ"]))
            word, rest = self.lines.pop().strip().split(" ", 1)
            speed = next(iter(re.findall(r",v\d+,", rest)))
            before, _, behind = rest.rpartition(speed)
            self.say(depth, f"{word.replace('Move', 'Trigg')} {before}{speed}{taken},{behind}")

    def _set_up(self, depth: int, name: str) -> None:
        rng = self.rng
        place = rng.choice(["0", "0\\Start", "0\\Start", "0\\Start", "5", "20", "37.5"])
        if rng.random() < 0.08:
            place = rng.choice(
                [
                    "20\\Start",
                    "0.2\\Time",
                    "0\\Time",
                    self.terms.pick("real") or "2",
                    self.terms.whole(2),
                ]
            )
        output = f"\\DOp:={rng.choice(list(w.OUTPUTS))},{rng.choice('01')}"
        if self.scope.has("groups") and rng.random() < 0.4:
            output = f"\\GOp:=goSlot,{rng.randint(0, 15)}"
        if "Time" not in place and rng.random() < 0.3:
            self.say(depth, f"TriggEquip {name},{place},0{output};")
        else:
            self.say(depth, f"TriggIO {name},{place}{output};")

    def output(self, depth: int) -> None:
        rng, name = self.rng, self.rng.choice(list(w.OUTPUTS))
        value = rng.choice(["0", "1", "high", "low"])
        self.say(depth, rng.choice([f"SetDO {name},{value};", f"Set {name};", f"Reset {name};"]))

    def pulse(self, depth: int) -> None:
        length = self.rng.choice(["", "\\PLength:=0.5", "\\PLength:=2"])
        self.say(depth, f"PulseDO\\High{length},{self.rng.choice(list(w.OUTPUTS))};")

    def group(self, depth: int) -> None:
        name = self.rng.choice(list(w.GROUP_OUTPUTS))
        most = 1 << w.GROUP_OUTPUTS[name][1]
        self.say(depth, f"SetGO {name},Abs({self.terms.whole(1)}) MOD {most};")

    def wait(self, depth: int) -> None:
        rng = self.rng
        self.say(
            depth,
            rng.choice(
                [
                    "WaitTime 0.5;",
                    "WaitTime 1;",
                    f"WaitDI {rng.choice(list(w.INPUTS))},1;",
                    f"WaitUntil {rng.choice(list(w.INPUTS))}=1;",
                    "WaitRob\\InPos;",
                    "WaitRob\\ZeroSpeed;",
                    "WaitTime\\InPos,0.5;",
                ]
            ),
        )

    def limited(self, depth: int) -> None:
        """A wait that ends with an error when its time is over."""
        rng, name = self.rng, self.rng.choice(list(w.INPUTS))
        limit = rng.choice(["0.5", "1", "2"])
        waits = [f"WaitDI {name},{rng.choice('01')}", f"WaitUntil {name}={rng.choice('01')}"]
        if self.scope.has("groups"):
            waits.append(f"WaitUntil giOrder<{rng.randint(1, 15)} OR {name}=1")
        self.say(depth, f"{rng.choice(waits)}\\MaxTime:={limit};")

    def setting(self, depth: int) -> None:
        self.say(depth, self.rng.choice(w.SETTINGS))

    def message(self, depth: int) -> None:
        self.say(depth, 'TPWrite "part done";')

    def branch(self, depth: int) -> None:
        rng = self.rng
        if rng.random() < 0.25:
            before = len(self.lines)
            self.simple(0)
            kept = self.lines[before:]
            del self.lines[before:]
            if len(kept) == 1:
                self.say(depth, f"IF {self.terms.truth()} {kept[0].strip()}")
            return
        self.say(depth, f"IF {self.terms.truth()} THEN")
        self.block(depth + 1)
        if rng.random() < 0.3:
            self.say(depth, f"ELSEIF {self.terms.truth()} THEN")
            self.block(depth + 1)
        if rng.random() < 0.4:
            self.say(depth, "ELSE")
            self.block(depth + 1)
        self.say(depth, "ENDIF")

    def simple(self, depth: int) -> None:
        self.rng.choice(
            [Body.number, Body.truth] if self.routine.pure else [Body.number, Body.move]
        )(self, depth)

    def test(self, depth: int) -> None:
        rng = self.rng
        self.say(depth, f"TEST {self.terms.whole(2)}")
        values = rng.sample(range(10), 4)
        self.say(depth, f"CASE {values[0]}:")
        self.block(depth + 1)
        self.say(depth, f"CASE {values[1]},{values[2]}:")
        self.block(depth + 1)
        if rng.random() < 0.6:
            self.say(depth, "DEFAULT:")
            self.block(depth + 1)
        self.say(depth, "ENDTEST")

    def loop(self, depth: int) -> None:
        """FOR: fixed bounds, computed ones without STEP, and a STEP either way."""
        rng = self.rng
        name = rng.choice(w.LOOPS)
        if self.scope.has("shadows") and rng.random() < 0.2:
            name = rng.choice(w.NUMBERS)
        taken = [p.name.lower() for p in self.routine.parameters]
        if name.lower() in taken or any(
            d.name == name and d.storage == "LOOP" for d in self.scope.data
        ):
            return
        first, last, step = rng.choice(
            [
                ("1", str(rng.randint(1, 4)), ""),
                (str(rng.randint(2, 4)), "1", ""),
                (self.terms.small(), self.terms.small(), ""),
                (self.terms.small(), self.terms.small(), ""),
                ("0", str(rng.randint(2, 6)), " STEP 2"),
                (str(rng.randint(3, 6)), "1", " STEP -1"),
                (self.terms.small(), self.terms.small(), " STEP -1"),
            ]
        )
        hidden = list(self.scope.data)
        self.say(depth, f"FOR {name} FROM {first} TO {last}{step} DO")
        self.scope.add(Data(name, "whole", "LOOP"))
        self.block(depth + 1)
        self.say(depth, "ENDFOR")
        self.scope.data = hidden

    def repeat(self, depth: int) -> None:
        """WHILE with a counter of its own, that nothing else changes."""
        self.counters += 1
        name = f"turn{self.counters}"
        self.declared.append(f"VAR num {name};")
        self.say(depth, f"{name}:=0;")
        more = f" AND ({self.terms.steady()})" if self.rng.random() < 0.6 else ""
        self.say(depth, f"WHILE {name}<{self.rng.randint(1, 4)}{more} DO")
        self.say(depth + 1, f"{name}:={name}+1;")
        self.block(depth + 1)
        self.say(depth, "ENDWHILE")

    def jump(self, depth: int) -> None:
        self.labels += 1
        label = f"L{self.labels}"
        if self.rng.random() < 0.5:
            self.say(depth, f"IF {self.terms.truth()} GOTO {label};")
            self.block(depth, 1, 2)
            self.say(depth, f"{label}:")
            return
        self.counters += 1
        name = f"turn{self.counters}"
        self.declared.append(f"VAR num {name};")
        self.say(depth, f"{name}:=0;")
        self.say(depth, f"{label}:")
        self.say(depth, f"{name}:={name}+1;")
        self.block(depth, 1, 2)
        self.say(depth, f"IF {name}<{self.rng.randint(2, 3)} GOTO {label};")

    def call(self, depth: int) -> None:
        callable_ = [r for r in self.later if r.kind == "PROC" and self.terms.can_call(r)]
        if not callable_:
            return
        routine = self.rng.choice(callable_)
        arguments = ",".join(self.terms.arguments(routine))
        fast = [p for p in routine.parameters if p.kind == "switch"]
        option = "\\fast" if fast and self.rng.random() < 0.5 else ""
        if option and any(p.kind == "switch" for p in self.routine.parameters):
            option = self.rng.choice([option, "\\fast?fast"])
        self.say(depth, f"{routine.name} {arguments}{option}".strip() + ";")

    def give_back(self, depth: int) -> None:
        value = f" {self.terms.whole(2)}" if self.routine.kind == "FUNC" else ""
        self.say(depth, f"IF {self.terms.truth()} RETURN{value};")

    def end(self, depth: int) -> None:
        self.say(depth, f"IF {self.terms.truth()} {self.rng.choice(['EXIT', 'Stop'])};")


Draw = Callable[[Body, int], None]

STATEMENTS: Final[Sequence[tuple[Draw, int, str, bool]]] = (
    (Body.number, 14, "", False),
    (Body.real, 5, "", False),
    (Body.truth, 4, "", False),
    (Body.target, 6, "", False),
    (Body.here, 4, "here", False),
    (Body.move, 14, "", False),
    (Body.arc, 2, "arcs", False),
    (Body.angle, 8, "angles", False),
    (Body.constant_tool, 1, "constant tools", False),
    (Body.speed_limit, 2, "speed limits", False),
    (Body.output, 6, "signals", False),
    (Body.pulse, 1, "signals", False),
    (Body.trigger, 8, "triggers", False),
    (Body.group, 3, "groups", False),
    (Body.wait, 3, "waits", False),
    (Body.limited, 3, "limits", False),
    (Body.setting, 2, "settings", False),
    (Body.message, 1, "", False),
    (Body.branch, 7, "", True),
    (Body.test, 3, "tests", True),
    (Body.loop, 6, "loops", True),
    (Body.repeat, 3, "loops", True),
    (Body.jump, 4, "jumps", True),
    (Body.call, 12, "", False),
    (Body.give_back, 2, "returns", False),
    (Body.end, 1, "ends", False),
)
"""What draws a statement, its weight, the feature that it needs, and whether it nests."""

PURE: Final[Sequence[tuple[Draw, int, str, bool]]] = (
    (Body.number, 8, "", False),
    (Body.branch, 3, "", True),
    (Body.loop, 2, "loops", True),
    (Body.give_back, 3, "", False),
)
