"""A changed tree keeps the text of everything that was not changed."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable
from dataclasses import replace
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, example, given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.languages.rapid.tree import syntax as s
from tests.examples import drawn
from tests.languages.rapid.changes import change, settled
from tests.languages.rapid.modules import files
from tests.tables import every_row

RAPID = languages.get("rapid")

LETTERS = """MODULE m(SYSMODULE,NOVIEW)
CONST num a:=5; ! size
LOCAL PERS string texts{2}:=["one","two ""x"" "]; TASK PERS num d:=-1;
RECORD pair num first; string second; ENDRECORD
ALIAS num metre;
! routines
PROC p(num x, VAR num y{*,*} \\switch on|switch off, INOUT bool ready)
  VAR num i;
  a:=1+x*(y{1,2}-3) DIV 2; ! sum
  start:
  IF ready THEN ! go
    Go p1, v100\\T:=2, z10, tool0\\WObj:=w; b.c{2}.d:=[[1,2],[TRUE,NOT f(a\\Dec:=2)]];
  ELSEIF a=2 OR a<>3 THEN
  ELSE
    %"late"+s% 1,2;
    ! end
  ENDIF
  IF a<1 Stop;
  FOR i FROM 1 TO 10 STEP 2 DO a:=i; ENDFOR
  WHILE TRUE DO GOTO start; ENDWHILE
  TEST a
  CASE 1,2: b;
  CASE 3:
  DEFAULT: q x\\Off?off;
  ENDTEST
  CONNECT i1 WITH trap1;
BACKWARD
  RETURN;
ERROR (ERR_A, ERR_B)
  RETRY;
UNDO
ENDPROC
LOCAL FUNC num f(num x\\num Dec)
  RETURN x;
ENDFUNC
TRAP trap1
  RAISE ERR_C;
