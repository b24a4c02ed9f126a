"""Bifurcations by SciPy alone, from the text of the equations: nothing of slipfold is used.

Formulas are run by Python; derivatives are complex steps; motions and their variations are SciPy's
`solve_ivp`; the point, with its orbit, duration and parameter, is one root of one system.
"""

import re
from itertools import combinations

import numpy as np
from scipy.integrate import solve_ivp

TINY = 1e-30

STEP, CLOSE, CORRECTIONS = 1e-6, 1e-8, 20
"""Of Newton's method, in units of what is looked for."""

FAR = 1e-4
"""What is found farther from where it was looked for, as a share, is something else."""

WAYS = (
    {"method": "DOP853", "tolerance": 1e-12},
    {"method": "DOP853", "tolerance": 1e-10},
)

FUNCTIONS = {
    name: getattr(np, name) for name in ("sin", "cos", "tan", "tanh", "cosh", "exp", "log", "sqrt")
}
FUNCTIONS |= {"pi": np.pi, "atan": np.arctan, "sigmoid": lambda x: 1 / (1 + np.exp(-x))}


class Equations:
    """The rates of a system of text, with its parameters as they are."""

    def __init__(self, model, values):
        sizes = model.get("sizes", {})
        self.values = values
        formulas = _expanded(model.get("formulas", {}), sizes)
        states = model["states"].items()
        rates = {key: item if isinstance(item, str) else item["rate"] for key, item in states}
        rates = _expanded(rates, sizes)
        self.names = list(rates)
        self._formulas = [(key, _code(formulas[key])) for key in _in_order(formulas)]
        self._rates = [_code(rates[name]) for name in self.names]
        period = model.get("forcing", {}).get("period")
        self.angles = [
            not isinstance(item, str) and item.get("angle", False)
            for key, item in model["states"].items()
            for _ in _indices(key, sizes)
        ]
        self.period = None if period is None else eval(_code(period), FUNCTIONS | values)

    def rates(self, t, x, **changed):
        """Shapes: x (n, ...); returns the same."""
        names = FUNCTIONS | self.values | changed | {"t": t}
        names |= dict(zip(self.names, x, strict=True))
        for key, code in self._formulas:
            names[key] = eval(code, names)
        return np.array([np.broadcast_to(eval(code, names), x[0].shape) for code in self._rates])

    def jacobian(self, t, x, **changed):
        steps = x[:, None] + 1j * TINY * np.eye(len(x))
        return self.rates(t, steps, **changed).imag / TINY


def points_near(case, diagram):
    """Find the special points of a diagram again: type, period, value, what it is known to.

    Of the diagram it takes eight digits of where they are.
    """
    found = []
    for branch in diagram.branches:
        for item in branch.special:
            cycle = branch.kind != "equilibrium"
            duration = item.orbit.duration if cycle else None
            near = [rounded(x) for x in (item.value, *item.nodes[0])]
            lasts = None if duration is None else rounded(duration)
            half = case.table.get("symmetric", False) and item.type == "BP" and cycle
            values = [
                Point(
                    case.file["model"], dict(case.model.values), case.table["vary"], item.type,
                    half=half, **way,
                ).find(near[0], near[1:], lasts)
                for way in (WAYS if cycle else WAYS[:1])
            ]  # fmt: skip
            spread = float(f"{max(np.ptp(values), 1e-12 * abs(values[0])):.0e}")
            found.append([item.type, branch.period, values[0], spread])
    return sorted(found)


def rounded(value):
    return float(f"{value:.7e}")


