"""The toy prior's clips show what their prompts say, its gradient is that of its loss, and a bad one is refused."""

import zlib

import numpy as np
import pytest

import physagent_jax as pa
from baselines.scores.toy import clips as clips_module
from baselines.scores.toy.clips import SIZE, Clips, Command, draw_options, make_clips, play
from baselines.scores.toy.motions import FRAMES, MOTIONS, WORDS, draw_force_field, read_prompt
from baselines.scores.toy.objects import OBJECTS, write_object
from baselines.scores.toy.validation import classify, summarise
from physagent_jax.core.errors import UserError

pytestmark = pytest.mark.usefixtures("module_least_optimised")  # to compile takes longest


def mean_of_words(*words):
    return np.array([word in words for word in WORDS], np.float32)


@pytest.mark.parametrize(
    "sentence, words",
    [
        ("push the robot to the left", ("move", "left")),
        ("A strong wind bends the plant to the right", ("move", "tilt", "right")),
        ("the loaf FALLS", ("move", "down")),
        ("Twist the jelly", ("turn",)),
        ("stretch it sideways", ("stretch", "sideways")),
    ],
)
def test_sentences_are_read_word_by_word(sentence, words):
    assert np.array_equal(read_prompt(sentence), mean_of_words(*words))


def test_every_motion_has_its_own_condition_and_unknown_words_are_refused():
    conditions = {tuple(read_prompt(prompt)) for prompt in MOTIONS}
    assert len(conditions) == len(MOTIONS)
    with pytest.raises(UserError, match="knows no word"):
        read_prompt("a cat plays the piano")


def test_force_fields_follow_the_seed_and_fit_the_clip():
    for prompt in MOTIONS:
        one, again, other = (draw_force_field(prompt, np.random.default_rng(seed)) for seed in (1, 1, 2))
        assert one == again and (one != other or prompt == "still")
        assert all((action.active_time or (0, 0))[1] <= FRAMES - 1 for action in one.actions)


def measure_shift(video):
    """Path of what is not white, from the first frame to the last, in pictures (right, down)."""
    dark = (1 - video.astype(float) / 255).mean(-1)
    rows, columns = np.indices(video.shape[1:3])
    centres = [((d * columns).sum() / d.sum(), (d * rows).sum() / d.sum()) for d in dark]
    return (np.array(centres[-1]) - centres[0]) / SIZE


def test_clips_show_what_their_prompts_say(tmp_path):
    """Directions are the viewer's: by the centre of what is not white."""
    path = write_object("drum", 0, tmp_path)
    with pytest.warns(UserWarning, match="thinly filled"):
        drum = pa.load_object(path, up="+z", kind="jelly", extent=0.8, cells=32, max_particles=400)
    shifts = {
        prompt: measure_shift(play(drum, draw_options(prompt, np.random.default_rng(0))))
        for prompt in ("move left", "move right", "move up", "move down", "still")
    }
    assert shifts["move left"][0] < -0.05 and shifts["move right"][0] > 0.05
    assert shifts["move up"][1] < -0.05 and shifts["move down"][1] > 0.05
    assert np.abs(shifts["still"]).max() < 1e-3
    for prompt in ("move left", "move right"):
        assert abs(shifts[prompt][1]) < 0.5 * abs(shifts[prompt][0])


def test_objects_are_others_for_other_seeds(tmp_path):
    made = {name: [write_object(name, seed, tmp_path).read_bytes() for seed in (0, 0, 1)] for name in OBJECTS}
    assert all(one == again != other for one, again, other in made.values())
    assert len({one for one, _, _ in made.values()}) == len(OBJECTS)


def test_clips_are_kept(tmp_path):
    rng = np.random.default_rng(0)
    clips = Clips(rng.integers(0, 255, (3, FRAMES, SIZE, SIZE, 3), np.uint8), *np.arange(9).reshape(3, 3))
    clips.save(tmp_path / "clips.npz")
    again = Clips.load(tmp_path / "clips.npz")
    assert np.array_equal(again.videos, clips.videos) and np.array_equal(again.objects, clips.objects)
    assert again.select(again.motions == 1).instances.tolist() == [7]
    with pytest.raises(UserError, match="toy.clips"):
        Clips.load(tmp_path / "none.npz")


