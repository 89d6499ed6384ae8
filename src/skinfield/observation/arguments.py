"""What a skin is said to be, checked before anything is computed of it."""

from skinfield.errors import check_offers, check_type
from skinfield.layout import Patch
from skinfield.mechanics import Layer

LAYER = "such as Layer(thickness=2e-3, young_modulus=150e3), in m and Pa"
PATCH = "such as layouts.hexagon72(), or one of load_layout(file), which is a skin of patches"


def check_skin(patch: object, layer: object, mechanics: object, quantity: object) -> None:
    """Raise InputError, with what to hand in, for what is no patch, layer, elastomer or quantity.

    A number, a name or a class in place of an object would fail much later, and elsewhere.
    """
    check_type("patch", patch, Patch, PATCH)
    check_type("layer", layer, Layer, LAYER)
    needs = ("base_stress", "surface_displacement", "indentation")
    check_offers("mechanics", mechanics, needs, "a model such as BondedLayer() or HalfSpace()")
    needs = ("matrix", "linearise", "typical_noise")
    check_offers("quantity", quantity, needs, "one of Capacitance(), BaseStress() and Gap()")
