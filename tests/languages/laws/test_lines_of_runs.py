"""A line is judged as if it stood alone, however many lines like it are around it.

Long runs of like lines are read as columns. Each bad line is put first, in the middle and last into
runs that are short enough to be read line by line, and into long ones: both have the same findings,
at the same places.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, Final, NamedTuple

import pytest

from assistant import languages
from assistant.findings.rulebook import pages
from assistant.program.text import SourceText

ALONE: Final = 3
"""Lines of a run that no reader takes for columns."""
PLACES: Final = ("first", "middle", "last")


class Way(NamedTuple):
    """Form of a run. size: its lines. place: of the bad one. mixed: with lines of other
    kinds between them. comments: behind each line.
    """

    size: int
    place: str
    mixed: bool = False
    comments: bool = False

    @property
    def at(self) -> int:
        return {"first": 0, "middle": self.size // 2, "last": self.size - 1}[self.place]

    @property
    def alone(self) -> Way:
        return self._replace(size=ALONE)


QUICK: Final = [
    *(Way(size, "middle") for size in (7, 8, 9)),
    *(Way(50, place) for place in PLACES),
    Way(20, "middle", mixed=True),
    Way(9, "last", comments=True),
]
EVERY: Final = [
    Way(size, place, mixed, comments)
    for size in (7, 8, 9, 20, 50)
    for place in PLACES
    for mixed in (False, True)
    for comments in (False, True)
]
Finding = tuple[str, int, int, int, str]
Check = Callable[[str], Sequence[Any]]


class Kind(NamedTuple):
    """A kind of bad line. bad: the line, or what it is by its number. plain: what stands around it,
    by the number of the line. text: of a program with a run. mark: of comments, empty where none
    may be.
    """

    bad: str | Callable[[int], str]
    plain: Callable[[int, Way], str]
    text: Callable[[str], str]
    mark: str

    def program(self, way: Way) -> tuple[str, int]:
        """The text of a program, and the line that is the bad one, counted from 0."""
        lines = [self.plain(number, way) for number in range(way.size)]
        bad = lines[way.at] = self.bad if isinstance(self.bad, str) else self.bad(way.at)
        comment = f" {self.mark} seen" if way.comments else ""
        text = self.text("".join(f"{line}{comment}\n" for line in lines))
        return text, text.split("\n").index(bad + comment)

    def findings(self, check: Check, way: Way) -> list[Finding]:
        """Code, line, columns and message of each finding.

        Lines are counted from the bad one; those behind the run from the end of the text.
        """
        text, bad = self.program(way)
        end, lines = bad + way.size - way.at, text.count("\n")
        return sorted(
            (f.code, (f.line or 0) - 1 - (bad if (f.line or 0) <= end else lines), *of(f))
            for f in check(text)
        )


_STEP: Final = re.compile(r"\bstep \d+")


def of(finding: Any) -> tuple[int, int, str]:
    """Columns and message, without step numbers, which differ from run to run."""
    return finding.column or 0, finding.end_column or 0, _STEP.sub("step", finding.message)


def judge(kind: Kind, check: Check, ways: Sequence[Way]) -> set[str]:
    """The codes that a kind has in every way that it is written."""
    codes: set[str] = set()
    expected: dict[Way, list[Finding]] = {}
    for way in ways:
        if way.comments and not kind.mark:
            continue
        if way.alone not in expected:
            expected[way.alone] = kind.findings(check, way.alone)
        found = kind.findings(check, way)
        assert found == expected[way.alone], way
        codes.update(code for code, *_ in found)
    return codes


# RAPID

EAX: Final = "[9E9,9E9,9E9,9E9,9E9,9E9]"
DATA: Final = f"""\
PERS tooldata t1:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
CONST tooldata tc:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
VAR tooldata tv;
PERS wobjdata w1:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
CONST wobjdata wc:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
CONST jointtarget jt:=[[0,0,0,0,30,0],{EAX}];
CONST robtarget two{{2}}:=[
  [[400,0,300],[0,0,1,0],[0,0,0,0],{EAX}],[[0,0,9],[0,0,1,0],[0,0,0,0],{EAX}]];
