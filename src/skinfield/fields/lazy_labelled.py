"""Labelled arrays whose values are computed when they are asked for."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import SkinfieldError
from skinfield.layout import Grid

TEXTS = {
    "pressure": ("Pa", "pressure, compression positive"),
    "indentation": ("m", "displacement into the skin along its normal"),
    "displacement": ("m", "displacement of the surface"),
}


def dataset_from_lazy(grid: Grid, stamp_ns: NDArray[Any], arrays: Mapping[str, Any]) -> Any:
    """Data set over reading, row, column, axis; nothing is computed yet.

    Parameters
    ----------
    grid : Grid
    stamp_ns : (T,) array, ns
    arrays : mapping of str to array
        By a name of `TEXTS`: with shape (T, rows, columns) or (T, rows, columns, 3), a dtype, and
        NumPy's indexing.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    SkinfieldError
        If xarray is not installed.
    """
    try:
        import xarray
        from xarray.core.indexing import LazilyIndexedArray
    except ImportError as error:
        raise SkinfieldError(
            "to_xarray() needs xarray, which is not installed: pip install 'skinfield[xarray]'"
        ) from error
    fields = {}
    for name, values in arrays.items():
        unit, text = TEXTS[name]
        dims = ("reading", "row", "column", "axis")[: len(values.shape)]
        said = {"units": unit, "long_name": text}
        fields[name] = xarray.Variable(dims, LazilyIndexedArray(_adapter()(values)), said)
    rows, columns = grid.shape
    coords: dict[str, Any] = {
        "x": ("column", grid.origin[0] + np.arange(columns) * grid.pitch, {"units": "m"}),
        "y": ("row", grid.origin[1] + np.arange(rows) * grid.pitch, {"units": "m"}),
        "axis": ("axis", ["x", "y", "z"]),
        "stamp": ("reading", stamp_ns, {"units": "ns"}),
    }
    return xarray.Dataset(
        fields, coords, {"patch": grid.patch.name, "cell_area_m2": grid.cell_area}
    )


def _adapter() -> Any:
    """Class that shows xarray how such an array is indexed; made here, where xarray is loaded."""
    from xarray.backends import BackendArray
    from xarray.core import indexing

    class Adapter(BackendArray):
        def __init__(self, array: Any) -> None:
            self.array, self.shape, self.dtype = array, array.shape, array.dtype

        def __getitem__(self, key: Any) -> Any:
            support = indexing.IndexingSupport.OUTER_1VECTOR
            return indexing.explicit_indexing_adapter(key, self.shape, support, self._taken)

        def _taken(self, key: tuple[Any, ...]) -> Any:
            """One array at most: whole numbers as slices, or NumPy would take them for arrays."""
            single = tuple(k for k, item in enumerate(key) if isinstance(item, int | np.integer))
            slices = [slice(i, i + 1 or None) if k in single else i for k, i in enumerate(key)]
            return np.squeeze(self.array[tuple(slices)], axis=single)

    return Adapter
