MODULE MainModule
    ! Poses by files: a PC puts three files into HOME:/, the robot goes there and answers with three.
    PERS tooldata GRIPPER:=[TRUE,[[0,0,100],[1,0,0,0]],[0.8,[0,0,50],[1,0,0,0],0,0,0]];
    CONST robtarget pos1:=[[420,-60,420],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

    VAR string string1:="position.txt";
    VAR string string2:="orientation.txt";
    VAR string string3:="configuration.txt";
    VAR string string4:="selfconfiguration.txt";
    VAR string string5:="selforientation.txt";
    VAR string string6:="selfposition.txt";
    VAR iodev newposedata;
    VAR iodev selfposedata;
    VAR bool object:=FALSE;
    VAR bool bool1;
    VAR bool bool2;
    VAR bool bool3;
    VAR string text_pos;
    VAR string text_orient;
    VAR string text_config;
    VAR pos posnow;
    VAR robtarget temptarget;
    VAR robtarget Posenew;

    PROC main()
        MoveJ pos1,v500,fine,GRIPPER;
        temptarget:=pos1;
        send_pose;
        FOR i FROM 1 TO 35 DO
            IF object THEN
                object:=FALSE;
            ELSE
                WaitUntil IsFile(string1) AND IsFile(string2) AND IsFile(string3)\MaxTime:=240;
                object:=FALSE;
            ENDIF
            text_pos:=read_file(string1);
            text_orient:=read_file(string2);
            text_config:=read_file(string3);
            Posenew:=robo_target(text_pos,text_orient,text_config);
            MoveL Posenew,v150,z100,GRIPPER;
            send_pose;
        ENDFOR
    ENDPROC

    FUNC robtarget cur_pose()
        WaitRob\ZeroSpeed;
        RETURN CRobT(\Tool:=GRIPPER\WObj:=wobj0);
    ENDFUNC

    PROC send_pose()
        VAR robtarget now;
        now:=cur_pose();
        posnow:=now.trans;
        Open diskhome\File:=string6,selfposedata\Write;
        Rewind selfposedata;
        Write selfposedata,""\Pos:=posnow;
        Close selfposedata;
        Open diskhome\File:=string5,selfposedata\Write;
        Rewind selfposedata;
        Write selfposedata,""\Orient:=now.rot;
        Close selfposedata;
        reg1:=now.robconf.cf1;
        reg2:=now.robconf.cf4;
        reg3:=now.robconf.cf6;
        reg4:=now.robconf.cfx;
        Open diskhome\File:=string4,selfposedata\Write;
        Rewind selfposedata;
        Write selfposedata,"["\Num:=reg1\NoNewLine;
        Write selfposedata,","\Num:=reg2\NoNewLine;
        Write selfposedata,","\Num:=reg3\NoNewLine;
        Write selfposedata,","\Num:=reg4\NoNewLine;
        Write selfposedata,"]";
        Close selfposedata;
    ENDPROC

    FUNC string read_file(string name)
        VAR string text;
        Open diskhome\File:=name,newposedata\Read;
        text:=ReadStr(newposedata);
        Close newposedata;
        RemoveFile diskhome+"/"+name;
        RETURN text;
    ENDFUNC

    FUNC robtarget robo_target(string postext1,string orienttext,string robconfigtext)
        bool1:=StrToVal(postext1,temptarget.trans);
        bool2:=StrToVal(orienttext,temptarget.rot);
        bool3:=StrToVal(robconfigtext,temptarget.robconf);
        RETURN temptarget;
    ENDFUNC
ENDMODULE
