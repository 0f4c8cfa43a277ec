"""A line is judged as if it stood alone, however many lines like it are around it.

Long runs of like lines are read as columns. Each bad line is put first, in the middle and last into
runs that are short enough to be read line by line, and into long ones: both have the same findings,
at the same places.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any, Final, NamedTuple

import pytest

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.findings.rulebook import pages, rules_in
from assistant.languages.melfa_basic.reading import parser
from tests.tables import every_row

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
LONGEST: Final = Way(50, "last")
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

        Lines are counted from the bad one; those above the run from the begin of the text, those
        behind it from its end.
        """
        text, bad = self.program(way)
        first, end, lines = bad - way.at, bad + way.size - way.at, text.count("\n")
        found = list[Finding]()
        for one in check(text):
            line = (one.line or 0) - 1
            near = line - (0 if line < first else bad if line < end else lines)
            found.append((one.code, near, *of(one)))
        return sorted(found)


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


def some(name: str, names: Iterable[str]) -> Sequence[Way]:
    """The longest way for a kind, and another for the next one: all are tried by many kinds."""
    at = list(names).index(name)
    return [LONGEST, QUICK[at % len(QUICK)]]


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
PERS wobjdata wh:=[TRUE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
PERS tooldata ts:=[FALSE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
VAR triggdata trg;
VAR robtarget here;
CONST robtarget a1:=[[400,0,300],[0,0,1,0],[0,0,0,0],{EAX}];
CONST robtarget a2:=[[420,0,300],[0,0,1,0],[0,0,0,0],{EAX}];
CONST robtarget a3:=[[420,20,300],[0,0,1,0],[0,0,0,0],{EAX}];
CONST robtarget a4:=[[400,20,300],[0,0,1,0],[0,0,0,0],{EAX}];
"""
USED: Final = "t1 tc tv w1 wc jt two n1 text wh ts trg here a1 a2 a3 a4 ppp"
USES: Final = f'PROC other()\nTPWrite "{USED}";\nENDPROC\n'
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
    "a comma that is missing": ("MoveL a1 v100,z10,t1;", "RA103"),
    "a missing comma and an undeclared speed": ("MoveL a1 v2OO,z10,t1;", "RA103"),
    "a semicolon that is missing": ("MoveL a1,v100,z10,t1", "RA103"),
    "a bracket that is missing": (f"MoveL [[4,0,3,[0,0,1,0],[0,0,0,0],{EAX}],v9,z1,t1;", "RA103"),
    "an instruction that nobody knows": ("MoveX a1,v100,z10,t1;", "RA401"),
    "an instruction that is misspelt": ("MoveLL a1,v100,z10,t1;", "RA402"),
    "no tool": ("MoveL a1,v100,z10;", "RA404"),
    "an argument too many": ("MoveL a1,v100,z10,t1,n1;", "RA405"),
    "an option that is not there": (r"MoveL a1,v100,z10,t1\Fast;", "RA418"),
    "options that exclude each other": (r"MoveL a1,v100\V:=100\T:=5,z10,t1;", "RA407"),
    "an option without its value": (r"MoveL a1,v100,z10,t1\WObj;", "RA408"),
    "a switch with a value": (r"MoveL\Conc:=1,a1,v100,z10,t1;", "RA409"),
    "an identity that is a text": (r"MoveL a1\ID:=text,v100,z10,t1;", "RA411"),
    "a component that is not there": ("MoveL a1.foo,v100,z10,t1;", "RA426"),
    "an index too many": ("MoveL two{1,2},v100,z10,t1;", "RA427"),
    "an index outside of the array": ("MoveL two{5},v100,z10,t1;", "RA430"),
    "a target without external axes": ("MoveL [[4,0,3],[0,0,1,0],[0,0,0,0]],v100,z10,t1;", "RA423"),
    "a text in a target": (f"MoveL [[text,0,3],[0,0,1,0],[0,0,0,0],{EAX}],v100,z10,t1;", "RA425"),
    "a sum of a target and a text": ("MoveL a1+text,v100,z10,t1;", "RA428"),
    "a function as instruction": ("Offs a1,0,0,0;", "RA415"),
    "a procedure as target": ("MoveL other(),v100,z10,t1;", "RA416"),
    "the name of a procedure as target": ("MoveL other,v100,z10,t1;", "RA419"),
    "a procedure in a target": ("MoveL Offs(a1,other,0,0),v100,z10,t1;", "RA419"),
    "data that are called": ("MoveL a1(1),v100,z10,t1;", "RA417"),
    "a declaration among moves": (f"CONST robtarget late:={_target(1)};", "RA209"),
    "moves that nothing reaches": ("RETURN;", "RA450"),
    "a jump to nowhere": ("GOTO nowhere;", "RA224"),
    "a trigger that nothing sets up": ("TriggL a1,v100,trg,z10,t1;", "RA465"),
    "a position read in a corner": (r"here:=CRobT(\Tool:=t1);", "RA456"),
    "an arc that goes round": ("MoveL a1,v9,z1,t1;MoveC a2,a4,v9,z1,t1;", "RA461"),
    "a constant that is assigned to": ("a1:=a2;", "RA215"),
    "a tool and a work object that are held": (r"MoveL a1,v100,z10,t1\WObj:=wh;", "RA470"),
    "neither of them held": ("MoveL a1,v100,z10,ts;", "RA471"),
    "an output in a corner": ("SetDO doX,1;", "RA455"),
    "a text that is too long": (f'TPWrite "{"x" * 81}";', "RA203"),
}  # fmt: skip
"""What is wrong with a move, or with a line among moves → the line, and the code of its finding."""
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
    "a name that is too long": (f"CONST robtarget {'p' * 33}:={{}};", "RA202"),
    "a type that is misspelt": ("CONST robtargt ppp:={};", "RA422"),
    "a type that nobody knows": ("CONST foobar ppp:={};", "RA421"),
    "no external axes": ("CONST robtarget ppp:=[[4,0,3],[0,0,1,0],[0,0,0,0]];", "RA423"),
    "a text": (f'CONST robtarget ppp:=[["x",0,3],[0,0,1,0],[0,0,0,0],{EAX}];', "RA425"),
    "a comma that is missing": (
        f"CONST robtarget ppp:=[[4 0,3],[0,0,1,0],[0,0,0,0],{EAX}];", "RA103",
    ),
    "a missing comma and the name of a speed": (
        f"CONST robtarget v100:=[[4 0,3],[0,0,1,0],[0,0,0,0],{EAX}];", "RA103",
    ),
    "a semicolon that is missing": ("CONST robtarget ppp:={}", "RA103"),
    "a reserved word": ("CONST robtarget IF:={};", "RA101"),
    "a PERS that is no literal": ("PERS robtarget ppp:=a1;", "RA207"),
    "a constant of a variable": ("CONST tooldata ppp:=tv;", "RA217"),
    "a constant without a value": ("CONST robtarget ppp;", "RA218"),
    "a type that has no value": ('VAR iodev ppp:="x";', "RA219"),
    "an array of nothing": ("CONST robtarget ppp{{0}}:=[{}];", "RA221"),
    "an array that lacks an element": ("CONST robtarget ppp{{2}}:=[{}];", "RA424"),
    "the name of the module": ("CONST robtarget m:={};", "RA214"),
    "a tool without a mass": (
        "PERS tooldata ppp:=[TRUE,[[0,0,1],[1,0,0,0]],[0,[0,0,1],[1,0,0,0],0,0,0]];", "RA469",
    ),
    "a work object that nothing moves": (
        'PERS wobjdata ppp:=[FALSE,FALSE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];', "RA468",
    ),
    "a number that is too large": ("CONST dnum ppp:=1E400;", "RA230"),
    "an alias of an alias": ("ALIAS num one;ALIAS one other_one;", "RA223"),
}  # fmt: skip
OF_MODULES: Final = frozenset(("RA201", "RA214", "RA223", "RA452"))
"""Findings on declarations in modules only."""


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
        if code not in OF_MODULES:
            yield f"declared in a routine: {name}", inner, code


def _in_routine(data: str) -> str:
    inner = data.replace("LOCAL ", "")
    return f"MODULE m\n{DATA}PROC main()\n{inner}{USES[13:]}{USES}ENDMODULE\n"


def _check(name: str) -> Check:
    language = languages.get(name)

    def check(text: str) -> Sequence[Any]:
        tree = language.parse(SourceText(text, "m.txt", newline="\n"))
        return [*dict.fromkeys((*tree.findings, *language.check([tree])))]

    return check


RAPID: Final = {name: (kind, code) for name, kind, code in rapid()}
SOME: Final = [
    *(name for at, name in enumerate(RAPID) if at < 3 * len(MOVES) and at % 3 == at // 3 % 3),
    *(name for name in RAPID if name.startswith("declared:")),
]
"""Each kind of move among lines of one kind."""


@every_row("name", SOME)
def test_a_line_of_rapid_is_judged_alone(name: str) -> None:
    kind, code = RAPID[name]
    assert code in judge(kind, _check("rapid"), some(name, SOME))


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
    "a comma that is missing": ("{} MVS P1 P2", "MB002"),
    "a character that is none": ("{} MVS P1 ?", "MB002"),
    "words behind the move": ("{} MVS P1 HELLO", "MB002"),
    "a number as position": ("{} MVS 5", "MB603"),
    "joints as position": ("{} MVS J1", "MB603"),
    "a variable that nothing sets": ("{} MVS P1,M9", "MB113"),
    "an argument too many": ("{} MVS P1,1,2,3", "MB602"),
    "a type that is none": ("{} MVS P1 TYPE 9,9", "MB601"),
    "an array that is none": ("{} MVS P(2)", "MB119"),
    "a line that is too long": ("{} MVS P1 '" + "x" * 240, "MB107"),
    "a jump to no label": ("{} GOTO *NONE", "MB101"),
    "a jump to no line": ("{} GOTO 7777", "MB102"),
    "moves that nothing reaches": ("{} END", "MB141"),
    "a step that is empty": ("{}", "MB618"),
    "an input that is set": ("{} M_IN(1)=1", "MB607"),
    "a number for a position": ("{} P1=5", "MB604"),
    "a text for a number": ('{} M1="A"', "MB612"),
    "a return from nowhere": ("{} RETURN", "MB137"),
    "an end of no loop": ("{} NEXT", "MB105"),
    "a label before a move": ("{} *HERE MVS P1", "MB111"),
    "a wait that is too short": ("{} DLY 0.001", "MB619"),
}
"""What is wrong with a move, or with a line among moves → the line behind its step number, and the
code of its finding."""
OF_POSITIONS: Final = {
    "a position that is there": ("P1=(1.00,0.00,0.00,0.00,0.00,0.00)(7,0)", "MB112"),
    "a position that nothing uses": ("P55=(1.00,0.00,0.00,0.00,0.00,0.00)(7,0)", "MB116"),
    "a name that is too long": ("P12345678=(1.00,0.00,0.00,0.00,0.00,0.00)(7,0)", "MB106"),
    "an element that is left out": ("P55=(1.00,0.00,,0.00,0.00,0.00)(7,0)", "MB616"),
    "three elements": ("P1234=(1.00,0.00,0.00)(7,0)", "MB616"),
    "a comma that is missing": ("P55=(1.00 0.00,0.00,0.00,0.00,0.00)(7,0)", "MB002"),
    "a bracket that is missing": ("P55=(1.00,0.00,0.00,0.00,0.00,0.00(7,0)", "MB002"),
    "a text": ('P55=("A",0.00,0.00,0.00,0.00,0.00)(7,0)', "MB002"),
    "joints": ("J55=(0.00,0.00,0.00,0.00,0.00,0.00)", "MB116"),
    "a letter alone": ("P=(1.00,0.00,0.00,0.00,0.00,0.00)(7,0)", "MB116"),
}
NOT_SINCE_V: Final = frozenset(("MB106", "MB107", "MB111"))
"""MELFA-BASIC V and VI have longer names and lines, and labels in front of statements."""


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


NEWER: Final = ("melfa-basic-5", "melfa-basic-6")


def judge_melfa(name: str, language: str, ways: Sequence[Way]) -> None:
    kind, code = MELFA[name]
    found = judge(kind, _check(language), ways)
    assert code in found or (language in NEWER and code in NOT_SINCE_V), found


@every_row("name", list(MELFA))
def test_a_line_of_melfa_basic_is_judged_alone(name: str) -> None:
    at = list(MELFA).index(name)
    judge_melfa(name, "melfa-basic-4", some(name, MELFA))
    judge_melfa(name, NEWER[at % 2], [LONGEST])


@every_row("name", list(MELFA))
def test_tables_of_melfa_basic_change_nothing(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two lines make a table, so that also the shortest run has some."""
    (kind, code), check = MELFA[name], _check("melfa-basic-4")
    found = kind.findings(check, LONGEST)
    assert code in [one for one, *_ in found]
    with monkeypatch.context() as patch:
        patch.setattr(parser, "rows_at", lambda *_: None)
        assert found == kind.findings(check, LONGEST)


@every_row("name", list(MELFA))
def test_an_include_changes_nothing_of_how_runs_are_judged(name: str) -> None:
    """Names that are not there may be in what is included."""
    check = _check("melfa-basic-6")
    judge(MELFA[name][0], lambda text: check(f'#Include "B"\n{text}'), [LONGEST])


@pytest.mark.parametrize("size", [1, 7, 8, 9, 50])
def test_each_position_between_steps_is_reported(size: int) -> None:
    """MB620 is about a line, and is seen by a step far below it."""
    table = "".join(_position(number, LONGEST) + "\n" for number in range(size))
    found = _check("melfa-basic-5")(f"10 HLT\n{table}20 HLT\n")
    assert [f.line for f in found if f.code == "MB620"] == [*range(2, size + 2)]


@pytest.mark.slow
@pytest.mark.parametrize("language", ["melfa-basic-4", *NEWER])
@pytest.mark.parametrize("name", MELFA)
def test_a_line_of_melfa_basic_is_judged_alone_in_every_way(name: str, language: str) -> None:
    judge_melfa(name, language, EVERY)


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


@every_row(("code", "kind", "number"), list(examples()))
def test_an_example_is_judged_alone(code: str, kind: str, number: int) -> None:
    assert _seen(code, kind, number, 10) == _seen(code, kind, number, 1)


# Which rules are tried

ELSEWHERE: Final = {
    "they are about a file, a list of files or a program as a whole": """
        MB001 MB110 MB114 MB115 MB118 MB122 MB123 MB142 MB143 MB148 MB149 MB401 MB707 MB710
        RA104 RA105 RA106 RA107 RA211 RA212 RA213 RA235""",
    "only a translation, a draft or a way back reports them": """
        MB2.. MB300 MB501 RA3.. RA472 RA473 RA474""",
    "they are about labels, subroutines, blocks, jumps and loops, which no run holds": """
        MB103 MB117 MB120 MB121 MB131 MB132 MB133 MB134 MB135 MB136 MB138 MB139 MB140 MB144 MB145
        MB146 MB147 RA216 RA220 RA222 RA225 RA226 RA228 RA229 RA451 RA453 RA457 RA458 RA467""",
    "they are about operators, conditions, functions and status variables, which no run holds": """
        MB605 MB606 MB608 MB609 MB610 MB611 MB613 MB614 MB617 MB622 RA108 RA429""",
    "they are about calls of routines that are declared, which no run holds": """
        RA406 RA410 RA412 RA413 RA414""",
    "a test of its own tries it": "MB620",
    "they are about waits, files, interrupts and outputs, which no run holds": """
        MB621 MB706 MB708 MB709 MB711 MB712 MB713 RA454""",
    "full circles of their own, which no run holds": "MB705",
    "a damaged line is told by a rule that says more": "MB003 MB004 RA102",
}
"""Why rules are not tried here → their codes, dots for any digit."""


def known() -> set[str]:
    """The codes of all rules of languages."""
    families = {languages.get(name).family for name in languages.names()}
    codes = (rule.code for rule in rules_in(languages))
    return {code for code in codes if code[:2] in families}


def test_every_rule_is_tried_or_concerns_no_line_of_a_run() -> None:
    there = known()
    tried = {code for _, code in (*RAPID.values(), *MELFA.values())}
    tried |= {code for code, *_ in examples()}
    assert tried - there == set()
    patterns = [code for codes in ELSEWHERE.values() for code in codes.split()]
    left = {code for code in there if any(re.fullmatch(one, code) for one in patterns)}
    assert there - tried - left == set(), "write a kind of bad line, or why there is none"
    spare = {code for code in patterns if "." not in code}
    assert spare - there == set() and spare & tried == set()
