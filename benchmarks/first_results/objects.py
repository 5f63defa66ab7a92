"""`python -m benchmarks.first_results.objects --into DIR [--from FOLDER]`: fetch the objects that are held back.

They are other people's test assets, so that none is in the repository: each is pinned by its sha256, with the address,
the licence and the credit. A copy that is on the machine is taken by its hash, whatever its name.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from benchmarks.first_results.held_back import FILES
from benchmarks.first_results.pins import collect
from physagent_jax.core.errors import UserError


def main(arguments: list[str] | None = None) -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(FILES)}; none = all")
    parser.add_argument("--into", type=Path, required=True, metavar="DIR", help="the folder of the files")
    parser.add_argument("--from", type=Path, metavar="FOLDER", dest="folder", help="a folder with copies")
    given = parser.parse_args(arguments)
    if unknown := [name for name in given.names if name not in FILES]:
        print(f"there is no object {unknown[0]}; there are: {', '.join(FILES)}", file=sys.stderr)
        return 2
    try:
        for path in collect([FILES[name] for name in given.names or FILES], given.into, given.folder):
            print(path)
    except UserError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
