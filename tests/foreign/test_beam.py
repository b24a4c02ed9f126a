"""A steel cantilever of finite elements: a few modes move, and many stiff ones follow."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq, root
from tests.helpers.beams import free_beam

import slipfold as sf
from slipfold.bifurcations.branches.start import measured_over
from slipfold.flow.equilibrium import linear_responses
from slipfold.flow.flow import flow_of
from slipfold.models.equilibria import damped_newton

LENGTH, WIDTH, HEIGHT, YOUNG, DENSITY = 0.3, 0.02, 0.002, 210e9, 7850.0
BENDING = YOUNG * WIDTH * HEIGHT**3 / 12
DAMPING = sf.ProportionalDamping(alpha_M=1, beta_K=1e-6)
LAW = {"mu_s": 0.4, "mu_k": 0.2, "vs": 0.3}
LOAD = 2.0
HARMONICS, SAMPLES = 24, 256


def matrices(count):
    """Mass and stiffness of a clamped beam: deflection and slope at each node."""
    heavy = DENSITY * WIDTH * HEIGHT
    mass, stiffness = free_beam(count, length=LENGTH, stiffness=BENDING, density=heavy)
    return mass[2:, 2:], stiffness[2:, 2:]


def beam(count, **parts):
    mass, stiffness = matrices(count)
    names = [name for node in range(1, count + 1) for name in (f"w{node}", f"r{node}")]
    return sf.Structure(mass, DAMPING, stiffness, names=names, **parts)


def sliding(count, **parts):
    contact = sf.FrictionContact(f"w{count}", sf.Stribeck(**LAW), load=LOAD, Vd=1.0)
    return beam(count, contacts=contact, **parts)


def friction(speed):
    return LAW["mu_k"] + (LAW["mu_s"] - LAW["mu_k"]) * np.exp(-speed / LAW["vs"])


def growth_of_the_lowest_mode(count, speed):
    mass, stiffness = matrices(count)
    squares, modes = eigh(stiffness, mass)
    falls = LOAD * (LAW["mu_s"] - LAW["mu_k"]) / LAW["vs"] * np.exp(-speed / LAW["vs"])
    tip = modes[-2]
    damping = np.diag(1 + 1e-6 * squares) - falls * np.outer(tip, tip)
    whole = np.block(
        [[np.zeros_like(damping), np.eye(len(tip))], [-np.diag(squares), -damping]]
    )  # in modal coordinates, where nothing cancels
    values = np.linalg.eigvals(whole)
    lowest = values[np.abs(np.abs(values) - np.sqrt(squares[0])).argmin()]
    return lowest.real


def series(parts):
    """Samples over a period of what harmonics add up to."""
    padded = np.zeros(SAMPLES // 2 + 1, complex)
    padded[: HARMONICS + 1] = parts
    return np.fft.irfft(padded, SAMPLES) * SAMPLES


class Balance:
    """Harmonics of the tip by the answer of all modes to a force there: no state, no time."""

    def __init__(self, count, push, force=0.0):
        self.squares, modes = eigh(*matrices(count)[::-1])
        self.tip, self.push, self.force = modes[-2], push, force
        self.first = np.sqrt(self.squares[0])
        self.orders = np.arange(HARMONICS + 1)

    def solve(self, guess, omega, closing):
        """Return harmonics in mm and the frequency in rad/s; `closing` is the last equation."""

        def parts(unknown):
            imaginary = unknown[HARMONICS + 1 : -1]
            return unknown[: HARMONICS + 1] + 1j * np.append(0.0, imaginary)

        def apart(unknown):
            tip, turned = parts(unknown), 1j * self.orders * unknown[-1] * self.first
            moved, speed = series(1e-3 * tip), series(1e-3 * turned * tip)
            forces = np.fft.rfft(self.push(moved, speed))[: HARMONICS + 1] / SAMPLES
            forces[1] += self.force / 2
            lag = turned[:, None] * (1 + 1e-6 * self.squares)
            answer = (self.tip**2 / (turned[:, None] ** 2 + lag + self.squares)).sum(axis=1)
            gap = tip - 1e3 * answer * forces
            last = closing(tip, unknown[-1] * self.first)
            return np.concatenate([gap.real, gap.imag[1:], [last]])

        guess = np.concatenate([guess.real, guess.imag[1:], [omega / self.first]])
        found = root(apart, guess, tol=1e-13).x
        assert np.abs(apart(found)).max() < 1e-9
        return parts(found), found[-1] * self.first


def duration_of_the_cycle(count, speed):
    """Of the unstable cycle; the first guess balances what friction gives and damping takes."""
    balance = Balance(count, lambda moved, tip_speed: LOAD * friction(speed - tip_speed))
    turn = np.cos(2 * np.pi * np.arange(SAMPLES) / SAMPLES)
    takes = (1 + 1e-6 * balance.squares[0]) / balance.tip[0] ** 2

    def gives(size):
        return 2 * LOAD * np.mean(friction(speed - size * turn) * turn) / size

    size = brentq(lambda size: gives(size) - takes, 1e-3 * speed, 0.999 * speed)
    guess = np.zeros(HARMONICS + 1, complex)
    guess[0] = 1e3 * LOAD * friction(speed) * LENGTH**3 / (3 * BENDING)
    guess[1] = 1e3 * size / balance.first / 2
    return 2 * np.pi / balance.solve(guess, balance.first, lambda tip, _: tip[1].imag)[1]


@pytest.mark.parametrize("count", [3, 8, pytest.param(15, marks=pytest.mark.long)])
def test_how_far_the_tip_moves_does_not_depend_on_the_elements(count):
    model = sliding(count, name="beam")
    sizes = measured_over(model, "Vd", (1.5, 0.5)).state_scales()
    of = dict(zip([state.name for state in model.states], sizes, strict=True))
    # It slides with a meter a second, at 18 Hz; the highest mode has up to 450 kHz.
    assert 1e-4 < of[f"w{count}"] < 1e-2
    assert 0.5 < of[f"vw{count}"] < 32


@pytest.mark.parametrize("count", [5, pytest.param(15, marks=pytest.mark.long)])
def test_the_response_about_rest_is_that_of_the_modes(count):
    tip = f"w{count}"
    force = sf.HarmonicForce(tip, F=0.1)
    model = beam(count, elements=sf.CubicSpring(tip, k3=1e6), forcing=force, f=18.0)
    model = measured_over(model, "f", (15, 30))
    flow = flow_of(model)
    constants = flow.constants(model.vector)
    found = linear_responses(flow, constants, model.state_scales(), 4, model.start[None])[0]
    mass, stiffness = matrices(count)
    squares, modes = eigh(stiffness, mass)
    omega = 2 * np.pi * 18.0
    answer = modes[-2] / (squares - omega**2 + 1j * omega * (1 + 1e-6 * squares))
    amplitude = 0.1 * modes[-2] @ answer
    there = [state.name for state in model.states].index(tip)
    moved = np.hypot(found[0, there], found[1, there])
    assert moved == pytest.approx(abs(amplitude), rel=1e-5)


def test_where_stiff_structures_rest_is_found_to_the_digits_there_are():
    mass, stiffness = matrices(15)
    n = len(mass)
    jacobian = np.zeros((2 * n, 2 * n))
    jacobian[:n, n:], jacobian[n:, :n] = np.eye(n), -np.linalg.solve(mass, stiffness)
    jacobian[n:, n:] = -np.eye(n)
    push = np.zeros(2 * n)
    push[n:] = np.linalg.solve(mass, np.eye(n)[-2])

    def linear(states, _):
        return states @ jacobian.T + push, np.tile(jacobian, (len(states), 1, 1))

    (found,) = damped_newton(linear, np.zeros((1, 2 * n)), np.full(2 * n, 1e-3))
    assert found[n - 2] == pytest.approx(LENGTH**3 / (3 * BENDING), rel=1e-6)


@pytest.mark.parametrize("count", [8, pytest.param(15, marks=pytest.mark.long)])
def test_a_beam_rests_where_it_does_in_closed_form(count):
    (still,) = sf.response(sliding(count), vary="Vd", span=(1.5, 1.3)).branches
    assert still.stopped.kind == "span"
    tip = LOAD * friction(still.parameter) * LENGTH**3 / (3 * BENDING)
    assert still.nodes[:, 0, 2 * count - 2] == pytest.approx(tip, rel=1e-6)


def test_few_modes_squeal_where_fifteen_elements_do():
    held = sf.CraigBampton("w15", modes=3)
    model = sliding(15, reduction=held)
    assert model.reduction_report.error < 5e-3
    diagram = sf.response(model, vary="Vd", span=(1.25, 1.15))
    still, cycles = diagram.branches
    exact = brentq(lambda speed: growth_of_the_lowest_mode(15, speed), 1.15, 1.25)
    assert still.special[0].value == pytest.approx(exact, rel=5e-5)
    assert cycles.stopped.kind == "span"
    whole = duration_of_the_cycle(15, 1.25)
    assert cycles.durations[-1] == pytest.approx(whole, rel=model.reduction_report.error)


def forced_on_a_belt():
    """Five modes: friction that falls with speed leaves them little damping."""
    law = sf.Regularized(sf.Stribeck(**LAW), e=0.05)
    contact = sf.FrictionContact("w15", law, load=2.0, Vd=1.0)
    force, few = sf.HarmonicForce("w15", F=1.0), sf.ModalReduction(modes=5)
    return beam(15, contacts=contact, forcing=force, f=18.0, reduction=few)


def test_modes_of_equal_energy_count_the_same_in_a_step():
    model = measured_over(forced_on_a_belt(), "f", (18.0, 18.4))
    squares, modes = eigh(*matrices(15)[::-1])
    masses = 1 / np.abs(modes[:, :5]).max(axis=0) ** 2  # where the largest displacement is one
    energies = np.array([masses * squares[:5], masses]).ravel() * model.step_scales() ** 2
    assert energies.max() < 16 * energies.min()  # powers of two have errors of up to 2 in a square
    own = model.step_scales() / model.state_scales()
    assert own.min() >= 1
    assert 4 <= own.max() <= 16


def test_small_modes_do_not_set_the_steps():
    """With its own scale for each mode it took 52 points."""
    model = forced_on_a_belt()
    (branch,) = sf.response(model, vary="f", span=(17.6, 18.2)).branches
    assert branch.stopped.kind == "span"
    assert len(branch) <= 34
    assert branch.residual.max() <= 1e-10


WHOLE = [(3, (1.3, 0.8)), (5, (1.25, 1.15)), (8, (1.25, 1.15)), (15, (1.25, 1.15))]


# Beside the Hopf point of the first two spans folds were invented.
@pytest.mark.long
@pytest.mark.parametrize(("count", "span"), [(3, (1.25, 1.0)), *WHOLE])
def test_cycles_of_whole_beams(count, span):
    diagram = sf.response(sliding(count), vary="Vd", span=span)
    still, cycles = diagram.branches[:2]
    assert not diagram.checked.disagreeing
    assert [point.type for point in still.special][:1] == ["HB"]
    exact = brentq(lambda speed: growth_of_the_lowest_mode(count, speed), 1.15, 1.25)
    assert still.special[0].value == pytest.approx(exact, rel=5e-5)
    assert not cycles.special
    assert cycles.stopped.kind == "span"
    assert cycles.durations[-1] == pytest.approx(duration_of_the_cycle(count, span[0]), rel=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("law", ["cubic", "Stribeck"])
def test_a_forced_beam_goes_through_its_first_resonance(law):
    """Three modes, by shooting, have the same but for what the reduction leaves out."""
    force, parts = sf.HarmonicForce("w15", F=0.1), {}
    if law == "cubic":
        parts["elements"] = sf.CubicSpring("w15", k3=1e6)
    else:
        parts["contacts"] = sf.FrictionContact("w15", sf.Stribeck(**LAW), load=LOAD, Vd=1.0)
    whole = beam(15, forcing=force, f=15.0, **parts)
    few = whole.replace(reduction=sf.CraigBampton("w15", modes=3))
    (branch,) = sf.response(whole, vary="f", span=(15, 30)).branches
    (other,) = sf.response(few, vary="f", span=(15, 30)).branches
    assert branch.stopped.kind == other.stopped.kind == "span"
    assert [point.type for point in branch.special] == {"cubic": ["LP"] * 2}.get(law, ["NS"] * 2)
    values = [point.value for point in branch.special]
    error = few.reduction_report.error
    assert values == pytest.approx([point.value for point in other.special], rel=error)


def test_harmonic_balance_states_what_rounding_makes_of_multipliers():
    force = sf.HarmonicForce("w12", F=0.1)
    orbit = sf.periodic_orbit(beam(12, forcing=force, f=37.0))
    squares, _ = eigh(*matrices(12)[::-1])
    damping = (1 + 1e-6 * squares) / 2
    exact = np.exp((-damping + 1j * np.sqrt(squares - damping**2))[:2] / 37.0)
    balance = orbit.harmonic_balance()
    for multiplier in exact:
        apart = np.abs(balance.floquet - multiplier).min()
        assert apart <= balance.truncation
    assert 1e-8 < balance.truncation < 1e-4  # of harmonics alone it is less than 1e-8
