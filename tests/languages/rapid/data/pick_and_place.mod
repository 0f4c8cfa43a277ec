MODULE PickAndPlace
  ! Takes parts from a feeder and sets them down in a fixture.
  PERS tooldata tGripper:=[TRUE,[[0,0,142.5],[1,0,0,0]],[1.2,[0,0,60],[1,0,0,0],0,0,0]];
  PERS wobjdata wFixture:=[FALSE,TRUE,"",[[620,-150,80],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  CONST robtarget pHome:=[[450,0,600],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pPick:=[[380,-310,120],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pPlace:=[[60,40,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR num nParts:=0;

  PROC main()
    MoveJ pHome,v500,z50,tGripper;
    WHILE nParts<24 DO
      PickPart;
      PlacePart;
      nParts:=nParts+1;
    ENDWHILE
    MoveJ pHome,v500,fine,tGripper;
    TPWrite "parts: "\Num:=nParts;
  ENDPROC

  PROC PickPart()
    MoveJ Offs(pPick,0,0,100),v500,z10,tGripper;
    WaitDI diPartReady,1\MaxTime:=10;
    MoveL pPick,v100,fine,tGripper;
    Set doClose;
    WaitTime 0.3;
    MoveL Offs(pPick,0,0,100),v200,z10,tGripper;
  ENDPROC

  PROC PlacePart()
    MoveJ Offs(pPlace,0,0,80),v500,z10,tGripper\WObj:=wFixture;
    MoveL pPlace,v50,fine,tGripper\WObj:=wFixture;
    Reset doClose;
    WaitTime 0.3;
    MoveL Offs(pPlace,0,0,80),v200,z10,tGripper\WObj:=wFixture;
  ENDPROC
ENDMODULE
