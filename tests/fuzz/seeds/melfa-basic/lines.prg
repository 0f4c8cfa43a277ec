Open "COM2:" As #1
Print #1,"a";C1$
Input #1,M1
On Com(1) GoSub *R
Com(1) On
Hlt
*R:Mvr P1,P2,P3
