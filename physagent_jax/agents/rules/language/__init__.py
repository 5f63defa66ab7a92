"""Everyday English read by rules: tokens -> mentions -> clauses -> events -> force field.

`verbs` and `modifiers` are the lexicon (tables); `tokens` cuts the sentence, `mentions` finds the lexicon's phrases
in it, `timing` its durations, `clauses` its grammar, `events` what each clause does, `schedule` when, and
`compilation` turns that into actions, expectations and evidence, which `builder` collects.

`doubts` says what was not understood and would change the motion: words, and what the words that are known say
together. Each kind has a module: `comparisons`, `constructions`, `contradictions`, `movers`, `particles`, `parts`,
`questions`, `retractions`, `series`, `sides`, `suppositions`, `surroundings`, `turnings`. `corrections` reads what is
said instead, and `scopes` how far a word reaches.
"""
