"""Normal forms: what happens near a bifurcation, from higher derivatives of maps and fields."""
