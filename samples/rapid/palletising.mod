MODULE Palletising
    ! Boxes from the infeed conveyor onto a pallet of 4 x 3 boxes in three layers.
    ! Cell: IRB 1200-7/0.7, vacuum gripper, pallet on the left.

    PERS tooldata tVacuum:=[TRUE,[[0,0,96],[1,0,0,0]],[0.8,[0,0,41],[1,0,0,0],0,0,0]];
    PERS wobjdata wPallet:=[FALSE,TRUE,"",[[320,-340,60],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
    PERS wobjdata wInfeed:=[FALSE,TRUE,"",[[300,260,140],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];

    CONST robtarget pHome:=[[380,0,420],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pPick:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pFirst:=[[30,30,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

    CONST num nColumns:=4;
    CONST num nRows:=3;
    CONST num nLayers:=3;
    CONST num nPitchX:=55;
    CONST num nPitchY:=60;
    CONST num nHeight:=40;
    CONST num nApproach:=60;
    VAR num nPlaced:=0;

    PROC main()
        nPlaced:=0;
        MoveJ pHome,v1000,fine,tVacuum;
        FOR nLayer FROM 1 TO nLayers DO
            FOR nRow FROM 1 TO nRows DO
                FOR nColumn FROM 1 TO nColumns DO
                    PickBox;
                    PlaceBox (nColumn-1)*nPitchX,(nRow-1)*nPitchY,(nLayer-1)*nHeight;
                    nPlaced:=nPlaced+1;
                ENDFOR
            ENDFOR
        ENDFOR
        MoveJ pHome,v1000,fine,tVacuum;
    ENDPROC

    PROC PickBox()
        MoveJ Offs(pPick,0,0,nApproach),v1000,z20,tVacuum\WObj:=wInfeed;
        WaitDI diBoxReady,1\MaxTime:=120;
        MoveL pPick,v200,fine,tVacuum\WObj:=wInfeed;
        SetDO doVacuum,1;
        WaitTime 0.3;
        MoveL Offs(pPick,0,0,nApproach),v400,z20,tVacuum\WObj:=wInfeed;
    ENDPROC

    PROC PlaceBox(num nX,num nY,num nZ)
        MoveJ Offs(pFirst,nX,nY,nZ+nApproach),v1000,z20,tVacuum\WObj:=wPallet;
        MoveL Offs(pFirst,nX,nY,nZ),v200,fine,tVacuum\WObj:=wPallet;
        SetDO doVacuum,0;
        WaitTime 0.2;
        MoveL Offs(pFirst,nX,nY,nZ+nApproach),v400,z20,tVacuum\WObj:=wPallet;
    ENDPROC
ENDMODULE
