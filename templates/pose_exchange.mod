MODULE {{ module }}
    ! Poses by files, the robot's side; written by robot-assistant.
    ! A PC puts a request into {{ request }}, the answer goes to {{ answer }}.
    ! Both appear under their names when they are whole, carry a number and end with END and it.
    ! A pose has the number after that of the request before, and the robot goes there once.
    ! While {{ stop }} is there the robot is stopped and the program ends.
{% if tool_data %}

    PERS tooldata {{ tool }}:={{ tool_data }};
{% endif %}

    LOCAL CONST string stRequest:="{{ request }}";
    LOCAL CONST string stAnswer:="{{ answer }}";
    LOCAL CONST string stHalf:="{{ answer }}.new";
    LOCAL CONST string stStop:="{{ stop }}";
    LOCAL CONST string stStopped:="{{ stopped }}";
    LOCAL CONST string stHalfStopped:="{{ stopped }}.new";
    LOCAL CONST num nTries:=100;

    LOCAL VAR intnum iStop;
    LOCAL VAR clock clMotion;
    LOCAL VAR iodev selfposedata;
    LOCAL VAR iodev newposedata;
    LOCAL VAR iodev ioStop;
    LOCAL VAR robtarget temptarget;
    LOCAL VAR robtarget Posenew;
    LOCAL VAR jointtarget jAxes;
    LOCAL VAR string text_number;
    LOCAL VAR string text_word;
    LOCAL VAR string text_pos;
    LOCAL VAR string text_orient;
    LOCAL VAR string text_config;
    LOCAL VAR string text_end;
    LOCAL VAR string stResult;
    LOCAL VAR num nNumber:=0;
    LOCAL VAR num nLast:=0;
    LOCAL VAR bool bNobody:=FALSE;
    LOCAL VAR bool bTaken:=FALSE;
    LOCAL VAR bool bOpen:=FALSE;
    LOCAL VAR bool bRead:=FALSE;
    LOCAL VAR bool bReached:=FALSE;

    PROC main()
        nLast:=0;
        stResult:="";
        bNobody:=FALSE;
        ! What an earlier exchange left is never carried out.
        remove stRequest;
        remove stAnswer;
        remove stStop;
        remove stStopped;
        IDelete iStop;
        CONNECT iStop WITH look_for_stop;
        ITimer {{ look }},iStop;
        ConfL\On;
        WHILE NOT bNobody DO
            WaitUntil IsFile(stRequest)\MaxTime:={{ longest }}\TimeFlag:=bNobody\PollRate:={{ poll }};
            IF NOT bNobody THEN
                take_request;
                IF bTaken THEN
                    carry_out;
                ELSE
                    ! Somebody still holds the file.
                    WaitTime 0.05;
                ENDIF
            ENDIF
        ENDWHILE
        IDelete iStop;
        TPWrite "Pose exchange: nobody sent a request";
    ENDPROC

    LOCAL PROC take_request()
        bTaken:=FALSE;
        bOpen:=FALSE;
        Open stRequest,newposedata\Read;
        bOpen:=TRUE;
        text_number:=ReadStr(newposedata);
        text_word:=ReadStr(newposedata);
        text_pos:=ReadStr(newposedata);
        text_orient:=ReadStr(newposedata);
        text_config:=ReadStr(newposedata);
        text_end:=ReadStr(newposedata);
        Close newposedata;
        bOpen:=FALSE;
        ! Taken is what this program removes: what the PC took back before is not carried out.
        RemoveFile stRequest;
        bTaken:=TRUE;
    ERROR
        IF ERRNO=ERR_FILEOPEN OR ERRNO=ERR_FILEACC OR ERRNO=ERR_RCVDATA THEN
            IF bOpen THEN
                Close newposedata;
            ENDIF
            RETURN;
        ELSE
            RAISE;
        ENDIF
    ENDPROC

    LOCAL PROC carry_out()
        ClkReset clMotion;
        IF NOT is_whole() THEN
            text_number:="0";
            tell "incomplete";
        ELSEIF text_word="where" THEN
            nLast:=nNumber;
            stResult:="ok";
            tell stResult;
        ELSEIF text_word<>"move" AND text_word<>"pass" THEN
            tell "unknown";
        ELSEIF nNumber=nLast AND stResult<>"" THEN
            ! Asked once more: it has been done.
            tell stResult;
        ELSEIF nNumber<>nLast+1 THEN
            tell "number";
        ELSE
            nLast:=nNumber;
            ! A request whose motion fails is never made again.
            stResult:="failed";
            go_there;
            tell stResult;
        ENDIF
    ENDPROC

    LOCAL FUNC bool is_whole()
        IF NOT StrToVal(text_number,nNumber) THEN
            RETURN FALSE;
        ENDIF
        RETURN text_end="END "+text_number;
    ERROR
        IF ERRNO=ERR_STRTOOLNG THEN
            RETURN FALSE;
        ELSE
            RAISE;
        ENDIF
    ENDFUNC

    LOCAL PROC go_there()
        Posenew:=robo_target(text_pos,text_orient,text_config);
        IF NOT bRead THEN
            stResult:="unreadable";
            RETURN;
        ENDIF
        bReached:=TRUE;
        IF NOT in_reach(Posenew) THEN
            stResult:="unreachable";
            RETURN;
        ENDIF
        IF text_config<>"" AND (NOT bReached) THEN
            stResult:="limits";
            RETURN;
        ENDIF
        IF text_config="" THEN
            ConfL\Off;
        ELSE
            ConfL\On;
        ENDIF
        ClkStart clMotion;
        IF text_word="pass" THEN
            MoveL Posenew,{{ speed }},{{ zone }},{{ tool }}{{ wobj }};
        ELSE
            MoveL Posenew,{{ speed }},fine,{{ tool }}{{ wobj }};
            WaitRob\InPos;
        ENDIF
        ClkStop clMotion;
        stResult:="ok";
    ENDPROC

    LOCAL FUNC robtarget cur_pose()
        RETURN CRobT(\Tool:={{ tool }}\WObj:={{ work_object }});
    ENDFUNC

    LOCAL FUNC robtarget robo_target(string postext1,string orienttext,string robconfigtext)
        VAR bool bool1;
        VAR bool bool2;
        VAR bool bool3:=TRUE;
        VAR num nSquares;
        ! External axes stay where they are, the configuration too where none is stated.
        temptarget:=cur_pose();
        bool1:=StrToVal(postext1,temptarget.trans);
        bool2:=StrToVal(orienttext,temptarget.rot);
        IF robconfigtext<>"" THEN
            bool3:=StrToVal(robconfigtext,temptarget.robconf);
        ENDIF
        bRead:=bool1 AND bool2 AND bool3;
        nSquares:=0;
        IF bRead THEN
            nSquares:=temptarget.rot.q1*temptarget.rot.q1+temptarget.rot.q2*temptarget.rot.q2;
            nSquares:=nSquares+temptarget.rot.q3*temptarget.rot.q3+temptarget.rot.q4*temptarget.rot.q4;
            bRead:=Abs(nSquares-1)<0.01;
        ENDIF
        IF bRead THEN
            temptarget.rot:=NOrient(temptarget.rot);
        ENDIF
        RETURN temptarget;
    ENDFUNC

    LOCAL FUNC bool in_reach(robtarget pWanted)
        jAxes:=CalcJointT(pWanted,{{ tool }}{{ wobj }});
        RETURN TRUE;
    ERROR
        IF ERRNO=ERR_ROBLIMIT THEN
            ! Another configuration may do; where none is stated the motion looks for it.
            bReached:=FALSE;
            RETURN TRUE;
        ELSEIF ERRNO=ERR_OUTSIDE_REACH THEN
            RETURN FALSE;
        ELSE
            RAISE;
        ENDIF
    ENDFUNC

    LOCAL PROC tell(string stWord)
        VAR robtarget pNow;
        VAR pos posnow;
        pNow:=cur_pose();
        posnow:=pNow.trans;
        bOpen:=FALSE;
        Open stHalf,selfposedata\Write;
        bOpen:=TRUE;
        Rewind selfposedata;
        Write selfposedata,text_number;
        Write selfposedata,stWord;
        Write selfposedata,""\Pos:=posnow;
        Write selfposedata,""\Orient:=pNow.rot;
        Write selfposedata,ValToStr(pNow.robconf);
        Write selfposedata,ValToStr(pNow.extax);
        Write selfposedata,""\Num:=ClkRead(clMotion);
        Write selfposedata,"END "+text_number;
        Close selfposedata;
        bOpen:=FALSE;
        remove stAnswer;
        RenameFile stHalf,stAnswer;
    ERROR
        IF ERRNO=ERR_FILEOPEN OR ERRNO=ERR_FILEACC OR ERRNO=ERR_FILEEXIST OR ERRNO=ERR_FILNOTFND THEN
            ! Something else has the name of the answer, as a folder; the next request tries again.
            IF bOpen THEN
                Close selfposedata;
            ENDIF
            TPWrite "Pose exchange: no answer can be written";
            RETURN;
        ELSE
            RAISE;
        ENDIF
    ENDPROC

    LOCAL PROC remove(string stFile)
        FOR i FROM 1 TO nTries DO
            IF NOT IsFile(stFile) THEN
                RETURN;
            ENDIF
            RemoveFile stFile;
            IF IsFile(stFile) THEN
                ! The file server may still hold it.
                WaitTime 0.02;
            ENDIF
        ENDFOR
    ERROR
        TRYNEXT;
    ENDPROC

    LOCAL TRAP look_for_stop
        VAR robtarget pNow;
        VAR string text_stop;
        IF NOT IsFile(stStop) THEN
            RETURN;
        ENDIF
        StopMove\Quick;
        ClearPath;
        IDelete iStop;
        Open stStop,ioStop\Read;
        text_stop:=ReadStr(ioStop);
        Close ioStop;
        pNow:=cur_pose();
        Open stHalfStopped,ioStop\Write;
        Rewind ioStop;
        Write ioStop,text_stop;
        Write ioStop,"stopped";
        Write ioStop,""\Pos:=pNow.trans;
        Write ioStop,""\Orient:=pNow.rot;
        Write ioStop,ValToStr(pNow.robconf);
        Write ioStop,ValToStr(pNow.extax);
        Write ioStop,"0";
        Write ioStop,"END "+text_stop;
        Close ioStop;
        RemoveFile stStopped;
        RenameFile stHalfStopped,stStopped;
        RemoveFile stStop;
        RemoveFile stRequest;
        EXIT;
    ERROR
        ! Whatever cannot be read or written, the robot is stopped.
        TRYNEXT;
    ENDTRAP
ENDMODULE
