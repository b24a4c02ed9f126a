"""Each claim is confirmed by data that fit it and refuted by data that do not."""

from types import SimpleNamespace

import numpy as np
import pytest

from helpers.hand_drawn import FLIPPED, INSIDE, TWISTED, diagram_of, drawn_branch, drawn_point
from helpers.hand_drawn import threshold_diagram as diagram
from slipfold.paper.cases import Cases, read_cases
from slipfold.paper.claims import CLAIMS, Findings, claims_markdown, judge_claims

CASES = read_cases()


def rows(number):
    if number == 9:
        return [CASES.further[0][1]]
    return next(figure.rows for figure in CASES.figures if figure.number == number)


def judge(number, changes, spectra=None):
    """Judge one claim on given diagrams: ``{figure: one list of diagrams a row}``."""
    found = {}
    for figure, lists in changes.items():
        for row, diagrams in zip(rows(figure), lists, strict=True):
            found.update(zip(row.curves, diagrams, strict=True))
    return judge_claims(Findings(CASES, found, spectra or {}))[number - 1]


def spectra(below=0.0, above=0.3, settled=True):
    made = {}
    for case, half in zip(CASES.figures[0].spectra, (below, above), strict=True):
        lines = {0.5: half, 1: 0.04, 1.5: half / 10}
        made[case] = SimpleNamespace(
            line=lambda name, order, lines=lines: lines[order], settled=settled
        )
    return made


@pytest.mark.parametrize(
    ("doubling", "given", "verdict"),
    [
        (0.14, spectra(), True),
        (0.14, spectra(below=0.01), False),
        (0.14, spectra(above=0.0), False),
        (0.14, spectra(settled=False), False),
        (0.20, spectra(), False),
        (0.04, spectra(), False),
    ],
)
def test_claim_1(doubling, given, verdict):
    claim = judge(1, {2: [[diagram(0.04), diagram(doubling)]]}, given)
    assert claim.verdict is verdict
    assert f"{doubling:g} N" in claim.evidence


@pytest.mark.parametrize(
    ("at_12_5", "at_12_2", "verdict"),
    [
        ("supercritical", "subcritical", True),
        ("supercritical", "supercritical", False),
        ("subcritical", "subcritical", False),
        (None, "subcritical", False),
    ],
)
def test_claim_2(at_12_5, at_12_2, verdict):
    given = [diagram(0.04, criticality=at_12_5), diagram(0.14, criticality=at_12_2)]
    claim = judge(2, {2: [given]})
    assert claim.verdict is verdict
    assert "0.14" in claim.evidence


@pytest.mark.parametrize(("tori", "verdict"), [([0.06, 0.2], True), ([], False)])
def test_claim_3(tori, verdict):
    assert judge(3, {2: [[diagram(0.04, tori), diagram(0.1)]]}).verdict is verdict


def frequency_diagram(*, low=12.3, high=12.7, reach=0.2, folded=True, tori=True, split=True):
    """A response with a peak at 12.5 Hz and a doubled branch that bends to lower frequencies."""
    f = np.concatenate([np.linspace(11, 14, 60), [low, high]])
    f.sort()
    f = f[(np.abs(f - low) > 1e-9) & (np.abs(f - high) > 1e-9)]
    peak = {"x": 0.1 + 0 * f, "y": 1 / (1 + 20 * (f - 12.5) ** 2)}
    at = {value: {"x": 0.1, "y": 1 / (1 + 20 * (value - 12.5) ** 2)} for value in (low, high)}
    special = [
        drawn_point("PD", value, value, at[value], leads_to=2, vary="f") for value in (low, high)
    ]
    multipliers = [FLIPPED if low < value < high else INSIDE for value in f]
    first = drawn_branch(f, peak, multipliers, special, arclength=f, vary="f")
    s = np.linspace(0, 1, 41)
    fold = 0.3
    lowest = low - reach
    g = np.where(
        s < fold,
        lowest + (low - lowest) * (1 - s / fold) ** 2,
        lowest + (high - lowest) * ((s - fold) / (1 - fold)) ** 2,
    )
    x = 0.1 + 0.4 * s * (1 - s) * (1 + np.exp(-(((s - fold) / 0.2) ** 2)))
    y = (0.3 if split else 3.0) + 0 * s
    special = [drawn_point("LP", lowest, fold, {"x": 0.3, "y": y[0]}, vary="f")] if folded else []
    kinds = [INSIDE] * len(s)
    if tori:
        points = [(12.5, 0.8), (12.6, 0.9)]
        special += [
            drawn_point("NS", v, at_s, {"x": 0.15, "y": y[0]}, vary="f") for v, at_s in points
        ]
        kinds = [TWISTED if 0.8 < value < 0.9 else INSIDE for value in s]
    keep = np.array([all(abs(value - p.arclength) > 1e-9 for p in special) for value in s])
    second = drawn_branch(
        g[keep],
        {"x": x[keep], "y": y[keep]},
        [kind for kind, kept in zip(kinds, keep, strict=True) if kept],
        special,
        arclength=s[keep],
        period=2,
        begun="born",
        stopped="closed",
        vary="f",
    )
    return diagram_of(first, second)


