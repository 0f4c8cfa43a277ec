"""Draws a task: modules that share data and call each other, and the lines of their statements.

A task comes to its end, and no value leaves what a controller of either maker holds: so what was
written of it can be run beside it.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from random import Random
from typing import Final

from tests.fuzz.tasks.statements import STATEMENT, Statements
from tests.fuzz.tasks.values import DOWN, LEAST_MARK, UNUSED, Routine

SYSTEM: Final = """MODULE CellData(SYSMODULE)
  PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
  PERS tooldata tSpike:=[TRUE,[[10,0,60],[0.965925826,0,0.258819045,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
  PERS wobjdata wTable:=[FALSE,TRUE,"",[[300,-100,50],[0.991444861,0,0,0.130526192]],[[0,0,0],[1,0,0,0]]];
  TASK PERS wobjdata wShelf:=[FALSE,TRUE,"",[[200,100,0],[1,0,0,0]],[[10,0,5],[1,0,0,0]]];
  CONST speeddata vSlow:=[80,50,5000,1000];
  CONST zonedata zOwn:=[FALSE,3,5,5,0.5,5,0.5];
  VAR errnum ERR_OWN:=-1;
ENDMODULE
"""  # noqa: E501
FOLDER: Final = "RAPID/TASK1"
SYSTEM_FILE: Final = f"{FOLDER}/SYSMOD/CellData.sys"
STORAGE: Final = ("VAR", "VAR", "PERS")


@dataclass(slots=True)
class Drawn:
    """files: texts by their paths. statements: how many there are in a line of a file, each of
    which the report has to name once. marks: numbers that stand in nothing but one statement, with
    its place. plain: whether all of it is known to cross.
    """

    files: dict[str, str] = field(default_factory=dict)
    statements: Counter[tuple[str, int]] = field(default_factory=Counter)
    marks: dict[int, tuple[str, int]] = field(default_factory=dict)
    plain: bool = True


@dataclass(slots=True)
class _Module:
    name: str
    data: list[str] = field(default_factory=list)
    routines: list[str] = field(default_factory=list)


def drawn(seed: str, odd: float | None = None) -> Drawn:
    """The task of a seed. odd: the share of statements that few languages say; None draws it."""
    rng = Random(seed)
    share = rng.choice((0.0, 0.0, 0.05, 0.3)) if odd is None else odd
    return _Task(rng, share, lacks=rng.random() < 0.3).draw()


class _Task(Statements):
    def draw(self) -> Drawn:
        rng = self.rng
        names = rng.sample(("Work", "Pick", "Tools", "Lib"), rng.randint(1, 3))
        self.modules = [_Module(name) for name in ("MainModule", *names)]
        self._data()
        for _ in range(rng.randint(2, 5)):
            self._routine(rng.choice(self.modules[1:]))
        self._main(self.modules[0])
        out = Drawn(plain=not self.oddly)
        for made in self.modules:
            lines = [f"MODULE {made.name}", *made.data, *made.routines, "ENDMODULE"]
            self._file(out, f"{FOLDER}/PROGMOD/{made.name}.mod", lines)
        out.files[SYSTEM_FILE] = SYSTEM
        declared = SYSTEM.count("\n") - 2
        out.statements.update((SYSTEM_FILE, 2 + at) for at in range(declared))
        return out

    def _file(self, out: Drawn, path: str, lines: list[str]) -> None:
        texts = []
        for number, line in enumerate(lines, 1):
            if STATEMENT in line:
                out.statements[path, number] = line.count(STATEMENT)
            for digits in re.findall(r"(?<![\w.])\d{4,}(?![\w.])", line):
                if LEAST_MARK <= int(digits) < self.next_mark:
                    out.marks[int(digits)] = path, number
            texts.append(line.replace(STATEMENT, ""))
        out.files[path] = "\n".join(texts) + "\n"

    # ------------------------------------------------------------------------------- data

    def _data(self) -> None:
        rng = self.rng
        for _ in range(rng.randint(2, 4)):
            self._declare(rng.choice(STORAGE), "num", "n", str(rng.randint(0, 9)), "int")
        for _ in range(2):
            self._declare(rng.choice(STORAGE), "num", "x", "2.5")
            self._declare("VAR", "bool", "b", rng.choice(("TRUE", "FALSE")))
            self._declare(rng.choice(STORAGE), "string", "st", '"part 12"')
            self._declare("VAR", "num", "w", "0", "loop")
        self._declare("CONST", "num", "nMost", "7", "int")
        for _ in range(rng.randint(2, 4)):
            place = (rng.randint(200, 400), rng.randint(-9, 9) * 20, rng.randint(5, 12) * 30)
            value = f"[[{place[0]},{place[1]},{place[2]}],{rng.choice(DOWN)},[0,0,0,0],{UNUSED}]"
            self._declare(rng.choice((*STORAGE, "CONST", "CONST")), "robtarget", "p", value)
        if rng.random() < 0.5:
            angles = ",".join(str(rng.randint(-30, 30)) for _ in range(6))
            self._declare("CONST", "jointtarget", "jp", f"[[{angles}],{UNUSED}]")
        if rng.random() < 0.5:
            self._declare("VAR", "pos", "ps", "[10,20,30]")
        if rng.random() < 0.5:
            self._record()
        if rng.random() < 0.6:
            size, name = rng.randint(2, 5), self.name("aRow")
            values = ",".join(str(rng.randint(0, 9)) for _ in range(size))
            self._put(f"VAR num {name}{{{size}}}:=[{values}];")
            self.rows.append((name, size))
        if rng.random() < 0.3:
            self._declare("VAR", "clock", "ck", "")

    def _record(self) -> None:
        kind = self.name("part")
        parts = ("number;", "bool good;", "pos size;")
        lines = [f"    {'num ' if at == 0 else ''}{part}" for at, part in enumerate(parts)]
        head = f"{STATEMENT}  RECORD {kind}"
        self.modules[0].data[:0] = [head, *lines, "  ENDRECORD"]
        for _ in range(self.rng.randint(1, 2)):
            self._declare("VAR", kind, "r", "[4,TRUE,[1,2,3]]", "record")

    def _declare(self, storage: str, type: str, stem: str, value: str, kind: str = "") -> None:
        name, kind = self.name(stem), kind or type
        self._put(f"{storage} {type} {name}{f':={value}' if value else ''};")
        self.known.setdefault(kind, []).append(name)
        if storage != "CONST":
            self.written.setdefault(kind, []).append(name)

    def _put(self, line: str) -> None:
        self.rng.choice(self.modules).data.append(f"{STATEMENT}  {line}")

    # --------------------------------------------------------------------------- routines

    def _routine(self, module: _Module) -> None:
        rng = self.rng
        kinds = ("int", "int", "robtarget", "bool")
        types = tuple(rng.choice(kinds) for _ in range(rng.randint(0, 2)))
        result = rng.choice(("", "", "int", "robtarget"))
        one = Routine(self.name("f" if result else "rDo"), types, result)
        kept = {kind: list(names) for kind, names in self.known.items()}
        parameters = []
        for at, kind in enumerate(types):
            parameters.append(f"{'num' if kind == 'int' else kind} a{at}")
            self.known.setdefault(kind, []).append(f"a{at}")
        self.lines = []
        if rng.random() < 0.4:
            local = self.name("k")
            self.say(2, f"VAR num {local}:={self.mark()};")
        for _ in range(rng.randint(1, 5)):
            self.statement(2)
        if result:
            self.say(2, f"RETURN {self.value(result)};")
        elif rng.random() < 0.25:
            self._handler()
        word = f"FUNC {'num' if result == 'int' else result}" if result else "PROC"
        head = f"{STATEMENT}  {word} {one.name}({','.join(parameters)})"
        module.routines += [head, *self.lines, f"  END{word.split()[0]}"]
        loops = self.known.get("loop", [])
        self.known = kept | {"loop": loops}
        self.routines.append(one)

    def _handler(self) -> None:
        self.say(2, f"WaitDI diReady,{self.rng.randint(0, 1)}\\MaxTime:=2;")
        self.say(1, "ERROR")
        self.say(2, "IF ERRNO=ERR_WAIT_MAXTIME THEN")
        self.say(3, f"SetGO goErr,{self.small()};")
        self.say(3, self.rng.choice(("TRYNEXT;", "RETURN;")))
        self.end(2, "ENDIF")

    def _main(self, module: _Module) -> None:
        self.lines = []
        for _ in range(self.rng.randint(4, 10)):
            self.statement(2)
        for one in self.routines:
            if self.rng.random() < 0.8 and not one.result:
                self.call(2, one)
        self.say(2, f"SetGO goEnd,{self.small()};")
        module.routines[:0] = [f"{STATEMENT}  PROC main()", *self.lines, "  ENDPROC"]
