"""Contacts as few round or drawn-out loads: the most accurate answer on a thin skin."""

from dataclasses import dataclass

from skinfield.elastic import ObservationModel
from skinfield.solve.atoms.settings import FitSettings
from skinfield.solve.operator import ContactOperator


@dataclass(frozen=True, kw_only=True)
class ContactFit(FitSettings):
    r"""Fit of the fewest contacts that explain the readings.

    Between taxels a thin skin is nearly blind, so a field must guess there. A contact has few
    unknowns: place, force and radius, and for a line its length and direction. Each is an atom:
    the pressure of a ball or of a flat end on the layer, exact, whose readings are tabulated with
    the nonlinear field in the gap for capacitance. Atoms are added where the residual is most
    significant, all are refined together (Levenberg 1944), and shapes are chosen by their marginal
    likelihood (Laplace's approximation; MacKay 2003, Information Theory, chapter 28).

    Parameters
    ----------
    most_contacts : int
        Atoms that are sought at most.
    false_alarm_rate : float
        Readings of an idle patch in which a contact may be seen, at most.
    typical_radius : float, m
        Of curvature of what touches: the middle of a broad prior, within a factor of two.
    model_error : float
        What the model is wrong by, part of what taxels read: middle of a prior within a factor of
        ten, from which it is inferred, reading by reading and press by press.
    starts : int
        Places from which each new contact is sought.
    warm : bool
        Start from the reading before. Its answer is kept only as long as it explains the readings.
    common_mode : float
        Standard deviation of an offset that all taxels share, such as a drift, in those of the
        noise; it is integrated out. 0 for none.
    extended : NonNegative or None
        Answers the readings that no few contacts explain, such as a whole palm's; the estimate's
        `notes` say so. None leaves them to the best set of contacts.
    """

    def prepare(self, model: ObservationModel) -> ContactOperator:
        """Tabulate what single contacts are read as, and templates of them all over the patch."""
        from skinfield.solve.atoms.fitter import ContactFitter

        fitter = ContactFitter(self, model)
        fitter.run_in()
        return fitter
