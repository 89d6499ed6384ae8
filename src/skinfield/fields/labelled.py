"""Estimates as labelled arrays."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import SkinfieldError

if TYPE_CHECKING:
    import xarray

    from skinfield.fields.estimate import Estimate


def dataset_from_estimate(estimate: "Estimate") -> "xarray.Dataset":
    """Data set over (reading,) row, column, axis with the unit of each variable in its attributes.

    Raises
    ------
    SkinfieldError
        If xarray is not installed.
    """
    try:
        import xarray
    except ImportError as error:
        raise SkinfieldError(
            "to_xarray() needs xarray, which is not installed: pip install 'skinfield[xarray]'"
        ) from error
    grid = estimate.grid
    cell = ("row", "column")
    lead = ("reading",) if estimate.is_batch else ()

    def variable(values: Any, unit: str, text: str, dims: tuple[str, ...]) -> Any:
        folded = values.reshape(
            *values.shape[: len(lead)], *grid.shape, *values.shape[len(lead) + 1 :]
        )
        return (dims, folded, {"units": unit, "long_name": text})

    fields = {
        "pressure": variable(
            estimate.pressure, "Pa", "pressure, compression positive", lead + cell
        ),
        "traction": variable(
            estimate.traction, "Pa", "traction on the skin", (*lead, *cell, "axis")
        ),
        "displacement": variable(
            estimate.displacement, "m", "displacement of the surface", (*lead, *cell, "axis")
        ),
        "pressure_std": variable(
            estimate.pressure_std, "Pa", "standard deviation of pressure", lead + cell
        ),
    }
    rows, columns = grid.shape
    coords: dict[str, Any] = {
        "x": ("column", grid.origin[0] + np.arange(columns) * grid.pitch, {"units": "m"}),
        "y": ("row", grid.origin[1] + np.arange(rows) * grid.pitch, {"units": "m"}),
        "axis": ("axis", ["x", "y", "z"]),
        "position": ((*cell, "axis"), grid.positions.reshape(rows, columns, 3), {"units": "m"}),
    }
    if estimate.is_batch:
        stamps = np.broadcast_to(estimate.stamp_ns, len(estimate))
        coords["stamp"] = ("reading", stamps, {"units": "ns"})
    return xarray.Dataset(
        fields, coords, {"patch": grid.patch.name, "cell_area_m2": grid.cell_area}
    )
