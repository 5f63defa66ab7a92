"""The judgement's clauses: what the sentence and the motion alone say, each as a `Check`."""
