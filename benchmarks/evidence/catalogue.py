"""The pages that have measured tables."""

from __future__ import annotations

from benchmarks import distillation, gpu, limits, rendering, startup
from benchmarks.accuracy import markdown as accuracy
from benchmarks.agents import markdown as agents
from benchmarks.executor import markdown as executor
from benchmarks.first_results import markdown as first_results
from benchmarks.gradients import markdown as gradients
from benchmarks.harness import Page
from benchmarks.harness.sources import ROOT
from benchmarks.headtohead import markdown as headtohead
from benchmarks.inverse import markdown as inverse
from benchmarks.language import markdown as language
from benchmarks.parts import markdown as parts
from benchmarks.perception import markdown as perception
from benchmarks.skipping import markdown as skipping
from benchmarks.stability import markdown as stability
from benchmarks.throughput import markdown as throughput
from benchmarks.verdicts import markdown as verdicts

RESULTS, DOCS = ROOT / "benchmarks" / "results", ROOT / "docs"
_MODULES = (
    accuracy,
    agents,
    distillation,
    executor,
    first_results,
    gpu,
    gradients,
    headtohead,
    inverse,
    language,
    limits,
    parts,
    perception,
    rendering,
    skipping,
    stability,
    startup,
    throughput,
    verdicts,
)
PAGES: dict[str, Page] = {module.PAGE.name: module.PAGE for module in _MODULES}
