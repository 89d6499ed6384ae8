"""Layouts: files of taxel positions; `load` reads and writes them."""
