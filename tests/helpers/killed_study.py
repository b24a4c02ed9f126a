"""A study killed again and again; run as a program, which prints what became of it as JSON.

    python killed_study.py FOLDER KILLS

Everything is imported once, and no thread has started: each attempt is a copy of this process.
"""

import json
import os
import random
import signal
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.studies import CHEAP, content
from slipfold import study

LONGEST = 0.25
"""Seconds after which an attempt is killed at the latest."""


def main():
    folder, kills = Path(sys.argv[1]), int(sys.argv[2])
    moments = random.Random(8)
    killed = finished = 0
    while killed < kills:
        attempt = os.fork()
        if not attempt:
            study(CHEAP, folder / f"{finished}.study", resume=True)
            os._exit(0)
        time.sleep(moments.uniform(0, LONGEST))
        os.kill(attempt, signal.SIGKILL)
        _, status = os.waitpid(attempt, 0)
        if os.WIFSIGNALED(status):
            killed += 1
        else:  # it was done before; another one is started
            assert os.WEXITSTATUS(status) == 0
            finished += 1
    undisturbed = content(study(CHEAP), folder)
    results = [
        content(study(CHEAP, folder / f"{number}.study", resume=True), folder)
        for number in range(finished + 1)
    ]
    same = [found == undisturbed for found in results]
    print(json.dumps({"killed": killed, "studies": len(results), "same": same}))


if __name__ == "__main__":
    main()
