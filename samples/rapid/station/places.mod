MODULE Places
    ! What the programs of the station share: tool, places, and how a box is carried.

    PERS tooldata tGripper:=[TRUE,[[0,0,130],[1,0,0,0]],[1.1,[0,0,60],[1,0,0,0],0,0,0]];
    CONST robtarget pHome:=[[380,0,420],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pFeeder:=[[330,220,150],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pScale:=[[420,0,150],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pPallet:=[[330,-220,120],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST num nBoxes:=12;
    CONST num nWeighing:=1.5;

    PROC Carry(robtarget pFrom,robtarget pTo)
        Prepare;
        MoveJ Offs(pFrom,0,0,60),v1000,z20,tGripper;
        MoveL pFrom,v200,fine,tGripper;
        SetDO doGrip,1;
        WaitTime 0.2;
        MoveL Offs(pFrom,0,0,60),v400,z20,tGripper;
        MoveJ Offs(pTo,0,0,60),v1000,z20,tGripper;
        MoveL pTo,v200,fine,tGripper;
        SetDO doGrip,0;
        WaitTime 0.2;
        MoveL Offs(pTo,0,0,60),v400,z20,tGripper;
    ENDPROC

    LOCAL PROC Prepare()
        SetDO doGrip,0;
    ENDPROC
ENDMODULE
