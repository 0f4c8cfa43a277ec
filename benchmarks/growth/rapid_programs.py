"""Modules of RAPID that grow: data, routines, blocks, and what is wrong many times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from benchmarks.growth.construct import Lines


def _semicolons(n: int) -> Iterator[str]:
    yield from ("PROC main()", ";" * n, "ENDPROC")


def _marks(n: int) -> Iterator[str]:
    yield from ("PROC main()", ";," * n, "ENDPROC")


def _marks_in_a_value(n: int) -> Iterator[str]:
    yield from ("PROC main()", f"a := [{'1,,' * n}];", "ENDPROC")


def _equal_names(n: int) -> Iterator[str]:
    for _ in range(n):
        yield from ("PROC a()", "ENDPROC")


def _equal_data(n: int) -> Iterator[str]:
    yield from ("VAR num a := 1;" for _ in range(n))


def _data(n: int) -> Iterator[str]:
    yield from (f"VAR num a{k} := {k};" for k in range(n))


def _used_data(n: int) -> Iterator[str]:
    yield from (f"PERS num a{k} := {k};" for k in range(n))
    yield "PROC main()"
    yield from (f"  a{k} := a{(k + 1) % n};" for k in range(n))
    yield "ENDPROC"


def _constants(n: int) -> Iterator[str]:
    yield "CONST num a0 := 1;"
    yield from (f"CONST num a{k} := a{k - 1} + 1;" for k in range(1, n))


def _records(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"RECORD r{k}", "num a;", "ENDRECORD")


def _targets(n: int) -> Iterator[str]:
    rest = "[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    yield from (f"CONST robtarget p{k} := [[{k},1,2],{rest};" for k in range(n))
    yield "PROC main()"
    yield from (f"MoveL p{k}, v{100 if k % 2 else 200}, fine, tool0;" for k in range(n))
    yield "ENDPROC"


def _processes(n: int) -> Iterator[str]:
    yield "CONST robtarget p := [[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    for k in range(n):
        yield from (f"PERS spotdata s{k} := [{k},2000,2,1];", f'PERS beaddata b{k} := ["",1];')
    yield "PROC main()"
    for k in range(n):
        yield from (f"SpotL p, v100, gun{k % 4}, s{k}, tool0;", f"DispL p, v100, b{k}, z1, tool0;")
    yield "ENDPROC"


def _outputs_on_the_way(n: int) -> Iterator[str]:
    yield "CONST robtarget p := [[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    yield from ("VAR triggdata t;", "PROC main()", "VAR num a;")
    for k in range(n):
        yield from (
            f"a := {k % 50};",
            "TriggIO t, a\\DOp:=do1, 1;",
            f"TriggL Offs(p, {k % 100}, 0, 0), v100, t, fine, tool0;",
        )
    yield "ENDPROC"


def _routines(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"PROC p{k}()", f"p{k + 1};" if k + 1 < n else "", "ENDPROC")


def _routine_ring(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (f"PROC p{k}()", f"p{(k + 1) % n};", "ENDPROC")


def _function_chain(n: int) -> Iterator[str]:
    for k in range(n):
        yield from (
            f"FUNC num f{k}(num x)",
            f"RETURN f{k + 1}(x);" if k + 1 < n else "RETURN 1;",
            "ENDFUNC",
        )


def _by_reference(n: int) -> Iterator[str]:
    yield from ("PROC main()", "VAR num y;", "p0 y;", "ENDPROC")
    for k in range(n):
        yield from (
            f"PROC p{k}(INOUT num x)",
            f"p{k + 1} x;" if k + 1 < n else "x := 1;",
            "ENDPROC",
        )


def _rapid_ladder(n: int) -> Iterator[str]:
    yield from ("PROC main()", "VAR num y;", "VAR num z;", "p0 y;", "p0 z;", "ENDPROC")
    for k in range(n):
        calls = (f"p{k + 1} x;", f"p{k + 1} w;") if k + 1 < n else ("x := 1;",)
        yield from (f"PROC p{k}(INOUT num x)", "VAR num w;", *calls, "ENDPROC")


def _parameters(n: int) -> Iterator[str]:
    yield f"PROC p({', '.join(f'num a{k}' for k in range(n))})"
    yield "ENDPROC"


def _options(n: int) -> Iterator[str]:
    yield f"PROC p({' '.join(f'{chr(92)}num a{k}' for k in range(n))})"
    yield "ENDPROC"


def _rapid_if_open(n: int) -> Iterator[str]:
    yield from ("PROC main()", *("IF a THEN" for _ in range(n)), "ENDPROC")


def _rapid_if_lines(n: int) -> Iterator[str]:
    yield "PROC main()"
    for _ in range(n):
        yield from ("IF a THEN", "b;", "", "c;")
    yield "ENDPROC"


def _rapid_half_if(n: int) -> Iterator[str]:
    yield "PROC main()"
    for _ in range(n):
        yield from ("IF a", "b;", "ENDIF")
    yield "ENDPROC"


def _rapid_ends(n: int) -> Iterator[str]:
    yield from ("PROC main()", *("ENDIF" for _ in range(n)), "ENDPROC")


def _rapid_labels(n: int) -> Iterator[str]:
    yield "PROC main()"
    for k in range(n):
        yield from (f"l{k}:", f"GOTO l{(7 * k + 1) % n};")
    yield "ENDPROC"


def _rapid_back(n: int) -> Iterator[str]:
    yield "PROC main()"
    yield from (f"l{k}:" for k in range(n))
    yield from (f"IF a = {k} GOTO l{k};" for k in range(n))
    yield "ENDPROC"


def _traps(n: int) -> Iterator[str]:
    yield from (f"VAR intnum i{k};" for k in range(n))
    yield "PROC main()"
    yield from (f"CONNECT i{k} WITH t{k};" for k in range(n))
    yield "ENDPROC"
    for k in range(n):
        yield from (f"TRAP t{k}", "ENDTRAP")


def _sum(n: int) -> Iterator[str]:
    yield "PROC main()"
    yield from ("a := " + " + ".join(["1"] * min(50, n - k)) + ";" for k in range(0, n, 50))
    yield "ENDPROC"


def _loops(n: int) -> Iterator[str]:
    yield "PROC main()"
    for k in range(n):
        yield from (f"FOR i FROM 1 TO {k} DO", "MoveL p, v10, fine, tool0;", "ENDFOR")
    yield "ENDPROC"


def _strings(n: int) -> Iterator[str]:
    yield from ("PROC main()", *(f'TPWrite "a{k}";' for k in range(n)), "ENDPROC")


def _string(n: int) -> Iterator[str]:
    yield from ("PROC main()", f'TPWrite "{"x" * n}";', "ENDPROC")


def _comments(n: int) -> Iterator[str]:
    yield from ("PROC main()", *("! a" for _ in range(n)), "ENDPROC")


def _long_line(n: int) -> Iterator[str]:
    yield from ("PROC main()", "a;" * n, "ENDPROC")


def _rapid_long_name(n: int) -> Iterator[str]:
    yield from ("PROC main()", "a" * n + ";", "ENDPROC")


def _blanks(n: int) -> Iterator[str]:
    yield from ("PROC main()", " " * n + ";", "ENDPROC")


def _outside(n: int) -> Iterator[str]:
    yield "ENDMODULE"
    for _ in range(n):
        yield "a b c"


RAPID: Final[Mapping[str, Lines]] = {
    "semicolons on a line": _semicolons,
    "semicolons and commas on a line": _marks,
    "commas in a value": _marks_in_a_value,
    "routines of one name": _equal_names,
    "data of one name": _equal_data,
    "data": _data,
    "data that is used": _used_data,
    "constants of each other": _constants,
    "records": _records,
    "targets and moves": _targets,
    "spots and beads": _processes,
    "outputs on the way": _outputs_on_the_way,
    "routines in a chain": _routines,
    "routines in a ring": _routine_ring,
    "functions in a chain": _function_chain,
    "routines in a chain, by reference": _by_reference,
    "routines in a ladder, by reference": _rapid_ladder,
    "parameters": _parameters,
    "options": _options,
    "IF without ENDIF": _rapid_if_open,
    "IF without ENDIF and statements": _rapid_if_lines,
    "IF without THEN": _rapid_half_if,
    "ENDIF alone": _rapid_ends,
    "labels and jumps": _rapid_labels,
    "jumps back": _rapid_back,
    "traps": _traps,
    "sums": _sum,
    "loops": _loops,
    "strings": _strings,
    "a long string": _string,
    "comments": _comments,
    "a long line": _long_line,
    "a long name": _rapid_long_name,
    "blanks": _blanks,
    "words behind the module": _outside,
}
