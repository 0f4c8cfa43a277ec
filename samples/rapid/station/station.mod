MODULE Station
    ! Boxes from a feeder to the scale and on to the pallet.

    VAR num nDone:=0;

    PROC main()
        Prepare;
        WHILE nDone<nBoxes DO
            WaitDI diBoxReady,1\MaxTime:=60;
            Carry pFeeder,pScale;
            WaitTime nWeighing;
            Carry pScale,pPallet;
            nDone:=nDone+1;
        ENDWHILE
        MoveJ pHome,v1000,fine,tGripper;
    ENDPROC

    LOCAL PROC Prepare()
        nDone:=0;
        MoveJ pHome,v1000,fine,tGripper;
    ENDPROC
ENDMODULE
