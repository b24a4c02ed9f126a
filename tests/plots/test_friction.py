"""Figures of friction laws show the law's own numbers."""

import numpy as np
import pytest

from slipfold import Coulomb, InputError, LuGre, Stribeck
from slipfold.plots.contacts import draw_friction


def beside(ax):
    [other] = [item for item in ax.get_figure().axes if item is not ax]
    return other


def test_coefficient_and_slope_are_those_of_the_law(ax):
    law = Stribeck(mu_s=0.6, mu_k=0.4, vs=0.2, exponent=2, s2=0.1)
    assert law.plot(ax=ax, fastest=1.5) is ax
    speed, coefficient = ax.get_lines()[0].get_data()
    assert (speed[0], speed[-1]) == (0.0, 1.5)
    assert coefficient == pytest.approx(law.coefficient(speed), rel=1e-15)
    assert beside(ax).get_lines()[0].get_ydata() == pytest.approx(law.slope(speed), rel=1e-15)
    assert ax.get_xlabel() == "slip speed (m/s)"
    assert ax.get_ylabel() == r"friction coefficient $\mu$"
    assert "(s/m)" in beside(ax).get_ylabel()
    assert ax.get_title() == "exponential Stribeck"


def test_falling_friction_is_shaded(ax):
    law = Stribeck(mu_s=0.6, mu_k=0.4, vs=0.2, exponent=2, s2=0.1)
    law.plot(ax=ax)
    shaded = np.concatenate([path.vertices[:, 0] for path in ax.collections[0].get_paths()])
    speeds = np.linspace(1e-3, 1.2, 2000)
    falling = speeds[law.slope(speeds) < 0]
    assert shaded.max() == pytest.approx(falling.max(), abs=5e-3)
    ax.clear()
    Coulomb().plot(ax=ax)
    assert not ax.collections[0].get_paths()


def test_a_bar_shows_what_a_contact_at_rest_bears(ax):
    draw_friction(Coulomb(mu_s=0.7, mu_k=0.4), ax)
    assert ax.get_lines()[1].get_ydata() == pytest.approx([0, 0.7])
    assert ax.get_ylim()[1] > 0.7
    ax.clear()
    draw_friction(LuGre(), ax)
    assert len(ax.get_lines()) == 1


@pytest.mark.parametrize("fastest", [0, -1.0, np.nan, np.inf])
def test_a_speed_that_is_none_is_refused(fastest):
    with pytest.raises(InputError, match="give a positive number"):
        Coulomb().plot(fastest=fastest)
