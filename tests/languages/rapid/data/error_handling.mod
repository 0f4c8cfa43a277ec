MODULE ErrorHandling
  VAR errnum ERR_NO_PART:=-1;
  VAR num nTries:=0;
  VAR bool bFound;
  CONST robtarget pAbove:=[[500,100,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pBelow:=[[500,100,80],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR robtarget pFound;

  PROC main()
    BookErrNo ERR_NO_PART;
    FindPart;
    TPWrite "height "\Num:=pFound.trans.z;
  ERROR(ERR_NO_PART)
    TPWrite "no part after three searches";
    TRYNEXT;
  ENDPROC

  PROC FindPart()
    MoveJ pAbove,v500,fine,tool0;
    bFound:=FALSE;
    SearchL\Stop,diTouch,pFound,pBelow,v20,tool0;
    bFound:=TRUE;
    nTries:=0;
  ERROR
    IF ERRNO=ERR_WHLSEARCH THEN
      StorePath;
      MoveL pAbove,v100,fine,tool0;
      RestoPath;
      ClearPath;
      StartMove;
      nTries:=nTries+1;
      IF nTries<3 RETRY;
      RAISE ERR_NO_PART;
    ENDIF
  UNDO
    nTries:=0;
  ENDPROC
ENDMODULE
