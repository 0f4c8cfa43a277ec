MODULE Guided
    ! Externally Guided Motion: a PC leads the joints, until it sends nothing more.
    ! Needs the option 689-1 and the UdpUc device UCdevice with the PC's address.

    PERS tooldata tGripper:=[TRUE,[[0,0,118],[1,0,0,0]],[0.9,[0,0,52],[1,0,0,0],0,0,0]];
    CONST jointtarget jStart:=[[0,10,-20,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST egm_minmax egmNear:=[-0.5,0.5];
    VAR egmident egmArm;

    PROC main()
        MoveAbsJ jStart,v100,fine,tGripper;
        Follow;
    ENDPROC

    PROC Follow()
        EGMReset egmArm;
        EGMGetId egmArm;
        EGMSetupUC ROB_1,egmArm,"default","UCdevice:"\Joint\CommTimeout:=1;
        EGMActJoint egmArm\Tool:=tGripper\J1:=egmNear\J2:=egmNear\J3:=egmNear\J4:=egmNear\J5:=egmNear\J6:=egmNear\LpFilter:=20\SampleRate:=4\MaxPosDeviation:=1000\MaxSpeedDeviation:=120;
        EGMRunJoint egmArm,EGM_STOP_HOLD\J1\J2\J3\J4\J5\J6\CondTime:=3600\RampInTime:=0.05\PosCorrGain:=1;
        EGMReset egmArm;
    ERROR
        IF ERRNO=ERR_UDPUC_COMM THEN
            TPWrite "The PC has ended";
            EGMReset egmArm;
            TRYNEXT;
        ENDIF
    ENDPROC
ENDMODULE
