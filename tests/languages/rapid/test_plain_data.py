"""Records cross over as plain data: each case is run in both languages and compared."""

from __future__ import annotations

import random
from functools import partial

import pytest

import assistant
from tests.compiler.proven import crossed_module, moves_the_same

HEAD = """MODULE Cell
RECORD size
  num length;
  num width;
ENDRECORD
RECORD box
  size outer;
  string label;
  bool full;
ENDRECORD
RECORD place
  robtarget at;
  pos moved;
  box on;
ENDRECORD
PERS tooldata tGrip:=[TRUE,[[0,0,125],[1,0,0,0]],[0.1,[0,0,100],[1,0,0,0],0,0,0]];
CONST robtarget p10:=[[354,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC go(num x,num y,num z)
  MoveL Offs(p10,x,y,z),v100,fine,tGrip;
ENDPROC
"""
crossed = partial(crossed_module, HEAD, runs=2)

CASES = {
    "components": """VAR box one:=[[7,8],"x",TRUE];
    PROC main()
      one.outer.length:=one.outer.length*2;
      IF one.full AND one.label="x" go one.outer.length,one.outer.width,0;
    ENDPROC""",
    "records in records, assigned whole": """VAR place here;
    VAR box two:=[[7,8],"x",TRUE];
    PROC main()
      here.on:=two;
      here.on.outer.width:=30;
      here.at:=p10;
      here.moved:=[1,2,3];
      two.outer:=here.on.outer;
      MoveL here.at,v100,fine,tGrip;
      here.at.trans.x:=370;
      MoveL here.at,v100,fine,tGrip;
      go two.outer.length,two.outer.width,here.moved.z;
    ENDPROC""",
    "arrays of records, of two dimensions": """
    VAR size many{2,3}:=[[[1,2],[3,4],[5,6]],[[7,8],[9,10],[11,12]]];
    VAR size row{2};
    PROC main()
      VAR num i:=2;
      row{1}:=many{i,3};
      many{1,i}:=row{1};
      many{2,1}:=[many{2,1}.width,many{2,1}.length];
      FOR k FROM 1 TO 3 DO
        go many{1,k}.length,many{2,k}.width,many{2,k}.length;
      ENDFOR
    ENDPROC""",
    "a record of its own parts, changed about": """VAR pos off:=[10,20,30];
    VAR pos bit:=[1,2,3];
    PROC main()
      off:=[off.y,off.z,off.x];
      off:=off+bit*2-off*0.5;
      off:=-off*bit;
      go off.x,off.y,off.z;
    ENDPROC""",
    "handed over, changed by the routine, and given back": """VAR size one:=[4,5];
    VAR size other:=[6,7];
    PROC main()
      turn one;
      other:=grown(one,3);
      go other.length,other.width,area(one);
      other:=grown(other,other.width);
      go other.length,other.width,area(grown(one,1));
      only other;
      go one.length,other.length,other.width;
    ENDPROC
    PROC turn(INOUT size s)
      s:=[s.width,s.length];
    ENDPROC
    PROC only(size s)
      s.length:=100;
    ENDPROC
    FUNC size grown(size s,num by)
      VAR size r;
      r:=s;
      r.length:=r.length+by;
      RETURN r;
    ENDFUNC
    FUNC num area(size s)
      RETURN s.length*s.width;
    ENDFUNC""",
    "handed to a function in a value of a case, which reads one part": """VAR pos off:=[1,7,9];
    VAR num n:=3;
    PROC main()
      TEST n
      CASE first(off,2):
        go 30,first(off,4),0;
      DEFAULT:
        go 40,first(off,5),0;
      ENDTEST
    ENDPROC
    FUNC num first(pos p,num by)
      RETURN p.x+by;
    ENDFUNC""",
    "compared": """CONST size limit:=[4,5];
    VAR size one:=[4,5];
    PROC main()
      IF one=limit go 1,0,0;
      one.width:=6;
      IF one=limit go 2,0,0;
      IF one<>limit go 3,0,0;
      WHILE one<>limit DO
        one.width:=one.width-1;
      ENDWHILE
      go one.width,4,0;
    ENDPROC""",
    "a tool and a speed that are read": """PROC main()
      VAR num z;
      z:=tGrip.tframe.trans.z/10;
      go z,tGrip.tload.mass,tool0.tframe.trans.x;
    ENDPROC""",
    "a configuration that is taken from another target, or stated": """VAR extjoint outside;
    VAR robtarget many{2};
    PROC main()
      VAR robtarget a;
      VAR num n:=5;
      a:=p10;
      a.trans.z:=a.trans.z+n;
      many{2}:=a;
      many{2}.robconf:=p10.robconf;
      MoveL many{2},v100,fine,tGrip;
      a.robconf:=[0,0,0,0];
      MoveL a,v100,fine,tGrip;
      a:=[[350+n,n,300],[0,0,1,0],p10.robconf,outside];
      MoveL a,v100,fine,tGrip;
      a:=[[350,n,300],[0,0,1,0],[0,0,0,0],outside];
      MoveL a,v100,fine,tGrip;
    ENDPROC""",
    "targets that are compared": """VAR robtarget many{2};
    PROC main()
      VAR robtarget a;
      VAR pose at:=[[1,2,3],[1,0,0,0]];
      VAR pose other:=[[1,2,3],[0.70710678,0.70710678,0,0]];
      a:=p10;
      many{1}:=a;
      IF a=p10 go 1,0,0;
      many{1}.trans.y:=9;
      IF a<>many{1} go 2,0,0;
      IF a=many{1} OR at=other go 3,0,0;
      other:=at;
      WHILE at=other DO
        go 4,0,0;
        other.trans.x:=2;
      ENDWHILE
    ENDPROC""",
    "a frame through three positions": """VAR robtarget a;
    VAR robtarget b;
    VAR robtarget c;
    PROC main()
      a:=p10;
      b:=Offs(p10,20,15,5);
      c:=Offs(p10,5,30,-10);
      seen DefFrame(a,b,c);
      seen DefFrame(a,b,c\\Origin:=2);
      seen DefFrame(a,b,c\\Origin:=3);
      b:=Offs(p10,0,0,-40);
      seen DefFrame(a,b,c);
    ENDPROC
    PROC seen(pose at)
      VAR robtarget there;
      there:=p10;
      there.trans:=at.trans;
      there.rot:=at.rot;
      MoveJ there,v100,fine,tGrip;
    ENDPROC""",
    "aliases": """ALIAS num count;
    ALIAS size format;
    VAR count n:=3;
    VAR format f:=[1,2];
    PROC main()
      n:=n+1;
      go n,f.width,0;
    ENDPROC""",
    "optional parameters": """VAR num n:=0;
    VAR size one:=[4,5];
    PROC main()
      add 1;
      add 2\\by:=3;
      add 4\\twice;
      add 5\\by:=6\\twice;
      both 7\\by:=1;
      both 8;
      n:=n+of(n\\less)+of(n\\least);
      always\\of:=one;
      sized one;
      sized one\\limit:=[1,2];
      put 1\\into:=n;
      put 2;
      go n,one.length,one.width;
    ENDPROC
    PROC add(num m\\num by\\switch twice)
      n:=n+m;
      IF Present(by) n:=n+by;
      IF Present(twice)=TRUE n:=n*2;
      IF NOT (Present(by) OR Present(twice)) n:=n+100;
    ENDPROC
    PROC both(num m\\num by\\switch twice\\num never)
      add m\\by?by\\twice?twice;
      IF Present(never) n:=never;
    ENDPROC
    FUNC num of(num q\\switch less|switch least)
      IF Present(less) RETURN q-1;
      IF Present(least) RETURN q-2;
      RETURN q;
    ENDFUNC
    PROC always(\\size of)
      IF Present(of) n:=n+of.length;
    ENDPROC
    PROC sized(INOUT size s\\size limit)
      s.length:=s.length+1;
      IF Present(limit) s:=limit;
    ENDPROC
    PROC put(num v\\INOUT num into)
      IF Present(into) into:=into+v;
    ENDPROC""",
    "speeds and zones in records": """RECORD way
      speeddata v;
      zonedata z;
      num n;
    ENDRECORD
    CONST way slow:=[[100,500,5000,1000],[FALSE,10,15,15,1.5,15,1.5],4];
    PROC main()
      MoveL Offs(p10,0,0,slow.n),slow.v,slow.z,tGrip;
      MoveL p10,slow.v,fine,tGrip;
    ENDPROC""",
    "arrays: their extents, and values in brackets": """VAR num few{3};
    VAR num rows{2,3};
    VAR size all{2};
    PROC main()
      VAR num sum:=0;
      few:=[1,2,3];
      rows:=[[1,2,3],[4,5,few{3}]];
      all:=[[1,2],[3,4]];
      few:=[few{3},few{2},9];
      FOR i FROM 1 TO Dim(rows,1) DO
        FOR j FROM 1 TO Dim(rows,2) DO
          sum:=sum+rows{i,j}*few{j};
        ENDFOR
      ENDFOR
      go sum,all{Dim(all,1)}.width,all{1}.length;
    ENDPROC""",
    "external axes that there are none of": """VAR robtarget here;
    VAR extjoint ext;
    PROC main()
      here:=p10;
      ext:=here.extax;
      here.extax.eax_a:=5;
      here.extax:=[9E9,9E9,9E9,9E9,9E9,9E9];
      here.extax.eax_b:=ext.eax_b;
      IF here.extax.eax_c>1E9 AND ext.eax_a=9E9 here.trans.z:=310;
      MoveL here,v100,fine,tGrip;
    ENDPROC""",
    "a value is worked out for an external axis that there is none of": """
    FUNC num degrees(num a)
      RETURN a*180/pi;
    ENDFUNC
    PROC main()
      VAR robtarget here;
      here:=p10;
      here.extax.eax_a:=degrees(here.extax.eax_a);
      here.trans.z:=degrees(4);
      MoveL here,v100,fine,tGrip;
    ENDPROC""",
    "names that are taken": """VAR size one:=[4,5];
    VAR num one_length:=7;
    PROC main()
      VAR num one_width:=8;
      one.length:=one.length+1;
      go one.length,one_length,one.width+one_width;
    ENDPROC""",
    "data of a routine hides that of the module": """VAR size one:=[4,5];
    PROC main()
      sub;
      go one.length,one.width,0;
    ENDPROC
    PROC sub()
      VAR size one:=[14,15];
      FOR k FROM 1 TO 2 DO
        one.length:=one.length+k;
      ENDFOR
      go one.length,one.width,1;
    ENDPROC""",
}


