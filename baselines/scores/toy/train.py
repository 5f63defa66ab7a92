"""`python -m baselines.scores.toy.train`: trains the toy prior on the clips of `toy.clips`, and validates it.

The loss is that of flow matching (Lipman et al. 2023), by optax; weights are averaged over steps, and kept by orbax.
What was cut off goes on from its last checkpoint.
"""

from __future__ import annotations

import dataclasses
import shutil
import sys
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import optax
import orbax.checkpoint as ocp  # pyright: ignore[reportMissingImports]
import tyro
from flax import nnx  # pyright: ignore[reportMissingImports]

import physagent_jax as pa
from baselines.scores.toy.clips import UNSEEN, Clips
from baselines.scores.toy.model import SPREAD, ModelConfig, ToyVideoModel, measure_input
from baselines.scores.toy.motions import MOTIONS, WORDS, read_prompt
from baselines.scores.toy.objects import OBJECTS
from baselines.scores.toy.prior import save
from baselines.scores.toy.validation import LEAST_ACCURACY, Validation, classify, summarise
from physagent_jax.core.errors import UserError

PROMPTS = tuple(MOTIONS)
_OTHER_SIDE = {"left": "right", "right": "left"}
_MIRRORED = [PROMPTS.index(" ".join(_OTHER_SIDE.get(w, w) for w in prompt.split())) for prompt in PROMPTS]
_SHIFT = 4  # [px] at most by which a clip is moved
_KEPT_EVERY = 200  # steps


@dataclasses.dataclass(frozen=True)
class Command:
    """Trains the toy prior."""

    clips: Path = Path("runs/toy_prior/clips.npz")
    """File that `python -m baselines.scores.toy.clips` wrote."""
    out: Path = Path("runs/toy_prior/prior")
    """Folder of the prior."""
    steps: int = 4000
    """Steps of the optimiser."""
    batch: int = 16
    """Clips per step."""
    learning_rate: float = 2e-3
    """Highest."""
    drop_prompt: float = 0.1
    """Share of the clips that are shown without a prompt, for guidance."""
    validation_draws: int = 16
    """Noises per held-out clip."""
    seed: int = 0
    """Seed of everything random."""

    @property
    def checkpoints(self) -> Path:
        """The folder of the training's checkpoints until it is done."""
        return self.out.with_name(f"{self.out.name}.training")

    def list_settings(self) -> dict[str, float]:
        """The settings that two trainings must share for one to continue the other."""
        names = ("steps", "batch", "learning_rate", "drop_prompt", "seed")
        return {name: getattr(self, name) for name in names}


def split(clips: Clips) -> tuple[Clips, Clips]:
    """Clips to learn from, and held-out ones: of an unseen kind of object, and of each kind's last instance."""
    held_out = (clips.objects == list(OBJECTS).index(UNSEEN)) | (clips.instances == clips.instances.max())
    return clips.select(~held_out), clips.select(held_out)


