"""Recorder and replay of a live skin."""
