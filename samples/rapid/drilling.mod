MODULE Drilling
    ! Holes at places that were taught, and a row of holes that is computed.
    ! Cell: IRB 1200-7/0.7, drilling spindle.

    PERS tooldata tSpindle:=[TRUE,[[0,0,110],[1,0,0,0]],[1.8,[0,0,75],[1,0,0,0],0,0,0]];
    PERS wobjdata wPlate:=[FALSE,TRUE,"",[[300,-110,100],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];

    CONST num nTaught:=3;
    CONST robtarget pTaught{3}:=[[[20,20,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
                                 [[120,40,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
                                 [[60,180,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
    CONST jointtarget jSafe:=[[0,-20,20,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR num nDepth{3}:=[6,6,9];
    VAR robtarget pHole;

    PROC main()
        MoveAbsJ jSafe,v1000,fine,tSpindle;
        FOR i FROM 1 TO nTaught DO
            Drill pTaught{i},nDepth{i};
        ENDFOR
        FOR i FROM 1 TO 5 DO
            pHole:=Offs(pTaught{1},RowX(i),150,0);
            Drill pHole,Deepest(6,nDepth{3});
        ENDFOR
        MoveAbsJ jSafe,v1000,fine,tSpindle;
    ENDPROC

    PROC Drill(robtarget pAt,num nDeep)
        MoveJ Offs(pAt,0,0,40),v500,fine,tSpindle\WObj:=wPlate;
        SetDO doSpindle,1;
        MoveL Offs(pAt,0,0,2),v200,fine,tSpindle\WObj:=wPlate;
        MoveL Offs(pAt,0,0,-nDeep),v5,fine,tSpindle\WObj:=wPlate;
        MoveL Offs(pAt,0,0,40),v200,fine,tSpindle\WObj:=wPlate;
        SetDO doSpindle,0;
    ENDPROC

    FUNC num RowX(num nHole)
        RETURN 20+(nHole-1)*15;
    ENDFUNC

    FUNC num Deepest(num nFirst,num nSecond)
        IF nFirst>nSecond THEN
            RETURN nFirst;
        ENDIF
        RETURN nSecond;
    ENDFUNC
ENDMODULE
