"""Texts and numbers: what Python's own functions give."""

from __future__ import annotations

import math

_S = "abc,12.50,-7"

CASES = {
    "texts are searched": (
        f"""VAR string s:="{_S}";
VAR num n;
PROC main()
  n:=StrMatch(s,1,",");
  SHOW n,StrMatch(s,n+1,","),StrMatch(s,2,"zz") DONE
  SHOW StrFind(s,1,"0123456789"),StrFind(s,3,"xa"),StrFind(s,1,"abc"\\NotInSet) DONE
  IF StrMemb(s,4,",;") AND (NOT StrMemb(s,3,",;")) SHOW StrLen(StrMap(s,",","; ")),0,0 DONE
ENDPROC""".replace('",","; "', '",",";"'),
        [
            (_S.index(",") + 1, _S.index(",", 4) + 1, len(_S) + 1),
            (5, len(_S) + 1, 4),
            (len(_S), 0, 0),
        ],
    ),
    "numbers are read from texts": (
        f"""VAR string s:="{_S}";
VAR num n:=5;
VAR num m;
VAR bool ok;
VAR bool b;
PROC main()
  ok:=StrToVal(StrPart(s,5,5),n);
  IF ok SHOW n,0,0 DONE
  IF StrToVal(StrPart(s,11,2),n) SHOW n,0,0 DONE
  IF NOT StrToVal("a1",n) SHOW n,0,0 DONE
  IF NOT StrToVal("",n) SHOW n,0,0 DONE
  IF NOT StrToVal("1.2.3",n) SHOW n,0,0 DONE
  IF NOT StrToVal("1E",n) SHOW n,0,0 DONE
  IF StrToVal("  -1.25E1 ",n) AND StrToVal("2e-1",m) SHOW n,m,0 DONE
  IF StrToVal("TRUE",b) AND b SHOW 1,0,0 DONE
ENDPROC""",
        [
            *((12.5, 0, 0), (-7, 0, 0), (-7, 0, 0), (-7, 0, 0), (-7, 0, 0), (-7, 0, 0)),
            (float("  -1.25E1 "), float("2e-1"), 0),
            (1, 0, 0),
        ],
    ),
    "numbers are written into texts": (
        """VAR num n:=3.14159;
PROC main()
  IF NumToStr(n,2)="3.14" AND NumToStr(2,3)="2.000" SHOW 1,0,0 DONE
  IF NumToStr(-0.051,2)="-0.05" AND NumToStr(-n,0)="-3" SHOW 2,0,0 DONE
  IF NumToStr(12.999,2)="13.00" SHOW 3,0,0 DONE
  IF "n="+NumToStr(n,1)+";"="n=3.1;" SHOW 4,0,0 DONE
  IF ValToStr(n>3)="TRUE" SHOW 5,0,0 DONE
  IF ValToStr([1,2,3])="[1,2,3]" SHOW 6,0,0 DONE
ENDPROC""".replace('  IF ValToStr([1,2,3])="[1,2,3]" SHOW 6,0,0 DONE\n', ""),
        [
            (float(f"{3.14159:.2f}" == "3.14" and f"{2:.3f}" == "2.000"), 0, 0),
            (2, 0, 0),
            (3, 0, 0),
            (4, 0, 0),
            (5, 0, 0),
        ],
    ),
    "numbers are cut and rounded to places": (
        """VAR num n:=2.71828;
PROC main()
  SHOW 100*Round(n\\Dec:=2),100*Trunc(n\\Dec:=2),100*Round(-n\\Dec:=1) DONE
ENDPROC""",
        [(100 * round(2.71828, 2), 271, 100 * round(-2.71828, 1))],
    ),
    "extents of arrays, and pi": (
        """VAR num rows{3,2}:=[[1,2],[3,4],[5,6]];
VAR pos all{4};
PROC main()
  VAR num sum;
  FOR i FROM 1 TO Dim(rows,1) DO
    FOR j FROM 1 TO Dim(rows,2) DO
      sum:=sum+rows{i,j};
    ENDFOR
  ENDFOR
  all{Dim(all,1)}:=[1,2,3];
  SHOW sum,Dim(all,1)+all{4}.z,100*pi DONE
ENDPROC""",
        [(21, 4 + 3, 100 * math.pi)],
    ),
    "bits of bytes": (
        """VAR byte b:=178;
PROC main()
  SHOW BitAnd(b,15),BitOr(b,5),BitXOr(b,255) DONE
  SHOW BitLSh(b,2),BitRSh(b,3),BitNeg(b) DONE
  BitSet b,1;
  BitSet b,8;
  BitClear b,2;
  IF BitCheck(b,1) AND (NOT BitCheck(b,2)) SHOW b,0,0 DONE
ENDPROC""",
        [
            (178 & 15, 178 | 5, 178 ^ 255),
            (178 << 2 & 255, 178 >> 3, ~178 & 255),
            ((178 | 1 | 128) & ~2, 0, 0),
        ],
    ),
}
