"""The whole skin at run time: one budget for all patches of a cycle."""
