"""Special points do not depend on the processor: linear algebra kernels, tolerance, lanes, code.

The last digits of all numbers do. What is compared is what is stated, within the uncertainties
stated beside it: the honest test of those.
"""

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.portable

SCRIPT = Path(__file__).with_name("located_points.py")

KERNELS = ["Nehalem", "Sandybridge", "Haswell", "SkylakeX"]

ENVIRONMENTS = {
    "here": {},
    **{kernel: {"OPENBLAS_CORETYPE": kernel} for kernel in KERNELS},
    "tight": {"SLIPFOLD_TOLERANCE": "3e-14"},
    # The order of the Taylor series follows the tolerance in steps: 3e-13 has that of 1e-13.
    "loose": {"SLIPFOLD_TOLERANCE": "3e-13"},
    "looser": {"SLIPFOLD_TOLERANCE": "1e-12"},
    "four lanes": {"SLIPFOLD_LANES": "4"},
    "not optimized": {"SLIPFOLD_OPTIMIZATION": "0"},
}


def runs_here(environment):
    """Whether the processor has what the kernel needs."""
    if ENVIRONMENTS[environment].get("OPENBLAS_CORETYPE") != "SkylakeX":
        return True
    information = Path("/proc/cpuinfo")
    return information.exists() and "avx512f" in information.read_text()


@cache
def located(environment):
    """Special points by case and branch, computed by a process of its own."""
    run = subprocess.run(
        [sys.executable, "-W", "error", str(SCRIPT)],
        env={**os.environ, "SLIPFOLD_OPTIMIZATION": "2", **ENVIRONMENTS[environment]},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def numbers(pairs):
    return np.array([complex(*pair) for pair in pairs])


def differences(one, other):
    """How far two descriptions of a special point are apart, in units of what they allow."""
    allowed = one["uncertainty"] + other["uncertainty"]
    value = abs(one["value"] - other["value"]) / allowed
    # A multiplier of one may stand before or after a critical one: nearest ones are compared.
    distance = np.abs(numbers(one["multipliers"])[:, None] - numbers(other["multipliers"]))
    uncertain = np.add.outer(one["multiplier_uncertainty"], other["multiplier_uncertainty"])
    rounded = np.spacing(np.abs(numbers(one["multipliers"])))[:, None]
    return value, (distance / (uncertain + rounded)).min(axis=1).max()


@pytest.mark.parametrize("environment", [name for name in ENVIRONMENTS if name != "here"])
def test_special_points_agree_within_their_uncertainties(environment):
    if not runs_here(environment):
        pytest.skip("this processor has no AVX-512")
    here, there = located("here"), located(environment)
    assert here.keys() == there.keys()
    worst = {}
    for case, branches in here.items():
        kinds = [[item["type"] for item in branch] for branch in branches]
        assert [[item["type"] for item in branch] for branch in there[case]] == kinds, case
        for branch, others in zip(branches, there[case], strict=True):
            for item, other in zip(branch, others, strict=True):
                assert item["criticality"] == other["criticality"], (case, item)
                worst[case, item["type"], item["value"]] = differences(item, other)
    beyond = {place: pair for place, pair in worst.items() if max(pair) > 1}
    assert not beyond


def test_uncertainties_are_small():
    # Else agreement within them would say nothing.
    for case, branches in located("here").items():
        for item in (item for branch in branches for item in branch):
            size = max(1.0, abs(item["value"]))
            assert item["uncertainty"] < 1e-12 * size, (case, item["type"], item["value"])
