"""A door for methods of one's own: each runs in a process that has no target, no judge and no file of tasks.

`sandbox` keeps files from it, `inside` is its program, with an `Evaluator` that asks through the `wire`. `outside`
starts it, answers, and charges. Built-in methods are part of this package and need no door.
"""

from baselines.door.outside import ClosedMethod as ClosedMethod
