"""A system of equations as the text of its file."""

TEXT = """\
name = "Duffing"
title = "a cubic spring"
[parameters]
W = { value = 0.9, unit = "rad/s", above = 0, doc = "forcing frequency" }
F = 0.18
g = { value = 0.1, max = 10 }
[formulas]
cubic = "g*q^3"
force = "F*cos(W*t)"
stiff = "1 + 0*g"
[states]                      # name = its rate
q = { rate = "v", doc = "displacement", start = 0.5 }
v = "force - 0.05*v - stiff*q - cubic"
[forcing]
period = "2*pi/W"
amplitude = "F"
[outputs]
energy = "v^2/2 + q^2/2 + g/4*q^4"
force = { formula = "force", unit = "N", doc = "force", label = "$F$" }
[limits]
"too far" = { output = "energy", bound = -1.0, reason = "energy fell to {value:.3g}" }
[events]
large = { output = "q", value = 2, measure = "max", stop = true }
"""