ENDTRAP
ENDMODULE
! between
MODULE n
ENDMODULE
"""
MOVES = "".join(f"MoveL p{k},v100,z10,tool0;\n" for k in range(10))
TARGETS = "".join(
    f"CONST robtarget p{k}:=[[{k}.50,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
    for k in range(10)
)
TABLES = f"MODULE m\n{TARGETS}PROC p()\nStop;\n{MOVES}! done\nENDPROC\nENDMODULE\n"
GAPS = (" ", "\n", "  ", "\n\n   ", "\t", " ! note\n", "\r\n  ")
WORD = re.compile(r'"(?:[^"]|"")*"|![^\n]*\n|\w+(?:\.\d+)?|:=|<>|\\|\s+|.')


def laid_out(text: str, random: Random) -> str:
    """The same words with other blanks, line ends and comments between them, and in other case."""
    out = ""
    for word in WORD.findall(text):
        if word.isspace():
            odd = random.random() < 0.3
            out += random.choice(GAPS) if odd else word
        elif word[0] == '"' or word[0] == "!":
            out += word
        else:
            case = random.choice((str.lower, str.title, str)) if word.isupper() else str
            out += case(word) + random.choice(("", "", "", " ", random.choice(GAPS)))
    return out


def parsed(text: str) -> s.File:
    tree: s.File = RAPID.parse(text)
    assert not tree.findings, (tree.findings, text)
    return tree


def printed(tree: s.File) -> str:
    return RAPID.render(replace(tree, origin=None))


def lines_of(nodes: tuple[Any, ...], text: str | None = None) -> int:
    """How many lines nodes take, as printed or in the text."""
    count = 0
    for node in nodes:
        span = getattr(node, "span", None)
        if span is not None and text is not None:
            count += text.count("\n", span.start, span.end) + 1
        elif isinstance(node, s.Node):
            count += repr(node).count("(") + 2
    return count


def at_random(seed: int, *texts: str) -> tuple[Random, s.File]:
    """A source of chances and a text in odd layout that it made, read."""
    random = Random(seed)
    tree: s.File = RAPID.parse(laid_out(random.choice(texts), random))
    assume(not tree.findings)  # a comment may stand where it is no statement of its own
    return random, tree


SEEDS = st.integers(0, 1 << 32)
QUICK = settings(max_examples=drawn(50), deadline=None, phases=(Phase.explicit, Phase.generate))


@QUICK
@given(SEEDS)
def test_a_changed_tree_reads_as_it_was_changed(seed: int) -> None:
    random, tree = at_random(seed, LETTERS, TABLES)
    for _ in range(random.randint(1, 3)):
        tree = change(tree, random).tree
    tree = settled(tree)
    assert parsed(RAPID.render(tree)) == parsed(printed(tree))


@settings(QUICK, suppress_health_check=[HealthCheck.filter_too_much])
@given(files(), SEEDS)
def test_a_changed_random_tree_reads_as_it_was_changed(file: s.File, seed: int) -> None:
    random, tree = at_random(seed, printed(file))
    # a comment that the layout puts behind the header has another place than one below it
    assume(parsed(RAPID.render(tree)) == RAPID.parse(printed(tree)))
    tree = settled(change(tree, random).tree)
    wanted = RAPID.parse(printed(tree))
    assume(not wanted.findings)  # what is put in may not fit beside what is there
    assert parsed(RAPID.render(tree)) == wanted


A_BLOCK = 18
"""Lines that the longest block of LETTERS has before and after: where its words share a line
with what they hold, as in `CASE 1,2: b;`, a change in them lays it out anew."""


@QUICK
@given(SEEDS)
@example(5743)
@example(105805)
def test_one_change_stays_in_its_lines(seed: int) -> None:
    random, tree = at_random(seed, LETTERS)
    text = tree.origin.source.text
    made = change(tree, random)
    rendered = RAPID.render(made.tree)
    differ = [
        line for line in difflib.ndiff(text.splitlines(), rendered.splitlines()) if line[0] in "+-"
    ]
    most = 2 * lines_of(made.old, text) + lines_of(made.new) + A_BLOCK
    assert len(differ) <= most, "\n".join(differ)


def edited(text: str, rendered: str) -> list[str]:
    """The lines that went and came, each with its sign."""
    lines = difflib.unified_diff(text.split("\n"), rendered.split("\n"), lineterm="", n=0)
    return [line for line in lines if not line.startswith(("---", "+++", "@@"))]


def in_body(text: str, put: Callable[[tuple[Any, ...]], tuple[Any, ...]]) -> list[str]:
    """What changing the body of the last routine of a module with that body does to the text."""
    whole = f"MODULE  m\r\n  proc p( )\r\n{text}\r\n  endproc\r\nENDMODULE\r\n"
    tree = parsed(whole)
    module = tree.modules[0]
    routine = module.items[-1]
    routine = replace(routine, body=put(routine.body))
    new = replace(tree, parts=(replace(module, items=(*module.items[:-1], routine)),))
    rendered = RAPID.render(new)
    assert parsed(rendered) == new
    assert "\n" not in rendered.replace("\r\n", "")
    return [line.replace("\r", "") for line in edited(whole, rendered)]


STOP = s.ProcedureCall("Stop")


@every_row(
    ("text", "put", "lines"),
    [
        ("  a:=1 ;  ! c\r\n\r\n  b;", lambda b: b[:1] + b[2:], ["-  a:=1 ;  ! c", "+  a:=1 ;"]),
        ("  a;\r\n\r\n  b;", lambda b: b[1:], ["-  a;"]),
        ("  a;\r\n\r\n  b;", lambda b: b[:1], ["-  b;"]),
        ("  a; b; c;", lambda b: b[:1] + b[2:], ["-  a; b; c;", "+  a; c;"]),
        ("  a;\r\n\r\n  b;", lambda b: (b[0], STOP, b[1]), ["+  Stop;"]),
        ("  a; ! c", lambda b: (*b, STOP), ["+  Stop;"]),
        ("\t\t! c", lambda b: (STOP, *b), ["+\t\tStop;"]),
        ("  a;\r\n  B ;", lambda b: b[::-1], ["+  B ;", "-  B ;"]),
        ("  MoveL p,\r\n    v5 , z1,t;", lambda b: (
            replace(b[0], arguments=(b[0].arguments[0], s.Positional(s.NameRef("v7")),
                                     *b[0].arguments[2:])),
        ), ["-    v5 , z1,t;", "+    v7 , z1,t;"]),
        ("  Go 1 ,\\X;", lambda b: (replace(b[0], arguments=b[0].arguments[:1]),),
         ["-  Go 1 ,\\X;", "+  Go 1;"]),
        ("  Go 1 ,\\X;", lambda b: (
            replace(b[0], arguments=(b[0].arguments[0], s.Positional(s.NameRef("y")))),
        ), ["-  Go 1 ,\\X;", "+  Go 1,y;"]),
        ("  a := b + ! why\r\n  c ;", lambda b: (replace(b[0], value=b[0].value.left),),
         ["-  a := b + ! why", "-  c ;", "+  a := b ! why", "+   ;"]),
        ("  if a then\r\n   B ;\r\n  endif", lambda b: (
            replace(b[0], otherwise=(STOP,)),), ["+  ELSE", "+    Stop;"]),
        ("  if a then\r\n   B ;\r\n  else\r\n   C;\r\n  endif", lambda b: (
            replace(b[0], otherwise=None),), ["-  else", "-   C;"]),
        ("  if a then\r\n   B ;\r\n  endif", lambda b: b[0].branches[0].body,
         ["-  if a then", "-   B ;", "-  endif", "+  B ;"]),
        ("  B  ;", lambda b: (s.WhileLoop(s.BoolLiteral(True), b),),
         ["-  B  ;", "+  WHILE TRUE DO", "+    B  ;", "+  ENDWHILE"]),
    ],
)  # fmt: skip
def test_a_change_is_made_where_it_belongs(
    text: str, put: Callable[[tuple[Any, ...]], tuple[Any, ...]], lines: list[str]
) -> None:
    assert in_body(text, put) == lines


def moved(run: Any, row: int) -> Any:
    values = run.values.copy()
    values[row, 0] = 77.5
    return replace(run, values=values)


def test_a_change_in_a_table_prints_its_row_only() -> None:
    tree = parsed(TABLES)
    module = tree.modules[0]
    table, *rest = module.items
    assert isinstance(table, s.TargetRunNode)
    table = replace(table, run=moved(table.run, 4))
    new = replace(tree, parts=(replace(module, items=(table, *rest)),))
    rendered = RAPID.render(new)
    assert parsed(rendered) == new
    old = TARGETS.splitlines()[4]
    assert edited(TABLES, rendered) == [f"-{old}", f"+{old.replace('4.50', '77.5')}"]


@pytest.mark.parametrize("row", [0, 4, 9])
def test_a_row_that_is_taken_out_of_a_table_takes_its_line(row: int) -> None:
    tree = parsed(TABLES)
    module = tree.modules[0]
    table, routine = module.items
    kept = np.array([k for k in range(10) if k != row])
    run = replace(table.run, names=table.run.names.rows(kept), values=table.run.values[kept])
    new = replace(tree, parts=(replace(module, items=(replace(table, run=run), routine)),))
    rendered = RAPID.render(new)
    assert parsed(rendered) == new
    assert edited(TABLES, rendered) == [f"-{TARGETS.splitlines()[row]}"]


@pytest.mark.parametrize("count", [7, 9])
def test_moves_to_written_targets_keep_their_lines_beside_new_and_lost_ones(count: int) -> None:
    """Seven are single moves in the tree, eight and more are a run."""

    def module(rows: int, blank: str) -> str:
        value = "[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
        lines = "".join(f"MoveL{blank}[[{n},0,300],{value},{blank}v5,z1,t;\n" for n in range(rows))
        return f"MODULE m\nPROC p()\n{lines}ENDPROC\nENDMODULE\n"

    text = module(8, "  ")
    old, new = parsed(text), parsed(module(count, ""))
    rendered = RAPID.render(replace(new, origin=old.origin))
    assert parsed(rendered) == new
    kept = [line for line in text.splitlines() if line in rendered.splitlines()]
    assert len(kept) == 4 + min(count, 8)


def test_statements_may_stand_between_the_moves_of_a_run() -> None:
    text = f"MODULE m\nPROC p()\n{MOVES.replace(',', ' , ')}ENDPROC\nENDMODULE\n"
    tree = parsed(text)
    single = [parsed(f"MODULE m PROC p() {m} ENDPROC ENDMODULE") for m in MOVES.splitlines()]
    moves = [one.modules[0].items[0].body[0] for one in single]
    module = tree.modules[0]
    routine = replace(module.items[0], body=(*moves[:5], STOP, *moves[5:]))
    new = replace(tree, parts=(replace(module, items=(routine,)),))
    rendered = RAPID.render(new)
    assert parsed(rendered) == new
    assert edited(text, rendered) == ["+Stop;"]


@pytest.mark.parametrize("header", [None, " VERSION:2 "])
def test_a_header_is_a_part_of_the_file(header: str | None) -> None:
    text = "%%% VERSION:1 %%%\n! c\nMODULE  m\nENDMODULE"
    tree = parsed(text)
    new = replace(tree, header=header)
    rendered = RAPID.render(new)
    assert parsed(rendered) == new
    assert rendered.endswith("! c\nMODULE  m\nENDMODULE")
    assert RAPID.render(replace(parsed("MODULE  m\nENDMODULE"), header=" x ")) == (
        "%%% x %%%\nMODULE  m\nENDMODULE"
    )


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252"])
def test_a_changed_file_keeps_its_encoding(encoding: str) -> None:
    text = "MODULE m\r\n  ! Größe\r\n  VAR num a;\r\nENDMODULE\r\n"
    tree = RAPID.parse(RAPID.decode(text.encode(encoding)))
    module = tree.modules[0]
    items = (module.items[0], replace(module.items[1], name="Maß"))
    new = replace(tree, parts=(replace(module, items=items),))
    assert RAPID.encode(new) == text.replace("num a", "num Maß").encode(encoding)


def test_a_character_that_the_encoding_lacks_is_named() -> None:
    tree = RAPID.parse(RAPID.decode("MODULE m\n! ä\nENDMODULE\n".encode("cp1252")))
    module = tree.modules[0]
    new = replace(tree, parts=(replace(module, items=(s.CommentLine("→ ä"),)),))
    with pytest.raises(Refused) as refused:
        RAPID.encode(new)
    (finding,) = refused.value.findings
    assert (finding.line, finding.column) == (2, 3)
    assert "→" in finding.message and "cp1252" in finding.message


def test_a_change_of_a_long_module_takes_one_line() -> None:
    rows = "".join(f"  a{{{k}}}:=f({k}) ;\n" for k in range(3000))
    moves = "".join(f"  MoveL p{k},v100,z10,tool0;\n" for k in range(30_000))
    text = f"MODULE m\nPROC p()\n{rows}{moves}  Stop ;\nENDPROC\nENDMODULE\n"
    tree = parsed(text)
    module = tree.modules[0]
    (routine,) = module.items
    at = 1500
    body = (*routine.body[:at], STOP, *routine.body[at:-1], replace(routine.body[-1], name="Halt"))
    new = replace(tree, parts=(replace(module, items=(replace(routine, body=body),)),))
    rendered = RAPID.render(new)
    assert rendered == text.replace(f"  a{{{at}}}", f"  Stop;\n  a{{{at}}}").replace(
        "  Stop ;", "  Halt ;"
    )


@pytest.mark.parametrize("put", ["front", "end", "first", "last"])
def test_what_is_not_understood_stays(put: str) -> None:
    """A tree may hold less than its text, as one of a damaged file does."""
    text = "MODULE m\n  PROC p( oops )\n    a ;\n    b ;\n  ENDPROC\nENDMODULE\n"
    sound = parsed(text.replace("oops", "    "))
    assert sound.origin is not None
    source = replace(sound.origin.source, text=text)
    tree = replace(sound, origin=replace(sound.origin, source=source))
    module = tree.modules[0]
    (routine,) = module.items
    bodies = {
        "front": (STOP, *routine.body),
        "end": (*routine.body, STOP),
        "first": routine.body[1:],
        "last": routine.body[:1],
    }
    new = replace(module, items=(replace(routine, body=bodies[put]),))
    rendered = RAPID.render(replace(tree, parts=(new,)))
    assert "PROC p( oops )\n" in rendered
    assert parsed(rendered.replace("oops", "")).modules == (new,)
