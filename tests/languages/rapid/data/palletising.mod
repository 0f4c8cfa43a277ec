MODULE Palletising
  CONST num nRows:=4;
  CONST num nColumns:=6;
  CONST num nLayers:=3;
  CONST num nPitch:=85.5;
  CONST robtarget pFirst:=[[100,200,15],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata tVacuum:=[TRUE,[[0,0,210],[1,0,0,0]],[3.5,[0,0,95],[1,0,0,0],0,0,0]];
  PERS num nDone:=0;

  PROC main()
    VAR num nKind;
    FOR layer FROM 1 TO nLayers DO
      FOR row FROM 1 TO nRows DO
        FOR column FROM nColumns TO 1 STEP -1 DO
          nKind:=(row+layer) MOD 2;
          TEST nKind
          CASE 0:
            PutBox row,column,layer;
          CASE 1:
            PutBox row,column,layer\Turned;
          DEFAULT:
            Stop;
          ENDTEST
          nDone:=nDone+1;
        ENDFOR
      ENDFOR
    ENDFOR
    IF nDone>=nRows*nColumns*nLayers THEN
      TPWrite "pallet is full";
      nDone:=0;
    ELSEIF nDone=0 THEN
      TPWrite "nothing was done";
    ELSE
      TPWrite "pallet holds "\Num:=nDone;
    ENDIF
  ENDPROC

  PROC PutBox(num row,num column,num layer\switch Turned)
    VAR robtarget pBox;
    pBox:=Offs(pFirst,row*nPitch,column*nPitch,layer*40);
    IF Present(Turned) pBox:=RelTool(pBox,0,0,0\Rz:=90);
    MoveJ Offs(pBox,0,0,150),v1000,z20,tVacuum;
    MoveL pBox,v200,fine,tVacuum;
    SetDO doVacuum,0;
    WaitTime\InPos,0.25;
    MoveL Offs(pBox,0,0,150),v500,z20,tVacuum;
  ENDPROC
ENDMODULE