@pytest.mark.parametrize("name", CASES)
def test_records_do_the_same_in_the_other_language(name: str) -> None:
    moves_the_same(crossed(CASES[name]))


def test_what_nothing_reads_is_left_out_and_told() -> None:
    done = crossed(
        'VAR box one:=[[7,8],"x",TRUE];\nPROC main()\none.label:="y";\n'
        "go one.outer.length,0,0;\nENDPROC"
    )
    text = b"".join(done.files.values()).decode("ascii")
    assert "LABEL" not in text.upper()
    told = [r for r in done.rows if any(f.code == "RA341" for f in r.reasons)]
    assert [row.text for row in told] == ['VAR box one:=[[7,8],"x",TRUE];']
    assert "`one_outer_width`" in told[0].reasons[-1].message + told[0].reasons[0].message
    (row,) = [row for row in done.rows if row.text == 'one.label:="y"']
    assert [f.code for f in row.reasons] == ["RA344"]


def test_only_the_statement_that_needs_the_whole_record_is_refused() -> None:
    done = crossed(
        "VAR size one:=[7,8];\nPROC main()\nTPWrite ArgName(one);\nReadBlock one;\n"
        "go one.length,0,0;\nENDPROC"
    )
    refused = [row.text for row in done.rows if row.level == "not"]
    assert refused == ["TPWrite ArgName(one)", "ReadBlock one"]


