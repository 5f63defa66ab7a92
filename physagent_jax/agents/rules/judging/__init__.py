"""The judgement's clauses: what the sentence and the motion alone say, each as a `Check`."""

from physagent_jax.agents.rules.judging.clauses import make_checks as make_checks
from physagent_jax.agents.rules.judging.seen import View as View
