"""All that a study can compute, by name."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, TypeAdapter

from slipfold.studies.work.attractors import Attractors
from slipfold.studies.work.locus import Locus
from slipfold.studies.work.lyapunov import Lyapunov
from slipfold.studies.work.response import Response
from slipfold.studies.work.simulation import Simulation
from slipfold.studies.work.threshold import Threshold

Known = Response | Threshold | Locus | Simulation | Lyapunov | Attractors

WORK: TypeAdapter[Known] = TypeAdapter(Annotated[Known, Field(discriminator="what")])
"""Reads what is to be computed; the entry ``what`` says which."""
