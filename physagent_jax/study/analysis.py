"""Results of a study: preference rates, strengths, and agreement among raters and with our judge."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import stats

from physagent_jax.metrics.statistics import estimate_share
from physagent_jax.study.schema import QUESTIONS, Ballot, Study, StudyClip
from physagent_jax.study.statistics import (
    compute_agreement,
    compute_alpha,
    compute_fleiss_kappa,
    draw_participants,
    fit_strengths,
    is_estimable,
)

Row = dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Vote:
    """An answer to a question about a set: indices of participant, item and methods, shown from left to right."""

    participant: int
    item: int
    family: str
    shown: tuple[int, ...]
    chosen: int
    judged: int | None


def list_votes(study: Study, ballots: Sequence[Ballot], question: str) -> list[Vote]:
    """All votes on a question."""
    place = {clip.id: (index, clip) for index, item in enumerate(study.items) for clip in item.clips}
    method = {name: index for index, name in enumerate(study.methods)}
    votes = []
    for participant, ballot in enumerate(ballots):
        for answer, ids in zip(ballot.answers, study.sheets[ballot.sheet].sets):
            item, clips = place[ids[0]][0], [place[id_][1] for id_ in ids]
            judged = _find_favourite(clips)
            votes.append(
                Vote(
                    participant,
                    item,
                    study.items[item].family,
                    tuple(method[clip.method] for clip in clips),
                    method[place[answer.choices[question]][1].method],  # type: ignore[index]
                    None if judged is None else method[judged],
                )
            )
    return votes


def _find_favourite(clips: Sequence[StudyClip]) -> str | None:
    """The method whose clip one judge puts above all others; None where a clip is not judged, or two are level."""
    opinions = [clip.judged for clip in clips]
    if None in opinions or len({opinion.by for opinion in opinions if opinion}) != 1:
        return None
    order = sorted(((o.success, o.score, clip.method) for o, clip in zip(opinions, clips) if o), reverse=True)
    return order[0][2] if order[0][:2] != order[1][:2] else None


def analyse_study(study: Study, ballots: Sequence[Ballot]) -> Row:
    """All results as JSON: of each question, preference rates by family, strengths and agreement."""
    seconds = [answer.seconds for ballot in ballots for answer in ballot.answers]
    whole = sum(len(ballot.answers) == len(study.sheets[ballot.sheet].sets) for ballot in ballots)
    return {
        "study": study.id,
        "methods": list(study.methods),
        "alternatives": study.alternatives,
        "participants": len(ballots),
        "complete": whole,
        "sets": len(seconds),
        "median_seconds": float(np.median(seconds)) if seconds else None,
        "questions": {name: _analyse(study, list_votes(study, ballots, name)) for name in QUESTIONS},
    }


def _analyse(study: Study, votes: list[Vote]) -> Row:
    families = [family for family in dict.fromkeys(item.family for item in study.items) if family]
    rates = {family: _rate(study, [vote for vote in votes if vote.family == family]) for family in families}
    places = np.array([sum(v.shown.index(v.chosen) == k for v in votes) for k in range(study.alternatives)])
    asked = [vote for vote in votes if vote.judged is not None]
    judge: Row = {
        "sets": len(asked),
        "without_favourite": len(votes) - len(asked),
        "chance": 1 / study.alternatives,
    }
    if asked:
        share = estimate_share([vote.chosen == vote.judged for vote in asked])
        judge |= {"share": share.value, "low": share.low, "high": share.high}
    return {
        "upr": {**rates, "all": _rate(study, votes)},
        "strengths": _fit(study, votes),
        "agreement": _compare(study, votes),
        "judge": judge,
        "places": {"chosen": places.tolist(), "p": float(stats.chisquare(places).pvalue) if votes else None},
    }


def _rate(study: Study, votes: list[Vote]) -> Row:
    rates: Row = {}
    people = sorted({vote.participant for vote in votes})
    for index, name in enumerate(study.methods):
        mine = [vote for vote in votes if index in vote.shown]
        if not mine:
            continue
        won = Counter(vote.participant for vote in mine if vote.chosen == index)
        met = Counter(vote.participant for vote in mine)
        share = estimate_share([vote.chosen == index for vote in mine])
        drawn = draw_participants(np.array([won[p] for p in people]), np.array([met[p] for p in people]))
        rates[name] = {"chosen": won.total(), "shown": len(mine)}
        rates[name] |= {"share": share.value, "low": share.low, "high": share.high, "by_participants": drawn}
    return rates


def _fit(study: Study, votes: list[Vote]) -> Row:
    """Strengths of the methods that were shown; why there are none, where some are without bound."""
    met = sorted({index for vote in votes for index in vote.shown})
    place = {index: number for number, index in enumerate(met)}
    choices = Counter((tuple(sorted(place[i] for i in vote.shown)), place[vote.chosen]) for vote in votes)
    if not is_estimable(choices, len(met)):
        never = [study.methods[i] for i in met if all(vote.chosen != i for vote in votes)]
        reason = (
            f"never chosen: {', '.join(never)}" if never else "some methods were never chosen over the others"
        )
        return {"methods": None, "reason": f"no finite estimate ({reason})"}
    found, covariance = fit_strengths(choices, len(met))
    half = stats.norm.ppf(0.975) * np.sqrt(np.diag(covariance))
    told = zip(met, found, half)
    return {"methods": {study.methods[i]: {"log": s, "low": s - h, "high": s + h} for i, s, h in told}}


def _compare(study: Study, votes: list[Vote]) -> Row:
    """Agreement among raters who saw the same clips of an item, in whatever order."""
    units: dict[tuple, np.ndarray] = {}
    for vote in votes:
        key = (vote.item, frozenset(vote.shown))
        units.setdefault(key, np.zeros(len(study.methods)))[vote.chosen] += 1
    counts = np.array(list(units.values())).reshape(-1, len(study.methods))
    return {
        "units": len(units),
        "same": compute_agreement(counts),
        "chance": 1 / study.alternatives,
        "fleiss_kappa": compute_fleiss_kappa(counts),
        "krippendorff_alpha": compute_alpha(counts),
    }


def write_summary(result: Row) -> str:
    """The results as text for a terminal."""
    lines = [
        f"{result['participants']} participants ({result['complete']} saw all their sets), {result['sets']} sets, "
        f"median {result['median_seconds']:.0f} s a set. Intervals have 95 %: of UPR Wilson's, then by participants."
    ]
    for name, found in result["questions"].items():
        lines += ["", f"{name}: {QUESTIONS[name]}"]
        for family, rates in found["upr"].items():
            for method, rate in rates.items():
                ends = ", ".join(
                    _span(each, ".1%") for each in (_ends(rate), rate["by_participants"]) if each
                )
                line = f"  {family:12} {method:24} UPR {rate['share']:6.1%} ({ends}) {rate['chosen']}/{rate['shown']}"
                if family == "all" and found["strengths"]["methods"]:
                    strength = found["strengths"]["methods"][method]
                    line += f"  strength {strength['log']:+.2f} ({_span(_ends(strength), '+.2f')})"
                lines.append(line)
        if "reason" in found["strengths"]:
            lines.append(f"  strengths: {found['strengths']['reason']}")
        both, judge, places = found["agreement"], found["judge"], found["places"]
        lines.append(
            f"  raters: {_tell(both['same'], '.1%')} of pairs agree (chance {both['chance']:.1%}), alpha "
            f"{_tell(both['krippendorff_alpha'], '.3f')}, Fleiss' kappa {_tell(both['fleiss_kappa'], '.3f')}"
        )
        told = "our judge: it has a favourite in no set that was shown"
        if judge["sets"]:
            told = f"our judge: {judge['share']:.1%} ({_span(_ends(judge), '.1%')}) of {judge['sets']} votes are for "
            told += (
                f"its favourite (chance {judge['chance']:.1%}); in {judge['without_favourite']} it has none"
            )
        lines.append(f"  {told}")
        chosen = " / ".join(map(str, places["chosen"]))
        lines.append(f"  places: {chosen} chosen from left to right, p = {places['p']:.2g}")
    return "\n".join(lines)


def _ends(row: Row) -> tuple[float, float]:
    return row["low"], row["high"]


def _span(ends: tuple[float, float], form: str) -> str:
    return f"{ends[0]:{form}} to {ends[1]:{form}}"


def _tell(value: float | None, form: str) -> str:
    return "none" if value is None else format(value, form)
