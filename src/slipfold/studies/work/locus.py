"""Loci of bifurcations in a window of two parameters, with their points of codimension two."""

from __future__ import annotations

from collections.abc import Collection
from typing import Literal, Self

from slipfold.errors import InputError
from slipfold.loci.bifurcation_set import check_asked, find_bifurcation_set
from slipfold.loci.window import measured_across
from slipfold.models.model import Model
from slipfold.studies.work.work import Findings, Quantity, Span, Value, Work, parsed_span


class Locus(Work):
    """Loci of some types in a window: how far they reach, and their points of codimension two."""

    what: Literal["locus"]
    types: tuple[str, ...] = ("PD",)
    periods: tuple[int, ...] = (1,)
    window: dict[str, Span]

    def varied(self) -> Collection[str]:
        """Return the two parameters of the window."""
        return tuple(self.window)

    def checked(self, model: Model) -> Self:
        """Return it with the window in SI units."""
        if len(self.window) != 2:
            raise InputError(
                f"compute.window names {', '.join(self.window) or 'nothing'}; give the spans of "
                "two parameters, e.g. {f = [11.5, 13.5], Nd = [0, 0.98]}"
            )
        check_asked(model, self.types, self.periods)
        spans = {name: parsed_span(model, name, span) for name, span in self.window.items()}
        return self.model_copy(update={"window": spans})

    def quantities(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is found of every case."""
        ends = [
            Quantity(f"{which}_{name}", "real", f"{which} {name} of any locus",
                     model.parameter(name).unit)
            for name in self.window
            for which in ("least", "largest")
        ]  # fmt: skip
        return (Quantity("loci", "whole", "number of loci"), *ends)

    def lists(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is said of each point of codimension two."""
        return (
            Quantity("type", "text", "type of special point"),
            Quantity("locus", "whole", "number of its locus, from 1"),
            Quantity("locus_type", "text", "type of its locus"),
            Quantity("period", "whole", "in forcing periods"),
            *(
                Quantity(name, "real", f"{name} there", model.parameter(name).unit)
                for name in self.window
            ),
        )

    def of(self, model: Model) -> Findings:
        """Follow the loci."""
        first, second = self.window
        spans = tuple((float(low), float(high)) for low, high in self.window.values())
        plane, window = (first, second), (spans[0], spans[1])
        corner = model.replace(**{first: window[0][0], second: window[1][0]})
        found = find_bifurcation_set(
            measured_across(corner, plane, window),
            plane,
            window,
            types=self.types,
            periods=self.periods,
            regions=False,
        )
        if found.interrupted:
            raise KeyboardInterrupt
        values: dict[str, Value] = {"loci": len(found.loci)}
        for place, name in enumerate(plane):
            along = [item.values[:, place] for item in found.loci if len(item.values)]
            values[f"least_{name}"] = float(min(map(min, along))) if along else None
            values[f"largest_{name}"] = float(max(map(max, along))) if along else None
        listed: tuple[dict[str, Value], ...] = tuple(
            {
                "type": point.type,
                "locus": item.id,
                "locus_type": item.type,
                "period": item.period,
                **dict(zip(plane, map(float, point.values), strict=True)),
            }
            for item in found.loci
            for point in item.special
        )
        return Findings(values, listed)
