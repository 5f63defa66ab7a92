"""Everyday English read by rules: words -> marks -> clauses -> events -> force field.

`verbs` and `modifiers` are the lexicon (tables); `words` cuts the sentence into tokens, `marks` finds
the lexicon's phrases in it, `timing` its durations, `clauses` its grammar, `events` what each clause
does, `schedule` when, and `compilation` turns that into actions, expectations and evidence.
"""
