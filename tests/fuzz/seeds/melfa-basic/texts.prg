Dim M1(3),P1(2,2)
Def Char C1
C1$="a"+Str$(M1(1))+Mid$(C2$,1,2)
M2=Val(C1$)+Asc("b") Mod 3
M3=&H1F And Not &B101 Xor M2
Function M F(M A)
F=A+1
FEnd
'comment
Rem more
End
