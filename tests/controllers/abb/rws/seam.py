"""A program for the tests with the virtual IRC5, and its signals."""

from assistant.virtual.irc5.cabinet import Signal

SEAM = b"""MODULE Seam
  PERS num count:=0;
  PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
  CONST num fixed:=3;
  VAR num arr{3}:=[1,2,3];
  PROC main()
    count:=count+1;
    SetDO doGripper,1;
    WaitTime 0.1;
  ENDPROC
ENDMODULE
"""
SIGNALS = [Signal("doGripper", "DO"), Signal("diStart", "DI"), Signal("aoSpeed", "AO")]


def codes(refused):
    return [finding.code for finding in refused.value.findings]
