"""Programs that grow in what the other language says in other words: records, handlers, calls."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from benchmarks.growth.construct import Lines

_TURN: Final = "[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
_PART: Final = ("RECORD part", "num height;", "pos place;", "ENDRECORD")


def _main(*lines: str) -> Iterator[str]:
    yield from ("PROC main()", *lines, "ENDPROC")


def _record_data(n: int) -> Iterator[str]:
    yield from _PART
    yield from (f"VAR part a{k} := [{k},[{k},0,0]];" for k in range(n))
    yield from _main(*(f"a{k}.height := a{(k + 1) % n}.place.x;" for k in range(n)))


def _record_copies(n: int) -> Iterator[str]:
    yield from (*_PART, "VAR part a;", "VAR part b;")
    yield from _main(*("a := b;" if k % 2 else f"b.height := a.height + {k};" for k in range(n)))


def _record_types(n: int) -> Iterator[str]:
    yield from ("RECORD r0", "num a;", "num b;", "ENDRECORD")
    for k in range(1, n):
        yield from (f"RECORD r{k}", f"r{k - 1} a;", "ENDRECORD")
    yield f"VAR r{n - 1} x;"
    yield from _main(f"x{'.a' * n} := 1;")


def _record_rows(n: int) -> Iterator[str]:
    yield from (*_PART, f"VAR part rows{{{n}}};", "VAR num i := 1;")
    yield from _main(*(f"rows{{{k + 1}}}.height := rows{{i}}.place.y;" for k in range(n)))


def _aggregates(n: int) -> Iterator[str]:
    yield from (
        *_PART,
        "VAR num sum;",
        "PROC take(part one)",
        "sum := sum + one.height;",
        "ENDPROC",
    )
    yield from _main(*(f"take [{k},[{k},0,0]];" for k in range(n)))


def _record_results(n: int) -> Iterator[str]:
    yield from (*_PART, "VAR part a;", "FUNC part made(num h)", "VAR part one;")
    yield from ("one.height := h;", "RETURN one;", "ENDFUNC")
    yield from _main(*(f"a := made({k});" for k in range(n)))


def _places(n: int) -> Iterator[str]:
    yield f"CONST robtarget home := [[400,0,300],{_TURN};"
    yield "VAR robtarget at;"
    moves = ("at.trans.z := {k};", "MoveL Offs(at,{k},0,0), v100, fine, tool0;")
    yield from _main("at := home;", *(moves[k % 2].format(k=k) for k in range(n)))


def _handlers(n: int) -> Iterator[str]:
    yield from ("VAR num a;", "VAR bool b;")
    for k in range(n):
        yield from (f"PROC p{k}()", f'b := StrToVal("{k}",a);', "IF NOT b RAISE 99;")
        yield from ("ERROR", "IF ERRNO = 99 THEN", "a := 0;", "TRYNEXT;", "ENDIF", "ENDPROC")
    yield from _main(*(f"p{k};" for k in range(n)))


def _handled(n: int) -> Iterator[str]:
    yield from ("VAR num a;", "PROC main()", *(f"a := {k} DIV a;" for k in range(n)))
    yield from ("ERROR", "IF ERRNO = ERR_DIVZERO THEN", "a := 1;", "RETRY;", "ENDIF", "ENDPROC")


def _interrupts(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"VAR intnum i{k};", f"VAR signaldi d{k};")
        yield from (f"TRAP t{k}", 'TPWrite "now";', "ENDTRAP")
    ordered = (f"IDelete i{k};\nCONNECT i{k} WITH t{k};\nISignalDI d{k},1,i{k};" for k in range(n))
    yield from _main(*ordered)


def _ways_of_calling(n: int) -> Iterator[str]:
    yield from ("VAR num a;", r"PROC p(num x \num y \switch z)", r"IF Present(y) a := a + y;")
    yield from (r"IF Present(z) a := 0;", "a := a + x;", "ENDPROC")
    ways = ("p {k};", r"p {k} \y:={k};", r"p {k} \z;", r"p {k} \y:={k} \z;")
    yield from _main(*(ways[k % 4].format(k=k) for k in range(n)))


def _procedures_by_way(n: int) -> Iterator[str]:
    yield "VAR num a;"
    for k in range(n):
        yield from (rf"PROC p{k}(\num y)", "IF Present(y) a := a + y;", "ENDPROC")
    yield from _main(*(rf"p{k};" if k % 2 else rf"p{k} \y:=a;" for k in range(n)))


def _given_tools(n: int) -> Iterator[str]:
    yield f"CONST robtarget home := [[400,0,300],{_TURN};"
    for k in range(n):
        flange = "[[0,0,1],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]"
        yield f"PERS tooldata grip{k} := [TRUE,{flange}];"
    yield from ("PROC go(PERS tooldata t)", "MoveL home, v100, fine, t;", "ENDPROC")
    yield from _main(*(f"go grip{k};" for k in range(n)))


def _late_calls(n: int) -> Iterator[str]:
    yield from ("VAR num a;", "VAR string name;")
    for k in range(n):
        yield from (f"PROC part{k}()", f"a := {k};", "ENDPROC")
    yield from _main('name := "part" + NumToStr(a,0);', "%name%;")


def _late_calls_of_few(n: int) -> Iterator[str]:
    yield from ("VAR num a;", "PROC part1()", "a := 1;", "ENDPROC", "PROC part2()", "a := 2;")
    yield from ("ENDPROC", *_main(*(f'%"part" + NumToStr(a + {k},0)%;' for k in range(n))))


def _named_data(n: int) -> Iterator[str]:
    yield from (f"PERS num count{k} := {k};" for k in range(n))
    yield from ("VAR num a;", "VAR string name;")
    yield from _main('name := "count" + NumToStr(a,0);', "GetDataVal name,a;")


def _sockets(n: int) -> Iterator[str]:
    yield from ("VAR socketdev line;", "VAR string got;")
    opened = ("SocketCreate line;", 'SocketConnect line,"192.168.125.2",5000;')
    said = (r"SocketSend line\Str:=got;", r"SocketReceive line\Str:=got;")
    yield from _main(*opened, *(said[k % 2] for k in range(n)), "SocketClose line;")


def _bytes(n: int) -> Iterator[str]:
    yield from ("VAR socketdev line;", "VAR rawbytes raw;", "VAR num a;")
    opened = ("SocketCreate line;", 'SocketConnect line,"192.168.125.2",5000;')
    packed = (r"PackRawBytes a,raw,(RawBytesLen(raw)+1)\Float4;", r"SocketSend line\RawData:=raw;")
    yield from _main(*opened, *(packed[k % 2] for k in range(n)), "SocketClose line;")


def _displacements(n: int) -> Iterator[str]:
    yield f"CONST robtarget home := [[400,0,300],{_TURN};"
    yield "VAR pose shift := [[0,0,0],[1,0,0,0]];"
    lines = ("shift.trans.x := {k};", "PDispSet shift;", "MoveL home, v100, fine, tool0;")
    yield from _main(*(lines[k % 3].format(k=k) for k in range(n)), "PDispOff;")


def _speeds(n: int) -> Iterator[str]:
    yield f"CONST robtarget home := [[400,0,300],{_TURN};"
    yield "VAR speeddata pace := [100,500,5000,1000];"
    lines = ("pace.v_tcp := {k} + 1;", "MoveL home, pace, fine, tool0;")
    yield from _main(*(lines[k % 2].format(k=k) for k in range(n)))


def _stopwatches(n: int) -> Iterator[str]:
    yield from ("VAR clock watch;", "VAR num a;")
    lines = ("ClkReset watch;", "ClkStart watch;", "ClkStop watch;", "a := ClkRead(watch);")
    yield from _main(*(lines[k % 4] for k in range(n)))


def _triggers(n: int) -> Iterator[str]:
    yield f"CONST robtarget home := [[400,0,300],{_TURN};"
    yield from ("VAR triggdata on;", "VAR signaldo d;")
    lines = (r"TriggIO on,{k}\Start\DOp:=d,1;", "TriggL home,v100,on,fine,tool0;")
    yield from _main(*(lines[k % 2].format(k=k % 97) for k in range(n)))


def _asked(n: int) -> Iterator[str]:
    yield "VAR num a;"
    yield from _main(*(f'TPReadFK a,"{k}?","yes","no",stEmpty,stEmpty,stEmpty;' for k in range(n)))


def _text_functions(n: int) -> Iterator[str]:
    yield from ("VAR string a;", "VAR num b;")
    lines = ("b := StrFind(a,{k} MOD 80+1,STR_DIGIT);", "a := StrMap(a,STR_LOWER,STR_UPPER);")
    yield from _main(*(lines[k % 2].format(k=k) for k in range(n)))


WHOLE_RAPID: Final[Mapping[str, Lines]] = {
    "data of records": _record_data,
    "copies of records": _record_copies,
    "records in each other": _record_types,
    "an array of records": _record_rows,
    "records in brackets for a routine": _aggregates,
    "functions that give back records": _record_results,
    "components of targets": _places,
    "handlers": _handlers,
    "statements above a handler": _handled,
    "interrupts": _interrupts,
    "ways of calling": _ways_of_calling,
    "procedures, each called in a way": _procedures_by_way,
    "tools that are handed over": _given_tools,
    "routines that a late call may mean": _late_calls,
    "late calls": _late_calls_of_few,
    "data that a text may name": _named_data,
    "messages over a socket": _sockets,
    "bytes over a socket": _bytes,
    "displacements": _displacements,
    "speeds that change": _speeds,
    "stopwatches": _stopwatches,
    "outputs on the way": _triggers,
    "questions": _asked,
    "functions of texts": _text_functions,
}


def _worked_out_signals(n: int) -> Iterator[str]:
    yield "M1=3"
    yield from (f"M_Out(M1+{k})=M_In(M1)" for k in range(n))
    yield "End"


def _array_moves(n: int) -> Iterator[str]:
    yield from ("Dim P1(100)", "M1=1")
    lines = ("Mvs P1(M1),-{k}", "Spd 100+M1", "P1(M1).X=P1(M1).X+{k}", "Mov P1(M1)*P2")
    yield from (lines[k % 4].format(k=k) for k in range(n))
    yield "End"


def _functions(n: int) -> Iterator[str]:
    yield from ("M1=1", *(f"M1=F{k}(M1)" for k in range(n)), "End")
    for k in range(n):
        yield from (f"Function M F{k}(MX)", f"F{k}=MX+{k}", "FEnd")


def _with_signals(n: int) -> Iterator[str]:
    lines = ("Mvs P1 Wth M_Out(2)=1", "Mvs P2 WthIf M_In(3)=1, M_Out(4)=1")
    yield from (lines[k % 2] for k in range(n))
    yield "End"


def _acts(n: int) -> Iterator[str]:
    yield "Def Act 1,M_In(3)=1 GoSub *Now"
    yield from ("Act 1=1" if k % 2 else "Act 1=0" for k in range(n))
    yield from ("End", "*Now", "M1=M1+1", "Return 1")


def _servo(n: int) -> Iterator[str]:
    lines = ("Servo On", "Wait M_Svo=1", "Spd M_NSpd", "Ovrd 50", "Fine 100", "Mov P1")
    yield from (lines[k % len(lines)] for k in range(n))
    yield "End"


WHOLE_MELFA_BASIC: Final[Mapping[str, Lines]] = {
    "signals by worked-out numbers": _worked_out_signals,
    "moves to elements of arrays": _array_moves,
    "functions with values": _functions,
    "outputs beside moves": _with_signals,
    "interrupts on and off": _acts,
    "settings of the controller": _servo,
}