class Point:
    """A bifurcation of some type of orbits near one that is known roughly."""

    def __init__(self, model, values, vary, type_, *, half=False, method="DOP853", tolerance=1e-11):
        self._model, self._fixed, self._vary = model, values, vary
        self._type, self._half = type_, half
        self._method, self._tolerance = method, tolerance

    def find(self, value, state, duration=None):
        """Return the value of the parameter; a duration in seconds is that of a cycle or orbit."""
        state = np.asarray(state, dtype=float)
        free = duration is not None and self._equations(value).period is None
        largest = np.abs(state).max()
        sizes = np.maximum(np.abs(state), 0.1 * (largest if largest > 1e-12 else 1.0))
        units = [*sizes, abs(value) or 1.0, *([duration] if free else [])]
        start = np.array([*state, value, *([duration] if free else [])]) / units
        flow = self._equations(value).rates(0.0, state) if free else None

        def fails(z):
            z = z * units
            x, equations = z[: len(state)], self._equations(z[len(state)])
            if duration is None:
                matrix = equations.jacobian(0.0, x)
                return [*(equations.rates(0.0, x) / sizes), self._critical_rest(matrix)]
            ratio = duration if equations.period is None else round(duration / equations.period)
            lasts = z[-1] if free else ratio * equations.period
            end, matrix = self._propagated(equations, x, lasts / (2 if self._half else 1))
            sign = -1.0 if self._half else 1.0
            phase = [] if flow is None else [flow @ (x - state) / (flow @ flow)]
            ahead = sign * end - x
            turned = (ahead + np.pi) % (2 * np.pi) - np.pi
            ahead = np.where(equations.angles, turned, ahead)
            return [*(ahead / sizes), *phase, self._critical(sign * matrix, free)]

        there = float(_root(fails, start)[len(state)] * units[len(state)])
        assert abs(there - value) <= FAR * abs(value), f"{self._type} near {value} at {there}"
        return there

    def _equations(self, value):
        return Equations(self._model, {**self._fixed, self._vary: value})

    def _propagated(self, equations, x, lasts):
        n = len(x)

        def rates(t, y):
            along = equations.jacobian(t, y[:n]) @ y[n:].reshape(n, n)
            return np.concatenate([equations.rates(t, y[:n]), along.ravel()])

        sizes = np.concatenate([np.abs(x).max() * np.ones(n) + 1e-12, np.ones(n * n)])
        y = np.concatenate([x, np.eye(n).ravel()])
        tolerance = {"rtol": self._tolerance, "atol": 1e-2 * self._tolerance * sizes}
        end = solve_ivp(rates, (0.0, lasts), y, method=self._method, **tolerance).y[:, -1]
        return end[:n], end[n:].reshape(n, n)

    def _critical_rest(self, matrix):
        values = np.linalg.eigvals(matrix)
        rate = np.abs(values).max()
        if self._type == "HB":
            pairs = values[values.imag > 1e-9 * rate]
            return float(pairs[np.abs(pairs.real).argmin()].real) / rate
        return float(np.prod(values).real) / rate ** len(values)

    def _critical(self, matrix, free):
        """A function of the monodromy matrix that is zero at the bifurcation."""
        one = np.eye(len(matrix))
        values = np.linalg.eigvals(matrix)
        if self._type == "NS":
            pairs = values[values.imag > 1e-9]
            return float((np.abs(pairs) ** 2 - 1)[np.abs(np.abs(pairs) - 1).argmin()])
        sign = -1.0 if (self._type == "PD") != self._half else 1.0
        large = np.prod(1 + np.abs(values))
        if free and sign > 0:
            # One multiplier is always one: the derivative of the characteristic polynomial there.
            rest = combinations(range(len(matrix)), len(matrix) - 1)
            return sum(np.linalg.det((one - matrix)[np.ix_(some, some)]) for some in rest) / large
        return float(np.linalg.det(one - sign * matrix)) / large


def _root(fails, z):
    """Newton's method with differences: motions are known too roughly for anything cleverer."""
    for _ in range(CORRECTIONS):
        missed = np.array(fails(z))
        shifted = [np.array(fails(z + STEP * unit)) for unit in np.eye(len(z))]
        slopes = np.transpose([(there - missed) / STEP for there in shifted])
        change = np.linalg.solve(slopes, missed)
        z = z - change
        if np.abs(change).max() < CLOSE:
            return z
    raise AssertionError(f"the last of {CORRECTIONS} corrections was {np.abs(change).max():.1e}")


def _code(text):
    return compile(text.replace("^", "**"), text, "eval")


def _in_order(formulas):
    """Names of formulas, each after those that it needs."""
    done = []
    while len(done) < len(formulas):
        ready = [
            key
            for key, text in formulas.items()
            if key not in done
            and not (set(re.findall(r"[A-Za-z_]\w*", text)) & set(formulas) - set(done))
        ]
        done += ready
    return done


def _expanded(table, sizes):
    """Write entries such as `x[i=1:n]` out, as `x_1`, `x_2`, ..."""
    result = {}
    for key, text in table.items():
        for index, known in _indices(key, sizes):
            result[_plain(key, index, known)] = _plain(text, None, known)
    return result


def _indices(key, sizes):
    found = re.search(r"\[(\w+)=([^:]+):([^\]]+)\]", key)
    if found is None:
        return [(None, sizes)]
    name, first, last = found.groups()
    first, last = (eval(item, dict(sizes)) for item in (first, last))
    return [(i, {**sizes, name: i}) for i in range(first, last + 1)]


def _plain(text, index=None, known=None):
    if index is not None:
        text = re.sub(r"\[[^\]]*\]", f"_{index}", text, count=1)
    return re.sub(r"\[([^\]]*)\]", lambda item: f"_{eval(item[1], dict(known))}", text)
