MODULE e
PROC main(
 MoveL p1,v100 z10,tool0;
 IF a=1
 Set do1
 ENDIF
 x = 1;
ENDPROC
