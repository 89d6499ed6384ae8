"""Laboratory: cases and scores, the experiments of the paper, reports; nothing of it is core."""
