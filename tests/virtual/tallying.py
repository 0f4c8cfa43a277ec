"""Count random programs that translate and do the same, and the reasons that stop the others.

    python -m tests.virtual.tallying melfa-basic-5 rapid 300
    python -m tests.virtual.tallying rapid melfa-basic-6 300

They have angle arithmetic, unused routines, tools by constants, programs that call programs, and
inputs that change at each read.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.virtual import test_translated_melfa, test_translated_rapid


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("source")
    parser.add_argument("target")
    parser.add_argument("count", type=int)
    parser.add_argument("--first", type=int, default=0, help="number of the first program")
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.count)
    with TemporaryDirectory() as folder:
        if given.source == "rapid":
            tally = test_translated_rapid.more_tally_of(given.target, seeds, Path(folder))
        else:
            tally = test_translated_melfa.more_tally_of(int(given.source[-1]), seeds)
    for line in tally.kept:
        print(line)  # noqa: T201
    for reason, count in tally.reasons.most_common():
        print(f"{count:5} {reason}")  # noqa: T201


if __name__ == "__main__":
    main()
