"""Models of a user's own, as files, for the explorer."""

HOSTILE = """
name = "hostile"
title = "<img src=x onerror=alert(1)>"
[parameters]
W = { value = 1.2, unit = "rad/s", above = 0, doc = "<b>forcing</b>", symbol = "<i>W</i>" }
F = { value = 0.2, doc = "<script>alert(2)</script>" }
[states]
q = { rate = "v", label = "<u>q</u>" }
v = { rate = "F*cos(W*t) - 0.2*v - q" }
[forcing]
period = "2*pi/W"
amplitude = "F"
"""
"""A model whose texts are markup; the page must show them as they are."""

BRAKE = """
name = "brake"
[structure]
names = ["tip"]
M = [[0.05]]
C = [[0.4]]
K = [[2000.0]]
[[contacts]]
along = "tip"
friction = { law = "Stribeck", mu_s = 0.6, mu_k = 0.3, vs = 0.4 }
load = 5
Vd = "2 m/s"
"""
"""The structure of the README: nothing forces it."""

STIFFNESS = "%%MatrixMarket matrix coordinate real symmetric\n1 1 1\n1 1 2000.0\n"
BRAKE_OF_FILE = BRAKE.replace("[[2000.0]]", '"K.mtx"')
"""The same with its stiffness in a file, K.mtx."""

RAYLEIGH = """
name = "rayleigh"
parameters = { omega = 1.0, eps = 0.5 }
[states]
x = "v"
v = "eps*v*(1 - v^2) - omega^2*x"
"""
"""An oscillator that vibrates by itself; at eps = 0 there are cycles of every amplitude."""

MANY = [f"parameter_{number}" for number in range(70)]

UNUSUAL = f"""
name = "two pads / disc, {"as measured " * 6}"
[states]
q = {{ rate = "v" }}
v = {{ rate = "{MANY[1]}*cos({MANY[0]}*t) - v - q*({"+".join(MANY)})/70" }}
[forcing]
period = "2*pi/{MANY[0]}"
amplitude = "{MANY[1]}"
[parameters]
""" + "".join(f"{name} = 1\n" for name in MANY)
"""A model with a long name that is no name of a file, and more parameters than usual."""
