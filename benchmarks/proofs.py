"""How many programs of a folder cross whole into another language, and are proven by motion.

    python -m benchmarks.proofs FOLDER --to melfa-basic-5 --process cell.process.toml

What cannot be said, cannot be run or differs is counted by its reason; a program that differs is
named with its first difference. Files of data alone, in which nothing can be run, are told apart.
"""

from __future__ import annotations

import argparse
import re
import time
from collections import Counter
from pathlib import Path

from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.compiler import translate
from assistant.compiler.loader import whole_programs
from assistant.compiler.motion_proof import Proving
from assistant.compiler.program_files import programs_in


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("folder")
    arguments.add_argument("--to", default="melfa-basic-5", help="language to write")
    arguments.add_argument("--from", dest="spoken", help="language of the programs, if not said")
    arguments.add_argument("--process", type=Path, help="file with the signals of the cell")
    arguments.add_argument("--runs", type=int, default=20, help="of each program")
    arguments.add_argument("--seconds", type=float, default=5.0, help="of each program")
    arguments.add_argument("--seed", type=int, default=0)
    chosen = arguments.parse_args()
    proving = Proving(seed=chosen.seed, runs=chosen.runs, seconds=chosen.seconds)
    counts: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    began = time.perf_counter()
    for program in whole_programs(list(programs_in(chosen.folder, chosen.spoken)), chosen.spoken):
        word, why = _becomes(program, chosen.to, chosen.spoken, chosen.process, proving)
        counts[word] += 1
        reasons.update(f"{word}: {reason}" for reason in why)
        if word in ("different", "crashed"):
            print(f"{program}: {word}: {'; '.join(why)}", flush=True)
    whole = sum(counts[word] for word in ("proven", "different", "not run"))
    share = f" ({100 * counts['proven'] / whole:.0f} %)" if whole else ""
    print(
        f"\n{sum(counts.values())} programs to {chosen.to} in {time.perf_counter() - began:.0f} s"
    )
    print(f"{whole} cross whole, {counts['proven']} of them{share} are proven by motion")
    print(", ".join(f"{count} {word}" for word, count in counts.most_common()))
    for reason, count in reasons.most_common(40):
        print(f"{count:>6}  {reason}")


def _becomes(
    program: str, to: str, spoken: str | None, process: Path | None, proving: Proving
) -> tuple[str, list[str]]:
    """What becomes of one program, in a word, and why."""
    try:
        found = translate(program, to=to, language=spoken, process=process, proving=proving)
    except Refused as refused:
        return "not read", sorted({f.code for f in refused.findings})
    except Exception as error:  # noqa: BLE001 - a crash is what is looked for
        return "crashed", [repr(error)]
    if found.motion is None:
        errors = {f.code for f in found.findings if f.severity is Severity.ERROR}
        return "not whole", sorted(errors)
    if found.motion.holds:
        ran = found.motion.found is not None and found.motion.found.runs
        return ("proven" if ran else "data only"), []
    wrong = [f for f in found.motion.findings if f.severity is Severity.ERROR]
    differs = any(f.code == "CO110" for f in wrong)
    return "different" if differs else "not run", [_reason(f, differs) for f in wrong]


def _reason(finding: Diagnostic, differs: bool) -> str:
    """A message without what only one program has."""
    if differs:
        return finding.message[:300]
    return re.sub(r"`[^`]*\.\w+`", "a program", finding.message)


if __name__ == "__main__":
    main()
