"""Saved results read back."""

from __future__ import annotations

from pathlib import Path

from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.results import orbit
from slipfold.results.design_space.design import Design
from slipfold.results.design_space.threshold_uncertainty import ThresholdUncertainty
from slipfold.results.diagram import Diagram
from slipfold.results.labelled_table import read_netcdf
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.measured.fit import Fit
from slipfold.results.measured.measurement_plan import MeasurementPlan
from slipfold.results.motions.attractors import Attractors
from slipfold.results.motions.basin_fractions import BasinFractions
from slipfold.results.motions.basins import Basins
from slipfold.results.motions.lyapunov_exponents import LyapunovExponents
from slipfold.results.motions.regime_map import RegimeMap
from slipfold.results.motions.sweep import Sweep
from slipfold.results.saved_table import open_table
from slipfold.results.simulation import Simulation
from slipfold.results.studies.study_result import StudyResult
from slipfold.results.threshold_map import ThresholdMap

__all__ = ["load"]

_KINDS = (
    Diagram,
    Simulation,
    LocusDiagram,
    ThresholdMap,
    LyapunovExponents,
    Attractors,
    ThresholdUncertainty,
    Basins,
    BasinFractions,
    Design,
    Sweep,
    RegimeMap,
    Fit,
    MeasurementPlan,
    StudyResult,
)

_READERS = {**{kind.schema: kind._read for kind in _KINDS}, orbit.SCHEMA: orbit.read_orbit}

Saved = (
    Diagram
    | Simulation
    | LocusDiagram
    | ThresholdMap
    | LyapunovExponents
    | Attractors
    | Basins
    | BasinFractions
    | Fit
    | MeasurementPlan
    | Sweep
    | StudyResult
    | ThresholdUncertainty
    | RegimeMap
    | Design
    | PeriodicOrbit
)
"""What files hold."""


def load(path: str | Path, *, kind: type[Model] | None = None) -> Saved:
    """Read a result that was saved.

    Parameters
    ----------
    path
        A file written by ``save``, by the command line's ``--out``, or saved from the explorer.
    kind
        The class of the model, if it is not a built-in one.

    Returns
    -------
    Saved
        What was saved, number for number: a `slipfold.Diagram`, `slipfold.Simulation` or whatever
        else it was.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or was not written by slipfold.
    """
    table = read_netcdf(path)
    schema = str(table.attributes.get("schema", ""))
    if schema in _READERS:
        try:
            return _READERS[schema](open_table(table, kind))
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
            f"{', '.join(_READERS)}; upgrade slipfold"
        )
    raise InputError(f"{path} is not a result of slipfold; give a file that slipfold saved")
