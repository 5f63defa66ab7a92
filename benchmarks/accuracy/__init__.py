"""Work against precision: the error of each case over the wall time it took, for ours and for peers."""
