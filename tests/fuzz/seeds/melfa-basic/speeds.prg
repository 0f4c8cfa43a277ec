Ovrd 50
Spd 100
JOvrd 20
Accel 50,60
Cnt 1,10,20
Mov P1
Mvs P2,-10 Type 0,1
Mvs P3 WthIf M_In(1)=1,Skip
Fine 10
Servo On
HOpen 1
HClose 2
Dly 0.5
Wait M_In(1)=1
M_Timer(1)=0
End
