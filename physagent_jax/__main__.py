"""`python -m physagent_jax`: the `physagent` command."""

import sys

from physagent_jax.cli import main

sys.exit(main())
