"""Make the picture of tracks.md: a minute or two.

python docs/track_figures.py
"""

from dataclasses import replace
from pathlib import Path

from skinfield.lab.report import SHORT, Settings
from skinfield.lab.sections.tracks import pictures_of_tracks
from skinfield.lab.tracking import run_of

SETTINGS = Settings(size=replace(SHORT, cell=0.25e-3))

if __name__ == "__main__":
    result = run_of(SETTINGS, "capacitance", "ContactFit", 0)
    (picture,) = pictures_of_tracks(result["pictures"])
    (Path(__file__).parent / "images" / "tracks.png").write_bytes(picture.png)
