"""Fuzzing: changed inputs to all that reads, and what nothing that reads may do.

    make fuzz                               # every target in turn, for SECONDS in all
    make fuzz SECONDS=3600 TARGETS="csv dxf"
    make fuzz INPUTS=10000                  # so many for each target
    python -m tests.fuzz --again FILE       # one input of a failure, with its traceback
    python -m tests.fuzz --keep FILE        # made small, among the cases that `make test` tries

Inputs are made from the seeds of a target, from its kept cases, and from what earlier runs found:
each input that reached code which none had reached before stays in `.fuzz/TARGET/corpus`, beside
the counts of all runs and the inputs that failed. `make test` tries the kept cases and a few
hundred changes of them, the same ones each time.

A target is a row of `TARGETS` in `table.py`: a function that takes bytes, and raises where it
should not have.
"""
