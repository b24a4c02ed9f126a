"""The engine: it follows curves of solutions, whatever they are solutions of.

It knows no orbit and no model. To follow something new takes a `Curve`, its equations, and the
monitors that say what is looked for along it:

- `newton` solves equations with one linear constraint, `walk` takes one step after the other;
- `search` and `locate` find the zeros between two points, none missed;
- `traced_curve` holds a curve while it is followed and what its monitors report;
- `follow` brings one curve to its end;
- `curve_set` follows all that begin on one another, each once.
"""
