"""Contacts over time, in the report: do the numbers last, and how near are the tracks."""
