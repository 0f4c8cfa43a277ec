"""Positions as vectors, poses: what numpy and spatialmath give."""

from __future__ import annotations

import numpy as np
from spatialmath import SE3, SO3, UnitQuaternion

A, B = np.array([1.0, 2.0, 3.0]), np.array([4.0, -5.0, 6.5])
TURNED = SE3(1, 2, 3) * UnitQuaternion([0.5, 0.5, 0.5, 0.5]).SE3()
AT = SE3(10, 20, 30) * SE3.Rz(90, unit="deg")


def three(values: object) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in np.asarray(values).ravel()[:3])
    return x, y, z


_HEAD = """VAR pos a:=[1,2,3];
VAR pos b:=[4,-5,6.5];
VAR pos c;
PERS pose at:=[[10,20,30],[0.707106781,0,0,0.707106781]];
"""
_C = "SHOW c.x,c.y,c.z DONE"

CASES = {
    "vectors are added, scaled and multiplied": (
        f"""{_HEAD}VAR num n:=2;
PROC main()
  c:=a+b;
  {_C}
  c:=a-b*n;
  {_C}
  c:=(n+1)*a;
  {_C}
  c:=a*b;
  {_C}
  c:=c-[1,n,3];
  {_C}
  c:=[c.y,c.x,-c.z];
  {_C}
ENDPROC""",
        [
            three(A + B),
            three(A - B * 2),
            three(A * 3),
            three(np.cross(A, B)),
            three(np.cross(A, B) - [1, 2, 3]),
            three((np.cross(A, B) - [1, 2, 3])[[1, 0, 2]] * [1, 1, -1]),
        ],
    ),
    "lengths, products and distances": (
        f"""{_HEAD}VAR robtarget pt;
PROC main()
  SHOW VectMagn(a),DotProd(a,b),Distance(a,b) DONE
  pt:=p10;
  pt.trans:=pt.trans+b;
  SHOW Distance(pt.trans,p10.trans),Distance(pt.trans,[354,0,300]),VectMagn(pt.trans-p10.trans) DONE
ENDPROC""",
        [
            (float(np.linalg.norm(A)), float(A @ B), float(np.linalg.norm(A - B))),
            three([np.linalg.norm(B)] * 3),
        ],
    ),
    "positions go into routines, and come out of them": (
        f"""{_HEAD}VAR pos all{{2}}:=[[1,1,1],[2,2,2]];
PROC main()
  c:=middle(a,b);
  {_C}
  all{{2}}:=middle(all{{1}},[9,8,7]);
  c:=all{{2}};
  {_C}
  turn c;
  {_C}
ENDPROC
FUNC pos middle(pos one,pos two)
  RETURN (one+two)*0.5;
ENDFUNC
PROC turn(INOUT pos one)
  one:=[one.z,one.x,one.y];
ENDPROC""",
        [three((A + B) / 2), (5.0, 4.5, 4.0), (4.0, 5.0, 4.5)],
    ),
    "a position seen from a pose": (
        f"""{_HEAD}VAR pose other;
PROC main()
  c:=PoseVect(at,a);
  {_C}
  other:=PoseMult(at,PoseInv([[1,2,3],[1,0,0,0]]));
  c:=other.trans;
  {_C}
  other:=PoseInv(at);
  c:=PoseVect(other,b);
  {_C}
  other:=[c,[1,0,0,0]];
  other:=PoseMult(other,[a,at.rot]);
  c:=PoseVect(other,b);
  {_C}
ENDPROC""",
        [
            three(AT * A),
            three((AT * SE3(1, 2, 3).inv()).t),
            three(AT.inv() * B),
            three((AT.inv() * B).ravel() + A + (SO3.Rz(90, unit="deg") * B).ravel()),
        ],
    ),
    "a pose that is written out is handed over, turned round and multiplied": (
        f"""{_HEAD}PROC main()
  VAR pose made;
  use [[1,2,3],[0.5,0.5,0.5,0.5]];
  use PoseInv([[1,2,3],[0.5,0.5,0.5,0.5]]);
  made:=PoseMult([[1,2,3],[0.5,0.5,0.5,0.5]],at);
  use made;
ENDPROC
PROC use(pose one)
  SHOW one.trans.x,one.trans.y,one.trans.z DONE
ENDPROC""",
        [three(TURNED.t), three(TURNED.inv().t), three((TURNED * AT).t)],
    ),
    "where the robot stands": (
        f"""{_HEAD}PROC main()
  MoveL Offs(p10,5,6,7),v100,fine,tool0;
  c:=CPos(\\Tool:=tool0\\WObj:=wobj0)-p10.trans;
  {_C}
  c:=c+CPos(\\Tool:=tool0\\WObj:=wobj0)-p10.trans;
  {_C}
ENDPROC""",
        [(5.0, 6.0, 7.0), (5.0, 6.0, 7.0), (10.0, 12.0, 14.0)],
    ),
}
