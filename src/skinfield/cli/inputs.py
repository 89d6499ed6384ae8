"""What the words of a command line stand for."""

from skinfield.layout.words import skin_from_text as skin_from_text

LAYOUT_HELP = """LAYOUT is a layout file, or a generator by name such as hexagon72 or
cylinder:radius_mm=40 ('skinfield layout generators' lists them)."""
