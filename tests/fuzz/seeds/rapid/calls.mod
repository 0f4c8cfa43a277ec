MODULE c
PROC main()
a 1,2\c:=3;
b\on;
x:=f(1)+g(TRUE\y:="s");
%"name"%;
q.r{2}.s:=Abs(-x) DIV 2 MOD 3;
ClkReset k;
WaitDI di1,1\MaxTime:=2;
SetDO\SDelay:=0.2,do1,high;
PulseDO\PLength:=0.2,do1;
TriggL p,v100,t1,z10,tool0;
WaitUntil di1=1 AND (x>2 OR NOT y);
IF x=1 Incr x;
EXIT;
ENDPROC
ENDMODULE
