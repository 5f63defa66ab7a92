"""Results of made-up methods, studies of them, and raters of known taste: for tests only."""

import numpy as np

from physagent_jax.output.video import write_video
from physagent_jax.study.build import build_study
from physagent_jax.study.schema import QUESTIONS, Answer, Ballot


def write_clip(path, shade=100, frames=6, sentence="push it to the left"):
    path.parent.mkdir(parents=True, exist_ok=True)
    pictures = np.full((frames, 48, 64, 3), shade, np.uint8)
    pictures[np.arange(frames), :, 4 * np.arange(frames)] = 255
    write_video(path, pictures, 24.0)
    path.with_name(f"{path.name[:-4]}.txt").write_text(sentence)


def write_results(
    folder, methods=("ours", "theirs", "others"), items=("drop/a", "drop/b", "sway/c"), lacking=()
):
    for number, method in enumerate(methods):
        for item in items:
            if (method, item) not in lacking:
                write_clip(
                    folder / method / f"{item}.mp4",
                    60 + 20 * number,
                    sentence=f"move <the {item[-1]}> & hold",
                )
    return [str(folder / method) for method in methods]


def make_study(folder, participants=6, sets=None, alternatives=3, open_=False, seed=0, **options):
    results = write_results(folder / "results", **options)
    study, balance, notes = build_study(
        results,
        folder / "study",
        participants=participants,
        sets=sets,
        alternatives=alternatives,
        open_=open_,
        seed=seed,
    )
    return study, folder / "study", balance, notes


def vote(study, sheet, choose, count=None):
    """A ballot; ``choose`` gets the methods from left to right and the question, and names one."""
    methods = {clip.id: clip.method for item in study.items for clip in item.clips}
    answers = []
    for shown in study.sheets[sheet].sets[:count]:
        by_name = {methods[id_]: id_ for id_ in shown}
        choices = {question: by_name[choose(list(by_name), question)] for question in QUESTIONS}
        answers.append(Answer(choices=choices, seconds=5.0))
    code = study.sheets[sheet].code or f"{sheet:03d}-{sheet:016x}"
    return Ballot(study=study.id, code=code, answers=tuple(answers))
