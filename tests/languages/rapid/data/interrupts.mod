MODULE Interrupts(SYSMODULE,NOSTEPIN)
  VAR intnum iStopped;
  VAR intnum iTick;
  PERS num nTicks:=0;
  PERS bool bHeld:=FALSE;
  CONST jointtarget jHome:=[[0,-20,20,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    CONNECT iStopped WITH tStopped;
    ISignalDI diStop,1,iStopped;
    CONNECT iTick WITH tTick;
    ITimer 1.5,iTick;
    WHILE TRUE DO
      MoveAbsJ jHome\NoEOffs,v300,fine,tool0;
      IF nTicks>100 GOTO finished;
      WaitUntil NOT bHeld\MaxTime:=30;
    ENDWHILE
    finished:
    IDelete iTick;
    ISleep iStopped;
  ENDPROC

  TRAP tStopped
    StopMove;
    bHeld:=TRUE;
    WaitDI diRelease,1\MaxTime:=120;
    StartMove;
    bHeld:=FALSE;
  ERROR
    IF ERRNO=ERR_WAIT_MAXTIME THEN
      TPWrite "still held";
      RETRY;
    ENDIF
  ENDTRAP

  TRAP tTick
    nTicks:=nTicks+1;
    RETURN;
  ENDTRAP
ENDMODULE
