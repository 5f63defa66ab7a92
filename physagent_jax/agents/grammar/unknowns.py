from physagent_jax.agents.grammar import coverage as c
def list_unknown(mentions, names, brief):
    cov = c.sort_words(mentions, names, brief)
    global LAST
    LAST = cov
    return list(cov.doubtful), ([f"'{' '.join(cov.taken)}' is taken to be the object ({brief.object_name})."] if cov.taken else [])
def is_mostly_unknown(mentions, unknown): return c.is_mostly_unknown(mentions, LAST)
