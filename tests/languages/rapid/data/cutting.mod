MODULE Cutting
  PERS tooldata tTorch:=[TRUE,[[-12,0,305],[0.92388,0,0.382683,0]],[2.1,[0,0,110],[1,0,0,0],0,0,0]];
  PERS wobjdata wTable:=[FALSE,TRUE,"",[[900,0,400],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  CONST speeddata vCut:=[12,500,5000,1000];
  CONST zonedata zCut:=[FALSE,0.5,0.5,0.5,0.1,0.5,0.1];
  CONST robtarget pIn:=[[0,0,30],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pA:=[[10,0,0],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pB:=[[60,50,0],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pC:=[[110,0,0],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pD:=[[60,-50,0],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    CutRing 3;
    MoveJ pIn,v500,z50,tTorch\WObj:=wTable;
  ENDPROC

  PROC CutRing(num rounds)
    MoveJ pIn,v500,z10,tTorch\WObj:=wTable;
    MoveL pA,v100,fine,tTorch\WObj:=wTable;
    SetDO doGas,1;
    WaitTime 0.8;
    FOR round FROM 1 TO rounds DO
      MoveC pB,pC,vCut,zCut,tTorch\WObj:=wTable;
      MoveC pD,pA,vCut,zCut,tTorch\WObj:=wTable;
    ENDFOR
    MoveL pA,vCut,fine,tTorch\WObj:=wTable;
    SetDO doGas,0;
    MoveL pIn,v100,fine,tTorch\WObj:=wTable;
  ENDPROC
ENDMODULE
