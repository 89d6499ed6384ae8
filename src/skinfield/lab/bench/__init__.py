"""Times on this machine: the paper's Figure 9 anew, and error against time."""
