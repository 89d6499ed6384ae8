"""What reconstructions are worth: cases with truth, scores, bounds, and the paper's campaign."""
