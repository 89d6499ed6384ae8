"""scikit-fem, loaded when a finite element is first needed."""

from typing import Any

from skinfield.errors import InputError


def scikit_fem() -> Any:
    """Return the package `skfem`.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        import skfem
    except ImportError as error:
        raise InputError(
            "finite elements need scikit-fem, which is not installed: pip install 'skinfield[fem]'"
        ) from error
    return skfem
