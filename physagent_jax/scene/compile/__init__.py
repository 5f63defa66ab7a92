"""From a `SceneConfig` and its `Body` to the simulator's `Model` and `State`."""

from physagent_jax.scene.compile.scene import CompiledScene as CompiledScene
from physagent_jax.scene.compile.scene import compile_scene as compile_scene