def draw_batch(clips: Clips, rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Clips in [-1, 1] and indices of their prompts: half of them mirrored, all moved a little, colours mixed."""
    chosen = rng.choice(len(clips.videos), count)
    videos, motions = [], []
    for index in chosen:
        video, motion = clips.videos[index], int(clips.motions[index])
        if rng.random() < 0.5:
            video, motion = video[:, :, ::-1], _MIRRORED[motion]
        down, right = rng.integers(0, 2 * _SHIFT + 1, 2)
        padded = np.pad(video, ((0, 0), (_SHIFT, _SHIFT), (_SHIFT, _SHIFT), (0, 0)), mode="edge")
        size = video.shape[1]
        videos.append(padded[:, down : down + size, right : right + size, rng.permutation(3)])
        motions.append(motion)
    return to_model(np.stack(videos)), np.array(motions)


def to_model(videos: np.ndarray) -> np.ndarray:
    """Colours in [-1, 1] from bytes."""
    return (videos.astype(np.float32) / 127.5 - 1).astype(np.float32)


def compute_loss(model: ToyVideoModel, clean: jax.Array, words: jax.Array, key: jax.Array) -> jax.Array:
    """Mean squared error of the velocity, in units of what a network that knows only mean and spread misses.

    Noise levels are drawn with a preference for the upper ones, where the prompt says most.
    """
    for_noise, for_share = jax.random.split(key)
    noise = jax.random.normal(for_noise, clean.shape)
    share = jax.nn.sigmoid(0.8 + jax.random.normal(for_share, (len(clean),)))
    s = share[:, None, None, None, None]
    velocity = model((1 - s) * clean + s * noise, share, words)
    weight = measure_input(s) / SPREAD**2
    return (weight * (velocity - (noise - clean)) ** 2).mean()


def train(command: Command, clips: Clips) -> ToyVideoModel:
    """The trained model, with averaged weights; goes on where an earlier call with these settings was cut off.

    Raises:
        UserError: The checkpoints are of other settings, or of other clips.
    """
    model = ToyVideoModel(ModelConfig(words=len(WORDS)), rngs=nnx.Rngs(command.seed))
    count = sum(leaf.size for leaf in jax.tree.leaves(nnx.state(model, nnx.Param)))
    print(f"{count} parameters, {len(clips.videos)} clips")
    schedule = optax.warmup_cosine_decay_schedule(
        0, command.learning_rate, command.steps // 20, command.steps
    )
    tx = optax.chain(optax.clip_by_global_norm(1.0), optax.adamw(schedule, weight_decay=1e-3))
    graph, weights = nnx.split(model)
    state = {"weights": weights, "moments": tx.init(weights), "average": weights}

    @jax.jit
    def update(state, clean, words, key, step):
        weights = state["weights"]
        loss, slope = jax.value_and_grad(lambda w: compute_loss(nnx.merge(graph, w), clean, words, key))(
            weights
        )
        change, moments = tx.update(slope, state["moments"], weights)
        weights = optax.apply_updates(weights, change)
        keep = jnp.minimum(0.998, (step + 1) / (step + 10))
        average = jax.tree.map(lambda a, w: keep * a + (1 - keep) * w, state["average"], weights)
        return {"weights": weights, "moments": moments, "average": average}, loss

    settings = command.list_settings() | {"clips": len(clips.videos), "shown": int(clips.videos.sum())}
    table = np.stack([read_prompt(prompt) for prompt in PROMPTS])
    key, losses = jax.random.key(command.seed), []
    with _open_checkpoints(command.checkpoints, settings) as kept:
        done = kept.latest_step() or 0
        if done:
            state = kept.restore(done, args=ocp.args.StandardRestore(state))
            print(f"goes on after step {done}, kept in {command.checkpoints}", flush=True)
        begun = time.perf_counter()
        for step in range(done, command.steps):
            rng = np.random.default_rng((command.seed, step))
            clean, motions = draw_batch(clips, rng, command.batch)
            words = table[motions] * (rng.random((command.batch, 1)) >= command.drop_prompt)
            state, loss = update(state, clean, words.astype(np.float32), jax.random.fold_in(key, step), step)
            losses.append(float(loss))
            if (step + 1) % 100 == 0:
                print(
                    f"step {step + 1}: loss {np.mean(losses[-100:]):.4f}, {time.perf_counter() - begun:.0f} s",
                    flush=True,
                )
            kept.save(step + 1, args=ocp.args.StandardSave(state))  # when it is due
    return nnx.merge(graph, state["average"])


def _open_checkpoints(folder: Path, settings: dict[str, float]) -> ocp.CheckpointManager:
    """Those of a training with ``settings``: one is kept, a new one comes every `_KEPT_EVERY` steps.

    Raises:
        UserError: Those in ``folder`` are of other settings.
    """
    options = ocp.CheckpointManagerOptions(save_interval_steps=_KEPT_EVERY, max_to_keep=1)
    kept = ocp.CheckpointManager(folder.resolve(), options=options, metadata=settings)
    found = kept.metadata().custom_metadata
    if kept.latest_step() and found != settings:
        kept.close()
        raise UserError(
            f"a training with other settings was cut off in {folder}",
            got=f"{settings}, there {found}",
            do="Give those settings and clips to go on, or delete the folder",
        )
    return kept


def validate(model: ToyVideoModel, held_out: Clips, *, draws: int, seed: int = 0) -> Validation:
    """Find the fitting prompt by the velocity's error, averaged over ``draws`` levels between 0.5 and 0.95."""
    table = jnp.asarray(np.stack([read_prompt(prompt) for prompt in PROMPTS]))
    rng = np.random.default_rng(seed)
    shares = np.linspace(0.5, 0.95, draws).astype(np.float32)
    shape = held_out.videos.shape[1:]
    noises = rng.standard_normal((draws, *shape), np.float32)

    @nnx.jit
    def find_error(model, clean, noise, share):
        noisy = jnp.broadcast_to((1 - share) * clean + share * noise, (len(table), *shape))
        velocity = model(noisy, jnp.full(len(table), share), table)
        return ((velocity - (noise - clean)) ** 2).mean((1, 2, 3, 4))

    def find_errors(video: np.ndarray) -> np.ndarray:
        clean = to_model(video)
        # Relative to the mean over the prompts, or the levels with the largest errors would decide alone.
        errors = np.stack([find_error(model, clean, e, s) for e, s in zip(noises, shares)])
        return (errors / errors.mean(1, keepdims=True)).mean(0)

    found = classify(find_errors, held_out.videos)
    unknown = held_out.objects == list(OBJECTS).index(UNSEEN)
    return summarise(found, held_out.motions, unknown, PROMPTS, draws)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    command = tyro.cli(Command, prog="python -m baselines.scores.toy.train", args=arguments)
    pa.enable_compile_cache()
    try:
        known, held_out = split(Clips.load(command.clips))
        begun = time.perf_counter()
        model = train(command, known)
        validation = validate(model, held_out, draws=command.validation_draws, seed=command.seed)
    except UserError as error:
        print(f"train: {error}", file=sys.stderr)
        return 2
    trained = dataclasses.asdict(command) | dict(
        seconds=round(time.perf_counter() - begun), learnt=len(known.videos)
    )
    save(command.out, model, validation, {name: str(value) for name, value in trained.items()})
    shutil.rmtree(command.checkpoints)
    print(
        f"toy prior in {command.out}: finds {validation.accuracy:.0%} of {validation.clips} held-out motions "
        f"(known kinds {validation.known_kinds:.0%}, unknown kind {validation.unknown_kind:.0%}, "
        f"chance {validation.chance:.0%}, needed {LEAST_ACCURACY:.0%})"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
