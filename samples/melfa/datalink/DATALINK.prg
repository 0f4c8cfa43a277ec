10 ' Slot 2: status stream over the port COM2, from the first message on
20 ' "0" stops all slots at any time, any other message starts the stream
30 DEF CHAR DATA
40 MGO=0
50 M_TIMER(1)=0
60 OPEN "COM2:" AS #2
70 ON COM(2) GOSUB *RECV
80 COM(2) ON
90 PRINT #2,"READY"
100 IF M_01=1 THEN *DONE
110 IF MGO=0 THEN DLY 0.05
120 IF MGO=1 THEN PRINT #2,M_TIMER(1),"|",P_CURR,"|",J_FBC,"|",J_CURR,"|",M_RSPD(3)
130 GOTO 100
140 *RECV
150 INPUT #2,DATA
160 IF DATA="0" THEN M_01=1 ELSE MGO=1
170 RETURN 0
180 *DONE
190 COM(2) OFF
200 PRINT #2,"END"
210 CLOSE #2
220 M_02=1
230 END
