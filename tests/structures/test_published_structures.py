"""Structures of the literature: closed forms, continuous bodies, symmetries, published examples."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import root

import slipfold as sf
from helpers.beams import free_beam

HARMONICS, SAMPLES = 60, 512


def series(parts):
    """Samples over a period of a series with the harmonics from 0."""
    padded = np.zeros((SAMPLES // 2 + 1, *parts.shape[1:]), complex)
    padded[: HARMONICS + 1] = parts
    return np.fft.irfft(padded, SAMPLES, axis=0) * SAMPLES


def balanced(receptance, omega, load, friction):
    """Harmonics of the one motion that friction resists, with a harmonic load there.

    Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems (Springer 2019), chapter 2.
    """
    turned = 1j * omega * np.arange(HARMONICS + 1)
    answer = np.array([receptance(s) for s in turned])

    def parts(unknown):
        return unknown[: HARMONICS + 1] + 1j * np.append(0.0, unknown[HARMONICS + 1 :])

    size = abs(answer[1] * load)

    def apart(unknown):
        moved = size * parts(unknown)
        forces = -np.fft.rfft(friction(series(turned * moved)))[: HARMONICS + 1] / SAMPLES
        forces[1] += load / 2
        gap = (moved - answer * forces) / size
        return np.concatenate([gap.real, gap.imag[1:]])

    start = answer[1] * load / 2 / size * np.eye(1, HARMONICS + 1, 1)[0]
    found = root(apart, np.concatenate([start.real, start.imag[1:]]), tol=1e-14).x
    assert np.abs(apart(found)).max() < 1e-10
    return size * parts(found)


def test_a_bar_with_friction_at_its_end():
    # The bar is continuous: a force at its end moves it by tan(kL)/(E A k), with damping beta K by
    # E (1 + beta s). Elements have the order two, so two meshes together leave the order four.
    stiff, length, dense, beta, load, rise = 4.0, 2.0, 0.5, 0.02, 0.3, 0.2
    omega = 0.9 * np.pi / 2 / length * np.sqrt(stiff / dense)

    def receptance(s):
        elastic = stiff * (1 + beta * s)
        number = np.sqrt(dense / elastic + 0j) * (-1j * s)
        return np.tan(number * length) / (elastic * number) if s else length / stiff

    exact = balanced(receptance, omega, load, lambda v: 0.1 * np.tanh(v / rise))
    found = []
    for count in (6, 12):
        step = length / count
        mass = dense * step * (4 * np.eye(count) + np.eye(count, k=1) + np.eye(count, k=-1)) / 6
        mass[-1, -1] /= 2
        spring = stiff / step * (2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
        spring[-1, -1] /= 2
        end = f"q{count}"
        bar = sf.Structure(
            mass,
            sf.ProportionalDamping(beta_K=beta),
            spring,
            contacts=sf.FrictionContact(
                end, sf.Regularized(sf.Coulomb(mu_k=0.1), e=rise), load=1.0, Vd=0
            ),
            forcing=sf.HarmonicForce(end, F=load),
            f=omega / (2 * np.pi),
        )
        _, moved = sf.periodic_orbit(bar).output(end, SAMPLES)
        found.append(np.fft.rfft(moved)[:4] / len(moved))
    coarse, fine = (np.abs(one - exact[:4]).max() / abs(exact[1]) for one in found)
    assert 3.6 < coarse / fine < 4.4
    assert np.abs((4 * found[1] - found[0]) / 3 - exact[:4]).max() < 0.06 * fine * abs(exact[1])


def test_a_travelling_wave_on_a_ring_is_one_sector():
    # Of N equal sectors under an engine order each moves as the one before, a time T k/N later: the
    # coupling is that of one sector whose harmonic h has the stiffness 2 kc (1 - cos(2 pi h k/N)).
    count, order, omega, load, rise = 5, 1, 1.3, 0.4, 0.3
    coupling, damping = 0.35, 0.04
    waves = 2 * np.pi * order / count
    ring = np.roll(np.eye(count), 1, axis=0)
    stiffness = np.eye(count) + coupling * (2 * np.eye(count) - ring - ring.T)
    names = [f"q{sector}" for sector in range(count)]
    law = sf.Regularized(sf.Coulomb(mu_k=0.2), e=rise)
    bladed = sf.Structure(
        np.eye(count),
        damping * np.eye(count),
        stiffness,
        names=names,
        contacts=[sf.FrictionContact(name, law, load=1.0, Vd=0, name=name) for name in names],
        forcing=[
            sf.HarmonicForce(name, F=load, phi=-waves * sector, name=f"f{name}")
            for sector, name in enumerate(names)
        ],
        f=omega / (2 * np.pi),
    )
    orbit = sf.periodic_orbit(bladed)

    def receptance(s):
        spring = 1 + 2 * coupling * (1 - np.cos(waves * s.imag / omega))
        return 1 / (s * s + damping * s + spring)

    exact = balanced(receptance, omega, load, lambda v: 0.2 * np.tanh(v / rise))
    orders = np.arange(HARMONICS + 1)
    for sector, name in enumerate(names):
        _, moved = orbit.output(name, SAMPLES)
        found = np.fft.rfft(moved)[: HARMONICS + 1] / len(moved)
        later = exact * np.exp(-1j * waves * orders * sector)
        assert np.abs(found - later).max() < 1e-10 * abs(exact[1])
    assert orbit.harmonic_balance().passed


def nlvib_two_masses():
    """NLvib 1.3 (M. Krack, J. Gross), example 02: two masses, each on a cubic spring."""
    return sf.Structure(
        np.diag([1, 0.05]),
        [[0.015, -0.013], [-0.013, 0.013]],
        [[1.0453, -0.0453], [-0.0453, 0.0453]],
        names="a b",
        elements=[
            sf.CubicSpring("a", k3=1.0, name="ground"),
            sf.CubicSpring({"a": 1, "b": -1}, k3=0.0042, name="between"),
        ],
        forcing=sf.HarmonicForce("a", F=0.11),
        length_scale=1.0,
    )


def nlvib_stop():
    """The same, example 03: two masses and a stop beyond a gap, here rounded off over 0.01."""
    return sf.Structure(
        np.eye(2),
        [[0.03, -0.03], [-0.03, 0.06]],
        [[1, -1], [-1, 2]],
        names="a b",
        elements=sf.GapSpring("a", k=100, gap=1, e=0.01),
        forcing=sf.HarmonicForce("b", F=0.1),
        length_scale=1.0,
    )


def followed(model, first, last):
    """The response over the circular frequency, period 1."""
    turn = 2 * np.pi
    settings = sf.Settings(largest_period=1)
    model = model.replace(f=first / turn)
    return sf.response(model, "f", (first / turn, last / turn), settings=settings).branches[0]


def agree(branch, orbits):
    """Special points with their multipliers and some orbits of the branch, by harmonic balance."""
    for point in branch.special:
        found = point.orbit.harmonic_balance()
        assert found.passed, (point.type, found)
        assert np.abs(found.floquet - point.critical_multiplier).min() < 1e-8
    for index in range(0, len(branch), len(branch) // orbits):
        found = branch.orbit(index).harmonic_balance()
        assert found.passed, found


def test_nlvib_s_two_masses_with_cubic_springs():
    # Its folds and secondary Hopf points are found there by the multipliers of shooting.
    branch = followed(nlvib_two_masses(), 0.8, 1.4)
    assert sorted(point.type for point in branch.special) == ["LP", "LP", "NS", "NS"]
    agree(branch, 6)


def test_nlvib_s_two_masses_with_a_stop():
    # It says of three points: the largest is "beyond a period doubling", the one at 0.635 is
    # stable, the one at 0.6 "beyond a Neimark-Sacker bifurcation". The stop there is sharp.
    branch = followed(nlvib_stop(), 0.8, 0.5)
    turns = {"LP": [], "PD": [], "NS": []}
    for point in branch.special:
        turns[point.type].append(2 * np.pi * point.value)
    assert [len(turns[name]) for name in ("LP", "PD", "NS")] == [2, 2, 2]
    assert min(turns["NS"]) < 0.6 < max(turns["NS"]) < 0.635 < min(turns["PD"])
    for point in branch.special:  # the stop is touched so briefly that series are long
        found = point.orbit.harmonic_balance(1e-6, largest=401)
        assert max(found.states, found.multipliers) < max(1e-6, found.truncation), found
        assert found.truncation < 1e-3


@pytest.mark.long
def test_nlvib_s_beam_with_a_friction_node():
    # Example 08, a cantilever. The numbers are those of a run with Octave, 7 harmonics, in steps of
    # 5 rad/s, printed in comparison 07 of julianjurai/NLvib-py (commit 64ad450); 7 harmonics in
    # place of 160 change the root mean square there by 7e-4.
    mass, stiffness = (
        part[2:, 2:] for part in free_beam(8, length=2, stiffness=4.625e6, density=234.9)
    )
    assert eigh(stiffness, mass, eigvals_only=True)[0] ** 0.5 == pytest.approx(123.341, abs=5e-4)
    held = np.delete(np.arange(16), 4)
    stuck = eigh(*(part[np.ix_(held, held)] for part in (stiffness, mass)), eigvals_only=True)[0]
    law = sf.Regularized(sf.Coulomb(mu_k=1.0), e=6e-7)
    beam = sf.Structure(
        mass,
        0.02 / stuck**0.5 * stiffness,
        stiffness,
        names=[f"{kind}{node}" for node in range(2, 10) for kind in "wr"],
        contacts=sf.FrictionContact("w4", law, load=1.5, Vd=0),
        forcing=sf.HarmonicForce("w9", F=0.2),
        watch={"tip": "w9"},
    )
    turn = 2 * np.pi
    events = [sf.Event("tip", measure="rms")]
    (branch,) = sf.response(beam, "f", (370 / turn, 110 / turn), events=events).branches
    (peak,) = branch.special
    assert peak.type == "MAX"
    assert peak.value == pytest.approx(195 / turn, abs=2.5 / turn)
    assert peak.orbit.harmonic_balance(1e-6).passed
    orbit = sf.periodic_orbit(beam.replace(f=195 / turn))
    assert orbit.rms("tip") == pytest.approx(6.709852e-08, rel=1e-3)
    assert orbit.harmonic("tip") == pytest.approx(9.482668e-08, rel=1e-3)


def test_nlvib_s_nonlinear_mode_with_a_friction_node():
    # Example 05: frequencies over that of the mode with the contact held, from 0.954859 to
    # 1.001358 with 21 harmonics, printed in comparison 04 there.
    law = sf.Regularized(sf.Coulomb(mu_k=1.0), e=0.05)
    contact = sf.FrictionContact("a", law, load=5, Vd=0)
    stiffness = [[40, -40], [-40, 640]]
    chain = sf.Structure(np.diag([0.02, 1]), None, stiffness, names="a b", contacts=contact)
    (branch,) = sf.backbone(chain, "b", 10).branches
    frequencies = 2 * np.pi / branch.durations / 640**0.5
    assert frequencies[0] == pytest.approx(1, abs=1e-5)
    assert frequencies.min() == frequencies[-1] == pytest.approx(0.954859, abs=1e-6)
    assert frequencies.max() == pytest.approx(1.001358, abs=2e-4)


@pytest.mark.long
def test_bifurcations_of_a_chain_of_ten_masses():
    size, law = 10, sf.Regularized(sf.Coulomb(mu_k=0.3), e=0.3)
    stiffness = 2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    chain = sf.Structure(
        np.eye(size),
        sf.ProportionalDamping(alpha_M=0.01, beta_K=0.002),
        stiffness,
        elements=sf.CubicSpring("q10", k3=3.0),
        contacts=sf.FrictionContact("q5", law, load=0.02, Vd=0),
        forcing=sf.HarmonicForce("q1", F=0.6),
    )
    lowest = 2 * np.sin(np.pi / 22)
    branch = followed(chain, lowest, 1.2 * lowest)
    assert sorted(point.type for point in branch.special) == ["LP", "LP", "NS", "NS"]
    agree(branch, 6)


def damped(law, load=0.3, force=1.0, f=0.9 / (2 * np.pi)):
    """One mass with a damper and a contact with a wall."""
    contact = sf.FrictionContact("q1", law, load=load, Vd=0, name="wall")
    forcing = sf.HarmonicForce("q1", F=force)
    return sf.Structure([[1]], [[0.05]], [[1]], contacts=contact, forcing=forcing, f=f)


def energies(orbit):
    """Energies of a cycle in J: put in, lost in the damper, lost in the contact."""
    names = ("power_forcing", "power_damping", "power_friction_wall")
    return [orbit.mean(name) * orbit.duration for name in names]


def test_the_energy_of_a_cycle_is_lost_in_damper_and_contact():
    orbit = sf.periodic_orbit(damped(sf.Regularized(sf.Coulomb(mu_k=0.5), e=0.1)))
    given, damper, contact = energies(orbit)
    assert given == pytest.approx(damper + contact, rel=1e-12)
    _, speed = orbit.output("vq1", 1024)
    _, force = orbit.output("Fx_wall", 1024)
    assert contact == pytest.approx(-(speed * force).mean() * orbit.duration, rel=1e-12)
    linear = sf.periodic_orbit(damped(sf.Regularized(sf.Coulomb(mu_k=1e-9), e=0.1)))
    amplitude = abs(1 / (1 - 0.81 + 0.045j))
    assert energies(linear)[1] == pytest.approx(np.pi * 0.05 * 0.9 * amplitude**2, rel=1e-6)


@pytest.mark.parametrize("load", [0.3, 1.6])
def test_dry_friction_loses_four_times_force_and_amplitude(load):
    # Den Hartog, Forced vibrations with combined Coulomb and viscous friction, Transactions of the
    # ASME 53 (1931) 107-115: between its turning points the friction force is constant. The larger
    # load makes the mass stick there.
    orbit = sf.periodic_orbit(damped(sf.Coulomb(mu_k=0.5), load=load))
    assert (orbit.stuck_fraction > 0) == (load > 1)
    given, damper, contact = energies(orbit)
    moved = orbit.extrema_of("q1")
    swing = float(np.ravel(moved.maximum)[0] - np.ravel(moved.minimum)[0])
    assert contact == pytest.approx(2 * 0.5 * load * swing, rel=1e-6)
    assert given == pytest.approx(damper + contact, rel=1e-6)
