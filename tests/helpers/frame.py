"""The file of a structure with parts of all kinds."""

TEXT = """\
name = "frame"
[structure]
M = { diagonal = [1, 2] }
K = [[200, -100], [-100, 100]]
names = "root tip"
length_scale = "10mm"
[damping]
type = "ModalDamping"
ratios = 0.01
[reduction]
type = "CraigBampton"
boundary = ["tip"]
modes = 1
[[elements]]
type = "CubicSpring"
at = "tip"
k3 = 1e4
[[elements]]
type = "GeometricSpring"
name = "tie"
at = "root"
axis = [0, 1]
k = "2 kN/m"
L = "5mm"
[[contacts]]
along = "tip"
friction = { law = "Stribeck", mu_s = 0.4, vs = "20 cm/s" }
load = { type = "ModulatedLoad", Ns = 2, Nd = 0.5 }
Vd = 0.5
[[forcing]]
type = "MultiHarmonicForce"
name = "shaker"
at = { tip = 1, root = -1 }
harmonics = { 0 = 0.1, 1 = 0.5, 3 = [0.1, "90deg"] }
[watch]
u = { root = 1 }
[parameters]
f = "1.5 Hz"
"""