def test_what_has_no_value_and_what_nobody_names_is_left_out_and_told() -> None:
    done = crossed(
        "VAR socketdev line;\nVAR capdata seam;\nPROC main()\nVAR iodev file;\ngo 1,2,3;\nENDPROC"
    )
    assert done.ok, [f"{f.code} {f.message}" for f in done.findings]
    told = [row.text for row in done.rows if any(f.code == "RA342" for f in row.reasons)]
    assert told == ["VAR socketdev line;", "VAR capdata seam;", "VAR iodev file;"]


def test_a_target_of_many_axes_is_left_out_where_nothing_speaks_of_it() -> None:
    joints = "PERS jointtarget {}:=[[0,-20,67,3,-47,-93],[0,0,0,0,0,0]];\n"
    place = "PERS robtarget {}:=[[354,0,300],[0,0,1,0],[0,0,0,0],[8,-4,-2,0,0,0]];\n"
    idle = joints.format("jIdle") + place.format("pIdle")
    done = crossed(idle + "PROC main()\ngo 1,2,3;\nENDPROC")
    assert done.ok, [f"{f.code} {f.message}" for f in done.findings]
    told = [row.text for row in done.rows if any(f.code == "RA342" for f in row.reasons)]
    assert told == idle.splitlines()
    taken = place.format("pTaken")
    done = crossed(taken + "PROC main()\nMoveL pTaken,v100,fine,tGrip;\nENDPROC")
    assert not done.ok
    assert not any(f.code == "RA342" for f in done.findings)


