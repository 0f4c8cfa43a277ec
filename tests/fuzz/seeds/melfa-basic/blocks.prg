Def Plt 1,P1,P2,P3,P4,2,3,1
Mov (Plt 1,5)
Select M1
Case 1
Dly 0.5
Break
Default
End Select
While M1<2
M1=M1+1
WEnd
Def Act 1,M_In(1)=1 GoSub *L
Act 1=1
End
*L
Return 0
P1=(+1.00,0)
