"""slipfold's beam on a belt, as a user would write it."""

import beam
import slipfold as sf

__all__ = ["structure"]


def structure(elements: int = beam.ELEMENTS) -> sf.Structure:
    """Deflections and slopes of so many elements, with a contact at the tip."""
    mass, stiffness = beam.matrices(elements)
    names = [f"{kind}{node}" for node in range(1, elements + 1) for kind in "wr"]
    law = sf.Stribeck(mu_s=beam.MU_S, mu_k=beam.MU_K, vs=beam.VS)
    contact = sf.FrictionContact(names[-2], law, load=beam.LOAD, Vd=1.0)
    damping = sf.ProportionalDamping(beam.OF_MASS, beam.OF_STIFFNESS)
    return sf.Structure(mass, damping, stiffness, names=names, contacts=contact)
