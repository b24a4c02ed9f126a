"""Hold the paper's claims against slower plates, where the tip sticks.

python docs/figures/stick_slip_claims.py writes stick_slip_claims.md.
All speeds of the paper's cases are taken at a share of theirs, else the cases are the paper's.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import slipfold as sf
from slipfold.interface.paper.cases import Case, Row, read_cases
from slipfold.interface.paper.claims import CLAIMS, Findings, first, judge_claims, on_branches
from slipfold.interface.paper.tables import table

FOLDER = Path(__file__).parent

SHARES = {1.0: "the paper's speeds", 1 / 6: "a sixth of its speeds", 1 / 12: "a twelfth"}
"""Speed of the plate over that of the paper."""

STATIC, WITHIN = 1.2, 0.05
"""Static over kinetic friction of Stribeck's law, and its speed (m/s)."""

PERIODS = 3000
"""Forcing periods until spectra are taken."""

LAWS = {"Coulomb": "Coulomb's", "Stribeck": "Stribeck's"}
"""What each law of friction is called."""

FOLLOW = ("LP", "NS")
"""What a doubled branch of the frequency responses may meet."""

Setting = tuple[str, float]
"""Friction law and share of the speed."""


def main() -> None:
    """Compute all and write the tables."""
    settings = [(law, share) for law in LAWS for share in SHARES]
    found = {setting: findings(setting) for setting in settings}
    (FOLDER / "stick_slip_claims.md").write_text(page(found) + "\n")


def page(found: dict[Setting, Findings]) -> str:
    """Return what becomes of the claims under each law, as Markdown."""
    parts = []
    for law in LAWS:
        slower = [found[law, share] for share in SHARES if share != 1.0]
        columns = [
            column(each, share) for each, share in zip(slower, list(SHARES)[1:], strict=True)
        ]
        rows = [
            [str(number), statement, *said]
            for number, ((statement, _), *said) in enumerate(
                zip(CLAIMS, *columns, strict=True), start=1
            )
        ]
        heads = ["", "claim", *list(SHARES.values())[1:]]
        confirmed = sum(claim.verdict is True for claim in judge_claims(found[law, 1.0]))
        parts.append(
            f"With {LAWS[law]} friction {confirmed} of {len(CLAIMS)} claims are confirmed at the "
            f"paper's speeds. On slower plates:\n\n{table(heads, rows)}"
        )
    return "\n\n".join(parts)


def variant(model: sf.SlidingOscillator, setting: Setting) -> sf.SlidingOscillator:
    """Return a case of the paper with a slower plate, and with another law of friction."""
    law, share = setting
    values = {**model.values, "Vd": share * model.values["Vd"]}
    if law == "Coulomb":
        return sf.SlidingOscillator(**values)
    mu = values.pop("mu")
    return sf.SlidingOscillator(sf.Stribeck(mu_s=STATIC * mu, mu_k=mu, vs=WITHIN), **values)


def computed(case: Case, setting: Setting) -> Any:
    """Return a response diagram, or the spectrum of a trajectory from rest."""
    model = variant(case.model, setting)
    if case.kind == "spectrum":
        return sf.simulate(model, PERIODS).spectrum()
    return sf.response(model, vary=case.vary[0], span=case.spans[0])


def findings(setting: Setting) -> Findings:
    """Compute all that the claims need; it replaces the paper's cases."""
    cases = read_cases()
    # Spectra are judged at the paper's speeds alone.
    kinds = ("response", "spectrum") if setting[1] == 1.0 else ("response",)
    needed = [case for case in cases.needs if case.kind in kinds]
    with ProcessPoolExecutor(2) as executor:
        results = list(executor.map(partial(computed, setting=setting), needed))
    return Findings(cases, dict(zip(needed, results, strict=True)))


def column(found: Findings, share: float) -> list[str]:
    """Return what is found of each claim, in a few words."""
    force = {f: found.diagram(f=f) for f in (12.2, 12.5)}
    doubling = {f: first(diagram, "PD", False) for f, diagram in force.items()}
    families = {figure: found.rows(figure) for figure in (3, 4, 5, 6, 7)}
    across = [diagram for _, diagram in found.family(families[3][0])]
    active = [diagram for diagram in across if any(b.period > 1 for b in diagram.branches)]
    kinds = {kind: sum(len(on_branches(each, kind, True)) for each in across) for kind in FOLLOW}
    speeds = thresholds(found, families[4][0], "PD", share)
    return [
        "12.2 Hz: "
        + ("no f/2" if doubling[12.2] is None else f"from {value(doubling[12.2])} N on"),
        "; ".join(f"{f} Hz: {judged(point)}" for f, point in doubling.items()),
        listed(on_branches(force[12.5], "NS", True)),
        f"x active at {len(active)} of {len(across)} amplitudes",
        ", ".join(f"{count} {kind}" for kind, count in kinds.items()),
        speeds,
        thresholds(found, families[4][0], "NS", share),
        thresholds(found, families[5][0], "PD"),
        thresholds(found, families[6][0], "PD"),
        thresholds(found, families[7][-1], "PD"),
    ]


def thresholds(found: Findings, row: Row, kind: str, share: float = 1.0) -> str:
    """Return where each member of a family meets a kind of point first (N)."""
    unit = np.degrees(1) if row.member == "alpha" else share
    points = [(x, first(diagram, kind, kind == "NS")) for x, diagram in found.family(row)]
    if not any(point for _, point in points):
        return f"no {kind}"
    said = ", ".join(f"{value(point)} ({x * unit:.3g})" for x, point in points)
    return f"{kind} at {said} for {row.member} in brackets"


def value(point: sf.SpecialPoint | None) -> str:
    """Return where a point is."""
    return "none" if point is None else f"{point.value:.4g}"


def judged(point: sf.SpecialPoint | None) -> str:
    """Return whether a doubling is soft or hard; coefficients are not computed through stick."""
    return "no PD" if point is None else point.criticality or "through stick"


def listed(points: list[sf.SpecialPoint]) -> str:
    """Return where points are."""
    return f"NS at {', '.join(map(value, points))} N" if points else "no NS"


if __name__ == "__main__":
    main()
