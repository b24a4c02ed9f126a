"""A response diagram: all branches of one computation, with what was asked for and by whom."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from slipfold.branches.branch import Branch
from slipfold.branches.event import Event
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.checks.checked import Checked
from slipfold.drawing import draw
from slipfold.models.model import Model
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.text.one_line import listed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipfold.results.labelled_table import LabelledTable

__all__ = ["Diagram", "Labelled"]


class Labelled(NamedTuple):
    """A special point with the branch that it lies on."""

    branch: Branch
    point: SpecialPoint

    def __repr__(self) -> str:
        return f"<{self.point._line()}; on branch {self.branch.id}>"

    def _repr_html_(self) -> str:
        return self.point._repr_html_()


@dataclass(frozen=True, eq=False)
class Diagram(Result):
    """The periodic responses of a model over one parameter; frozen.

    Made by `slipfold.response` and `slipfold.load`.

    Parameters
    ----------
    model
        The model, with the value of `vary` at the start of the span.
    vary
        Name of the parameter followed.
    span
        First and last value asked for.
    branches
        The branches; the first is the response of period 1.
    settings
        Options of continuation.
    events
        Values asked to be located.
    provenance
        Versions and time.
    checked
        Special points and ends that were computed again by other means; None if nothing was.

    Notes
    -----
    In the dataset of `to_xarray`, along ``point``: the points of all branches, one after the other;
    ``branch_of_point`` says whose. Along ``special``: the special points. In the spreadsheet of
    `to_csv`, one row a point, special points among them in their order.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
    >>> [(branch.period, point.type) for branch, point in diagram.special]
    [(1, 'PD'), (2, 'NS'), (2, 'NS')]
    """

    model: Model
    vary: str
    span: tuple[float, float]
    branches: tuple[Branch, ...]
    settings: Settings
    events: tuple[Event, ...]
    provenance: Provenance
    checked: Checked | None = None

    @property
    def special(self) -> tuple[Labelled, ...]:
        """All special points, each with its branch, branch after branch."""
        return tuple(
            Labelled(branch, point) for branch in self.branches for point in branch.special
        )

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted and later branches are missing."""
        return any(branch.interrupted for branch in self.branches)

    @property
    def failed(self) -> bool:
        """Whether a branch was given up before it came to an end of its own."""
        return any(branch.failed for branch in self.branches)

    def summary(self, outputs: Sequence[str] | None = None) -> str:
        """Return a table of ends and special points, as AUTO prints it, and why branches stop.

        Parameters
        ----------
        outputs
            States or outputs of which to show maximum and minimum over the continuous orbit; the
            first two states if None.

        Raises
        ------
        InputError
            For an unknown output.
        """
        from slipfold.results.summary import summary_text

        return summary_text(self, outputs)

    def to_json(self) -> dict[str, Any]:
        """Return special points and ends as plain data for `json`, schema slipfold.response/1.

        Limits of the model are not among the special points; a branch that meets one says so where
        it stopped. What is not finite is None.
        """
        from slipfold.results.record import diagram_record

        return diagram_record(self)

    def plot(self, output: str | None = None, **options: Any) -> Any:
        """Draw the diagram.

        Parameters
        ----------
        output
            A state or output of the model; the first state if None.
        **options
            Options of the drawing, e.g. ``measure="peak_to_peak"`` and ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        InputError
            For an unknown output.
        """
        return draw(self, output=output, **options)

    def _table(self) -> LabelledTable:
        from slipfold.results.diagram_table import diagram_table

        return diagram_table(self)

    def _csv(self) -> str:
        from slipfold.results.spreadsheet import diagram_csv

        return diagram_csv(self)

    def __repr__(self) -> str:
        """One line: what was followed, how far, and what was found."""
        found = listed((point.type for _, point in self.special), "no special points")
        return (
            f"<Diagram of {self.model.name}: {self.vary} = {self.span[0]:g} to {self.span[1]:g}, "
            f"{len(self.branches)} branches, {found}>"
        )

    def _repr_html_(self) -> str:
        from slipfold.results.summary import summary_html

        return summary_html(self)
