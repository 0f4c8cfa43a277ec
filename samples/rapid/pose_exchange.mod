MODULE PoseExchange
    ! A PC puts files with the next pose into HOME:/ by FTP and fetches the present one.
    ! It waits up to four minutes for a pose, goes there, and writes where it stands.

    PERS tooldata tGripper:=[TRUE,[[0,0,118],[1,0,0,0]],[0.9,[0,0,52],[1,0,0,0],0,0,0]];
    CONST robtarget pStart:=[[420,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST string stTarget:="HOME:/next_pos.txt";
    CONST string stTurn:="HOME:/next_rot.txt";
    CONST string stAnswer:="HOME:/now.txt";
    CONST num nPoses:=35;

    VAR robtarget pNext;
    VAR robtarget pNow;
    VAR iodev ioFile;
    VAR string stText;
    VAR bool bRead;

    PROC main()
        MoveJ pStart,v500,fine,tGripper;
        pNext:=pStart;
        FOR i FROM 1 TO nPoses DO
            TellPose;
            WaitUntil IsFile(stTarget) AND IsFile(stTurn)\MaxTime:=240;
            pNext:=NextPose();
            MoveL pNext,v150,z100,tGripper;
        ENDFOR
        TellPose;
    ENDPROC

    PROC TellPose()
        pNow:=CRobT(\Tool:=tGripper\WObj:=wobj0);
        Open stAnswer,ioFile\Write;
        Rewind ioFile;
        Write ioFile,""\Pos:=pNow.trans;
        Write ioFile,""\Orient:=pNow.rot;
        Close ioFile;
    ENDPROC

    FUNC robtarget NextPose()
        VAR robtarget pRead;
        pRead:=pNext;
        bRead:=StrToVal(TextOf(stTarget),pRead.trans);
        bRead:=bRead AND StrToVal(TextOf(stTurn),pRead.rot);
        IF NOT bRead THEN
            TPWrite "The pose cannot be read";
            Stop;
        ENDIF
        RETURN pRead;
    ENDFUNC

    FUNC string TextOf(string stFile)
        Open stFile,ioFile\Read;
        stText:=ReadStr(ioFile);
        Close ioFile;
        RemoveFile stFile;
        RETURN stText;
    ENDFUNC
ENDMODULE
