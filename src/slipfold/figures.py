"""How results and laws are drawn; matplotlib is imported with the first figure."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from slipfold.drawing import draw
from slipfold.errors import InputError
from slipfold.models.friction import FrictionLaw
from slipfold.results.design_space.design import Design
from slipfold.results.design_space.threshold_uncertainty import ThresholdUncertainty
from slipfold.results.diagram import Diagram
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.measured.fit import Fit
from slipfold.results.measured.measurement_plan import MeasurementPlan
from slipfold.results.motions.basin_fractions import BasinFractions
from slipfold.results.motions.basins import Basins
from slipfold.results.motions.regime_map import RegimeMap
from slipfold.results.motions.sweep import Sweep
from slipfold.results.simulation import Simulation
from slipfold.results.studies.study_result import StudyResult
from slipfold.results.threshold_map import ThresholdMap
from slipfold.tori.torus_spectrum import TorusSpectrum

__all__: list[str] = []


@draw.register
def _diagram(
    diagram: Diagram,
    output: str | None = None,
    measure: str | None = None,
    under: Sweep | None = None,
    kind: str = "response",
    **options: Any,
) -> Any:
    if output is None:  # an angle that turns round has all values
        names = [state.name for state in diagram.model.states]
        turning = {
            name for branch in diagram.branches for name in branch.turns if branch.turns[name]
        }
        output = next((name for name in names if name not in turning), names[0])
    if kind == "spectrum":
        from slipfold.plots.long_term.torus_spectrum import draw_spectrum_at

        given = {"measure": measure, "under": under, "measured": options.pop("measured", None)}
        idle = [name for name, value in given.items() if value is not None]
        if idle:
            raise InputError(f"the spectrum of a torus has no {idle[0]}; leave it out")
        return draw_spectrum_at(diagram.tori, output, **options)
    if kind != "response":
        raise InputError(f"kind = {kind!r} is unknown; give response, spectrum")
    if "at" in options:
        raise InputError("at goes with the spectrum of a torus; give kind = 'spectrum' as well")
    from slipfold.plots.response import draw_response

    measure = measure or "max"
    if under is not None:
        from slipfold.plots.motions.sweep import draw_points

        options["ax"] = draw_points(under, output, measure, options.get("ax"), legend=False)
    return draw_response(diagram, output, measure, **options)


@draw.register
def _torus_spectrum(spectrum: TorusSpectrum, output: str | None = None, **options: Any) -> Any:
    from slipfold.plots.long_term.torus_spectrum import draw_torus_spectrum

    return draw_torus_spectrum(spectrum, output or spectrum.names[0], **options)


@draw.register
def _locus_diagram(diagram: LocusDiagram, **options: Any) -> Any:
    from slipfold.plots.loci import draw_loci

    return draw_loci(diagram, **options)


@draw.register
def _threshold_map(found: ThresholdMap, **options: Any) -> Any:
    from slipfold.plots.threshold_map import draw_threshold_map

    return draw_threshold_map(found, **options)


@draw.register
def _study(found: StudyResult, **options: Any) -> Any:
    from slipfold.plots.studies.study import draw_study

    return draw_study(found, **options)


@draw.register
def _design(found: Design, **options: Any) -> Any:
    from slipfold.plots.design_space.trade_off import draw_design

    return draw_design(found, **options)


@draw.register
def _uncertainty(found: ThresholdUncertainty, **options: Any) -> Any:
    from slipfold.plots.design_space.threshold_uncertainty import draw_uncertainty

    return draw_uncertainty(found, **options)


@draw.register
def _basins(found: Basins, **options: Any) -> Any:
    from slipfold.plots.long_term.basins import draw_basins

    return draw_basins(found, **options)


@draw.register
def _basin_fractions(found: BasinFractions, **options: Any) -> Any:
    from slipfold.plots.long_term.basin_fractions import draw_basin_fractions

    return draw_basin_fractions(found, **options)


@draw.register
def _simulation(
    motion: Simulation, output: str | None = None, kind: str = "timeseries", **options: Any
) -> Any:
    from slipfold import plots

    of_contacts = {
        "hysteresis": plots.draw_hysteresis,
        "friction": plots.draw_friction_force,
        "path": plots.draw_path,
        "track": plots.draw_track,
        "timeline": plots.draw_timeline,
    }
    if kind in of_contacts:
        if output is not None:
            raise InputError(
                f"kind = {kind!r} shows contacts and no output; leave output = {output!r} out, and "
                "give contact= where there are several"
            )
        return of_contacts[kind](motion, **options)
    if "contact" in options:
        raise InputError(
            f"kind = {kind!r} shows an output and no contact; give {', '.join(of_contacts)}"
        )
    shown = motion.model.states[0].name if output is None else output
    if kind == "timeseries":
        from slipfold.plots.timeseries import draw_timeseries

        return draw_timeseries(motion, shown, **options)
    if kind == "phase":
        from slipfold.plots.phase import draw_phase

        return draw_phase(motion, shown, **options)
    if kind == "spectrum":
        from slipfold.plots.spectrum import draw_spectrum

        return draw_spectrum(motion.spectrum(), shown, **options)
    raise InputError(
        f"kind = {kind!r} is unknown; give timeseries, spectrum, phase, {', '.join(of_contacts)}"
    )


@draw.register
def _fit(found: Fit, **options: Any) -> Any:
    from slipfold.plots.measured import draw_fit

    return draw_fit(found, **options)


@draw.register
def _plan(plan: MeasurementPlan, **options: Any) -> Any:
    from slipfold.plots.measured import draw_plan

    return draw_plan(plan, **options)


@draw.register
def _sweep(sweep: Sweep, output: str | None = None, kind: str = "points", **options: Any) -> Any:
    from slipfold.plots.motions import sweep as plots

    ways: dict[str, Callable[..., Any]] = {
        "points": plots.draw_points,
        "section": plots.draw_section,
        "waterfall": plots.draw_waterfall,
    }
    if kind not in ways:
        raise InputError(f"kind = {kind!r} is unknown; give {', '.join(ways)}")
    return ways[kind](sweep, output or sweep.model.states[0].name, **options)


@draw.register
def _regimes(found: RegimeMap, **options: Any) -> Any:
    from slipfold.plots.motions.regimes import draw_regimes

    return draw_regimes(found, **options)


@draw.register
def _friction(law: FrictionLaw, **options: Any) -> Any:
    from slipfold.plots.friction import draw_friction

    return draw_friction(law, **options)
