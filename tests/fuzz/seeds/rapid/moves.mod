MODULE m
VAR num n{2}:=[1,2];
CONST robtarget p1:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveL Offs(p1,0,0,5),v100,z10,tool0\WObj:=wobj0;
FOR i FROM 1 TO 2 DO
n{i}:=i;
ENDFOR
IF n{1}=1 THEN
Set do1;
ELSE
f 1\a;
ENDIF
ENDPROC
FUNC num g(num a\switch b)
RETURN a;
ENDFUNC
ENDMODULE
