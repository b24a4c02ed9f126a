"""The engine: it follows curves of solutions, whatever they are solutions of.

It knows no orbit and no model. To follow something new takes a `Curve`, its equations, and the
monitors that say what is looked for along it:

- `newton` solves equations with one linear constraint, `walk` takes one step after the other;
- `search` and `locate` find what lies between two points, none missed;
- `monitor` says what is watched and what a hit does: it is recorded, or the curve ends there;
- `follow` brings one curve to its end, as a `Trail`;
- `atlas` follows all that begin on one another, each once.
"""

from slipfold.continuation.algebraic_curve import AlgebraicCurve as AlgebraicCurve
from slipfold.continuation.atlas import Atlas as Atlas
from slipfold.continuation.atlas import Chart as Chart
from slipfold.continuation.atlas import Start as Start
from slipfold.continuation.curve import Curve as Curve
from slipfold.continuation.end import End as End
from slipfold.continuation.follow import Endings as Endings
from slipfold.continuation.follow import follow as follow
from slipfold.continuation.monitor import Monitor as Monitor
from slipfold.continuation.monitor import Zeros as Zeros
from slipfold.continuation.point import Point as Point
from slipfold.continuation.search import Found as Found
from slipfold.continuation.trail import Sight as Sight
from slipfold.continuation.trail import Stop as Stop
from slipfold.continuation.trail import Stretch as Stretch
from slipfold.continuation.trail import Trail as Trail
