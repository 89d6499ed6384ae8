"""What touches the robot: force, deformation and contacts from capacitive skin, in SI units."""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from skinfield import calibrate as calibrate
    from skinfield import errors as errors
    from skinfield import simulate as simulate
    from skinfield.calibrate import load_calibration as load_calibration
    from skinfield.elastic import BaseStress as BaseStress
    from skinfield.elastic import BondedLayer as BondedLayer
    from skinfield.elastic import Capacitance as Capacitance
    from skinfield.elastic import CurvedLayer as CurvedLayer
    from skinfield.elastic import CylindricalBase as CylindricalBase
    from skinfield.elastic import Gap as Gap
    from skinfield.elastic import HalfSpace as HalfSpace
    from skinfield.elastic import Layer as Layer
    from skinfield.elastic import ObservationModel as ObservationModel
    from skinfield.elastic import SphericalBase as SphericalBase
    from skinfield.elastic import StandardLinearSolid as StandardLinearSolid
    from skinfield.estimate import Contact as Contact
    from skinfield.estimate import ContactFinder as ContactFinder
    from skinfield.estimate import Estimate as Estimate
    from skinfield.estimate import Tracker as Tracker
    from skinfield.files import load_contacts as load_contacts
    from skinfield.files import open_results as open_results
    from skinfield.files import read as read
    from skinfield.files import save_results as save_results
    from skinfield.files.layouts.load import load_layout as load_layout
    from skinfield.files.layouts.load import save_layout as save_layout
    from skinfield.loop import connect as connect
    from skinfield.reconstruct import Reconstructor as Reconstructor
    from skinfield.reconstruct.contact_images import ContactImages as ContactImages
    from skinfield.reconstruct.engine import Engine as Engine
    from skinfield.robot import load_robot as load_robot
    from skinfield.signal import find_faults as find_faults
    from skinfield.simulate import datasets as datasets
    from skinfield.skin import Grid as Grid
    from skinfield.skin import Patch as Patch
    from skinfield.skin import Skin as Skin
    from skinfield.skin import generators
    from skinfield.solve import Auto as Auto
    from skinfield.solve import ContactFit as ContactFit
    from skinfield.solve import GaussianField as GaussianField
    from skinfield.solve import Inverse as Inverse
    from skinfield.solve import NonNegative as NonNegative
    from skinfield.solve import PseudoInverse as PseudoInverse
    from skinfield.solve import Sheet as Sheet
    from skinfield.solve import Tikhonov as Tikhonov
    from skinfield.solve.detection import Detector as Detector

    layouts = generators
    __version__: str

_ON_DEMAND = {  # a module, or a module and what it holds
    "calibrate": "skinfield.calibrate",
    "datasets": "skinfield.simulate.datasets",
    "errors": "skinfield.errors",
    "layouts": "skinfield.skin.generators",
    "simulate": "skinfield.simulate",
    **{
        name: f"skinfield.{module}:{name}"
        for module, names in {
            "calibrate": "load_calibration",
            "elastic": "BaseStress BondedLayer Capacitance CurvedLayer CylindricalBase Gap "
            "HalfSpace Layer ObservationModel SphericalBase StandardLinearSolid",
            "estimate": "Contact ContactFinder Estimate Tracker",
            "files": "load_contacts open_results save_results",
            "files.layouts.load": "load_layout save_layout",
            "files.read": "read",
            "loop": "connect",
            "reconstruct": "Reconstructor",
            "reconstruct.contact_images": "ContactImages",
            "reconstruct.engine": "Engine",
            "robot": "load_robot",
            "signal": "find_faults",
            "skin": "Grid Patch Skin",
            "solve": "Auto ContactFit GaussianField Inverse NonNegative PseudoInverse "
            "Sheet Tikhonov",
            "solve.detection": "Detector",
        }.items()
        for name in names.split()
    },
}


__all__ = [  # what one begins with; the other names above are there as well
    "Auto", "BondedLayer", "Contact", "ContactFit", "ContactImages", "Detector", "Engine",
    "Estimate", "GaussianField", "Grid", "Layer", "NonNegative", "Patch", "Reconstructor", "Sheet",
    "Skin", "Tracker", "calibrate", "connect", "datasets", "find_faults", "layouts", "read",
    "save_layout", "save_results", "simulate",
]  # fmt: skip


def __getattr__(name: str) -> _typing.Any:
    """Load what is named when it is first named: to start costs nothing then."""
    if name == "__version__":
        version = globals()[name] = _version()
        return version
    if name not in _ON_DEMAND:
        raise AttributeError(f"module 'skinfield' has no attribute {name!r}")
    module, _, member = _ON_DEMAND[name].partition(":")
    found = _importlib.import_module(module)
    found = globals()[name] = getattr(found, member) if member else found
    return found


def _version() -> str:
    """Version as it is installed; of sources that are not, what their pyproject.toml says."""
    import re
    from importlib import metadata
    from pathlib import Path

    try:
        return metadata.version("skinfield")
    except metadata.PackageNotFoundError:
        project = Path(__file__).parents[2] / "pyproject.toml"
        text = project.read_text(encoding="utf-8") if project.is_file() else ""
        stated = re.search(r'^version = "(.+)"$', text, re.MULTILINE)
        return stated[1] if stated else "0+unknown"


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__")), "__version__"})
