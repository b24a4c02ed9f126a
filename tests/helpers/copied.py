"""What is copied from the explorer's page or saved: it is run as a reader does, and compared."""

import shlex
from pathlib import Path

import numpy as np

import slipfold as sf
from helpers.command_line import run
from slipfold.interface.explorer.messages import OrbitThrough
from slipfold.interface.explorer.trajectories import ShownOrbit, orbit_view


def run_python(text):
    """Run a copied script; return its names."""
    names = {}
    exec(compile(text, "copied.py", "exec"), names)
    return names


def run_command(text, *, ends=(0,)):
    """Run the command that a copied case file names; load what it saves."""
    Path("case.toml").write_text(text)
    program, *arguments = shlex.split(text.splitlines()[0].removeprefix("# "))
    assert program == "slipfold"
    assert run(*arguments, "--out", "run.nc").exit_code in ends
    return sf.load("run.nc")


def same_result(copied, saved):
    """Compare all numbers of two results."""
    assert copied.model == saved.model
    if getattr(saved, "interrupted", False):
        # The page ends what takes long where it is; the script goes on.
        assert set() < points_of(saved) <= points_of(copied)
        return
    mine, theirs = copied.to_xarray(), saved.to_xarray()
    assert set(mine.data_vars) == set(theirs.data_vars)
    for name, values in theirs.data_vars.items():
        np.testing.assert_array_equal(mine[name].values, values.values)


def points_of(result):
    """All points of all curves whose states are known: parameters with the first states."""
    curves = result.branches if hasattr(result, "branches") else result.loci
    rows = [row for each in curves for row in np.column_stack([each._values, each.states])]
    return {row.tobytes() for row in rows if np.isfinite(row).all()}


def same_orbit(names, shown):
    """Compare the orbit or equilibrium that a copied script found with the one that is shown."""
    if shown["eigenvalues"] is None:
        has_orbit(names["orbit"], shown)
        return
    values = [complex(*value) for value in shown["eigenvalues"]]
    np.testing.assert_array_equal(*map(np.sort_complex, (names["values"], values)))


def has_orbit(orbit, shown):
    """Compare all numbers of an orbit with those that are shown."""
    place = OrbitThrough.model_validate(shown["through"])
    rounds = 1 if orbit.model.forced else shown["period"]
    view = orbit_view(ShownOrbit(orbit, place, rounds=rounds), orbit.model.parameters[0].name)
    for name in ("period", "t", "states", "outputs", "spectrum", "multipliers"):
        assert view[name] == shown[name]
