5 ' Sends time, position, joints, motor currents and speed over the port COM2
10 WAIT M_02=0
20 M_TIMER(1)=0
25 DEF CHAR DATA
30 OPEN "COM2:" AS #2
35 INPUT #2,DATA
40 IF DATA="0" THEN 160
100 PRINT #2,M_TIMER(1),"|",P_CURR,"|",J_FBC,"|",J_CURR,"|",M_RSPD(3)
130 GOTO 100
160 M_02=1
170 WAIT M_02=0
180 END
