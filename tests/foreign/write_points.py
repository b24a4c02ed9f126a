"""Find the special points of the foreign systems by SciPy, and write them to points.json.

Where to look is read off a response and rounded to eight digits; what is written is what SciPy
finds from there, and by how much it differs with another tolerance.

    python tests/foreign/write_points.py NAME ...
"""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.foreign_systems import POINTS, cases
from helpers.points_by_scipy import points_near


def main(names):
    known = json.loads(POINTS.read_text()) if POINTS.exists() else {}
    for case in cases():
        if case.system not in names:
            continue
        diagram = case.response(case.methods[0])
        known[str(case)] = {
            "points": points_near(case, diagram),
            "ends": sorted(branch.stopped.kind for branch in diagram.branches),
        }
        print(case, json.dumps(known[str(case)]), flush=True)
        lines = (f"{json.dumps(key)}: {json.dumps(item)}" for key, item in sorted(known.items()))
        POINTS.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main(sys.argv[1:] or {case.system for case in cases()})
