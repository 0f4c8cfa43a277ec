MODULE MainModule
    ! Poses by plain text files, the robot's side; written by robot-assistant.
    ! The PC puts three files into HOME: with position, orientation and configuration.
    ! The robot goes there and answers with three files. Empty files ask where the robot is.
    ! An empty configuration leaves the choice of it to the controller.

    PERS tooldata GRIPPER:=[TRUE,[[0,0,118],[1,0,0,0]],[0.9,[0,0,52],[1,0,0,0],0,0,0]];

    LOCAL CONST string string1:="HOME:/position.txt";
    LOCAL CONST string string2:="HOME:/orientation.txt";
    LOCAL CONST string string3:="HOME:/configuration.txt";
    LOCAL CONST string string4:="HOME:/selfconfiguration.txt";
    LOCAL CONST string string5:="HOME:/selforientation.txt";
    LOCAL CONST string string6:="HOME:/selfposition.txt";
    LOCAL CONST string stNew:=".new";
    LOCAL CONST num nTries:=100;

    LOCAL VAR iodev newposedata;
    LOCAL VAR iodev selfposedata;
    LOCAL VAR robtarget temptarget;
    LOCAL VAR robtarget Posenew;
    LOCAL VAR pos posnow;
    LOCAL VAR orient orientnow;
    LOCAL VAR confdata confnow;
    LOCAL VAR string text_pos;
    LOCAL VAR string text_orient;
    LOCAL VAR string text_config;
    LOCAL VAR bool object:=FALSE;
    LOCAL VAR bool bOpen:=FALSE;
    LOCAL VAR bool bool1:=FALSE;
    LOCAL VAR bool bool2:=FALSE;
    LOCAL VAR bool bool3:=FALSE;

    PROC main()
        ! Files that an earlier exchange left are never carried out.
        remove string1;
        remove string2;
        remove string3;
        remove string4;
        remove string5;
        remove string6;
        WHILE TRUE DO
            object:=IsFile(string1) AND IsFile(string2) AND IsFile(string3);
            IF object THEN
                object:=FALSE;
            ELSE
                WaitUntil IsFile(string1) AND IsFile(string2) AND IsFile(string3)\MaxTime:=240;
                object:=FALSE;
            ENDIF
            IF taken() THEN
                go_there;
                send_pose;
            ENDIF
        ENDWHILE
    ERROR
        IF ERRNO=ERR_WAIT_MAXTIME THEN
            TPWrite "Pose exchange: nobody sent a pose";
            RETURN;
        ELSE
            RAISE;
        ENDIF
    ENDPROC

    LOCAL FUNC bool taken()
        text_pos:=text_of(string1);
        text_orient:=text_of(string2);
        text_config:=text_of(string3);
        ! The last answer goes before the question does: what the PC finds afterwards is the next.
        remove string4;
        remove string5;
        remove string6;
        RemoveFile string1;
        remove string2;
        remove string3;
        RETURN TRUE;
    ERROR
        IF ERRNO=ERR_FILEACC THEN
            ! The PC took it back in this moment.
            RETURN FALSE;
        ELSE
            RAISE;
        ENDIF
    ENDFUNC

    LOCAL PROC go_there()
        IF text_pos="" OR text_pos="EOF" THEN
            RETURN;
        ENDIF
        Posenew:=robo_target(text_pos,text_orient,text_config);
        IF NOT (bool1 AND bool2 AND bool3) THEN
            ! The answer tells the PC that the robot has not gone there.
            TPWrite "Pose exchange: the pose cannot be read";
            RETURN;
        ENDIF
        IF text_config="" OR text_config="EOF" THEN
            ConfL\Off;
        ELSE
            ConfL\On;
        ENDIF
        ! A stop point: with a zone the answer would be written before the robot has arrived.
        MoveL Posenew,v150,fine,GRIPPER;
        WaitRob\InPos;
    ENDPROC

    LOCAL FUNC robtarget cur_pose()
        RETURN CRobT(\Tool:=GRIPPER\WObj:=wobj0);
    ENDFUNC

    LOCAL FUNC robtarget robo_target(string postext1,string orienttext,string robconfigtext)
        ! External axes stay where they are, the configuration too where none is stated.
        temptarget:=cur_pose();
        bool1:=StrToVal(postext1,temptarget.trans);
        bool2:=StrToVal(orienttext,temptarget.rot);
        bool3:=TRUE;
        IF robconfigtext<>"" AND robconfigtext<>"EOF" THEN
            bool3:=StrToVal(robconfigtext,temptarget.robconf);
        ENDIF
        IF bool2 THEN
            bool2:=Abs(square_of(temptarget.rot)-1)<0.01;
        ENDIF
        IF bool2 THEN
            temptarget.rot:=NOrient(temptarget.rot);
        ENDIF
        RETURN temptarget;
    ENDFUNC

    LOCAL FUNC num square_of(orient oTurn)
        RETURN oTurn.q1*oTurn.q1+oTurn.q2*oTurn.q2+oTurn.q3*oTurn.q3+oTurn.q4*oTurn.q4;
    ENDFUNC

    LOCAL PROC send_pose()
        temptarget:=cur_pose();
        posnow:=temptarget.trans;
        orientnow:=temptarget.rot;
        confnow:=temptarget.robconf;
        reg1:=confnow.cf1;
        reg2:=confnow.cf4;
        reg3:=confnow.cf6;
        reg4:=confnow.cfx;
        bOpen:=FALSE;
        Open string6+stNew,selfposedata\Write;
        bOpen:=TRUE;
        Rewind selfposedata;
        Write selfposedata,""\Pos:=posnow;
        Close selfposedata;
        bOpen:=FALSE;
        Open string5+stNew,selfposedata\Write;
        bOpen:=TRUE;
        Rewind selfposedata;
        Write selfposedata,""\Orient:=orientnow;
        Close selfposedata;
        bOpen:=FALSE;
        Open string4+stNew,selfposedata\Write;
        bOpen:=TRUE;
        Rewind selfposedata;
        Write selfposedata,"["+NumToStr(reg1,0)+","+NumToStr(reg2,0)\NoNewLine;
        Write selfposedata,","+NumToStr(reg3,0)+","+NumToStr(reg4,0)+"]";
        Close selfposedata;
        bOpen:=FALSE;
        ! Each file appears under its name when it is whole.
        RenameFile string4+stNew,string4;
        RenameFile string5+stNew,string5;
        RenameFile string6+stNew,string6;
    ERROR
        IF ERRNO=ERR_FILEOPEN OR ERRNO=ERR_FILEACC OR ERRNO=ERR_FILEEXIST OR ERRNO=ERR_FILNOTFND THEN
            IF bOpen THEN
                Close selfposedata;
            ENDIF
            TPWrite "Pose exchange: no answer can be written";
            RETURN;
        ELSE
            RAISE;
        ENDIF
    ENDPROC

    LOCAL FUNC string text_of(string stFile)
        VAR string stText;
        bOpen:=FALSE;
        Open stFile,newposedata\Read;
        bOpen:=TRUE;
        stText:=ReadStr(newposedata);
        Close newposedata;
        RETURN stText;
    ERROR
        IF ERRNO=ERR_FILEOPEN OR ERRNO=ERR_FILEACC OR ERRNO=ERR_RCVDATA THEN
            IF bOpen THEN
                Close newposedata;
            ENDIF
            ! No pose can be read of it.
            RETURN "?";
        ELSE
            RAISE;
        ENDIF
    ENDFUNC

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
ENDMODULE
