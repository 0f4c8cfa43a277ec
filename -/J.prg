1 ' robot-assistant: melfa-basic-5
2 ' program: J
3 ' robot: rv-4frl
4 ' entry: main
5 ' target: PA = PA, PB = PB
6 ' robot-assistant: end
7 Ovrd 30
8 Tool P_NTool
9 Base P_NBase
10 JOvrd 1
11 Cnt 0
12 Mov PA
13 Spd M_NSpd
14 Mvs PB
15 Spd 200
16 Mvs PA
17 JOvrd 9
18 Mov PB
19 Mov PA
20 End
PA=(+300.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)
PB=(+300.00,+100.00,+300.00,+180.00,+0.00,+180.00)(7,0)
