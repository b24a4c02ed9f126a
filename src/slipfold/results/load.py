"""Saved results read back."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.results.labelled_table import read_netcdf
from slipfold.results.saved_table import open_table

if TYPE_CHECKING:
    from slipfold.orbits.periodic_orbit import PeriodicOrbit
    from slipfold.results.result import Result

KINDS = {
    "attractors": "motions.attractors.Attractors",
    "basin_fractions": "motions.basin_fractions.BasinFractions",
    "basins": "motions.basins.Basins",
    "design": "design_space.design.Design",
    "fit": "measured.fit.Fit",
    "locus": "locus_diagram.LocusDiagram",
    "lyapunov": "motions.lyapunov_exponents.LyapunovExponents",
    "measurement-plan": "measured.measurement_plan.MeasurementPlan",
    "orbit": "orbit.SavedOrbit",
    "regimes": "motions.regime_map.RegimeMap",
    "response": "diagram.Diagram",
    "responses": "responses.Responses",
    "simulation": "simulation.Simulation",
    "study": "studies.study_result.StudyResult",
    "sweep": "motions.sweep.Sweep",
    "threshold_map": "threshold_map.ThresholdMap",
    "uncertainty": "design_space.threshold_uncertainty.ThresholdUncertainty",
}
"""Class of each schema; it alone is imported."""


def load(path: str | Path, *, kind: type[Model] | None = None) -> Result | PeriodicOrbit:
    """Read a result that was saved.

    Parameters
    ----------
    path
        A file written by ``save``, by the command line's ``--out``, or saved from the explorer.
    kind
        The class of the model, if it is not a built-in one.

    Returns
    -------
    Result or PeriodicOrbit
        What was saved, number for number: a `slipfold.Diagram`, `slipfold.Simulation` or whatever
        else it was.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or was not written by slipfold.
    """
    table = read_netcdf(path)
    schema = str(table.attributes.get("schema", ""))
    known = {f"slipfold.{name}/1": where for name, where in KINDS.items()}
    if schema in known:
        module, _, name = known[schema].rpartition(".")
        reader = getattr(import_module(f"slipfold.results.{module}"), name)
        try:
            found: Result | PeriodicOrbit = reader._read(open_table(table, kind))
            return found
        except InputError as error:
            raise InputError(f"{path}: {error}") from error
        # The numbers are those of the schema, or somebody changed the file.
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            raise InputError(
                f"{path} is damaged: it says it is {schema} but lacks parts of it "
                f"({type(error).__name__}: {error}); compute it anew"
            ) from error
    if schema.startswith("slipfold."):
        raise InputError(
            f"{path} holds {schema}, which this version cannot read; it reads "
            f"{', '.join(known)}; upgrade slipfold"
        )
    raise InputError(f"{path} is not a result of slipfold; give a file that slipfold saved")
