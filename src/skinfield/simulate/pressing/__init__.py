"""A press from bodies to pressure, on finer squares than it is asked for, and what it does."""