VAR num n1:=5;
VAR string text:="x";
CONST robtarget a1:=[[400,0,300],[0,0,1,0],[0,0,0,0],{EAX}];
CONST robtarget a2:=[[420,0,300],[0,0,1,0],[0,0,0,0],{EAX}];
CONST robtarget a3:=[[420,20,300],[0,0,1,0],[0,0,0,0],{EAX}];
CONST robtarget a4:=[[400,20,300],[0,0,1,0],[0,0,0,0],{EAX}];
"""
USES: Final = 'PROC other()\nTPWrite "t1 tc tv w1 wc jt two n1 text a1 a2 a3 a4 ppp";\nENDPROC\n'
"""Words in a text count as uses."""


def _module(moves: str, data: str = "") -> str:
    return f"MODULE m\n{DATA}{data}PROC main()\nTPErase;\n{moves}ENDPROC\n{USES}ENDMODULE\n"


def _named(number: int, way: Way) -> str:
    word = "MoveJ" if way.mixed and (number - way.at) % 3 == 1 else "MoveL"
    return f"{word} a{number % 2 * 2 + 1},v100,z10,t1;"


def _in_frame(number: int, way: Way) -> str:
    return _named(number, way).replace(";", r"\WObj:=w1;")


def _target(number: int, rotation: str = "[0,0,1,0]", confdata: str = "[0,0,0,0]") -> str:
    return f"[[{400 + number},0,300],{rotation},{confdata},{EAX}]"


def _written(number: int, way: Way) -> str:
    if way.mixed and (number - way.at) % 3 == 1:
        return _named(number, way)
    return f"MoveL {_target(number)},v100,z10,t1;"


def _declared(number: int, way: Way) -> str:
    scope = "LOCAL " if way.mixed and (number - way.at) % 3 == 1 else ""
    return f"{scope}CONST robtarget ppp{number}:={_target(number)};"


MOVES: Final = {
    "an undeclared speed": ("MoveL a1,v2OO,z10,t1;", "RA403"),
    "a speed beside a predefined one": ("MoveL a1,v101,z10,t1;", "RA204"),
    "an undeclared zone": ("MoveL a1,v100,corner,t1;", "RA403"),
    "a zone beside a predefined one": ("MoveL a1,v100,z3,t1;", "RA205"),
    "an undeclared tool": ("MoveL a1,v100,z10,tX;", "RA403"),
    "an undeclared work object": (r"MoveL a1,v100,z10,t1\WObj:=wX;", "RA403"),
    "an undeclared target": ("MoveL nowhere,v100,z10,t1;", "RA403"),
    "an undeclared circle point": ("MoveC nowhere,a2,v100,z10,t1;", "RA403"),
    "speed and zone swapped": ("MoveL a1,z10,v100,t1;", "RA411"),
    "a number as speed": ("MoveL a1,n1,z10,t1;", "RA411"),
    "a number as zone": ("MoveL a1,v100,n1,t1;", "RA411"),
    "a string as tool": ("MoveL a1,v100,z10,text;", "RA411"),
    "a number as target": ("MoveL n1,v100,z10,t1;", "RA411"),
    "a joint target": ("MoveL jt,v100,z10,t1;", "RA411"),
    "an array without its index": ("MoveL two,v100,z10,t1;", "RA411"),
    "a predefined speed as target": ("MoveL v100,v100,z10,t1;", "RA411"),
    "a tool as work object": (r"MoveL a1,v100,z10,t1\WObj:=t1;", "RA411"),
    "a work object as tool": ("MoveL a1,v100,z10,w1;", "RA411"),
    "a constant tool": ("MoveL a1,v100,z10,tc;", "RA208"),
    "a variable tool": ("MoveL a1,v100,z10,tv;", "RA208"),
    "a constant work object": (r"MoveL a1,v100,z10,t1\WObj:=wc;", "RA208"),
    "a circle point at the end": ("MoveC a2,a2,v100,z10,t1;", "RA459"),
    "a move to numbers without orientation": (
        f"MoveL {_target(0, '[0,0,0,0]')},v100,z10,t1;", "RA462",
    ),
    "a quaternion that is no unit": (f"MoveL {_target(0, '[0,0.2,1,0]')},v100,z10,t1;", "RA206"),
    "half a quadrant": (f"MoveL {_target(0, confdata='[0,0.5,0,0]')},v100,z10,t1;", "RA463"),
    "a shape there is not": (f"MoveL {_target(0, confdata='[0,0,0,8]')},v100,z10,t1;", "RA464"),
}  # fmt: skip
"""What is wrong with a move → the move, and the code of its finding."""
DECLARATIONS: Final = {
    "the name of a speed": ("CONST robtarget v100:={};", "RA210"),
    "the name of a zone": ("CONST robtarget z10:={};", "RA210"),
    "a name that data have": ("CONST robtarget n1:={};", "RA201"),
    "a name that a routine has": ("CONST robtarget other:={};", "RA201"),
    "a name that a target above has": ("CONST robtarget A1:={};", "RA201"),
    "a target that nothing uses": ("CONST robtarget idle:={};", "RA452"),
    "no orientation": (f"CONST robtarget ppp:={_target(0, '[0,0,0,0]')};", "RA462"),
    "a quaternion that is no unit": (f"CONST robtarget ppp:={_target(0, '[0,0.2,1,0]')};", "RA206"),
    "half a quadrant": (f"CONST robtarget ppp:={_target(0, confdata='[0,0.5,0,0]')};", "RA463"),
    "a shape there is not": (f"CONST robtarget ppp:={_target(0, confdata='[0,0,0,8]')};", "RA464"),
}


def rapid() -> Iterator[tuple[str, Kind, str]]:
    """Each kind of bad line of RAPID with a name, and the code of its finding."""
    for name, (bad, code) in MOVES.items():
        for plain in (_named, _in_frame, _written):
            yield f"{name}, {plain.__name__[1:]}", Kind(bad, plain, _module, "!"), code
    for name, (bad, code) in DECLARATIONS.items():
        text = bad.format(_target(7))
        kind = Kind(text, _declared, lambda data: _module("MoveL a1,v100,z10,t1;\n", data), "!")
        yield f"declared: {name}", kind, code
        inner = Kind(text, _declared, _in_routine, "!")
        if code not in ("RA201", "RA452"):
            yield f"declared in a routine: {name}", inner, code


def _in_routine(data: str) -> str:
    inner = data.replace("LOCAL ", "")
    return f"MODULE m\n{DATA}PROC main()\n{inner}{USES[13:]}{USES}ENDMODULE\n"


def _check(name: str) -> Check:
    language = languages.get(name)
    return lambda text: language.check([language.parse(SourceText(text, "m.txt", newline="\n"))])


RAPID: Final = {name: (kind, code) for name, kind, code in rapid()}
SOME: Final = [
    *(name for at, name in enumerate(RAPID) if at < 3 * len(MOVES) and at % 3 == at // 3 % 3),
    *(name for name in RAPID if name.startswith("declared:")),
]
"""Each kind of move among lines of one kind."""


@pytest.mark.parametrize("name", SOME)
def test_a_line_of_rapid_is_judged_alone(name: str) -> None:
    kind, code = RAPID[name]
    assert code in judge(kind, _check("rapid"), QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("name", RAPID)
def test_a_line_of_rapid_is_judged_alone_in_every_way(name: str) -> None:
    kind, code = RAPID[name]
    assert code in judge(kind, _check("rapid"), EVERY)


# MELFA-BASIC

POSITIONS: Final = """\
P1=(400.00,0.00,300.00,180.00,0.00,180.00)(7,0)
P2=(420.00,0.00,300.00,180.00,0.00,180.00)(7,0)
P3=(420.00,20.00,300.00,180.00,0.00,180.00)(7,0)
"""
FURTHER: Final = (
    "P8=(440.00,0.00,300.00,180.00,0.00,180.00)(6,0)",
    "P9=(0.00,0.00,0.00,0.00,0.00,0.00)(0,0)",
    "P12345678=(440.00,0.00,300.00,180.00,0.00,180.00)(7,0)",
)
OF_LINES: Final = {
    "a position that is not there": ("{} MVS P77", "MB104"),
    "a circle point that is not there": ("{} MVR P1,P77,P2", "MB104"),
    "a step that does not ascend": ("2 MVS P1", "MB108"),
    "a step that is too large": ("40000 MVS P1", "MB109"),
    "a position that was never taught": ("{} MVS P9", "MB701"),
    "a line to another posture": ("{} MVS P8", "MB702"),
    "an arc without a circle point": ("{} MVR P1,P1,P2", "MB703"),
    "an arc that ends where its circle point is": ("{} MVR P1,P2,P2", "MB703"),
    "an arc from elsewhere": ("{} MVR P3,P1,P2", "MB704"),
    "a name that is too long": ("{} MVS P12345678", "MB106"),
}
"""What is wrong with a move → the move behind its step number, and the code of its finding."""
OF_POSITIONS: Final = {
    "a position that is there": ("P1=(1.00,0.00,0.00,0.00,0.00,0.00)(7,0)", "MB112"),
    "a position that nothing uses": ("P55=(1.00,0.00,0.00,0.00,0.00,0.00)(7,0)", "MB116"),
    "a name that is too long": ("P12345678=(1.00,0.00,0.00,0.00,0.00,0.00)(7,0)", "MB106"),
}


def _step(number: int, way: Way) -> str:
    word = "MOV" if way.mixed and (number - way.at) % 3 == 1 else "MVS"
    return f"{number * 10 + 1000} {word} P{(number - way.at) % 2 + 1}"


def _position(number: int, way: Way) -> str:
    flag = 7 - way.mixed * (number % 2)
    return f"P{number + 100}=({number}.50,0.00,300.00,180.00,0.00,180.00)({flag},0)"


def _steps(moves: str) -> str:
    more = "".join(f"{line}\n" for line in FURTHER if line.split("=")[0] in moves)
    uses = "9000 HLT\n9010 MOV P1\n9020 MOV P2\n9030 MOV P3\n"
    return f"1 TOOL (0,0,100,0,0,0)\n{moves}{uses}{POSITIONS}{more}"


def _listed(positions: str) -> str:
    names = re.findall(r"^(P1[0-9][0-9])=", positions, re.MULTILINE)
    uses = "".join(f"{k + 10} PX={name}\n" for k, name in enumerate(names))
    uses += "900 MOV P1\n910 MOV P2\n920 MOV P3\n930 MOV PX\n"
    return f"1 TOOL (0,0,100,0,0,0)\n{uses}{POSITIONS}{positions}"


def melfa() -> Iterator[tuple[str, Kind, str]]:
    """Each kind of bad line of MELFA-BASIC IV with a name, and the code of its finding."""
    for name, (bad, code) in OF_LINES.items():
        yield name, Kind(partial(_numbered, bad), _step, _steps, "'"), code
    for name, (bad, code) in OF_POSITIONS.items():
        yield f"declared: {name}", Kind(bad, _position, _listed, ""), code


def _numbered(bad: str, number: int) -> str:
    return bad.format(number * 10 + 1000)


MELFA: Final = {name: (kind, code) for name, kind, code in melfa()}


@pytest.mark.parametrize("name", MELFA)
def test_a_line_of_melfa_basic_is_judged_alone(name: str) -> None:
    kind, code = MELFA[name]
    assert code in judge(kind, _check("melfa-basic-4"), QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("name", MELFA)
def test_a_line_of_melfa_basic_is_judged_alone_in_every_way(name: str) -> None:
    kind, code = MELFA[name]
    assert code in judge(kind, _check("melfa-basic-4"), EVERY)


# The examples of the pages

CLEAN: Final = "CONST robtarget zzz{}:=" + _target(1) + ";"
SPOTS: Final = {
    "move": (re.compile(r"\s*Move[JLC] [^!\"]*;"), "MoveL zzz0,v100,z10,tool0;", 1),
    "declaration": (re.compile(r"\s*(?:LOCAL )?CONST robtarget [^!\"]*;"), CLEAN, 2),
}
"""Lines of examples that may be in a run: their form, what is put around them, and how it begins to
be counted."""


def examples() -> Iterator[tuple[str, str, int]]:
    """Each line of an example of RAPID that may be in a run: its code, the kind, its number."""
    for code, page in pages().items():
        lines = page.example.split("\n") if code.startswith("RA") else ()
        for number, line in enumerate(lines):
            for kind, (form, _, _) in SPOTS.items():
                if form.fullmatch(line):
                    yield code, kind, number


def _around(example: str, kind: str, number: int, count: int) -> tuple[str, int]:
    """An example with so many lines before and behind one of them, and where that is now."""
    _, plain, first = SPOTS[kind]
    lines = example.split("\n")
    before = [plain.format(first + k) for k in range(count)]
    after = [plain.format(first + count + k) for k in range(count)]
    lines[number : number + 1] = [*before, lines[number], *after]
    top = next(k for k, line in enumerate(lines) if line.startswith("MODULE")) + 1
    lines.insert(top, CLEAN.format(0).replace("CONST", "PERS"))
    end = next(k for k in reversed(range(len(lines))) if lines[k].startswith("ENDMODULE"))
    lines.insert(end, 'PROC zzz()\nTPWrite "zzz";\nENDPROC')
    return "\n".join(lines), number + count + (top <= number + count)


def _seen(code: str, kind: str, number: int, count: int) -> list[tuple[str, int, int, int, str]]:
    """The findings of an example with so many lines around one of it; see `Kind.findings`."""
    text, bad = _around(pages()[code].example, kind, number, count)
    lines, found = text.count("\n"), list[tuple[str, int, int, int, str]]()
    for one in _check("rapid")(text):
        line = (one.line or 0) - 1
        near = line - (0 if line < bad - count else bad if line <= bad + count else lines)
        found.append((one.code, near, *of(one)))
    return sorted(found)


@pytest.mark.parametrize(("code", "kind", "number"), list(examples()))
def test_an_example_is_judged_alone(code: str, kind: str, number: int) -> None:
    assert _seen(code, kind, number, 10) == _seen(code, kind, number, 1)
