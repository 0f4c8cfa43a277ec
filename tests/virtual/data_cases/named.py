"""Data that is named by a text, and positions that are read of one."""

from __future__ import annotations

_HEAD = """VAR string word{2}:=["at_b","[1,-2.5,30]"];
VAR pos at_a:=[9,8,7];
PERS pos at_b:=[1,1,1];
CONST pos at_c:=[5,6,7];
VAR pos seen;
VAR num n;
PERS num n_a:=4;
VAR bool read;
"""
CASES = {
    "data is named by a text": (
        f"""{_HEAD}PROC main()
  GetDataVal word{{1}},seen;
  SHOW seen.x,seen.y,seen.z DONE
  seen:=[3,4,5];
  SetDataVal word{{1}},seen;
  SHOW at_b.x,at_b.y,at_b.z DONE
  word{{1}}:="c";
  GetDataVal "at_"+word{{1}},seen;
  GetDataVal "n_a",n;
  SHOW seen.x,seen.z,n DONE
ENDPROC""",
        [(1, 1, 1), (3, 4, 5), (5, 7, 4)],
    ),
    "no data of that name, or none that may change": (
        f"""{_HEAD}PROC main()
  VAR num errors;
  seen:=[1,2,3];
  SetDataVal "at_c",seen;
  GetDataVal "at_x",seen;
  GetDataVal word{{2}},n;
  SHOW errors,seen.x,n DONE
ERROR
  IF ERRNO=ERR_SYM_ACCESS THEN
    errors:=errors+1;
    TRYNEXT;
  ENDIF
ENDPROC""",
        [(3, 1, 0)],
    ),
    "a position is read of a text": (
        f"""{_HEAD}PROC main()
  seen:=[1,2,3];
  read:=StrToVal(word{{2}},seen);
  IF read n:=1;
  SHOW seen.x,seen.y,seen.z+n DONE
  IF StrToVal("[7,8]",seen) OR StrToVal("[7,8,x]",seen) OR StrToVal("7,8,9",seen) n:=20;
  SHOW seen.x,seen.y,n DONE
ENDPROC""",
        [(1, -2.5, 31), (1, -2.5, 1)],
    ),
}
