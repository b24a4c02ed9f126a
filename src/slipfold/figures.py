"""How results and laws are drawn; matplotlib is imported with the first figure."""

from __future__ import annotations

from typing import Any

from slipfold.drawing import draw
from slipfold.errors import InputError
from slipfold.models.friction import FrictionLaw
from slipfold.results.diagram import Diagram
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.simulation import Simulation
from slipfold.results.threshold_map import ThresholdMap

__all__: list[str] = []


@draw.register
def _diagram(diagram: Diagram, output: str | None = None, **options: Any) -> Any:
    from slipfold.plots.response import draw_response

    if output is None:  # an angle that turns round has all values
        names = [state.name for state in diagram.model.states]
        turning = {
            name for branch in diagram.branches for name in branch.turns if branch.turns[name]
        }
        output = next((name for name in names if name not in turning), names[0])
    return draw_response(diagram, output, **options)


@draw.register
def _locus_diagram(diagram: LocusDiagram, **options: Any) -> Any:
    from slipfold.plots.loci import draw_loci

    return draw_loci(diagram, **options)


@draw.register
def _threshold_map(found: ThresholdMap, **options: Any) -> Any:
    from slipfold.plots.threshold_map import draw_threshold_map

    return draw_threshold_map(found, **options)


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
def _friction(law: FrictionLaw, **options: Any) -> Any:
    from slipfold.plots.friction import draw_friction

    return draw_friction(law, **options)
