MODULE PickAndPlace
    ! Castings from the tray into the machine, as the controller of the line asks for them.
    ! Cell: IRB 1200-7/0.7, two-finger gripper.

    PERS tooldata tGripper:=[TRUE,[[0,0,118],[1,0,0,0]],[0.9,[0,0,52],[1,0,0,0],0,0,0]];

    CONST robtarget pHome:=[[420,0,520],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pTray:=[[380,-240,180],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pMachine:=[[430,230,260],[0,0.707106781,0.707106781,0],[0,0,1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST robtarget pReject:=[[300,-330,240],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

    VAR num nOrder:=0;
    VAR num nDone:=0;

    PROC main()
        OpenGripper;
        MoveJ pHome,v1000,fine,tGripper;
        WHILE diCycleOn=1 DO
            WaitDI diOrder,1\MaxTime:=60;
            nOrder:=giOrder;
            TEST nOrder
            CASE 1:
                Transfer pMachine;
                nDone:=nDone+1;
                PulseDO\High\PLength:=0.5,doLoaded;
            CASE 2,3:
                Transfer pReject;
            DEFAULT:
                TPWrite "Unknown order "\Num:=nOrder;
                SetDO doFault,1;
                Stop;
                SetDO doFault,0;
            ENDTEST
            WaitDI diOrder,0\MaxTime:=10;
        ENDWHILE
        MoveJ pHome,v1000,fine,tGripper;
    ENDPROC

    PROC Transfer(robtarget pTo)
        MoveJ Offs(pTray,0,0,80),v1000,z10,tGripper;
        MoveL pTray,v150,fine,tGripper;
        CloseGripper;
        IF diPartHeld=0 THEN
            SetDO doFault,1;
            Stop;
            SetDO doFault,0;
        ENDIF
        MoveL Offs(pTray,0,0,80),v300,z10,tGripper;
        MoveJ Offs(pTo,0,0,80),v1000,z10,tGripper;
        MoveL pTo,v150,fine,tGripper;
        OpenGripper;
        MoveL Offs(pTo,0,0,80),v300,z10,tGripper;
    ENDPROC

    PROC CloseGripper()
        SetDO doGrip,1;
        WaitUntil diGripClosed=1 OR diPartHeld=1\MaxTime:=3;
        WaitTime 0.1;
    ENDPROC

    PROC OpenGripper()
        SetDO doGrip,0;
        WaitDI diGripOpen,1\MaxTime:=3;
    ENDPROC
ENDMODULE
