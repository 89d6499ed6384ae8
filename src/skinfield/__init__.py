"""What touches the robot: force, deformation and contacts from capacitive skin, in SI units."""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from skinfield import simulate as simulate
    from skinfield.contacts import ContactFinder as ContactFinder
    from skinfield.contacts import Tracker as Tracker
    from skinfield.detection import Detector as Detector
    from skinfield.engine import Engine as Engine
    from skinfield.fields import Contact as Contact
    from skinfield.fields import Estimate as Estimate
    from skinfield.inverse import ContactFit as ContactFit
    from skinfield.inverse import GaussianField as GaussianField
    from skinfield.inverse import Inverse as Inverse
    from skinfield.inverse import NonNegative as NonNegative
    from skinfield.inverse import PseudoInverse as PseudoInverse
    from skinfield.inverse import Sheet as Sheet
    from skinfield.inverse import Tikhonov as Tikhonov
    from skinfield.layout import Grid as Grid
    from skinfield.layout import Patch as Patch
    from skinfield.layout import Skin as Skin
    from skinfield.layout import generators
    from skinfield.layout import load_layout as load_layout
    from skinfield.layout import save_layout as save_layout
    from skinfield.live import connect as connect
    from skinfield.mechanics import BondedLayer as BondedLayer
    from skinfield.mechanics import HalfSpace as HalfSpace
    from skinfield.mechanics import Layer as Layer
    from skinfield.observation import BaseStress as BaseStress
    from skinfield.observation import Capacitance as Capacitance
    from skinfield.observation import Gap as Gap
    from skinfield.pipeline import Ladder as Ladder
    from skinfield.pipeline import Reconstructor as Reconstructor
    from skinfield.sinks import save_results as save_results
    from skinfield.sources import load_contacts as load_contacts
    from skinfield.sources import open_results as open_results

    layouts = generators

_ON_DEMAND = {  # a module, or a module and what it holds
    "BaseStress": "skinfield.observation:BaseStress",
    "BondedLayer": "skinfield.mechanics:BondedLayer",
    "Capacitance": "skinfield.observation:Capacitance",
    "connect": "skinfield.live:connect",
    "Contact": "skinfield.fields:Contact",
    "ContactFinder": "skinfield.contacts:ContactFinder",
    "ContactFit": "skinfield.inverse:ContactFit",
    "Detector": "skinfield.detection:Detector",
    "Engine": "skinfield.engine:Engine",
    "Estimate": "skinfield.fields:Estimate",
    "Gap": "skinfield.observation:Gap",
    "GaussianField": "skinfield.inverse:GaussianField",
    "Grid": "skinfield.layout:Grid",
    "HalfSpace": "skinfield.mechanics:HalfSpace",
    "Inverse": "skinfield.inverse:Inverse",
    "Ladder": "skinfield.pipeline:Ladder",
    "Layer": "skinfield.mechanics:Layer",
    "layouts": "skinfield.layout.generators",
    "load_layout": "skinfield.layout:load_layout",
    "NonNegative": "skinfield.inverse:NonNegative",
    "load_contacts": "skinfield.sources:load_contacts",
    "open_results": "skinfield.sources:open_results",
    "Patch": "skinfield.layout:Patch",
    "PseudoInverse": "skinfield.inverse:PseudoInverse",
    "Reconstructor": "skinfield.pipeline:Reconstructor",
    "save_layout": "skinfield.layout:save_layout",
    "save_results": "skinfield.sinks:save_results",
    "Sheet": "skinfield.inverse:Sheet",
    "simulate": "skinfield.simulate",
    "Skin": "skinfield.layout:Skin",
    "Tikhonov": "skinfield.inverse:Tikhonov",
    "Tracker": "skinfield.contacts:Tracker",
}


def __getattr__(name: str) -> _typing.Any:
    """Load what is named when it is first named: to start costs nothing then."""
    if name not in _ON_DEMAND:
        raise AttributeError(f"module 'skinfield' has no attribute {name!r}")
    module, _, member = _ON_DEMAND[name].partition(":")
    found = _importlib.import_module(module)
    found = globals()[name] = getattr(found, member) if member else found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_ON_DEMAND})
