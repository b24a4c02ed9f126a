"""Tests compile integrators without optimizing them; what users run finds the same."""

import json
import os
import subprocess
import sys

import slipfold as sf

PROGRAM = """
import json
import slipfold as sf
found = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.1), f=12.5)
print(json.dumps([(point.type, point.value, point.uncertainty) for _, point in found.special]))
"""


def test_optimized_integrators_find_the_same():
    environment = {**os.environ, "SLIPFOLD_OPTIMIZATION": "3"}
    run = [sys.executable, "-c", PROGRAM]
    output = subprocess.run(run, env=environment, capture_output=True, check=True).stdout
    optimized = json.loads(output)
    here = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.1), f=12.5).special
    assert [kind for kind, _, _ in optimized] == [point.type for _, point in here] == ["PD", "NS"]
    for (_, value, uncertainty), (_, point) in zip(optimized, here, strict=True):
        assert abs(value - point.value) <= uncertainty + point.uncertainty
