"""A simulated motion as a result: saved, printed, drawn, with where it comes from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from slipfold.checks.checked import Checked
from slipfold.drawing import draw
from slipfold.flow.trajectory import Trajectory
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result

if TYPE_CHECKING:
    from slipfold.attractors.spectrum import Spectrum
    from slipfold.results.labelled_table import LabelledTable

__all__ = ["Simulation"]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Simulation(Trajectory, Result):
    """A motion over many forcing periods, with its input; frozen.

    Made by `slipfold.simulate` and `slipfold.load`.

    Parameters
    ----------
    model
        The model with its parameter values.
    strobe
        States at phase zero of every forcing period, from the initial state on, shape
        (periods + 1, n_states).
    settlement
        Whether and on what it settled.
    stopped
        Why and when it ended early; None if it ran to its end.
    asked
        Forcing periods that were asked for.
    tolerance
        Distance from a periodic response at which the motion counts as settled, in scaled states.
    provenance
        Versions and time.
    checked
        Parts of the motion that were held against the equations; None if none was.

    Notes
    -----
    In the dataset of `to_xarray`, along ``strobe``: ``time`` in seconds and ``states``; the outcome
    is in the attributes. In the spreadsheet of `to_csv`, time and states once every forcing period,
    at phase zero.

    Examples
    --------
    >>> import slipfold as sf
    >>> motion = sf.simulate(sf.SlidingOscillator(), periods=1000, f=12.2, Nd=0.15)
    >>> motion.settlement.period, round(motion.spectrum().line("x", 0.5), 6)
    (2, 0.276327)
    """

    asked: int
    tolerance: float
    provenance: Provenance
    checked: Checked | None = None

    def spectrum(self, periods: int = 64, per_period: int = 64) -> Spectrum:
        """Return the spectra of all outputs at the end of the run.

        Parameters
        ----------
        periods
            Forcing periods to transform; rounded up to whole response periods.
        per_period
            Samples per forcing period.

        Raises
        ------
        InputError
            If the run is shorter than one response, or a number is less than 1.
        """
        from slipfold.attractors.spectrum import find_spectrum

        return find_spectrum(self, periods, per_period)

    def summary(self) -> str:
        """Return whether it settled, its last state, and the amplitudes of what it settled on."""
        from slipfold.results.simulation_record import simulation_summary

        return simulation_summary(self)

    def to_json(self) -> dict[str, Any]:
        """Return the outcome as plain data for `json`, schema slipfold.simulation/1."""
        from slipfold.results.simulation_record import simulation_record

        return simulation_record(self)

    def plot(self, output: str | None = None, kind: str = "timeseries", **options: Any) -> Any:
        """Draw the motion.

        Parameters
        ----------
        output
            A state or output of the model; the first state if None.
        kind
            ``"timeseries"``, ``"spectrum"`` or ``"phase"``.
        **options
            Options of the drawing, e.g. ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        InputError
            For an unknown output or kind.
        """
        return draw(self, output=output, kind=kind, **options)

    def _table(self) -> LabelledTable:
        from slipfold.results.simulation_table import simulation_table

        return simulation_table(self)

    def _csv(self) -> str:
        from slipfold.results.spreadsheet import simulation_csv

        return simulation_csv(self)

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(self.summary())}</pre>"
