MODULE SocketServer
  VAR socketdev sdServer;
  VAR socketdev sdClient;
  VAR string stCommand;
  VAR bool bRunning:=TRUE;
  CONST num nPort:=5000;

  PROC main()
    Open_Server;
    WHILE bRunning DO
      SocketReceive sdClient\Str:=stCommand\Time:=60;
      Answer stCommand;
    ENDWHILE
    SocketClose sdClient;
    SocketClose sdServer;
  ERROR
    IF ERRNO=ERR_SOCK_TIMEOUT THEN
      RETRY;
    ELSEIF ERRNO=ERR_SOCK_CLOSED THEN
      SocketClose sdClient;
      SocketAccept sdServer,sdClient\Time:=WAIT_MAX;
      RETRY;
    ELSE
      RAISE;
    ENDIF
  ENDPROC

  LOCAL PROC Open_Server()
    SocketCreate sdServer;
    SocketBind sdServer,"192.168.125.1",nPort;
    SocketListen sdServer;
    SocketAccept sdServer,sdClient\Time:=WAIT_MAX;
  ENDPROC

  LOCAL PROC Answer(string stText)
    VAR string stWord;
    VAR num nValue;
    VAR bool bOk;
    stWord:=StrPart(stText,1,3);
    TEST stWord
    CASE "END":
      bRunning:=FALSE;
    CASE "SPD","VEL":
      bOk:=StrToVal(StrPart(stText,4,StrLen(stText)-3),nValue);
      IF bOk AND nValue>0 THEN
        VelSet nValue,1000;
      ENDIF
    DEFAULT:
      SocketSend sdClient\Str:="unknown: "+stWord+"\0A";
      RETURN;
    ENDTEST
    SocketSend sdClient\Str:="ok\0A";
  ENDPROC
ENDMODULE
