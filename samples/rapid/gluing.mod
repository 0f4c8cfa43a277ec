MODULE Gluing
    ! A bead of glue around a cover: straight edges, round corners, one arc at the handle.
    ! Cell: IRB 1200-7/0.7, cartridge dispenser on the flange, cover on a table.

    PERS tooldata tNozzle:=[TRUE,[[0,0,120],[1,0,0,0]],[0.9,[0,0,50],[1,0,0,0],0,0,0]];
    PERS wobjdata wCover:=[FALSE,TRUE,"",[[290,-145,120],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
    VAR speeddata vBead:=[80,500,5000,1000];
    VAR zonedata zCorner:=[FALSE,2,3,3,0.3,3,0.3];

    CONST robtarget pHome:=[[380,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pStart:=[[20,0,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pCorner1:=[[200,0,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pArc1:=[[214.142,5.858,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pCorner2:=[[220,20,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pEdge:=[[220,120,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pHandle:=[[240,140,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pBack:=[[220,160,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pCorner3:=[[220,280,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pCorner4:=[[0,280,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pEnd:=[[0,10,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

    PROC main()
        AccSet 60,100;
        MoveJ pHome,v1000,fine,tNozzle;
        MoveJ Offs(pStart,0,0,50),v500,z10,tNozzle\WObj:=wCover;
        MoveL pStart,v100,fine,tNozzle\WObj:=wCover;
        SetAO aoPressure,45;
        SetDO doGlue,1;
        WaitTime 0.15;
        Bead;
        SetDO doGlue,0;
        MoveL Offs(pEnd,0,0,50),v100,fine,tNozzle\WObj:=wCover;
        SetAO aoPressure,0;
        MoveJ pHome,v1000,fine,tNozzle;
        AccSet 100,100;
    ENDPROC

    PROC Bead()
        MoveL pCorner1,vBead,zCorner,tNozzle\WObj:=wCover;
        MoveC pArc1,pCorner2,vBead,zCorner,tNozzle\WObj:=wCover;
        MoveL pEdge,vBead,z1,tNozzle\WObj:=wCover;
        MoveC pHandle,pBack,vBead,z1,tNozzle\WObj:=wCover;
        MoveL pCorner3,vBead,z5,tNozzle\WObj:=wCover;
        MoveL pCorner4,vBead,z5,tNozzle\WObj:=wCover;
        MoveL pEnd,vBead,fine,tNozzle\WObj:=wCover;
    ENDPROC
ENDMODULE
