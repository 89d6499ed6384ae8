"""Non-negative fields in the dual: as many unknowns as taxels, however many nodes."""
