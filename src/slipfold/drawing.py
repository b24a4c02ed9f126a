"""Which function of `slipfold.plots` draws what; they and matplotlib are imported when one does."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from inspect import signature
from typing import Any

from slipfold.errors import InputError

FIGURES: Mapping[str, Mapping[str, str]] = {
    "BasinFractions": {"fractions": "curves.draw_basin_fractions"},
    "Basins": {"basins": "maps.draw_basins"},
    "Design": {"designs": "curves.draw_design"},
    "Diagram": {
        "response": "response.draw_response",
        "spectrum": "trajectories.draw_spectrum_at",
        "eigenvalues": "eigenvalues.draw_eigenvalues",
        "backbone": "eigenvalues.draw_backbone",
    },
    "Fit": {"fit": "response.draw_fit"},
    "FrictionLaw": {"coefficient": "contacts.draw_friction"},
    "LocusDiagram": {"loci": "loci.draw_loci"},
    "MeasurementPlan": {"plan": "response.draw_plan"},
    "MeshShapes": {"shape": "shapes.draw_shape"},
    "RegimeMap": {"regimes": "maps.draw_regimes"},
    "Simulation": {
        "timeseries": "trajectories.draw_timeseries",
        "spectrum": "trajectories.draw_spectrum",
        "phase": "trajectories.draw_phase",
        "hysteresis": "contacts.draw_hysteresis",
        "friction": "contacts.draw_friction_force",
        "path": "contacts.draw_path",
        "track": "contacts.draw_track",
        "timeline": "contacts.draw_timeline",
    },
    "StudyResult": {"study": "maps.draw_study"},
    "Sweep": {
        "points": "trajectories.draw_points",
        "section": "trajectories.draw_section",
        "waterfall": "trajectories.draw_waterfall",
    },
    "ThresholdMap": {"thresholds": "maps.draw_threshold_map"},
    "ThresholdUncertainty": {"probability": "curves.draw_uncertainty"},
    "TorusSpectrum": {"spectrum": "trajectories.draw_torus_spectrum"},
}
"""Functions by class and kind of figure; the first kind is the default."""

SHOWN = ("output", "quantity")
"""Names of the parameter that says which quantity is shown."""


class Drawn:
    """Base of what has figures."""

    def plot(self, output: str | None = None, kind: str | None = None, **options: Any) -> Any:
        """Draw it.

        Parameters
        ----------
        output
            The state or output to draw, of a study the quantity; the first one if None.
        kind
            Kind of figure, where the notes of the class name several; the first one if None.
        **options
            Options of the drawing that the notes of the class name, and ``ax=`` the axes to draw
            in.

        Returns
        -------
        matplotlib.axes.Axes or ndarray of them
            The axes.
        """
        return draw(self, output, kind, **options)


def draw(thing: object, output: str | None = None, kind: str | None = None, **options: Any) -> Any:
    """Draw something and return its axes."""
    names = [each.__name__ for each in type(thing).__mro__ if each.__name__ in FIGURES]
    if not names:
        raise InputError(
            f"{type(thing).__name__} has no figure; those with one are {', '.join(FIGURES)}"
        )
    ways = FIGURES[names[0]]
    kind = getattr(thing, "default_kind", next(iter(ways))) if kind is None else kind
    if kind not in ways:
        raise InputError(f"kind = {kind!r} is unknown; give {', '.join(ways)}")
    known = _options(ways[kind])
    for name in SHOWN if output is not None else ():
        if name in known:
            options[name] = output
            break
    else:
        if output is not None:
            options["output"] = output
    for name in options:
        if name not in known:
            others = [f"kind = {other!r}" for other in ways if name in _options(ways[other])]
            instead = f"it goes with {' and '.join(others)}" if others else "leave it out"
            raise InputError(
                f"kind = {kind!r} has no {name}; {instead}, or give {', '.join(known)}"
            )
    return _function(ways[kind])(thing, **options)


def _function(name: str) -> Any:
    module, _, function = name.rpartition(".")
    return getattr(import_module(f"slipfold.plots.{module}"), function)


def _options(name: str) -> list[str]:
    return list(signature(_function(name)).parameters)[1:]
