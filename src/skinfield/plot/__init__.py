"""Pictures of readings, fields and contacts; matplotlib is loaded when one is drawn."""

from skinfield.plot.estimate import draw_estimate as draw_estimate
from skinfield.plot.layout import draw_layout as draw_layout
from skinfield.plot.style import check_name as check_name
from skinfield.plot.style import save as save
from skinfield.plot.timeline import draw_timeline as draw_timeline
