1 ' A lathe is loaded and unloaded; what is asked for comes as a number from the line.
2 ' Robot: RV-4FRL with a CR800.
3 Function V Main()
4     Spd 300
5     JOvrd 30
6     Tool PGripper
7     Cnt 0
8     Mov PHome
9     M1=Approach(80,2)
10     Load(PLathe,M1)
11     Load(PTray,Approach(40,1))
12     Mov PHome
13 FEnd
14 Function V Load(PTo,MHigh)
15     Mov PTo,-MHigh
16     Mvs PTo
17     M_Out(5)=1 Dly 0.5
18     Dly 0.2
19     Mvs PTo,-MHigh
20 FEnd
21 Function M Approach(MBase,MTimes)
22     If MBase*MTimes>100 Then
23         Approach=100
24     Else
25         Approach=MBase*MTimes
26     EndIf
27 FEnd
PGripper=(+0.00,+0.00,+95.00,+0.00,+0.00,+0.00)(0,0)
PHome=(+320.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
PLathe=(+300.00,-180.00,+210.00,+180.00,+0.00,+180.00)(7,0)
PTray=(+280.00,+80.00,+180.00,+180.00,+0.00,+180.00)(7,0)
