"""What every benchmark has: options, a file of rows that is gone on with, what it ran on, and tables.

A benchmark has parts, a part has jobs, a job makes rows. `main` does what the command line asks for and keeps the rows
in a JSON file, `{part: {"runs": [...], "complete": bool, "rows": [...]}}`: a run is one start of the command, with
machine, load, versions and revision, and every row says which run and job it is of.
"""

from benchmarks.harness.command import Command as Command
from benchmarks.harness.command import Job as Job
from benchmarks.harness.command import Row as Row
from benchmarks.harness.command import Rows as Rows
from benchmarks.harness.command import main as main
from benchmarks.harness.command import say as say
from benchmarks.harness.figures import import_pyplot as import_pyplot
from benchmarks.harness.tables import link as link
from benchmarks.harness.tables import number as number
from benchmarks.harness.tables import one_line as one_line
from benchmarks.harness.tables import provenance as provenance
from benchmarks.harness.tables import table as table
