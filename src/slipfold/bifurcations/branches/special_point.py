"""Special points of a branch: bifurcations and user events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.solution_curve import LocatedPoint
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION
from slipfold.orbits.bifurcation_types import (
    BIFURCATION_TYPES,
    COLLISIONS,
    EXTREMUM_TYPES,
    PAIRED,
)
from slipfold.orbits.test_functions import ALIKE, angles_on_circle


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class SpecialPoint(LocatedPoint):
    """A located point of a branch; frozen."""

    type: Annotated[
        str,
        '``"LP"``, ``"PD"``, ``"NS"``, ``"BP"``, ``"HB"``, or ``"EVENT"`` for a user\'s '
        'event, ``"MAX"`` or ``"MIN"`` where the output of an event without a value has an '
        "extremum along the branch. Where the model itself ends, the branch does: see "
        "`Branch.stopped`. Where contacts "
        'begin or cease to do something ``"GRAZE"``, ``"STICK"``, ``"LIFT"`` or ``"MEET"``, '
        "see `name`.",
    ]
    name: Annotated[
        str, 'The type in words, e.g. ``"period doubling"``, or what a user\'s event measures.'
    ]
    vary: Annotated[str, "Name of the parameter followed."]
    value: Annotated[float, "Value of that parameter."]
    uncertainty: Annotated[
        float,
        "Computed uncertainty of `value`: how much it moves when the orbit and its derivatives are "
        "integrated again with other steps (same unit). Infinite where nothing is known, NaN where "
        "the computation was interrupted before.",
    ]
    multiplier_uncertainty: Annotated[
        Array, "Computed uncertainty of each multiplier, shape (n_states,)."
    ]
    coefficient: Annotated[
        float | None,
        "Normal form coefficient: of the map for PD (cubic), NS (real part of the first Lyapunov "
        "coefficient), LP (quadratic) and BP (cubic of a pitchfork, else quadratic), of an "
        "equilibrium that of the flow; first Lyapunov coefficient of HB; None elsewhere. See "
        "`slipfold.orbits.normal_forms.normal_form`.",
    ] = None
    leads_to: Annotated[int | None, "Id of the branch that was started here, or None."] = None
    images: Annotated[
        int, "Branches that begin here and are not followed: symmetric images of those that are."
    ] = 0
    rare: Annotated[
        int,
        "Branches found from few of the directions tried: others may be missing then.",
    ] = 0
    angle: Annotated[
        float,
        "Angle in rad of the critical multiplier where others stay on the unit circle along the "
        "branch, as of a mode that nothing damps; NaN elsewhere.",
    ] = np.nan
    gradients: Annotated[
        Mapping[str, float] | None,
        "Derivatives of `value` with respect to the other parameters of the model, by name, in SI "
        "units: NaN where there is none. None of what has no locus, and unless they were "
        "requested, see `slipfold.gradients`.",
    ] = None

    def _numbers(self) -> Mapping[str, float | None]:
        return {"uncertainty": self.uncertainty, "coefficient": self.coefficient}

    @property
    def _values(self) -> tuple[float]:
        return (self.value,)

    @property
    def outcome(self) -> str:
        """What is watched, whether it is soft or hard, and where it leads, as far as known."""
        plain = self.type in BIFURCATION_TYPES and self.type != "BP"
        named = "" if plain and not self.collides else self.name
        started = f"to branch {self.leads_to}" if self.leads_to is not None else ""
        judged = self.criticality or self.undecided
        return ", ".join(part for part in (named, judged, started) if part)

    @property
    def undecided(self) -> str | None:
        """Why it is not known whether it is soft or hard; None where it is, or has no meaning."""
        meaningless = self.type == "LP" or self.type not in BIFURCATION_TYPES
        meaningless |= self.name.startswith("transcritical") or self.collides
        if self.interrupted and self.type in BIFURCATION_TYPES:
            return "interrupted before its normal form was computed"
        if self.criticality is not None or meaningless:
            return None
        if self.several:
            angles = np.sort(angles_on_circle(self.multipliers))
            left = ""
            if self.images:
                left = f"; not followed: {self.images} branches that are images of others"
            elif self.type == "BP" and self.leads_to is None:
                left = "; no other branch was found, as where a continuous symmetry turns one"
            elif self.type == "HB" and np.diff(angles).min(initial=1.0) < ALIKE:
                left = (
                    "; of pairs that have one frequency, cycles are followed that were found from "
                    "directions all around, and no images"
                )
            if self.rare:
                left += f"; others may be missing: few directions led to {self.rare} of those found"
            return (
                "criticality unknown: several multipliers are critical at once, as by a symmetry"
                f"{left}"
            )
        if self.type == "BP" and self.name == BIFURCATION_TYPES["BP"].title:
            return "no other branch was found to cross here"
        if self.coefficient is None or not np.isfinite(self.coefficient):
            contacts = "" if np.isnan(self.stuck_fraction) else "contacts stick or change nearby, "
            return (
                f"criticality unknown: {contacts}"
                "derivatives of the map overflow, or its digits are lost to growth round the orbit"
            )
        return "neither soft nor hard: the coefficient is zero within rounding"

    @property
    def collides(self) -> bool:
        """Whether two pairs meet on the unit circle and leave it, as without damping."""
        return self.name == COLLISIONS.get(self.type)

    @property
    def several(self) -> bool:
        """Whether several multipliers are critical at once, as by a symmetry."""
        if self.collides:
            return True
        if self.type in PAIRED:
            return bool(np.isnan(self.angle)) and len(angles_on_circle(self.multipliers)) > 1
        if self.type not in ("BP", "PD"):
            return False
        # A cycle has a multiplier one anyway, that of its own direction.
        cycle = self.type == "BP" and not self.model.forced and len(self.nodes) > 1
        off = self.multipliers - BIFURCATION_TYPES[self.type].critical
        nearest = off[np.argsort(np.abs(off))[: 2 + cycle]]
        # Two that meet are known to the root of rounding, but their sum is to rounding.
        return len(nearest) == 2 + cycle and bool(abs(nearest.sum()) < ALIKE)

    @property
    def measured(self) -> tuple[str, str] | None:
        """Measure and output of an extremum, as in ``("max", "x")``; None of other points."""
        if self.type not in EXTREMUM_TYPES:
            return None
        _, measure, output = self.name.split(" ", 2)
        return measure, output

    @property
    def duration(self) -> float:
        """Period of the orbit in seconds; at a Hopf point, that of the emanating cycle."""
        if self.type == "HB" and self.critical_multiplier is not None:
            return self.orbit.duration * 2 * np.pi / float(np.angle(self.critical_multiplier))
        return self.orbit.duration

    @property
    def critical_multiplier(self) -> complex | None:
        """The multiplier on the unit circle (upper one of a pair), None if there is none."""
        if self.type not in BIFURCATION_TYPES:
            return None
        if self.type in PAIRED:
            upper = self.multipliers[self.multipliers.imag > 0]
            known = None if np.isnan(self.angle) else np.exp(1j * self.angle)
            distance = np.abs(np.abs(upper) - 1) if known is None else np.abs(upper - known)
            return complex(upper[np.argmin(distance)])
        target = BIFURCATION_TYPES[self.type].critical
        return complex(self.multipliers[np.argmin(np.abs(self.multipliers - target))])


def sensitive_to(model: Model, vary: str) -> tuple[str, ...]:
    """Return the parameters with which special points move: all but the one followed."""
    names = (item.name for item in model.parameters)
    return tuple(name for name in names if name not in (vary, DURATION.name))
