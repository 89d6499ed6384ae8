"""What a rig knows and a skin has to find out."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints


@dataclass(frozen=True, eq=False)
class Truth:
    """Of one recording; its fields are the keys of ``truth.npz``, in SI units.

    Attributes
    ----------
    time_s : (S,) array
        Of the series, every 2 ms, since the start; stamp 0 is time 0.
    force_N : (S,) array
        Into the skin.
    effective_force_N : (S,) array
        Force at which the elastic solution has the displacements of that moment, of the pose that
        is pressed or was pressed last.
    depth_m : (S,) array
        Of the deepest point of the surface below the indenter.
    height_m : (S,) array
        Of the indenter's lowest point above the undeformed surface; negative while it presses.
    contact_area_m2 : (S,) array
        0 where there is no force.
    press : (S,) int array
        Row of the press under way; -1 before the first and after the last.
    press_x_m, press_y_m, press_angle_rad : (P,) arrays
        Pose of the indenter in the patch's plane.
    press_load : (P,) int array
        Row of the load.
    press_start_s, press_touch_s, press_hold_s, press_release_s, press_end_s : (P,) arrays
        When it comes down, touches, has its full load, lets go and is off again.
    press_force_N, press_effective_force_N, press_depth_m, press_area_m2 : (P,) arrays
        At the end of the hold.
    load_force_N : (N,) array
        Of the elastic solution of each load: the force given, or that of the depth given.
    load_effective_force_N : (N,) array
        Highest at any end of hold with that load.
    plane_m : (K, 2) array
        Cells of the fields as the indenter sees them: place = R(angle) plane + (x, y).
    cell_m : float
        Side of a cell.
    pressure_Pa : (N, K) array
        Of each load; sums to its force.
    displacement_m : (N, K, 3) array
        Of the surface, negative z is into the skin, at the effective force of each load.
    reading_time_s : (R,) array
        When the first taxels of each reading were converted.
    reading_change : (R, L) array
        True ΔC/C₀ of the taxels then.
    reading_force_N : (R,) array
        True force at `reading_time_s`.
    """

    time_s: Floats
    force_N: Floats
    effective_force_N: Floats
    depth_m: Floats
    height_m: Floats
    contact_area_m2: Floats
    press: Ints
    press_x_m: Floats
    press_y_m: Floats
    press_angle_rad: Floats
    press_load: Ints
    press_start_s: Floats
    press_touch_s: Floats
    press_hold_s: Floats
    press_release_s: Floats
    press_end_s: Floats
    press_force_N: Floats
    press_effective_force_N: Floats
    press_depth_m: Floats
    press_area_m2: Floats
    load_force_N: Floats
    load_effective_force_N: Floats
    plane_m: Floats
    cell_m: float
    pressure_Pa: Floats
    displacement_m: Floats
    reading_time_s: Floats
    reading_change: Floats
    reading_force_N: Floats

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """All by name, as they are stored."""
        return {item.name: np.asarray(getattr(self, item.name)) for item in fields(self)}