@pytest.mark.filterwarnings("ignore:only:UserWarning")
def test_clips_that_were_cut_off_go_on_as_if_they_had_not_been(tmp_path, monkeypatch, capsys):
    """Interrupted clips continue: objects, motions and videos, with the simulation replaced by a stand-in."""

    def write_down(loaded, options):
        return np.full((1, 1, 1, 3), zlib.crc32(str(options).encode()) % 251, np.uint8)

    def fail(loaded, options):
        played.append(0)
        if len(played) == 4:
            raise KeyboardInterrupt
        return write_down(loaded, options)

    played = []
    monkeypatch.setattr(clips_module, "_KEPT_EVERY", 2)
    monkeypatch.setattr(clips_module, "play", write_down)
    settings = dict(count=5, instances=2, particles=100)
    whole = make_clips(Command(out=tmp_path / "whole" / "clips.npz", **settings))
    cut = Command(out=tmp_path / "cut" / "clips.npz", **settings)
    monkeypatch.setattr(clips_module, "play", fail)
    with pytest.raises(KeyboardInterrupt):
        make_clips(cut)
    monkeypatch.setattr(clips_module, "play", write_down)
    with pytest.raises(UserError, match="other settings"):
        make_clips(Command(out=cut.out, count=6))
    again = make_clips(cut)
    assert "goes on after 2 clips" in capsys.readouterr().out
    for name in ("videos", "motions", "objects", "instances"):
        assert np.array_equal(getattr(whole, name), getattr(again, name)), name


def test_accuracy_counts_the_clips_whose_own_prompt_fits_best():
    errors = np.array([[1.0, 2.0, 3.0], [2.0, 1.0, 3.0], [1.0, 3.0, 2.0], [0.5, 1.0, 0.4]])
    found = classify(lambda clip: errors[int(clip)], np.arange(4))
    assert found.tolist() == [0, 1, 0, 2]
    made = summarise(found, np.array([0, 1, 2, 2]), np.array([False, False, True, True]), "abc", 5)
    assert (made.accuracy, made.known_kinds, made.unknown_kind) == (0.75, 1.0, 0.5)
    assert made.by_motion == {"a": 1.0, "b": 1.0, "c": 0.5} and made.chance == pytest.approx(1 / 3)


# What follows needs the network itself.


@pytest.fixture(scope="module")
def nnx():
    pytest.importorskip("orbax.checkpoint", reason="needs the extra `toy`")
    return pytest.importorskip("flax.nnx", reason="needs the extra `toy`")


def make_model(nnx, **sizes):
    """A small model, its weights moved off the zeros that some begin with."""
    import jax

    from baselines.scores.toy.model import ModelConfig, ToyVideoModel

    model = ToyVideoModel(ModelConfig(**(dict(width=16, depth=1, heads=2) | sizes)), rngs=nnx.Rngs(0))
    state = nnx.state(model, nnx.Param)
    leaves, tree = jax.tree.flatten(state)
    keys = jax.random.split(jax.random.key(1), len(leaves))
    moved = [leaf + 0.1 * jax.random.normal(key, leaf.shape) for leaf, key in zip(leaves, keys)]
    nnx.update(model, jax.tree.unflatten(tree, moved))
    return model


@pytest.fixture(scope="module")
def model(nnx):
    """A small model that no test changes."""
    return make_model(nnx)


def make_validation(accuracy=1.0):
    share = int(100 * accuracy)
    found = np.array([0] * share + [1] * (100 - share))
    return summarise(found, np.zeros(100, int), found < 0, list(MOTIONS), 1)


def draw_video(frames=FRAMES, height=SIZE, width=SIZE, seed=0):
    return np.random.default_rng(seed).uniform(0, 1, (frames, height, width, 3)).astype(np.float32)


def test_a_token_s_patch_comes_from_where_it_goes_to(nnx):
    """Without blocks nothing mixes: a changed pixel changes its own patch, four frames of 4 x 4 pixels."""
    model = make_model(nnx, depth=0)
    clip, words = draw_video(), np.zeros((1, len(WORDS)), np.float32)
    moved = clip.copy()
    moved[5, 20, 9, 1] += 1.0
    guesses = [np.asarray(model.guess_clean(each[None], np.full(1, 0.5), words))[0] for each in (clip, moved)]
    changed = (np.abs(guesses[1] - guesses[0]) > 1e-7).any(-1)
    wanted = np.zeros_like(changed)
    wanted[4:8, 20:24, 8:12] = True
    assert np.array_equal(changed, wanted)


