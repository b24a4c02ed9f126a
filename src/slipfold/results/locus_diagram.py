"""A bifurcation set: loci in a plane of two parameters, with the regions between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from slipfold.branches.settings import Settings
from slipfold.checks.checked import Checked
from slipfold.drawing import draw
from slipfold.loci.locus import Locus, LocusPoint
from slipfold.loci.region_map import RegionMap
from slipfold.loci.window import Window
from slipfold.models.model import Model
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.text.one_line import listed

if TYPE_CHECKING:
    from slipfold.results.labelled_table import LabelledTable

__all__ = ["LabelledLocus", "LocusDiagram"]


class LabelledLocus(NamedTuple):
    """A special point with the locus that it lies on."""

    locus: Locus
    point: LocusPoint

    def __repr__(self) -> str:
        return f"<{self.point._line()}; on locus {self.locus.id}>"

    def _repr_html_(self) -> str:
        return self.point._repr_html_()


@dataclass(frozen=True, eq=False)
class LocusDiagram(Result):
    """Bifurcations of a model in a plane of two parameters; frozen.

    Made by `slipfold.locus`, `slipfold.bifurcation_set` and `slipfold.load`.

    Parameters
    ----------
    model
        The model; the values of `vary` are those of a corner of the window.
    vary
        Names of the two parameters.
    window
        Least and largest value of each.
    loci
        The loci, in the order in which they were followed.
    regions
        Which stable responses exist where; None if that was not asked for.
    settings
        Options of continuation.
    provenance
        Versions and time.
    interrupted
        Whether the computation was interrupted, so that some of the set is missing.
    checked
        Ends and special points of loci that were computed again by other means; None if nothing
        was.

    Notes
    -----
    In the dataset of `to_xarray`, along ``point``: the points of all loci, one after the other;
    ``locus_of_point`` says whose. Along ``special``: the special points; along ``normal_form``:
    their coefficients. Along ``parameter``: the two parameters. The regions are in
    ``region_of_cell`` over ``first`` and ``second``, and along ``region`` and ``check``. In the
    spreadsheet of `to_csv`, one row a point, special points among them in their order.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> found = sf.locus(diagram.special[0], ("f", "Nd"), ((12.4, 12.6), (0, 0.1)), switch=False)
    >>> found.loci[0].type, found.loci[0].stopped.kind
    ('PD', 'window')
    """

    model: Model
    vary: tuple[str, str]
    window: Window
    loci: tuple[Locus, ...]
    regions: RegionMap | None
    settings: Settings
    provenance: Provenance
    interrupted: bool = False
    checked: Checked | None = None

    @property
    def special(self) -> tuple[LabelledLocus, ...]:
        """All special points, each with its locus, locus after locus."""
        return tuple(LabelledLocus(locus, point) for locus in self.loci for point in locus.special)

    @property
    def failed(self) -> bool:
        """Whether a locus was given up, at either end, before it came to an end of its own."""
        return any(locus.begun.early or locus.stopped.early for locus in self.loci)

    def summary(self) -> str:
        """Return tables of ends, special points and regions, and why loci begin and end."""
        from slipfold.results.locus_summary import locus_summary

        return locus_summary(self)

    def to_json(self) -> dict[str, Any]:
        """Return loci, special points and regions as plain data, schema slipfold.locus/1.

        What is not finite is None.
        """
        from slipfold.results.locus_record import locus_record

        return locus_record(self)

    def plot(self, **options: Any) -> Any:
        """Draw the loci in their plane, and the regions between them.

        Parameters
        ----------
        **options
            Options of the drawing, e.g. ``regions=False`` and ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def _table(self) -> LabelledTable:
        from slipfold.results.locus_table import locus_table

        return locus_table(self)

    def _csv(self) -> str:
        from slipfold.results.spreadsheet import locus_csv

        return locus_csv(self)

    def __repr__(self) -> str:
        """One line: the plane, how many loci, and what was found on them."""
        spans = ", ".join(
            f"{name} = {low:g} to {high:g}"
            for name, (low, high) in zip(self.vary, self.window, strict=True)
        )
        found = listed((point.type for _, point in self.special), "no special points")
        return f"<LocusDiagram of {self.model.name}: {spans}, {len(self.loci)} loci, {found}>"

    def _repr_html_(self) -> str:
        from slipfold.results.locus_summary import locus_html

        return locus_html(self)
