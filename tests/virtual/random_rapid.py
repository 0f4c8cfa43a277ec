"""Random RAPID programs that are valid and come to their end; one for each seed, everywhere.

Whatever ABB does not define is left out: the order in which an expression's parts are worked out
shows nowhere, and whole numbers are kept apart from those that arithmetic rounds.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from random import Random
from typing import Final

from tests.virtual import rapid_words as w
from tests.virtual.rapid_bodies import Body
from tests.virtual.rapid_names import Data, Parameter, Routine, Scope
from tests.virtual.translating import Changing, Text

FEATURES: Final = {
    "references": 0.5,
    "arrays": 0.5,
    "array arguments": 0.06,
    "functions": 0.6,
    "here": 0.4,
    "shadows": 0.4,
    "jumps": 0.4,
    "loops": 0.7,
    "signals": 0.6,
    "groups": 0.2,
    "waits": 0.3,
    "limits": 0.15,
    "returns": 0.5,
    "tests": 0.4,
    "components": 0.4,
    "persistent": 0.5,
    "settings": 0.15,
    "ends": 0.1,
    "optional": 0.1,
    "tables": 0.06,
    "arcs": 0.3,
    "registers": 0.1,
    "triggers": 0.2,
}
"""How likely each feature is that a program may use: each program leaves most others in peace."""
MORE: Final = frozenset({"angles", "changing", "constant tools"})
"""Features of `drawn_with_more`."""


@dataclass(slots=True)
class Drawn:
    """A program, and inputs of some scenarios by name in lower case."""

    text: str
    scenarios: list[dict[str, float]] = field(default_factory=list)
    beside: str = ""
    """The module that it calls, if there is one."""

    @property
    def texts(self) -> Text:
        return {"CELL": self.text, "BESIDE": self.beside} if self.beside else self.text


def program(seed: int) -> Drawn:
    """The program of a seed."""
    rng = Random(f"rapid {seed}")
    features = frozenset(name for name, part in FEATURES.items() if rng.random() < part)
    scope = Scope(features)
    lines = _data(rng, scope)
    routines = _routines(rng, scope)
    bodies = []
    for place, routine in enumerate(routines):
        bodies.append(Body(rng, scope.inside(routine), routines[place + 1 :]).text(routine))
    taken = set(re.findall(r"Trigg(?:[JL]|IO|Equip) .*", "\n".join(bodies)))
    named = [n for n in w.TRIGGERS if any(re.search(rf"\b{n}\b", line) for line in taken)]
    lines += [f"VAR triggdata {name};" for name in named]
    text = "\n".join(["MODULE Cell", *lines, *bodies, "ENDMODULE", ""])
    return Drawn(text, _scenarios(rng))


def drawn_with_more(seed: int) -> Drawn:
    """The program of a seed with angles, unused routines, tools by constants and a second module.

    Nothing waits for an input, and none is read where RAPID may leave it unread: inputs may change
    at each read.
    """
    rng = Random(f"rapid more {seed}")
    features = {name for name, part in FEATURES.items() if rng.random() < part}
    features = (features - {"waits", "limits", "ends"}) | MORE
    features |= {"speed limits"} if rng.random() < 0.15 else set()
    scope = Scope(frozenset(features))
    lines = _data(rng, scope)
    called = Routine("rBeside", "PROC", [Parameter("height", "real", "")])
    routines = [*_routines(rng, scope), called]
    bodies = [
        Body(rng, scope.inside(routine), routines[place + 1 :]).text(routine)
        for place, routine in enumerate(routines)
    ]
    taken = set(re.findall(r"Trigg(?:[JL]|IO|Equip) .*", "\n".join(bodies)))
    named = [n for n in w.TRIGGERS if any(re.search(rf"\b{n}\b", line) for line in taken)]
    lines += [f"VAR triggdata {name};" for name in named]
    text = "\n".join(["MODULE Cell", *lines, *bodies[:-1], "ENDMODULE", ""])
    beside = "\n".join(["MODULE Beside", bodies[-1], "ENDMODULE", ""])
    return Drawn(text, [*_scenarios(rng)[:2], Changing(seed), Changing(-seed)], beside)


def _scenarios(rng: Random) -> list[dict[str, float]]:
    inputs = [name.lower() for name in w.INPUTS]
    groups = {name.lower(): 1 << bits for name, (_, bits) in w.GROUP_INPUTS.items()}
    return [
        dict.fromkeys([*inputs, *groups], 0.0),
        dict.fromkeys(inputs, 1.0) | {name: most - 1.0 for name, most in groups.items()},
        {name: float(rng.randrange(2)) for name in inputs}
        | {name: float(rng.randrange(most)) for name, most in groups.items()},
    ]


# -------------------------------------------------------------------------------------- data


def _data(rng: Random, scope: Scope) -> list[str]:
    lines = []
    for name in rng.sample(list(w.TOOLS), rng.randint(1, 3)):
        head = rng.choice(["PERS", "PERS", "TASK PERS"])
        lines.append(f"{head} tooldata {name}:={w.TOOLS[name]};")
        scope.tools.append(name)
    if scope.has("tables"):
        rows = ",".join(w.TOOLS[name] for name in scope.tools[:2])
        lines.append(f"PERS tooldata tTable{{{len(scope.tools[:2])}}}:=[{rows}];")
        scope.tables = len(scope.tools[:2])
    if scope.has("constant tools"):
        lines += [
            f"PERS tooldata tWork:={w.TOOLS[scope.tools[0]]};",
            f"CONST pose poWork:={w.POSE};",
        ]
    for name in rng.sample(list(w.FRAMES), rng.randint(0, 2)):
        lines.append(f"PERS wobjdata {name}:={w.FRAMES[name]};")
        scope.frames.append(name)
    for name in rng.sample(w.TARGETS, rng.randint(2, 4)):
        lines.append(f"CONST robtarget {name}:={target(rng)};")
        scope.add(Data(name, "target", "CONST"))
    for name in rng.sample(w.CHANGING, rng.randint(1, 2)):
        lines.append(f"VAR robtarget {name}:={target(rng)};")
        scope.add(Data(name, "target", "VAR"))
    lines += [
        _number(rng, scope, name, "whole", str(rng.randint(0, 12)))
        for name in rng.sample(w.NUMBERS, rng.randint(2, 4))
    ]
    lines += [
        _number(rng, scope, name, "real", rng.choice(["0.5", "12.25", "40", "7.5"]))
        for name in rng.sample(w.REALS, rng.randint(1, 2))
    ]
    for name in rng.sample(w.TRUTHS, rng.randint(1, 2)):
        first = rng.choice(["", ":=TRUE", ":=FALSE"])
        lines.append(f"VAR bool {name}{first};")
        scope.add(Data(name, "truth", "VAR"))
    if scope.has("registers"):
        scope.add(Data(rng.choice(["reg1", "reg2"]), "whole", "VAR"))
    if scope.has("arrays"):
        lines += _arrays(rng, scope)
    return lines


def _number(rng: Random, scope: Scope, name: str, kind: str, first: str) -> str:
    storage = "PERS" if scope.has("persistent") and rng.random() < 0.4 else "VAR"
    scope.add(Data(name, kind, storage))
    stated = "" if storage == "VAR" and rng.random() < 0.3 else f":={first}"
    return f"{storage} num {name}{stated};"


def _arrays(rng: Random, scope: Scope) -> list[str]:
    lines = []
    for name in rng.sample(w.ARRAYS, rng.randint(1, 2)):
        size = rng.randint(2, 4)
        values = ",".join(str(rng.randint(0, 9)) for _ in range(size))
        first = rng.choice(["", f":=[{values}]"])
        lines.append(f"VAR num {name}{{{size}}}{first};")
        scope.add(Data(name, "whole", "VAR", size))
    if rng.random() < 0.3:
        name, size = rng.choice(w.TRUTH_ARRAYS), rng.randint(2, 3)
        lines.append(f"VAR bool {name}{{{size}}};")
        scope.add(Data(name, "truth", "VAR", size))
    if rng.random() < 0.3:
        name, size = rng.choice(w.TARGET_ARRAYS), rng.randint(2, 3)
        rows = ",".join(target(rng) for _ in range(size))
        lines.append(f"CONST robtarget {name}{{{size}}}:=[{rows}];")
        scope.add(Data(name, "target", "CONST", size))
    return lines


def target(rng: Random) -> str:
    x, y, z = rng.randint(250, 450), rng.randint(-150, 150), rng.randint(200, 450)
    return f"[[{x},{y},{z}],{rng.choice(w.ORIENTATIONS)},[0,0,0,0],{w.UNUSED}]"


# ---------------------------------------------------------------------------------- routines


def _routines(rng: Random, scope: Scope) -> list[Routine]:
    """`main`, then routines that call only those behind them."""
    found = [Routine("main", "PROC")]
    names = rng.sample(w.PROCEDURES, rng.randint(1, 4))
    found += [Routine(name, "PROC", _parameters(rng, scope)) for name in names]
    if scope.has("functions"):
        for name in rng.sample(w.FUNCTIONS, rng.randint(1, 2)):
            pure = rng.random() < 0.6
            found.append(Routine(name, "FUNC", _parameters(rng, scope, pure), pure))
    return found


def _parameters(rng: Random, scope: Scope, pure: bool = False) -> list[Parameter]:
    """pure: of a function that changes nothing."""
    names = rng.sample(w.PARAMETERS, rng.choice([0, 1, 1, 2]))
    found = [_parameter(rng, scope, name, pure) for name in names]
    if scope.has("optional") and not pure and rng.random() < 0.5:
        found.append(Parameter("fast", "switch", ""))
    return found


def _parameter(rng: Random, scope: Scope, name: str, pure: bool) -> Parameter:
    kind = rng.choice(["whole", "whole", "whole", "real", "target", "truth"])
    mode = ""
    if scope.has("references") and not pure and rng.random() < 0.65:
        mode = rng.choice(["INOUT", "INOUT", "VAR", "PERS"])
        if mode == "PERS" and not any(d.storage == "PERS" and d.kind == kind for d in scope.data):
            mode = "INOUT"
    size = 0
    if scope.has("array arguments") and kind == "whole" and mode != "PERS":
        size = 0 if rng.random() < 0.5 else -1
        if size and not any(d.size and d.kind == "whole" for d in scope.data):
            size = 0
    return Parameter(name, kind, mode, size)