def test_the_velocity_is_that_of_the_guess(model):
    """x_s = (1 - s) x_0 + s e and v = e - x_0 give x_0 = x_s - s v."""
    clip = draw_video()[None]
    share, words = np.full(1, 0.4, np.float32), read_prompt("move left")[None]
    velocity = np.asarray(model(clip, share, words))
    assert np.allclose(clip - 0.4 * velocity, model.guess_clean(clip, share, words), atol=1e-5)


@pytest.mark.parametrize("motion", [False, True])
def test_gradient_is_that_of_the_published_loss(nnx, model, motion):
    """JAX's derivative of 0.5 |x0 - (x0 - g).detach()|^2, through the same resampling."""
    import dataclasses

    import jax
    import jax.numpy as jnp

    from baselines.scores import ScorePrior, sds
    from baselines.scores.toy.prior import SETTINGS, ToyPrior

    settings = dataclasses.replace(SETTINGS, motion=motion)
    prior = ToyPrior(model, make_validation(), settings)
    assert isinstance(prior, ScorePrior) and prior.toy and prior.name == "toy prior"
    video = draw_video(20, 40, 48)
    found = prior.gradient(video, "push it left", jax.random.key(3))

    picked = video[np.linspace(0, 19, FRAMES).round().astype(int)]
    words = {told: told * read_prompt("move left")[None] for told in (0, 1)}

    def encode(frames):
        square = jnp.concatenate([frames[:, :1]] * 4 + [frames] + [frames[:, -1:]] * 4, 1)
        return 2 * jax.image.resize(square, (FRAMES, SIZE, SIZE, 3), "linear") - 1

    predict = nnx.jit(lambda model, *given: model(*given))  # operation by operation it takes far longer

    def find_slope(x0):
        total = 0
        draws = sds.draw(settings, jax.random.key(3), x0.shape)
        for drawn in draws:
            noisy, s = (1 - drawn.time) * x0 + drawn.time * drawn.noise, np.full(1, drawn.time, np.float32)
            bare, told = (predict(model, noisy[None], s, words[each])[0] for each in (0, 1))
            total += (bare + settings.guidance * (told - bare) - (drawn.noise - x0)) / len(draws)
        return total

    x0 = encode(picked)
    slope = find_slope(x0) - (find_slope(encode(np.repeat(video[:1], FRAMES, 0))) if motion else 0)
    detached = x0 - slope  # nothing goes back through it

    def loss(frames):
        return 0.5 * ((encode(frames) - detached) ** 2).sum()

    by_picked = np.asarray(jax.grad(loss)(picked))
    wanted = np.zeros_like(video)
    np.add.at(wanted, np.linspace(0, 19, FRAMES).round().astype(int), by_picked)
    assert np.abs(wanted).max() > 0 and np.abs(found - wanted).max() < 1e-3 * np.abs(wanted).max()
    assert prior.cost.calls == 2 * settings.draws * (1 + motion)


def test_a_prior_is_kept_and_one_that_learnt_nothing_is_refused(model, tmp_path):
    from baselines.scores import open_prior
    from baselines.scores.toy.prior import ToyPrior, save

    video = draw_video()
    save(tmp_path / "good", model, make_validation(0.9), dict(steps=1))
    again = open_prior("toy", str(tmp_path / "good"))
    wanted = ToyPrior(model, make_validation()).gradient(video, "move up", 0)
    assert np.array_equal(again.gradient(video, "move up", 0), wanted)
    save(tmp_path / "bad", model, make_validation(0.3), {})
    with pytest.raises(UserError, match="30%"):
        open_prior("toy", str(tmp_path / "bad"))
    with pytest.raises(UserError, match="no toy prior"):
        open_prior("toy", str(tmp_path))


def test_loss_of_a_model_that_knows_only_mean_and_spread(nnx):
    """A fresh model is the best linear guess: for a clip one spread off the mean its loss is 1 at every noise level."""
    import jax

    from baselines.scores.toy.model import MEAN, SPREAD, ModelConfig, ToyVideoModel
    from baselines.scores.toy.train import compute_loss

    model = ToyVideoModel(ModelConfig(width=16, depth=1, heads=2), rngs=nnx.Rngs(0))
    words = np.zeros((4, len(WORDS)), np.float32)
    clean = np.ones((4, FRAMES, SIZE, SIZE, 3), np.float32)
    loss = nnx.jit(compute_loss)
    losses = [
        float(loss(model, (MEAN + scale * SPREAD) * clean, words, jax.random.key(key)))
        for scale in (-1, 1)
        for key in range(3)
    ]
    assert losses == pytest.approx([1.0] * 6, abs=0.03)


