"""Arrays that routines are given whole: by their value, changed, of several dimensions."""

from __future__ import annotations

CASES = {
    "changed by the routine, of two dimensions": (
        """VAR num a{2,3};
VAR num b{2,3}:=[[1,2,3],[4,5,6]];
PROC main()
  fill a,10;
  fill b,a{2,3};
  SHOW a{1,2},a{2,1},b{2,2} DONE
ENDPROC
PROC fill(INOUT num m{*,*},num by)
  FOR i FROM 1 TO Dim(m,1) DO
    FOR j FROM 1 TO Dim(m,2) DO
      m{i,j}:=i*by+j;
    ENDFOR
  ENDFOR
ENDPROC""",
        [(12, 21, 2 * 23 + 2)],
    ),
    "of a routine, given on, and filled anew each time": (
        """VAR num seen:=0;
PROC main()
  once 5;
  once 7;
ENDPROC
PROC once(num by)
  VAR num v{3}:=[1,2,3];
  VAR num w{2,3};
  scaled v,by;
  w{2,1}:=w{2,1}+by;
  seen:=seen+total(v);
  SHOW v{3},w{2,1}+w{1,3},seen DONE
ENDPROC
PROC scaled(VAR num list{*},num by)
  FOR i FROM 1 TO Dim(list,1) DO
    list{i}:=list{i}*by;
  ENDFOR
ENDPROC
FUNC num total(num list{*})
  VAR num sum;
  FOR i FROM 1 TO Dim(list,1) DO
    sum:=sum+list{i};
  ENDFOR
  RETURN sum;
ENDFUNC""",
        [(15, 5, 30), (21, 7, 72)],
    ),
    "by its value, which the routine changes": (
        """VAR num v{3}:=[1,2,3];
PROC main()
  VAR num first;
  first:=doubled(v);
  SHOW first,v{1},v{3} DONE
  v{3}:=30;
  first:=doubled(v);
  SHOW first,v{1},v{3} DONE
ENDPROC
FUNC num doubled(num own{*})
  own{3}:=own{3}*2;
  RETURN own{1}+own{3};
ENDFUNC""",
        [(7, 1, 3), (61, 1, 30)],
    ),
    "by its value, beside the same array that is changed": (
        """VAR num v{3}:=[1,2,3];
VAR num w{3}:=[10,20,30];
PROC main()
  running v,v;
  SHOW v{1},v{2},v{3} DONE
  running w,v;
  SHOW v{1},v{2},v{3} DONE
ENDPROC
PROC running(num source{*},INOUT num into{*})
  into{1}:=source{1};
  FOR i FROM 2 TO Dim(source,1) DO
    into{i}:=source{i-1}+source{i};
  ENDFOR
ENDPROC""",
        [(1, 3, 5), (10, 30, 50)],
    ),
    "by its value, changed under its own name by what is called": (
        """VAR num v{2}:=[1,2];
PROC main()
  VAR num sum;
  sum:=both(v);
  SHOW sum,v{1},v{2} DONE
ENDPROC
FUNC num both(num source{*})
  other;
  RETURN source{1}+source{2};
ENDFUNC
PROC other()
  v{1}:=50;
ENDPROC""",
        [(3, 50, 2)],
    ),
    "named as the parameters of others are": (
        """VAR num a{2}:=[1,2];
VAR num b{2}:=[3,4];
PROC main()
  moved b,a;
  SHOW a{1},a{2},b{1} DONE
ENDPROC
PROC moved(num a{*},VAR num b{*})
  b{1}:=a{2};
  b{2}:=a{1};
ENDPROC""",
        [(4, 3, 3)],
    ),
    "of records, given whole values": (
        """RECORD size
  num long;
  num wide;
ENDRECORD
VAR size all{2};
PROC main()
  stretched all,3;
  SHOW all{1}.long,all{2}.wide,widest(all) DONE
ENDPROC
PROC stretched(INOUT size list{*},num by)
  list:=[[1,2],[3,4]];
  FOR i FROM 1 TO Dim(list,1) DO
    list{i}.wide:=list{i}.wide*by;
  ENDFOR
ENDPROC
FUNC num widest(size list{*})
  VAR num most:=0;
  FOR i FROM 1 TO Dim(list,1) DO
    IF list{i}.wide>most most:=list{i}.wide;
  ENDFOR
  RETURN most;
ENDFUNC""",
        [(1, 12, 12)],
    ),
    "optional, there or not": (
        """VAR num a{2}:=[5,6];
PROC main()
  SHOW last(1),last(1\\of:=a),0 DONE
ENDPROC
FUNC num last(num at\\num of{*})
  IF Present(of) RETURN of{at};
  RETURN at*9;
ENDFUNC""",
        [(9, 5, 0)],
    ),
    "a table of the size that is asked for": (
        """PERS num list{2,2}:=[[0,0],[0,0]];
PROC main()
  solved 2,list;
  SHOW list{1,1},list{1,2},list{2,2} DONE
ENDPROC
PROC solved(num of,INOUT num into{*,*})
  TEST of
  CASE 1:
    into:=[[1,2]];
  CASE 2:
    into:=[[3,4],[5,6]];
  CASE 3:
    into:=[[1,2,3],[4,5,6],[7,8,9]];
  ENDTEST
ENDPROC""",
        [(3, 4, 6)],
    ),
}
