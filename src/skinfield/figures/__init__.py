"""Pictures of readings, fields and contacts; matplotlib is loaded when one is drawn."""

from skinfield.figures.blindness import draw_blindness as draw_blindness
from skinfield.figures.estimate import draw_estimate as draw_estimate
from skinfield.figures.layout import draw_layout as draw_layout
from skinfield.figures.maps import draw_map as draw_map
from skinfield.figures.save import check_name as check_name
from skinfield.figures.save import save as save
from skinfield.figures.timeline import draw_timeline as draw_timeline
