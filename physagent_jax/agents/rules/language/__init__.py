"""Everyday English read by rules: tokens -> mentions -> clauses -> events -> force field.

`verbs` and `modifiers` are the lexicon (tables); `tokens` cuts the sentence, `mentions` finds the lexicon's phrases
in it, `timing` its durations, `clauses` its grammar, `events` what each clause does, `schedule` when, and
`compilation` turns that into actions, expectations and evidence, which `builder` collects.

`doubts` says what was not understood and would change the motion: words, and what the words that are known say
together. Each kind has a module: `comparisons`, `constructions`, `contradictions`, `movers`, `particles`, `parts`,
`elsewhere`, `questions`, `retractions`, `series`, `sides`, `suppositions`, `surroundings`, `turnings`. `corrections`
reads what is said instead, and `scopes` how far a word reaches. What the grammar made of the sentence is held against
it once more: `audit`, `accounting` (is every verb and way used?), `cross_check` (a second, simpler reading of the
words) and `coherence` (the motions against each other).
"""