def test_what_a_statement_needs_that_nobody_can_say_stays() -> None:
    done = crossed("VAR capdata seam;\nPROC main()\nseam.x:=1;\ngo 1,2,3;\nENDPROC")
    assert [row.level for row in done.rows if "seam" in row.text] == ["not", "not"]


def test_a_part_that_cannot_be_said_costs_no_other_part() -> None:
    done = crossed(
        "RECORD way\npathrecid r;\nnum n;\nENDRECORD\nVAR way one;\nPROC main()\n"
        "one.n:=3;\ngo one.n,0,0;\nPathRecStart one.r;\nENDPROC"
    )
    levels = {row.text: row.level for row in done.rows}
    assert levels["PathRecStart one.r"] == "not"
    assert levels["one.n:=3"] == levels["go one.n,0,0"] == "supported"


PLACES = ("a", "b", "many{1}", "many{2}", "many{k}", "got")
NUMBERS = ("outer.length", "outer.width")


def _number(rng: random.Random) -> str:
    place = f"{rng.choice(PLACES)}.{rng.choice(NUMBERS)}"
    return rng.choice((str(rng.randrange(1, 9)), place, f"{place}+1", f"2*{place}"))


def _statement(rng: random.Random) -> str:
    one, other = rng.sample(PLACES, 2)
    size = f"[{_number(rng)},{_number(rng)}]"
    return rng.choice(
        (
            f"{one}:={other};",
            f"{one}.outer:={other}.outer;",
            f"{one}.outer:={size};",
            f"{one}:=[{size},{rng.choice(PLACES)}.label,TRUE];",
            f"{one}.{rng.choice(NUMBERS)}:={_number(rng)};",
            f"turn {one};",
            f"turn {one}\\by:={_number(rng)};",
            f"turn {one}\\twice;",
            f"{one}:=made({other},{_number(rng)});",
            f"IF {one}={other} go 1,2,3;",
            f"IF {one}.outer<>{other}.outer OR {one}.full go {_number(rng)},0,1;",
            f"go {_number(rng)},{_number(rng)},0;",
            f'{one}.label:={other}.label+"x";',
            f"k:={rng.choice((1, 2))};",
            f"FOR k FROM 1 TO 2 DO {one}.outer.width:={_number(rng)}; ENDFOR",
        )
    )


