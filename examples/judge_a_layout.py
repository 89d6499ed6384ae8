"""Judge a skin before it is made: what does a thicker elastomer bring, and what do more taxels?

No solver is asked. What is printed are limits that no method can beat, from one reading.
"""

from dataclasses import replace

import numpy as np

import skinfield as sf
from skinfield.design import (
    Places,
    SkinDesign,
    Touch,
    blind_spots,
    few_places,
    judge,
    place_accuracy,
)
from skinfield.design.plot import draw_judgement
from skinfield.plot import save

layer = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.5)
thin = SkinDesign(
    patch=sf.layouts.hexagon72(), layer=layer, quantity=sf.BaseStress(), noise_std=400.0
)
thick = replace(thin, layer=replace(layer, thickness=5e-3))
denser = replace(thin, patch=sf.layouts.rectangular(rows=12, columns=12, pitch=4e-3))
touch = Touch(force=0.5, radius=1e-3)  # N, m: half a newton on a contact of 2 mm across

for name, skin in (("2 mm thick", thin), ("144 taxels", denser), ("5 mm thick", thick)):
    places = Places.over(skin.patch, 1e-3)
    blind = blind_spots(skin, touch, places).blind_share
    told = place_accuracy(skin, touch, places)
    print(f"{name}: {blind:.0%} blind; half of the patch places {touch.force} N to within "
          f"{np.median(told.place_std) * 1e3:.2f} mm")  # fmt: skip

found = judge(thick, touch, places, two_point_places=few_places(thick, 60))
save(draw_judgement(found), "thick.png")
print("wrote thick.png")
