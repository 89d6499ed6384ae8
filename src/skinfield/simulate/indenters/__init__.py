"""Rigid bodies that press on the skin: pose and load, shapes, and bodies of triangles."""