def _generated(seed: int) -> list[str]:
    rng = random.Random(seed)
    return [
        'VAR box a:=[[1,2],"a",TRUE];',
        'VAR box b:=[[1,2],"a",TRUE];',
        'VAR box many{2}:=[[[3,4],"c",FALSE],[[5,6],"d",TRUE]];',
        "PROC main()",
        'VAR box got:=[[7,8],"e",FALSE];',
        "VAR num k:=1;",
        *(_statement(rng) for _ in range(14)),
        "go a.outer.length,b.outer.width,got.outer.length;",
        "go many{1}.outer.width,many{2}.outer.length,k;",
        "ENDPROC",
        "PROC turn(INOUT box x\\num by|switch twice)",
        "x.outer:=[x.outer.width,x.outer.length];",
        "IF Present(by) x.outer.width:=by;",
        "IF Present(twice) x.outer.length:=2*x.outer.length;",
        "ENDPROC",
        "FUNC box made(box x,num by)",
        "x.outer.width:=by;",
        "RETURN [x.outer,x.label,NOT x.full];",
        "ENDFUNC",
    ]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_no_statement_of_a_generated_program_changes_silently(seed: int) -> None:
    lines = _generated(seed)
    done = crossed("\n".join(lines))
    first = HEAD.count("\n") + 1
    told = {row.place.line - first for row in done.rows}
    said = {at for at, line in enumerate(lines) if not line.startswith("END")}
    assert said <= told, [lines[at] for at in said - told]
    assert "CO110" not in {f.code for f in done.findings}
    assert done.ok, [f"{f.code} {f.message}" for f in done.findings]


def test_values_for_an_array_of_another_size_stop_the_program_and_are_told() -> None:
    done = crossed(
        "VAR num list{2}:=[1,2];\nPROC main()\ngo list{1},list{2},0;\nIF list{1}>1 solve list;\n"
        "go 2,list{2},0;\nENDPROC\nPROC solve(INOUT num values{*})\nvalues:=[1,2,3];\nENDPROC"
    )
    assert done.ok, [f"{f.code} {f.message}" for f in done.findings]
    told = [row.text for row in done.rows if any(f.code == "RA371" for f in row.reasons)]
    assert told == ["values:=[1,2,3]"]


@pytest.mark.parametrize(
    ("value", "kept"),
    [
        ("there", []),
        ("PoseInv(there)", []),
        ("tGrip", []),
        ("tGrip.tframe", []),
        ("still", []),
        ("moved.extax.eax_a", []),
        ("moved.extax.eax_c", []),
        ("p10", ["text:=ValToStr(p10)"]),
    ],
)
def test_what_has_no_text_costs_its_own_statement(value, kept, tmp_path):
    moved = (
        "VAR jointtarget moved:=[[0,0,0,0,30,0],[10,20,9E9,9E9,9E9,9E9]];\n"
        if "moved" in value
        else ""
    )
    path = tmp_path / "shown.mod"
    path.write_text(
        f"{HEAD}VAR string text;\nVAR pose there:=[[1,2,3],[1,0,0,0]];\n{moved}"
        "VAR jointtarget still:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        f"PROC main()\nthere.trans.x:=4;\ntGrip.tframe.trans.z:=5;\nstill.robax.rax_1:=6;\n"
        f"text:=ValToStr({value});\nENDPROC\nENDMODULE\n"
    )
    done = assistant.translate(path, to="melfa-basic-6", robot="rv-4frl", from_robot="rv-4frl")
    assert [row.text.rstrip(";") for row in done.rows if row.level == "not"] == kept


BLOCKS = {
    "if": 'IF go=1 THEN\nTPWrite "a";\nELSE\n{}\nENDIF',
    "case": "TEST go\nCASE 1:\n{}\nDEFAULT:\n{}\nENDTEST",
    "for": "FOR held FROM 1 TO 2 DO\n{}\nENDFOR",
    "while": "WHILE go<3 DO\n{}\nENDWHILE",
    "handler": "go:=2;\nERROR\n{}",
}


@pytest.mark.parametrize("block", BLOCKS)
def test_a_declaration_in_a_block_is_an_error_and_not_a_crash(block, tmp_path):
    inside = "VAR num held:=2;\ngo:=held;"
    body = BLOCKS[block].replace("{}", inside)
    path = tmp_path / "inside.mod"
    path.write_text(
        "MODULE inside\nPERS num held:=1;\nPROC main()\nVAR num go:=1;\n"
        f"{body}\nENDPROC\nENDMODULE\n"
    )
    assert "RA220" in {f.code for f in assistant.check(path).findings}
    translated = assistant.translate(path, to="melfa-basic-5")
    assert translated.ok == (block == "handler")  # this one handles no error, and is left out
