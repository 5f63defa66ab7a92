"""Fuzzing on demand: as many cases as one likes, in processes of their own, with a table of what became of them.

    python -m tests.fuzz --cases 10000 --seed 1             # split over the classes as in the test run
    python -m tests.fuzz --cases 500 --only scenes          # one class (may be given several times)
    python -m tests.fuzz --only scenes --seed 1 --index 42  # one case again, with its input and its traceback
    python -m tests.fuzz --cases 10000 --json out.json      # all failures, with the command that repeats each

A case is accepted (and finite), refused (in one line), or fails: with a traceback, without an end,
    beyond its memory, with
numbers that are none, with files lost or half-written, or by accepting nonsense in silence (`tests.fuzz.contract`).
A process that dies or does not come back is counted, and another goes on. The exit code is 1 if anything failed.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tests.fuzz import campaign
from tests.fuzz.classes import CLASSES, PLANTED


def main() -> int:
    """Parse the line; return the exit code."""
    sys.stdout.reconfigure(errors="backslashreplace")  # inputs hold what no terminal shows
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=3000, help="cases in all, split over the classes (3000)")
    parser.add_argument("--seed", type=int, default=0, help="another seed, other cases (0)")
    parser.add_argument("--only", action="append", choices=[*CLASSES, PLANTED.name], metavar="CLASS",
                        help=f"a class, may be repeated: {', '.join(CLASSES)}")  # fmt: skip
    parser.add_argument("--jobs", type=int, default=1, help="processes at the same time (1)")
    parser.add_argument("--json", type=Path, metavar="OUT", help="where to write counts and failures")
    parser.add_argument(
        "--index", type=int, help="only the case of this number, shown in full; needs one --only"
    )
    arguments = parser.parse_args()
    names = arguments.only or list(CLASSES)
    if arguments.index is not None:
        if len(names) != 1:
            parser.error("--index needs one --only CLASS")
        return campaign.show(names[0], arguments.seed, arguments.index)
    if arguments.cases < 1 or arguments.jobs < 1:
        parser.error("--cases and --jobs must be at least 1")
    tally = campaign.run(names, arguments.cases, arguments.seed, arguments.jobs)
    if arguments.json:
        arguments.json.write_text(tally.json(), encoding="utf-8")
    print(tally.table())
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
