"""Press of bodies on the skin, on finer squares than it is asked for, and what taxels read."""