def test_validation_finds_the_prompts_of_a_model_that_knows_them(nnx):
    """Each prompt's clip has a grey of its own; the model answers with the velocity to the grey of the words."""
    import jax.numpy as jnp

    from baselines.scores.toy.train import split, validate

    table = np.stack([read_prompt(prompt) for prompt in MOTIONS])
    greys = np.linspace(0, 255, len(MOTIONS)).round().astype(np.uint8)

    class Knowing(nnx.Module):
        def __call__(self, noisy, share, words):
            index = (jnp.abs(words[:, None] - table) < 0.5).all(-1).argmax(1)
            clean = jnp.asarray(greys / 127.5 - 1)[index][:, None, None, None, None]
            return (noisy - clean) / share[:, None, None, None, None]

    motions = np.arange(len(MOTIONS))
    videos = np.broadcast_to(greys[:, None, None, None, None], (len(greys), FRAMES, SIZE, SIZE, 3))
    kinds = motions % len(OBJECTS)
    clips = Clips(videos, motions, kinds, motions % 3)
    assert validate(Knowing(), clips, draws=2).accuracy == 1
    wrong = Clips(videos, np.roll(motions, 1), kinds, motions % 3)
    assert validate(Knowing(), wrong, draws=2).accuracy == 0
    known, held_out = split(clips)
    unseen = list(OBJECTS).index("vase")
    assert unseen not in known.objects and 2 not in known.instances
    assert len(known.videos) + len(held_out.videos) == len(videos)


def test_mirrored_clips_have_mirrored_prompts(nnx):
    from baselines.scores.toy.train import PROMPTS, draw_batch

    left, right = PROMPTS.index("move left"), PROMPTS.index("move right")
    video = np.full((1, FRAMES, SIZE, SIZE, 3), 255, np.uint8)
    for t in range(FRAMES):
        video[0, t, 12:20, 24 - t : 28 - t] = 0  # goes left
    clips = Clips(video, np.array([left]), np.zeros(1, int), np.zeros(1, int))
    drawn, motions = draw_batch(clips, np.random.default_rng(0), 16)
    assert set(motions.tolist()) == {left, right}
    for clip, motion in zip(drawn, motions):
        shift = measure_shift(np.round(127.5 * (clip + 1)))
        assert (shift[0] < 0) == (motion == left) and abs(shift[1]) < 0.02


@pytest.mark.slow
def test_a_training_that_was_cut_off_goes_on_as_if_it_had_not_been(nnx, tmp_path, monkeypatch, capsys):
    import dataclasses

    import jax

    from baselines.scores.toy import train as training

    small = training.ModelConfig(width=16, depth=1, heads=2)
    monkeypatch.setattr(training, "ModelConfig", lambda words: dataclasses.replace(small, words=words))
    monkeypatch.setattr(training, "_KEPT_EVERY", 2)
    rng = np.random.default_rng(0)
    clips = Clips(rng.integers(0, 255, (4, FRAMES, SIZE, SIZE, 3), np.uint8), *np.zeros((3, 4), int))
    command = training.Command(steps=5, batch=2, out=tmp_path / "whole")
    whole = jax.tree.leaves(nnx.state(training.train(command, clips), nnx.Param))

    cut, draw_batch, drawn = dataclasses.replace(command, out=tmp_path / "cut"), training.draw_batch, []

    def cut_off(*arguments):
        drawn.append(0)
        if len(drawn) == 4:
            raise KeyboardInterrupt
        return draw_batch(*arguments)

    monkeypatch.setattr(training, "draw_batch", cut_off)
    with pytest.raises(KeyboardInterrupt):
        training.train(cut, clips)
    monkeypatch.setattr(training, "draw_batch", draw_batch)
    with pytest.raises(UserError, match="other settings"):
        training.train(dataclasses.replace(cut, seed=1), clips)
    again = jax.tree.leaves(nnx.state(training.train(cut, clips), nnx.Param))
    assert "goes on after step 2" in capsys.readouterr().out
    assert all(np.array_equal(one, other) for one, other in zip(whole, again))
