"""Orientations: angles as rotation matrices of spatialmath give them."""

from __future__ import annotations

import numpy as np
from spatialmath import SO3

HALF = SO3.Rx(180, unit="deg") * SO3.Rz(180, unit="deg")
"""How `p10` is turned: [0,0,1,0]."""


def zyx(turn: SO3) -> tuple[float, float, float]:
    """Angles about z, the new y, the new x."""
    x, y, z = turn.rpy(order="zyx", unit="deg")
    return float(z), float(y), float(x)


def of(z: float, y: float, x: float) -> SO3:
    return SO3.Rz(z, unit="deg") * SO3.Ry(y, unit="deg") * SO3.Rx(x, unit="deg")


def tip(turn: SO3) -> tuple[float, float, float]:
    """Where 10, 20, 30 mm in the tool is behind a turn."""
    x, y, z = (float(v) for v in np.asarray(turn * [10, 20, 30]).ravel())
    return x, y, z


_ANGLES = r"EulerZYX(\Z,pt.rot),EulerZYX(\Y,pt.rot),EulerZYX(\X,pt.rot)"
_SHOWN = f"SHOW {_ANGLES} DONE"
_TIP = "MoveL RelTool(pt,10,20,30),v100,fine,tool0;"

CASES = {
    "angles are set and read": (
        f"""VAR robtarget pt;
VAR num a:=10;
PROC main()
  pt:=p10;
  pt.rot:=OrientZYX(a,20,a+20);
  {_SHOWN}
  {_TIP}
  pt.rot:=OrientZYX(EulerZYX(\\X,pt.rot),EulerZYX(\\Z,pt.rot),EulerZYX(\\Y,pt.rot));
  {_SHOWN}
  {_TIP}
ENDPROC""",
        [(10.0, 20.0, 30.0), tip(of(10, 20, 30)), (30.0, 10.0, 20.0), tip(of(30, 10, 20))],
    ),
    "angles are read back as those of the orientation": (
        f"""VAR robtarget pt;
VAR num a:=100;
PROC main()
  pt:=p10;
  pt.rot:=OrientZYX(2*a,a,30);
  {_SHOWN}
  {_TIP}
  pt.rot:=OrientZYX(200,100,-30);
  {_SHOWN}
ENDPROC""",
        [zyx(of(200, 100, 30)), tip(of(200, 100, 30)), zyx(of(200, 100, -30))],
    ),
    "an element of an array is turned": (
        f"""VAR robtarget ps{{2}};
VAR robtarget pt;
PROC main()
  VAR num i:=2;
  ps{{i}}:=p10;
  ps{{i}}.rot:=OrientZYX(10*i,30,-15);
  pt:=ps{{2}};
  {_TIP}
ENDPROC""",
        [tip(of(20, 30, -15))],
    ),
    "a target is turned in its tool by what is worked out": (
        f"""VAR robtarget pt;
VAR num a:=25;
PROC main()
  pt:=RelTool(p10,a,0,0\\Rx:=5\\Rz:=a);
  pt:=RelTool(pt,0,0,-a\\Rx:=a\\Ry:=2*a\\Rz:=-a);
  {_TIP}
ENDPROC""",
        [
            tuple(
                np.asarray(HALF * [25, 0, 0]).ravel()
                + np.asarray(HALF * SO3.Rx(5, "deg") * SO3.Rz(25, "deg") * [0, 0, -25]).ravel()
                + np.asarray(
                    HALF
                    * SO3.Rx(5, "deg")
                    * SO3.Rz(25, "deg")
                    * SO3.Rx(25, "deg")
                    * SO3.Ry(50, "deg")
                    * SO3.Rz(-25, "deg")
                    * [10, 20, 30]
                ).ravel()
            )
        ],
    ),
    "a place is given its own components in another order": (
        """VAR robtarget pt;
PROC main()
  pt:=p10;
  pt.trans:=[pt.trans.z,pt.trans.x,5];
  MoveL pt,v100,fine,tool0;
ENDPROC""",
        [(300.0 - 354.0, 354.0, 5.0 - 300.0)],
    ),
}
