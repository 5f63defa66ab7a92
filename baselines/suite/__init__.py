"""A suite of tasks that are drawn: templates with an object, a direction, an amount, a material and words by a seed.

`templates` says what each family asks for, `drawing` draws an instance and keeps it if the judge tells it from clips
that are wrong, `python -m baselines.suite` writes a folder of them.
"""

from baselines.suite.drawing import Drawn as Drawn
from baselines.suite.drawing import commit_seed as commit_seed
from baselines.suite.drawing import draw_task as draw_task
from baselines.suite.templates import CELLS as CELLS
