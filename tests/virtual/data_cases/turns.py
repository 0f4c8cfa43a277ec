"""Orientations as quaternions: what spatialmath gives."""

from __future__ import annotations

import numpy as np
from spatialmath import SO3, UnitQuaternion

from tests.virtual.data_cases.angles import HALF, of, tip

START = UnitQuaternion([0.9, 0.1, -0.3, 0.2])
"""Not of length 1 as it is written: spatialmath makes it so."""


def angles(turn: SO3) -> tuple[float, float, float]:
    """About z, y and x, of a turn that is steep about none of them."""
    r = np.asarray(turn.R)
    z = np.degrees(np.arctan2(r[1, 0], r[0, 0]))
    x = np.degrees(np.arctan2(r[2, 1], r[2, 2]))
    return float(z), float(-np.degrees(np.arcsin(r[2, 0]))), float(x)


_HEAD = """VAR orient o;
VAR orient q:=[0.9,0.1,-0.3,0.2];
VAR robtarget pt;
"""
_TIP = "MoveL RelTool(pt,10,20,30),v100,fine,tool0;"
_ANGLES = r"SHOW EulerZYX(\Z,o),EulerZYX(\Y,o),EulerZYX(\X,o) DONE"
_PRODUCT = START.SO3() * of(10, 20, 30)

CASES = {
    "quaternions are turned, read and given to targets": (
        f"""{_HEAD}VAR num a:=10;
PROC main()
  o:=NOrient(q);
  {_ANGLES}
  o:=o*OrientZYX(a,2*a,3*a);
  {_ANGLES}
  pt:=p10;
  pt.rot:=o;
  {_TIP}
  pt.rot:=p10.rot*o;
  {_TIP}
  pt.rot:=pt.rot*[0,0,0,1];
  {_TIP}
  pt.rot:=[0.5,0.5,-0.5,0.5];
  {_TIP}
ENDPROC""",
        [
            angles(START.SO3()),
            angles(_PRODUCT),
            tip(_PRODUCT),
            tip(HALF * _PRODUCT),
            tip(HALF * _PRODUCT * SO3.Rz(180, unit="deg")),
            tip(UnitQuaternion([0.5, 0.5, -0.5, 0.5]).SO3()),
        ],
    ),
    "parts of a target's orientation": (
        f"""{_HEAD}PROC main()
  VAR num back{{4}};
  pt:=p10;
  o:=NOrient(q);
  pt.rot:=o;
  SHOW 100*Abs(pt.rot.q1),100*Abs(pt.rot.q2),100*Abs(pt.rot.q3) DONE
  back:=[pt.rot.q1,pt.rot.q2,pt.rot.q3,pt.rot.q4];
  pt:=p10;
  pt.rot.q1:=back{{1}};
  pt.rot.q2:=back{{2}};
  pt.rot.q3:=back{{3}};
  pt.rot.q4:=back{{4}};
  {_TIP}
  o:=pt.rot;
  {_ANGLES}
ENDPROC""",
        [
            tuple(float(v) for v in 100 * np.abs(START.vec[:3])),
            tip(START.SO3()),
            angles(START.SO3()),
        ],
    ),
    "a target is put together": (
        f"""{_HEAD}VAR robtarget old;
VAR pos at:=[360,5,310];
PROC main()
  old:=p10;
  pt:=[at,OrientZYX(10,20,at.y),old.robconf,old.extax];
  pt:=[pt.trans-at+p10.trans,pt.rot,[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  {_TIP}
  pt:=[[at.x,at.y,at.z],pt.rot,pt.robconf,pt.extax];
  MoveL pt,v100,fine,tool0;
ENDPROC""",
        [tip(of(10, 20, 5)), (6.0, 5.0, 10.0)],
    ),
}
