"""The systems of tests/foreign/systems: models, diagrams, and what is known of them."""

import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import slipfold as sf

FOLDER = Path(__file__).parents[1] / "foreign" / "systems"
POINTS = FOLDER.parent / "points.json"
FILES = {path.stem: path for path in sorted(FOLDER.rglob("*.toml"))}


@dataclass(frozen=True)
class Case:
    """One diagram of a system: what is varied, and what there is to find."""

    system: str
    number: int

    @cached_property
    def file(self):
        return tomllib.loads(FILES[self.system].read_text())

    @property
    def table(self):
        return self.file["diagrams"][self.number]

    @property
    def model(self):
        return sf.System(self.file["model"]).replace(**self.table.get("with", {}))

    @property
    def methods(self):
        return self.table.get("methods", ["automatic", "collocation"])

    def response(self, discretization="automatic", **steps):
        settings = sf.Settings(
            discretization=discretization,
            largest_period=self.table.get("largest_period", 8),
            **steps,
        )
        vary, span, start = self.table["vary"], self.table["span"], self.table.get("start")
        settled = self.table.get("settled", False)
        given = {"vary": vary, "span": span, "start": start, "settled": settled}
        return sf.response(self.model, **given, settings=settings)

    def __str__(self):
        return f"{self.system}-{self.number}"


def cases():
    """All diagrams of all systems."""
    counts = ((name, len(Case(name, 0).file["diagrams"])) for name in FILES)
    return [Case(name, number) for name, count in counts for number in range(count)]


def fitzhugh_nagumo(eps=0.08):
    """FitzHugh, Biophysical Journal 1 (1961) 445-466, with his a = 0.7 and b = 0.8."""
    return sf.System(
        name="fitzhugh-nagumo",
        parameters={"I": 0.0, "eps": eps},
        states={
            "v": {"rate": "v - v^3/3 - w + I", "start": -1.2},
            "w": {"rate": "eps*(v + 0.7 - 0.8*w)", "start": -0.6},
        },
    )
