"""Prints `comparing.md`, the page about two programs, with what is compared from the tables.

python -m docs.comparing > docs/comparing.md
"""

# ruff: noqa: E501 - a paragraph of the page stands as it is written

from __future__ import annotations

import sys

from assistant.virtual.proving.comparison import COMPARED, NOT_COMPARED

HEAD = """\
# Comparing two programs

Does a translation by hand do the same as the original? Does the new version of a program do what the
old one did? `compare` runs both programs, each in an interpreter of its language and on a calculated
arm, and prints the differences:

```console
$ robot-assistant translate samples/rapid/gluing.mod --to melfa-basic-5 -r rv-4frl --from-robot irb1200-7-0.7 -p samples/rapid/cell.process.toml -o cr
$ robot-assistant compare samples/rapid/gluing.mod cr/GLUING.prg -r rv-4frl --from-robot irb1200-7-0.7 -p samples/rapid/cell.process.toml
$ sed -i 's/Dly 0.15/Dly 0.5/' cr/GLUING.prg
$ robot-assistant compare samples/rapid/gluing.mod cr/GLUING.prg -r rv-4frl --from-robot irb1200-7-0.7 -p samples/rapid/cell.process.toml  # exits 1
```

```
samples/rapid/gluing.mod:29: WaitTime 0.15;
cr/GLUING.prg:31: 31 Dly 0.5
  event 6: another delay: 0.15 s, and 0.5 s; with all inputs 0
samples/rapid/gluing.mod, cr/GLUING.prg: branches taken: 0 of 0 in gluing.mod, 0 of 0 in GLUING.prg; 1 run, 12 visits and 4 signal changes, largest distance 0.0000 mm, 0.0000 degrees: different; not compared: accelerations, speeds of joint moves
```

For each difference there are the statements of both programs, the conditions that they decided last
before it, and the inputs. Up to five are told, each with statements of its own; behind an effect that
one program lacks, a run is not compared any further. The last line says first how much was looked at,
then the word for it: *equal* (exit status 0), *different* (1), or *not compared* (2) with the reason:
a program cannot be read, comes to what is not simulated, or does nothing that could be compared.

Both may be files or folders, such as backups. Of folders with several programs those of one name are
compared, and a program that only one of them has is a finding (CL015). Drawings, tables and
pseudo-programs are run as they stand. Both have to be in the same place: give the arm of the first
program as `--from-robot` and that of the second as `--robot`. `--format json` gives everything to
programs. `--report page.html` writes a page for the browser: the statements of both programs side by
side, with the differences, and the second program as its arm goes through it.

## What is compared

Inputs are sought that take every branch of both programs, end each wait and let its longest time
pass, see [Proven by motion](translating.md#proven-by-motion). `--seconds` bounds the search (10
of the processor by default), `--seed` says what it draws; `--signals` names a script of the inputs,
and there is one run; inputs that it changes by seconds are warned of (CO124), as two programs take
different times. `when = "visit 3 of pPick"` names a place as the first program does, and the second
one sees the input with the same motion, whatever it calls the place. A run that does not
end is cut off after 20,000 statements and four for each line: the answer counts these runs, and what
they did until then is compared. Both programs do the same in the same order:

"""
MIDDLE = """
A fault may need an input at a moment that is not tried, such as an interrupt in the middle of a long way
or a sixth attempt: `--signals` plays such a case. Another task of the cell is not run: a wait for
an output or data that it sets ends the run. The answer names such a wait (CO114), and if no run gets past
it, the programs are not compared (CO119). A loop that looks at a timer is no delay, and a loop
with delays is no wait for inputs: programs that have one for the other differ.

Motions take no time here. Where a MELFA-BASIC program reads `P_Curr` while the last motion may be in its
corner, an arc that starts there counts as one that is reached by a line first, as the arm goes back.

Places may be apart by what the decimals of either text leave open, with two decimals of a millimetre
or degree at most. What a program has beside that is named in the answer:

"""
TAIL = """
## Which names are the same

Two programs call a signal or shared data otherwise. They are the same, in this order:

1. by a table of yours, `--names FILE`;
2. by a name that both have: in their texts, or in the lines above a program that this package wrote;
3. by a number that both have: `--process` gives those of the first program, a second `--process`
   those of the other one;
4. by their order, where either program has as many of a kind that no number tells: the answer says
   so (CO121).

Otherwise nothing is compared (CO120). The table has a line for each name of the first program:

```toml
[names]
diPart = 4                    # the number of a signal, or
doGrip = "doGripper"          # its name
nTotal = "MTOTAL"             # data that outlives a run
```

What neither program declares, such as tools of a system module, is said in a cell file: `--cell`.

## Without running them

`--text` pairs the statements of both programs, as the pseudo-program says them: places by their
numbers, tools and frames by where they are, signals as above. It tells which are missing or say
something else; another order or style is a difference here. Nothing is run, so it also works where a
program uses what is not simulated:

```console
$ robot-assistant compare samples/rapid/gluing.mod cr/GLUING.prg -p samples/rapid/cell.process.toml --text  # exits 1
```

## From Python

```python
import assistant

done = assistant.compare("samples/melfa/PALLET.prg", "samples/melfa/PALLET.prg", robot="rv-4frl")
print(done.answer, done.motion.found.runs)
for one in done.differences:
    print(one.what, one.inputs, one.places)
```
"""


def page() -> str:
    """The whole page."""
    compared = ["| effect | what has to be the same |", "|---|---|"]
    compared += [f"| {effect} | {what} |" for effect, what in COMPARED.items()]
    left = ["| not compared | as |", "|---|---|"]
    left += [f"| {effect} | {why} |" for effect, why in NOT_COMPARED.items()]
    return f"{HEAD}{_lines(compared)}{MIDDLE}{_lines(left)}{TAIL}"


def _lines(rows: list[str]) -> str:
    return "".join(f"{row}\n" for row in rows)


if __name__ == "__main__":
    sys.stdout.write(page())
