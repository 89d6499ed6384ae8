"""Parts of the tracker: what it hands out, the filter, the assignment, merging and splitting."""
