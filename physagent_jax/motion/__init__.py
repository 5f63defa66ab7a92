"""The motion that is asked for, and the verdict on the motion that is seen.

`schema` holds the scene brief, expected motions and judgements; `tolerances` are the amounts that viewers expect of
words; `matching` tells which action causes which motion; `judging` compares a motion report with the expectations. It
knows no agent and no sentence: whoever writes expectations and reports can be judged. No arrays, no jax.
"""
