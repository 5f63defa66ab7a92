"""Pairs on objects that nothing was developed with: a module for each lot, written before any of its pairs was run.

A pair is never changed, nor taken out because it fails: whoever wants another writes another lot.
"""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.first_results.cases import Case, Thing
from benchmarks.first_results.held_back import (
    again,
    eighteenth,
    eighth,
    eleventh,
    fifteenth,
    fifth,
    fourteenth,
    fourth,
    nineteenth,
    ninth,
    seventeenth,
    seventh,
    sixteenth,
    sixth,
    sixty,
    tenth,
    third,
    thirteenth,
    twelfth,
    twentieth,
    twentyeighth,
    twentyfifth,
    twentyfirst,
    twentyfourth,
    twentyninth,
    twentysecond,
    twentyseventh,
    twentysixth,
    twentythird,
)
from benchmarks.first_results.pins import PinnedFile

_LOTS = (
    sixty,
    again,
    third,
    fourth,
    fifth,
    sixth,
    seventh,
    eighth,
    ninth,
    tenth,
    eleventh,
    twelfth,
    thirteenth,
    fourteenth,
    fifteenth,
    sixteenth,
    seventeenth,
    eighteenth,
    nineteenth,
    twentieth,
    twentyfirst,
    twentysecond,
    twentythird,
    twentyfourth,
    twentyfifth,
    twentysixth,
    twentyseventh,
    twentyeighth,
    twentyninth,
)

FILES: Mapping[str, PinnedFile] = {name: file for lot in _LOTS for name, file in lot.FILES.items()}
THINGS: Mapping[str, Thing] = {name: thing for lot in _LOTS for name, thing in lot.THINGS.items()}
SETS: Mapping[str, tuple[Case, ...]] = {name: pairs for lot in _LOTS for name, pairs in lot.SETS.items()}
