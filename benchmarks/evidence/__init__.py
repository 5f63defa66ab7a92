"""Evidence of pages: summaries of raw rows, tables, and code that has changed since.

A benchmark writes raw rows to ``benchmarks/raw/NAME.json``, which git ignores. `summaries` makes of them
``benchmarks/results/NAME.json``, which is kept, and the tables of ``docs/NAME.md`` are made of that alone.
"""
