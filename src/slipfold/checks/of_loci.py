"""Special points and ends of loci, computed again by other means."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from slipfold.branches.seams import NAMES as SEAMS
from slipfold.checks.checked import Checked
from slipfold.checks.choice import Candidate, check_some
from slipfold.loci.locus import Locus
from slipfold.loci.progress import locus_progress
from slipfold.orbits.grazing import MET
from slipfold.progress import Observer
from slipfold.text.one_line import parameter_text


def check_loci(loci: Sequence[Locus], observer: Observer | None = None) -> Checked:
    """Check the ends of each locus, then its special points, those that come first first.

    Whoever interrupted the loci does not wait for checks.
    """
    if any(locus.interrupted for locus in loci):
        return Checked((), interrupted=True)
    points = sum(len(locus) * locus.period for locus in loci)

    def tell(done: int) -> None:
        if observer is not None:
            first, second = loci[-1].stopped.values
            observer(locus_progress("checks", done, None, (first, second), "by another method"))

    return check_some(_candidates(loci), points, tell)


def _candidates(loci: Sequence[Locus]) -> Iterator[Candidate]:
    # An orbit that only just touches changes in another order beside it: nothing to compare.
    loci = [locus for locus in loci if len(locus) and locus.type not in MET]
    for index, word in ((-1, "end"), (0, "beginning")):
        for locus in loci:
            name = f"{word} of locus {locus.id} at {_at(locus, locus.values[index])}"
            yield Candidate(name, locus.orbit(index), locus.kind == "equilibrium")
    ranked = [(rank, locus, point) for locus in loci for rank, point in enumerate(locus.special)]
    for _, locus, point in sorted(ranked, key=lambda item: item[0]):
        if point.type in SEAMS:
            continue
        name = f"{point.type} of locus {locus.id} at {_at(locus, point.values)}"
        yield Candidate(name, point.orbit, locus.kind == "equilibrium")


def _at(locus: Locus, values: Sequence[float]) -> str:
    pairs = zip(locus.vary, values, strict=True)
    return ", ".join(parameter_text(locus.model.parameter(name), value) for name, value in pairs)
