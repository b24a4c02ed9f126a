"""The engine: one curve of solutions after the other, whatever they are solutions of.

It knows no orbit and no model. `Curve` is what it asks of the equations, `walk` takes one step
after the other, `search` and `locate` find what lies between two points.
"""
