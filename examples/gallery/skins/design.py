"""
Judge a skin before it is made
==============================

Where would a light touch go unheard? The map of blind spots needs a layout, a layer and a noise,
and no solver: it is what no method can beat. A thicker layer spreads a touch to more taxels.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import skinfield as sf
from skinfield.design import Places, SkinDesign, Touch, blind_spots, place_accuracy
from skinfield.skin.maps import draw_cells, extent_of_pads, frame_axes, outline_pads

touch = Touch(force=0.5, radius=1e-3)  # N, m: half a newton on a contact of 2 mm across
thin = SkinDesign(
    patch=sf.layouts.hexagon72(),
    layer=sf.Layer(thickness=2e-3, young_modulus=150e3),
    quantity=sf.BaseStress(),
    noise_std=400.0,  # Pa
)
designs = {
    "2 mm thick": thin,
    "5 mm thick": replace(thin, layer=replace(thin.layer, thickness=5e-3)),
    "2 mm, 144 taxels": replace(
        thin, patch=sf.layouts.rectangular(rows=12, columns=12, pitch=4e-3)
    ),
}

# %%
# White is heard as well as anywhere, dark is deaf.

figure, row = plt.subplots(1, 3, figsize=(11.5, 4.2), layout="constrained")
blind = {}
for axes, (name, design) in zip(row, designs.items()):
    places = Places.over(design.patch, 1e-3)
    spots = blind_spots(design, touch, places)
    told = np.median(place_accuracy(design, touch, places).place_std) * 1e3  # mm
    frame_axes(axes, design.patch, extent_of_pads(design.patch))
    heard = places.picture(spots.response)
    cells = draw_cells(axes, places.grid, heard, cmap="magma", vmin=0, vmax=1)
    outline_pads(axes, design.patch)
    blind[name] = spots.blind_share
    axes.set_title(f"{name}: {blind[name]:.0%} blind,\nplaces {touch.force} N to {told:.2f} mm")
figure.colorbar(cells, ax=row, label="response, part of the best place's", shrink=0.7)
plt.show()

print(", ".join(f"{name}: {share:.1%} blind" for name, share in blind.items()))
assert blind["5 mm thick"] < 0.02 < 0.15 < blind["2 mm thick"] < 0.25