def frequency_family(**changes):
    """Three forces: the band widens and bends further with each; then one of them is changed."""
    plain = [
        {"low": 12.4 - 0.1 * i, "high": 12.6 + 0.1 * i, "reach": 0.1 + 0.3 * i} for i in range(3)
    ]
    plain[2].update(changes)
    return {3: [[frequency_diagram(**item) for item in plain]]}


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, True),
        ({"split": False}, False),
        ({"low": 12.4, "high": 12.6, "reach": 0.1}, False),  # as narrow as the first
        ({"reach": -0.01}, False),  # does not reach below the lower PD
        ({"low": 12.42, "high": 14.0, "reach": 0.05}, False),  # wider, but no longer softening
    ],
)
def test_claim_4(changes, verdict):
    assert judge(4, frequency_family(**changes)).verdict is verdict


def test_claim_5():
    assert judge(5, frequency_family()).verdict is True
    without_folds = {3: [[frequency_diagram(folded=False)] * 3]}
    assert judge(5, without_folds).verdict is False
    without_tori = {3: [[frequency_diagram(tori=False)] * 3]}
    assert judge(5, without_tori).verdict is False


@pytest.mark.parametrize(
    ("values", "verdict"),
    [((0.06, 0.05, 0.04, 0.03), True), ((0.06, 0.04, 0.05, 0.03), False)],
)
def test_claim_6(values, verdict):
    claim = judge(6, {4: [[diagram(value) for value in values]]})
    assert claim.verdict is verdict
    assert all(f"{value:g}" in claim.evidence for value in values)


@pytest.mark.parametrize(
    ("tori", "verdict"),
    [
        ([(), (0.1,), (0.1,), (0.1,)], True),
        ([(0.1,), (0.1,), (0.1,), (0.1,)], False),
        ([(), (0.1,), (), (0.1,)], False),
    ],
)
def test_claim_7(tori, verdict):
    assert judge(7, {4: [[diagram(0.05, item) for item in tori]]}).verdict is verdict


@pytest.mark.parametrize(
    ("doubling", "tori", "slopes", "verdict"),
    [
        ((0.02, 0.03, 0.04), (0.05, 0.06, 0.07), (1, 2, 3), True),
        ((0.04, 0.03, 0.02), (0.05, 0.06, 0.07), (1, 2, 3), False),
        ((0.02, 0.03, 0.04), (0.07, 0.06, 0.08), (1, 2, 3), False),
        ((0.02, 0.03, 0.04), (0.05, 0.06, 0.07), (3, 2, 1), False),
    ],
)
def test_claim_8(doubling, tori, slopes, verdict):
    given = [
        diagram(pd, [ns], slope=slope) for pd, ns, slope in zip(doubling, tori, slopes, strict=True)
    ]
    claim = judge(8, {5: [given]})
    assert claim.verdict is verdict
    assert f"{slopes[0] * 0.6:g}" in claim.evidence  # largest x/L at Nd = 0.5


FALLING = [(0.05, 0.2), (0.04, 0.15), (0.03, 0.1), (0.02, 0.05)]


def family(pairs):
    return [diagram(pd, [] if ns is None else [ns]) for pd, ns in pairs]


@pytest.mark.parametrize(
    ("fast", "verdict"),
    [
        (FALLING, True),
        (FALLING[::-1], False),
        ([*FALLING[:3], (0.02, 0.12)], False),
        ([*FALLING[:3], (0.02, None)], False),
    ],
)
def test_claim_9(fast, verdict):
    assert judge(9, {6: [family(fast)], 9: [family(FALLING)]}).verdict is verdict


@pytest.mark.parametrize(
    ("slow", "fast", "verdict"),
    [
        ([None, 0.2], [None, 0.2], True),
        ([0.2, 0.2], [None, 0.2], False),
        ([None, None], [None, 0.2], False),
    ],
)
def test_claim_10(slow, fast, verdict):
    given = [
        [
            diagram(pd, [] if ns is None else [ns])
            for pd, ns in zip((0.1, 0.08, 0.06, 0.04), [*tori, 0.2, 0.2][:4], strict=True)
        ]
        for tori in ([*slow, slow[1]], [*fast, fast[1]])
    ]
    if slow == [None, None]:
        given[0] = [diagram(pd) for pd in (0.1, 0.08, 0.06, 0.04)]
    assert judge(10, {7: given}).verdict is verdict


def test_what_is_missing_is_not_judged():
    claims = judge_claims(Findings(CASES))
    assert [claim.verdict for claim in claims] == [None] * 10
    assert "Nd_Vd0.4" in claims[5].evidence
    claims = judge_claims(Findings(Cases(())))
    assert {claim.verdict_text for claim in claims} == {"not computed"}


def test_markdown_lists_verdicts_and_evidence():
    claims = judge_claims(
        Findings(CASES, dict(zip(rows(4)[0].curves, family(FALLING), strict=True)))
    )
    text = claims_markdown(claims)
    assert text.count("\n## ") == len(CLAIMS) == 10
    assert "| 6 | A larger Vd lowers the PD threshold. | confirmed |" in text
    assert "| 7 | A small Vd removes the NS. | not confirmed |" in text
    assert (
        "| 2 | PD is subcritical at 12.2 Hz and supercritical at 12.5 Hz. | not computed |" in text
    )
