MODULE p
PROC main()
MoveAbsJ j,v1000,fine,tool0;
MoveJ a,v200,z50,tool0;
MoveL [[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z1,t\WObj:=w;
MoveL [[1,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z1,t\WObj:=w;
MoveL [[2,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z1,t\WObj:=w;
MoveL [[3,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z1,t\WObj:=w;
MoveC c,d,v100,z10,t;
ENDPROC
ENDMODULE
