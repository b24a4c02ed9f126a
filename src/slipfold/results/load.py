"""Saved results read back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from slipfold.errors import InputError
from slipfold.results.diagram_reader import read_diagram
from slipfold.results.labelled_table import read_netcdf
from slipfold.results.locus_reader import read_locus_diagram
from slipfold.results.orbit_reader import read_orbit
from slipfold.results.saved_table import SavedTable, open_table
from slipfold.results.simulation_reader import read_simulation
from slipfold.results.threshold_reader import read_threshold_map

if TYPE_CHECKING:
    from slipfold.models.model import Model
    from slipfold.orbits.periodic_orbit import PeriodicOrbit
    from slipfold.results.diagram import Diagram
    from slipfold.results.locus_diagram import LocusDiagram
    from slipfold.results.simulation import Simulation
    from slipfold.results.threshold_map import ThresholdMap

__all__ = ["load"]

_READERS: dict[
    str, Callable[[SavedTable], Diagram | Simulation | LocusDiagram | ThresholdMap | PeriodicOrbit]
] = {
    "slipfold.response/1": read_diagram,
    "slipfold.simulation/1": read_simulation,
    "slipfold.locus/1": read_locus_diagram,
    "slipfold.threshold_map/1": read_threshold_map,
    "slipfold.orbit/1": read_orbit,
}


def load(
    path: str | Path, *, kind: type[Model] | None = None
) -> Diagram | Simulation | LocusDiagram | ThresholdMap | PeriodicOrbit:
    """Read a result that was saved.

    Parameters
    ----------
    path
        A file written by ``save``, by the command line's ``--out``, or saved from the explorer.
    kind
        The class of the model, if it is not a built-in one.

    Returns
    -------
    Diagram, Simulation, LocusDiagram, ThresholdMap or PeriodicOrbit
        What was saved, number for number.

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
