"""Each claim is confirmed by data that fit it and refuted by data that do not."""

from types import SimpleNamespace

import pytest

from helpers.hand_drawn import threshold_diagram as diagram
from slipfold.interface.paper.cases import Cases, read_cases
from slipfold.interface.paper.claims import Findings, judge_claims

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
    return judge_claims(Findings(CASES, found | (spectra or {})))[number - 1]


def spectra(below=0.0, above=0.3, settled=True):
    made = {}
    for case, half in zip(CASES.figures[0].cases, (below, above), strict=True):
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


def test_what_is_missing_is_not_judged():
    claims = judge_claims(Findings(CASES))
    assert [claim.verdict for claim in claims] == [None] * 10
    assert "Nd_Vd0.4" in claims[5].evidence
    claims = judge_claims(Findings(Cases(())))
    assert {claim.verdict_text for claim in claims} == {"not computed"}
