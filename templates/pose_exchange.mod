MODULE {{ module }}
    ! Poses by files, the robot's side; written by robot-assistant.
    ! A PC puts a request into {{ request }}, the answer goes to {{ answer }}.
    ! Both appear under their names when they are whole, with a number, END with it and a checksum.
    ! A request that is taken is renamed to {{ taken }}, and removed when it is answered.
    ! A pose has the number after that of the request before, and the robot goes there once.
    ! While {{ stop }} is there the robot is stopped and the program ends.
{% if tool_data %}

    PERS tooldata {{ tool }}:={{ tool_data }};
{% endif %}

    LOCAL CONST string stRequest:="{{ request }}";
    LOCAL CONST string stTaken:="{{ taken }}";
    LOCAL CONST string stAnswer:="{{ answer }}";
    LOCAL CONST string stHalf:="{{ answer }}.new";
    LOCAL CONST string stStop:="{{ stop }}";
    LOCAL CONST string stStopped:="{{ stopped }}";
    LOCAL CONST string stHalfStopped:="{{ stopped }}.new";
    LOCAL CONST num nTries:=100;
    ! The checksum is Adler-32, its two halves as numbers of their own.
    LOCAL CONST num nBase:=65521;

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
    LOCAL VAR string text_sum;
    LOCAL VAR string stResult;
    LOCAL VAR num nNumber:=0;
    LOCAL VAR num nLast:=0;
    LOCAL VAR num nLow:=1;
    LOCAL VAR num nHigh:=0;
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
        remove stTaken;
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
        text_sum:=ReadStr(newposedata);
        Close newposedata;
        bOpen:=FALSE;
        ! Taken is what this program renames: what the PC took back before is not carried out.
        remove stTaken;
        RenameFile stRequest,stTaken;
        bTaken:=TRUE;
    ERROR
        IF ERRNO=ERR_FILEOPEN OR ERRNO=ERR_FILEACC OR ERRNO=ERR_RCVDATA THEN
            IF bOpen THEN
                Close newposedata;
            ENDIF
            RETURN;
        ELSEIF ERRNO=ERR_FILEEXIST OR ERRNO=ERR_FILNOTFND THEN
            ! The PC took it back in this moment, or something else has the name.
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
        ELSEIF text_sum<>sum_of_request() THEN
            ! Of a request whose text has changed the number is not trusted either.
            text_number:="0";
            IF text_sum="EOF" THEN
                tell "unchecked";
            ELSE
                tell "incomplete";
            ENDIF
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

    LOCAL FUNC string sum_of_request()
        begin_sum;
        add_line text_number;
        add_line text_word;
        add_line text_pos;
        add_line text_orient;
        add_line text_config;
        add_line text_end;
        RETURN sum_text();
    ENDFUNC

    LOCAL PROC begin_sum()
        nLow:=1;
        nHigh:=0;
    ENDPROC

    LOCAL PROC add_line(string stLine)
        ! A line has 80 characters at most, so that the sums stay exact without MOD for each.
        FOR i FROM 1 TO StrLen(stLine) STEP 1 DO
            nLow:=nLow+StrToByte(StrPart(stLine,i,1)\Char);
            nHigh:=nHigh+nLow;
        ENDFOR
        nLow:=nLow+10;
        nHigh:=nHigh+nLow;
        nLow:=nLow MOD nBase;
        nHigh:=nHigh MOD nBase;
    ENDPROC

    LOCAL FUNC string sum_text()
        RETURN "SUM "+NumToStr(nHigh,0)+" "+NumToStr(nLow,0);
    ENDFUNC

    LOCAL PROC put_line(VAR iodev ioFile,string stLine)
        Write ioFile,stLine;
        add_line stLine;
    ENDPROC

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
        pNow:=cur_pose();
        bOpen:=FALSE;
        Open stHalf,selfposedata\Write;
        bOpen:=TRUE;
        Rewind selfposedata;
        begin_sum;
        put_line selfposedata,text_number;
        put_line selfposedata,stWord;
        put_line selfposedata,ValToStr(pNow.trans);
        put_line selfposedata,ValToStr(pNow.rot);
        put_line selfposedata,ValToStr(pNow.robconf);
        put_line selfposedata,ValToStr(pNow.extax);
        put_line selfposedata,ValToStr(ClkRead(clMotion));
        put_line selfposedata,"END "+text_number;
        Write selfposedata,sum_text();
        Close selfposedata;
        bOpen:=FALSE;
        remove stTaken;
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
        begin_sum;
        put_line ioStop,text_stop;
        put_line ioStop,"stopped";
        put_line ioStop,ValToStr(pNow.trans);
        put_line ioStop,ValToStr(pNow.rot);
        put_line ioStop,ValToStr(pNow.robconf);
        put_line ioStop,ValToStr(pNow.extax);
        put_line ioStop,"0";
        put_line ioStop,"END "+text_stop;
        Write ioStop,sum_text();
        Close ioStop;
        RemoveFile stStopped;
        RenameFile stHalfStopped,stStopped;
        RemoveFile stStop;
        RemoveFile stRequest;
        RemoveFile stTaken;
        EXIT;
    ERROR
        ! Whatever cannot be read or written, the robot is stopped.
        TRYNEXT;
    ENDTRAP
ENDMODULE
