MODULE Records
  RECORD article
    string title;
    num weight;
    num width;
    bool fragile;
  ENDRECORD
  ALIAS num kilogram;
  CONST num nArticles:=3;
  CONST kilogram most:=12.5;
  VAR article list{3}:=[["plate",2.4,180,FALSE],["glass",0.3,75,TRUE],["frame",8.1,420,FALSE]];
  VAR num counts{3,2};

  PROC main()
    VAR article top;
    top:=Heaviest(list);
    TPWrite top.title+" weighs "+NumToStr(top.weight,1);
    FOR i FROM 1 TO nArticles DO
      counts{i,1}:=Count(list{i}\careful:=TRUE);
      counts{i,2}:=Count(list{i});
      IF list{i}.fragile AND counts{i,1}>0 THEN
        list{i}.weight:=list{i}.weight*1.1;
      ENDIF
    ENDFOR
    Clear counts{1,1};
  ENDPROC

  FUNC article Heaviest(article given{*})
    VAR num at:=1;
    FOR i FROM 2 TO Dim(given,1) DO
      IF given{i}.weight>given{at}.weight at:=i;
    ENDFOR
    RETURN given{at};
  ENDFUNC

  FUNC num Count(article one\bool careful)
    VAR num share:=1;
    IF Present(careful) THEN
      IF careful share:=0.5;
    ENDIF
    RETURN Trunc(share*most/one.weight);
  ENDFUNC
ENDMODULE
