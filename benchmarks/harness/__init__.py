"""Harness of every benchmark: options, a file of rows that a later run continues, provenance, and tables.

A benchmark has parts, a part has jobs, a job makes rows. `main` does what the command line asks for and keeps the rows
in a JSON file, `{part: {"runs": [...], "complete": bool, "rows": [...]}}`: a run is one start of the command, with
machine, load, versions and revision, and every row says which run and job it is of.
"""

from benchmarks.harness.command import Command as Command
from benchmarks.harness.command import Job as Job
from benchmarks.harness.command import Row as Row
from benchmarks.harness.command import main as main
from benchmarks.harness.command import say as say
from benchmarks.harness.figures import can_plot as can_plot
from benchmarks.harness.figures import import_pyplot as import_pyplot
from benchmarks.harness.pages import RAW as RAW
from benchmarks.harness.pages import Page as Page
from benchmarks.harness.pages import Result as Result
from benchmarks.harness.pages import Rows as Rows
from benchmarks.harness.pages import Tables as Tables
from benchmarks.harness.pages import condense_section as condense_section
from benchmarks.harness.pages import count_rows as count_rows
from benchmarks.harness.pages import drop_fields as drop_fields
from benchmarks.harness.pages import make_lines as make_lines
from benchmarks.harness.pages import read_lines as read_lines
from benchmarks.harness.pages import read_runs as read_runs
from benchmarks.harness.tables import number as number
from benchmarks.harness.tables import one_line as one_line
from benchmarks.harness.tables import provenance as provenance
from benchmarks.harness.tables import table as table
