"""The compiler of intents: words -> force field, expectations and evidence."""

from physagent_jax.agents.compiler.compilation import compile_forces, compile_intent

__all__ = ["compile_forces", "compile_intent"]
