MODULE Functions
  CONST num full_turn:=360;
  VAR num results{5};

  PROC main()
    VAR num angle:=0;
    VAR bool ok;
    FOR i FROM 1 TO Dim(results,1) DO
      angle:=Wrapped(angle+100.5);
      results{i}:=Sqrt(Pow(Sin(angle),2)+Pow(Cos(angle),2));
    ENDFOR
    ok:=AllAre(1,results\Tolerance:=0.001);
    IF NOT ok THEN
      ErrWrite "functions","sums are off";
    ENDIF
    Swap results{1},results{2};
    %"Report"+NumToStr(2,0)% angle;
  ENDPROC

  FUNC num Wrapped(num angle)
    IF angle>full_turn/2 RETURN angle-full_turn;
    IF angle<-full_turn/2 RETURN angle+full_turn;
    RETURN angle;
  ENDFUNC

  FUNC bool AllAre(num value,num given{*}\num Tolerance)
    VAR num off:=0;
    IF Present(Tolerance) off:=Tolerance;
    FOR i FROM 1 TO Dim(given,1) DO
      IF Abs(given{i}-value)>off RETURN FALSE;
    ENDFOR
    RETURN TRUE;
  ENDFUNC

  PROC Swap(INOUT num a,INOUT num b)
    VAR num kept;
    kept:=a;
    a:=b;
    b:=kept;
  ENDPROC

  PROC Report2(num angle)
    TPErase;
    TPWrite "angle "+ValToStr(angle);
  ENDPROC
ENDMODULE
