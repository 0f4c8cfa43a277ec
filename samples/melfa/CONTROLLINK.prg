5 ' Moves to each joint position that comes over the port COM1, without stops
10 WAIT M_01=0
20 OVRD 100
30 GETM 1
40 CNT 1,300
50 SERVO ON
60 OPEN "COM1:" AS #1
70 DEF JNT JNTPOS
80 INPUT #1,JNTPOS
90 MOV JNTPOS
100 GOTO 80
