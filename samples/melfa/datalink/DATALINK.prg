10 ' Slot 2: status stream over the port COM2, from the first message on
20 ' "0" stops all slots at any time, any other message starts the stream
30 ' Behind a "2" all slots stop, too, when no other "2" comes for 2 s
40 DEF CHAR DATA
50 MGO=0
60 M_TIMER(1)=0
70 OPEN "COM2:" AS #2
80 ON COM(2) GOSUB *RECV
90 COM(2) ON
100 PRINT #2,"READY"
110 *TELL
120 IF M_01=1 THEN *DONE
130 IF MGO=0 THEN DLY 0.05
140 IF MGO=1 THEN PRINT #2,M_TIMER(1),"|",P_CURR,"|",J_FBC,"|",J_CURR,"|",M_RSPD(3),"|",M_04
150 GOTO *TELL
160 *RECV
170 INPUT #2,DATA
180 IF DATA="2" THEN M_03=M_03 MOD 1000+1
190 IF DATA="0" THEN M_01=1 ELSE MGO=1
200 RETURN 0
210 *DONE
220 COM(2) OFF
230 PRINT #2,"END"
240 CLOSE #2
250 M_02=1
260 END
