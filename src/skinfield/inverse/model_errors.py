"""How wrong the built-in field solvers are without any noise, measured on simulated presses.

A contact is no Gaussian field, and between taxels a thin skin is nearly blind: there a field solver
finds a part of the force, at the nearest taxel. The numbers are such that, on the hexagon of 72
taxels with 2 mm of incompressible silicone (100 kPa), at the quantity's typical noise, 1.645
standard deviations each way hold nine of ten forces, and the 90 % ellipse as many places, of 600
presses of `pipeline.rehearsal` (balls, flats, a cone, a bar; 0.1 to 3 N).

At other noises one number cannot do. With 2.5 times the typical noise 88 to 98 % of the forces are
held. With a twentieth of it 70 to 82 %, but for capacitance 98 % (`NonNegative`) and 87 %
(`Inverse`): weak presses between taxels are then found, of which a linear solver sees a tenth. Of
the places 93 % are then held by the resampled solvers, 66 to 80 % by `GaussianField` and
`NonNegative`, and 29 to 36 % by `Tikhonov`, whose prior is only wide where it is told much noise.
On other layouts and layers nothing was measured: `Reconstructor.calibrated` learns what holds
there.

They do not shrink with the size of a contact. For stress they might: of flat ends over 4 to 64
taxel cells of a 16 x 16 skin (4 mm apart) `GaussianField` finds 88 to 98 % of the force. For
capacitance they must not: 81 to 92 % over 4 cells, 61 to 68 % over 13, 46 to 50 % over 28, and 28 %
over 64, as an incompressible layer hardly gives below the middle of a wide contact.
"""

from dataclasses import dataclass

from skinfield.fields import ModelError
from skinfield.observation import BaseStress, ObservationModel


@dataclass(frozen=True)
class Measured:
    """One standard deviation: of the force and the area as parts of them, of the place in pitches.

    Attributes
    ----------
    force, place, area : float
    """

    force: float
    place: float
    area: float


@dataclass(frozen=True)
class Errors:
    """Of one solver, by what taxels read; for the gap those of the capacitance."""

    stress: Measured
    capacitance: Measured

    def of(self, model: ObservationModel) -> ModelError:
        """For a model; none is known of a matrix that was built by hand."""
        if model.physics is None:
            return ModelError()
        read = isinstance(model.physics.quantity, BaseStress)
        part = self.stress if read else self.capacitance
        place = part.place * model.grid.patch.pitch
        return ModelError(force=part.force, place=place, area=part.area)


GAUSSIAN_FIELD = Errors(Measured(1.2, 0.20, 0.30), Measured(1.4, 0.22, 0.22))
NON_NEGATIVE = Errors(Measured(1.4, 0.13, 0.18), Measured(0.54, 0.14, 0.23))
TIKHONOV = Errors(Measured(1.9, 0.13, 0.0), Measured(1.8, 0.14, 0.0))
PSEUDO_INVERSE = Errors(Measured(2.2, 0.29, 0.46), Measured(2.6, 0.29, 0.64))
RESAMPLED_PSEUDO_INVERSE = Errors(Measured(0.92, 0.29, 0.53), Measured(0.60, 0.37, 0.58))
INVERSE = Errors(Measured(0.82, 0.29, 0.55), Measured(0.60, 0.44, 0.59))
