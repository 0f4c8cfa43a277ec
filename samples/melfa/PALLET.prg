1 ' Parts from the feeder onto a pallet of 4 x 3 places; every fifth one is measured.
2 ' Robot: RV-4FRL, hand 1 is the gripper.
3 Def Inte MColumn
4 Def Inte MRow
5 Def Inte MCount
6 Tool PGripper
7 Base P_NBase
8 JOvrd 40
9 Spd 250
10 MCount=0
11 HOpen 1
12 Cnt 0
13 Mov PHome
14 For MRow=0 To 2
15     For MColumn=0 To 3
16         Wait M_In(8)=1
17         GoSub *PICK
18         MCount=MCount+1
19         Select MCount Mod 5
20             Case 0
21                 M_Out(9)=1
22                 Dly 0.2
23                 M_Out(9)=0
24                 Break
25             Default
26                 Dly 0.05
27                 Break
28         End Select
29         PTo=PFirst
30         PTo.X=PFirst.X+MColumn*40
31         PTo.Y=PFirst.Y+MRow*50
32         Mov PTo,-60
33         Mvs PTo
34         HOpen 1
35         Dly 0.3
36         Mvs PTo,-60
37     Next MColumn
38 Next MRow
39 Mov PHome
40 End
41 *PICK
42 Mov PPick,-60
43 Mvs PPick
44 HClose 1
45 Dly 0.3
46 If M_In(3)=0 Then
47     Hlt
48 EndIf
49 Mvs PPick,-60
50 Return
PGripper=(+0.00,+0.00,+95.00,+0.00,+0.00,+0.00)(0,0)
PHome=(+320.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
PPick=(+300.00,-180.00,+210.00,+180.00,+0.00,+180.00)(7,0)
PFirst=(+280.00,+80.00,+180.00,+180.00,+0.00,+180.00)(7,0)
