"""Light touch: what the detector finds beside the paper's method."""
