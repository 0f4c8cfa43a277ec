MODULE d
TASK PERS tooldata t:=[TRUE,[[0,0,9],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
PERS wobjdata w:=[FALSE,TRUE,"",[[1,2,3],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
CONST speeddata v:=[100,500,5000,1000];
CONST zonedata z:=[FALSE,5,7,7,1,7,1];
CONST jointtarget j:=[[0,0,0,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
LOCAL VAR bool b:=NOT FALSE;
ALIAS num level;
VAR level l{3}:=[1,2,3];
ENDMODULE
