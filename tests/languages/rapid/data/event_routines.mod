%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE EventRoutines(SYSMODULE)
  LOCAL PERS num nStarts:=17;
  TASK PERS string stProduct:="housing";
  LOCAL VAR bool bMuted:=FALSE;
  LOCAL VAR clock ckCycle;

  ! Run by the controller at power on.
  PROC evPowerOn()
    SetDO doReady,0;
    SetGO goProgram,0;
    nStarts:=nStarts+1;
    ClkReset ckCycle;
  ENDPROC

  PROC evStart()
    AccSet 80,60;
    ConfL\Off;
    SingArea\Wrist;
    SetDO\SDelay:=0.2,doReady,1;
    ClkStart ckCycle;
  ENDPROC

  PROC evStop()
    VAR num seconds;
    ClkStop ckCycle;
    seconds:=ClkRead(ckCycle);
    IF seconds>0.5 AND (NOT bMuted) THEN
      TPWrite stProduct+" took "\Num:=seconds;
    ENDIF
    SetDO doReady,0;
  BACKWARD
    RETURN;
  ENDPROC
ENDMODULE
