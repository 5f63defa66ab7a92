"""`python -m physagent_jax`: the `physagent` command."""

from physagent_jax.cli.process import run_process

run_process()
