"""Valid pseudo-programs: every statement, function and form of a declaration."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Final

DEEPEST: Final = 2
TYPES: Final = ("number", "number", "integer", "truth", "text", "position", "pose", "joints")
OF_NUMBERS: Final = {
    "abs": 1,
    "sqrt": 1,
    "sin": 1,
    "cos": 1,
    "tan": 1,
    "asin": 1,
    "acos": 1,
    "atan": 1,
    "atan2": 2,
    "exp": 1,
    "ln": 1,
    "round": 1,
    "trunc": 1,
    "floor": 1,
    "min": 2,
    "max": 3,
    "bitand": 2,
    "bitor": 2,
    "bitxor": 2,
}
POINT: Final = ("300", "-120.5", "0", "250", "401.25")
TURNS: Final = ("[0, 0, 1, 0]", "[1, 0, 0, 0]", "[0, 1, 0, 0]", "[0.5, 0.5, 0.5, 0.5]")


class Pseudo:
    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.reached: set[str] = set()
        self.declared: list[str] = []
        self.names: dict[str, list[str]] = {type: [] for type in TYPES}
        self.lines: list[str] = []
        self.tools = ["tool0"]
        self.frames = ["base"]
        self.speeds: list[str] = []
        self.blends: list[str] = []
        self.outputs: list[str] = []
        self.inputs: list[str] = []
        self.targets: list[str] = []
        self.joints: list[str] = []
        self.procedures: list[tuple[str, list[tuple[str, str]], str]] = []
        self.labels = 0
        self.timers = False

    def program(self) -> str:
        rng = self.rng
        head = "program cell" + rng.choice(("", "", " for irb1200-7-0.7", " for rv-4frl"))
        self.declarations()
        for n in range(rng.choice((0, 1, 1, 2))):
            given = [(f"a{i}", rng.choice(TYPES)) for i in range(rng.choice((0, 1, 2)))]
            result = rng.choice(("", "", "number", "position", "truth"))
            self.procedures.append((f"part_{n}", given, result))
        bodies = [self.procedure("main", [], "")]
        bodies += [self.procedure(*one) for one in self.procedures]
        return "\n".join([head, "", *self.declared, "", *bodies, ""])

    def declarations(self) -> None:
        rng, say = self.rng, self.declared.append
        if rng.random() < 0.6:
            self.tools.append("gripper")
            mass = rng.choice(("", " mass 0.5 kg centre [0, 0, 30]", " mass 1 kg"))
            say(f"tool gripper tip [0, {rng.choice('05')}, 60] {rng.choice(TURNS)}{mass}")
        if rng.random() < 0.6:
            self.frames.append("table")
            more = rng.choice(("", " object [0, 10, 5]", f" object [1, 2, 3] {rng.choice(TURNS)}"))
            say(f"frame table user [400, 0, 50] {rng.choice(TURNS)}{more}")
        if rng.random() < 0.4:
            self.speeds.append("v_slow")
            say(
                rng.choice(
                    (
                        "speed v_slow 20 mm/s",
                        "speed v_slow 20 mm/s rotation 90 deg/s joint 10 %",
                        "speed v_slow maximum",
                    )
                )
            )
        if rng.random() < 0.4:
            self.blends.append("z_part")
            say(
                rng.choice(
                    (
                        "blend z_part 5 mm",
                        "blend z_part 5 mm exit 2.5 mm",
                        "blend z_part full",
                        "blend z_part fine",
                        "blend z_part 5 mm details [7.5, 7.5, 0.75, 7.5, 0.75]",
                    )
                )
            )
        for name, way in (("glue", "output"), ("valve", "output"), ("part_there", "input")):
            if rng.random() < 0.7:
                (self.outputs if way == "output" else self.inputs).append(name)
                say(f"signal {name} digital {way} {rng.randint(1, 30)}")
        if rng.random() < 0.2:
            self.inputs.append("number_in")
            say("signal number_in group input 40 bits 4")
        if rng.random() < 0.15:
            self.outputs.append("level")
            say("signal level analog output 3")
        for n in range(rng.randint(1, 3)):
            self.targets.append(f"p{n}")
            say(f"target p{n} {self.target()}")
        if rng.random() < 0.4:
            self.joints.append("home")
            say("joints home [0, 0, 10, 0, 90, 0]")
        for n in range(rng.randint(1, 4)):
            self.variable(f"v{n}", say)

    def variable(self, name: str, say: Callable[[str], None]) -> None:
        rng, type = self.rng, self.rng.choice(TYPES)
        storage = rng.choice(("variable", "variable", "constant", "persistent"))
        if rng.random() < 0.15 and storage == "variable":
            size = rng.choice((2, 3))
            say(f"variable {name} {type}[{size}]")
            self.names[type].append(f"{name}[{rng.randint(1, size)}]")
            return
        first = f" = {self.literal(type)}" if storage == "constant" or rng.random() < 0.6 else ""
        say(f"{storage} {name} {type}{first}")
        if storage != "constant":
            self.names[type].append(name)

    def procedure(self, name: str, given: list[tuple[str, str]], result: str) -> str:
        rng, before = self.rng, {type: list(names) for type, names in self.names.items()}
        self.lines = []
        for one, type in given:
            self.names[type].append(one)
        for n in range(rng.choice((0, 0, 1, 2))):
            self.variable(f"{name}_{n}", lambda text: self.lines.append(f"  {text}"))
        if name == "main":
            self.say(1, "restart timer cycle")
        self.body(rng.choice((2, 4, 7)), 1)
        if result:
            self.say(1, f"return {self.expression(result)}")
        listed = ", ".join(f"{one} {type}" for one, type in given)
        head = f"procedure {name}" + (f"({listed})" if given else "")
        self.names = before
        return "\n".join([head + (f" returns {result}" if result else ""), *self.lines, "end", ""])

    # ------------------------------------------------------------------------ statements

    def say(self, depth: int, text: str) -> None:
        self.lines.append("  " * depth + text)

    def body(self, most: int, depth: int) -> None:
        for _ in range(most):
            table = (*PLAIN, *BLOCKS) if depth < 4 else PLAIN
            draw = self.rng.choices([k for k, _ in table], [w for _, w in table])[0]
            self.reached.add(draw.__name__)
            draw(self, depth)

    def motion(self) -> str:
        rng = self.rng
        speed = rng.choice(("200 mm/s", "maximum", "50 mm/s joint 20 %", "7.5 mm/s", *self.speeds))
        blend = rng.choice(("fine", "fine", "10 mm", "full", "5 mm exit 3 mm", *self.blends))
        tool, frame = rng.choice(self.tools), rng.choice(self.frames)
        text = f"speed {speed} blend {blend}"
        text += f" tool {tool}" if tool != "tool0" else ""
        text += f" frame {frame}" if frame != "base" else ""
        if self.outputs and rng.random() < 0.1:
            place = rng.choice(("10 mm from start", "5 mm before end", "0.2 s before end", "50 %"))
            text += f" set {rng.choice(self.outputs)} = 1 at {place}"
            text += rng.choice(("", "", " ahead 0.1 s"))
        return text

    def move(self, depth: int) -> None:
        kind = self.rng.choice(("joint", "linear"))
        self.say(depth, f"move {kind} {self.expression('position', 1)} {self.motion()}")

    def arc(self, depth: int) -> None:
        a, b = (self.expression("position", 1) for _ in range(2))
        self.say(depth, f"move circular via {a} to {b} {self.motion()}")

    def absolute(self, depth: int) -> None:
        self.say(depth, f"move absolute {self.expression('joints', 1)} {self.motion()}")

    def follow(self, depth: int) -> None:
        rng = self.rng
        self.say(depth, f"follow way_{len(self.lines)}")
        said = f" {self.motion()}".split(" set ")[0]
        for n in range(rng.randint(1, 5)):
            place = f"[{300 + 10 * n}, {rng.choice(POINT)}, 250]"
            if n and rng.random() < 0.3:
                self.say(depth + 1, f"via {place}")
                self.say(depth + 1, f"to [{305 + 10 * n}, 20, 250]")
            else:
                turn = (
                    rng.choice(("", f" {rng.choice(TURNS)}"))
                    if said == ""
                    else f" {rng.choice(TURNS)}"
                )
                more = said if said else rng.choice(("", "", " blend 1 mm", " speed 20 mm/s"))
                self.say(
                    depth + 1, f"{rng.choice(('linear', 'linear', 'joint'))} {place}{turn}{more}"
                )
            said = ""
        self.say(depth, "end")

    def wait(self, depth: int) -> None:
        rng = self.rng
        limit = rng.choice(("", "", " timeout 2.5 s"))
        choices = [
            f"wait {rng.choice(('0.5', '1', self.expression('number', 1)))} s",
            f"wait until {self.expression('truth')}{limit}",
        ]
        if self.inputs:
            choices.append(f"wait for {rng.choice(self.inputs)} = {rng.choice('01')}{limit}")
        self.say(depth, rng.choice(choices))

    def set(self, depth: int) -> None:
        rng = self.rng
        if self.outputs:
            pulse = rng.choice(("", "", " pulse 0.2 s"))
            value = rng.choice(("1", "0", "true", self.expression("number", 1)))
            self.say(depth, f"set {rng.choice(self.outputs)} = {value}{pulse}")

    def small(self, depth: int) -> None:
        rng = self.rng
        self.say(
            depth,
            rng.choice(
                (
                    "open hand 1",
                    "close hand 2",
                    "acceleration 50 % deceleration 60 %",
                    "override 80 %",
                    "stop",
                    "exit",
                    "message",
                    "restart timer cycle",
                    f"# {rng.choice(('over', 'a `b`', '|'))}",
                    f'message "x = ", {self.expression("number", 1)}, " mm"',
                    "message " + self.expression("text"),
                )
            ),
        )

    def assign(self, depth: int) -> None:
        rng = self.rng
        type = rng.choice([type for type in TYPES if self.names[type]] or ["number"])
        if not self.names[type]:
            return
        name = rng.choice(self.names[type])
        if type == "position" and rng.random() < 0.2:
            self.say(depth, f"{name}.{rng.choice('xyz')} = {self.expression('number')}")
            return
        self.say(depth, f"{name} = {self.expression(type)}")

    def call(self, depth: int) -> None:
        rng = self.rng
        plain = [one for one in self.procedures if not one[2]]
        if plain:
            name, given, _ = rng.choice(plain)
            listed = ", ".join(self.expression(type, 1) for _, type in given)
            self.say(depth, f"call {name}" + (f"({listed})" if given else ""))

    def if_(self, depth: int) -> None:
        rng = self.rng
        self.say(depth, f"if {self.expression('truth')}")
        self.body(rng.choice((0, 1, 2)), depth + 1)
        if rng.random() < 0.3:
            self.say(depth, f"elseif {self.expression('truth')}")
            self.body(1, depth + 1)
        if rng.random() < 0.4:
            self.say(depth, "else")
            self.body(1, depth + 1)
        self.say(depth, "end")

    def for_(self, depth: int) -> None:
        rng, name = self.rng, f"i{depth}"
        last = rng.choice(
            (
                f"to {self.expression('integer', 1)}",
                "to 5",
                "to 1 step -1",
                f"towards {self.expression('integer', 1)}",
                "to 10 step 0.5",
            )
        )
        self.say(depth, f"for {name} from {rng.choice('125')} {last}")
        self.names["number"].append(name)
        self.body(rng.choice((1, 2)), depth + 1)
        self.names["number"].remove(name)
        self.say(depth, "end")

    def while_(self, depth: int) -> None:
        self.say(depth, f"while {self.expression('truth')}")
        self.body(self.rng.choice((0, 1, 2)), depth + 1)
        self.say(depth, "end")

    def switch(self, depth: int) -> None:
        rng, type = self.rng, self.rng.choice(("number", "integer", "text"))
        self.say(depth, f"switch {self.expression(type, 1)}")
        for n in range(rng.choice((1, 2))):
            self.say(depth, f'case "t{n}"' if type == "text" else f"case {n}, {n + 10}")
            self.body(rng.choice((0, 1)), depth + 1)
        if rng.random() < 0.4:
            self.say(depth, "else")
            self.body(1, depth + 1)
        self.say(depth, "end")

    def jump(self, depth: int) -> None:
        if depth > 1:
            return
        self.labels += 1
        name, rng = f"again_{self.labels}", self.rng
        if rng.random() < 0.5:
            self.say(depth, f"label {name}")
            self.body(1, depth + 1)
            parts = [f"if {self.expression('truth')}", f"  goto {name}", "end"]
        else:
            parts = [f"if {self.expression('truth')}", f"  goto {name}", "end", f"label {name}"]
        for part in parts:
            self.say(depth, part)

    # ----------------------------------------------------------------------- expressions

    def expression(self, type: str, depth: int = 0) -> str:
        rng, draw = self.rng, self.rng.random()
        if depth > DEEPEST or draw < 0.35:
            return self.leaf(type)
        own = [one for one in self.procedures if one[2] == type]
        if own and draw < 0.42:
            name, given, _ = rng.choice(own)
            return f"{name}({', '.join(self.expression(t, depth + 2) for _, t in given)})"
        inner = lambda of: self.expression(of, depth + 1)  # noqa: E731
        match type:
            case "number" | "integer":
                if draw < 0.7:
                    sign = rng.choice(("+", "-", "*", "/", "div", "mod", "^"))
                    return f"({inner(type)} {sign} {inner(type)})"
                if draw < 0.9:
                    name = rng.choice(list(OF_NUMBERS))
                    self.reached.add(name)
                    return f"{name}({', '.join(inner('number') for _ in range(OF_NUMBERS[name]))})"
                return rng.choice(
                    (
                        f"{rng.choice(self.targets)}.x",
                        "elapsed(cycle)",
                        f"-{self.leaf('number')}",
                        f"length({inner('text')})",
                        f"distance({inner('position')}, {inner('position')})",
                    )
                )
            case "truth":
                if draw < 0.75:
                    sign = rng.choice(("=", "<>", "<", ">", "<=", ">="))
                    return f"({inner('number')} {sign} {inner('number')})"
                if draw < 0.9:
                    return f"({inner('truth')} {rng.choice(('and', 'or', 'xor'))} {inner('truth')})"
                return f"(not {inner('truth')})"
            case "text":
                return rng.choice(
                    (
                        f"({inner('text')} + {inner('text')})",
                        f"text({inner('number')})",
                        f"fixed({inner('number')}, 2)",
                        f"part({inner('text')}, 1, 2)",
                    )
                )
            case "position":
                if draw < 0.75:
                    shift = ", ".join(
                        rng.choice(("0", "10", "-5.5", inner("number"))) for _ in range(3)
                    )
                    return f"offset({self.leaf('position')}, {shift})"
                turn = rng.choice(("", ", 0, 0, 30"))
                return rng.choice(
                    (
                        f"relative({self.leaf('position')}, 0, 0, -10{turn})",
                        "here(tool0, base)",
                        f"here({rng.choice(self.tools)}, {rng.choice(self.frames)})",
                    )
                )
            case "pose":
                return rng.choice(
                    (
                        f"({self.leaf('pose')} @ {self.leaf('pose')})",
                        f"inverse({self.leaf('pose')})",
                    )
                )
            case "joints":
                return "joints_here()" if draw < 0.6 else self.leaf(type)
        return self.leaf(type)

    def leaf(self, type: str) -> str:
        rng = self.rng
        names = list(self.names[type])
        if type == "number":
            names += self.names["integer"]
            names += self.inputs
        if type == "position":
            names += self.targets
        if type == "joints":
            names += self.joints
        return rng.choice(names) if names and rng.random() < 0.7 else self.literal(type)

    def target(self) -> str:
        rng = self.rng
        branch = rng.choice(("", "", " front up noflip 0 0 -1", " back down flip 0 1 0"))
        place = ", ".join(rng.choice(POINT) for _ in range(3))
        return f"[{place}] {rng.choice(TURNS)}{branch}"

    def literal(self, type: str) -> str:
        rng = self.rng
        match type:
            case "number":
                return rng.choice(("0", "1", "-2", "0.5", "12.25", "1e3", "100", "3"))
            case "integer":
                return rng.choice(("0", "1", "2", "7", "100"))
            case "truth":
                return rng.choice(("true", "false"))
            case "text":
                return rng.choice(('"part"', '""', '"a b;"'))
            case "position":
                return f"target {self.target()}"
            case "pose":
                return f"pose [{rng.choice(POINT)}, 0, 10] {rng.choice(TURNS)}"
        return "joints [0, 10, -20, 0, 45.5, 0]"


Draw = Callable[[Pseudo, int], None]
PLAIN: Final[tuple[tuple[Draw, int], ...]] = (
    (Pseudo.move, 10),
    (Pseudo.arc, 2),
    (Pseudo.absolute, 2),
    (Pseudo.follow, 2),
    (Pseudo.wait, 4),
    (Pseudo.set, 4),
    (Pseudo.small, 5),
    (Pseudo.assign, 8),
    (Pseudo.call, 4),
)
BLOCKS: Final[tuple[tuple[Draw, int], ...]] = (
    (Pseudo.if_, 3),
    (Pseudo.for_, 2),
    (Pseudo.while_, 2),
    (Pseudo.switch, 2),
    (Pseudo.jump, 2),
)


def program(rng: Random) -> tuple[str, set[str]]:
    made = Pseudo(rng)
    return made.program(), made.reached
