"""Clocks: what they read is the sum of the times that they ran."""

from __future__ import annotations

CASES = {
    "a clock is stopped and goes on": (
        """VAR clock c1;
VAR num t;
PROC main()
  ClkReset c1;
  ClkStart c1;
  WaitTime 1;
  ClkStop c1;
  WaitTime 5;
  t:=ClkRead(c1);
  ClkStart c1;
  ClkStart c1;
  WaitTime 0.5;
  SHOW Round(10*t),Round(10*ClkRead(c1)),0 DONE
ENDPROC""",
        [(10.0, 10.0 + 5.0, 0.0)],
    ),
    "a clock that was never reset, and what is asked of it in a loop": (
        """VAR clock c1;
PROC main()
  VAR num count;
  ClkStart c1;
  WHILE ClkRead(c1)<2 DO
    WaitTime 0.3;
    count:=count+1;
  ENDWHILE
  ClkStop c1;
  ClkReset c1;
  SHOW count,ClkRead(c1),0 DONE
ENDPROC""",
        [(7.0, 0.0, 0.0)],  # 7 * 0.3 is the first that is not under 2
    ),
    "the clock that every controller has": (
        """PROC main()
  ClkStart Clock1;
  WaitTime 2;
  ClkStop clock1;
  SHOW Round(ClkRead(clock1)),0,0 DONE
ENDPROC""",
        [(2.0, 0.0, 0.0)],
    ),
    "a routine's own clock begins anew beside one of the module": (
        """VAR clock c1;
PROC main()
  ClkReset c1;
  ClkStart c1;
  own 1;
  own 2;
  ClkStop c1;
  WaitTime 3;
  SHOW Round(ClkRead(c1)),0,0 DONE
ENDPROC
PROC own(num seconds)
  VAR clock c1;
  ClkStart c1;
  WaitTime seconds;
  ClkStop c1;
  SHOW Round(ClkRead(c1)),0,0 DONE
ENDPROC""",
        [(1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (3.0, 0.0, 0.0)],
    ),
}
