"""Bytes of real boards to readings and back; no sockets, no files: those are in `sources`."""
