"""Twenty pages at once: each gets its newest request answered, and memory stays what it is."""

import threading
from pathlib import Path
from time import monotonic

import pytest

from helpers.explorer_server import diagram

CLIENTS = 20


def drag(explorer, number, faults, is_over):
    """Move a slider as long as is wanted; note what goes wrong."""
    try:
        with explorer.client() as client:
            step = 0
            while step == 0 or not is_over():
                ids = range(3 * step, 3 * step + 3)
                for place in ids:
                    value = 12.4 + 0.001 * ((7 * number + place) % 200)
                    client.send(diagram(place, parameters={"f": value}))
                answers = client.until_done(ids[-1])
                faults += [answer["error"] for answer in answers if "error" in answer]
                step += 1
    except Exception as error:  # whatever it is, the test shall say it
        faults.append(repr(error))


def drag_all(explorer, is_over):
    faults = []
    threads = [
        threading.Thread(target=drag, args=(explorer, number, faults, is_over))
        for number in range(CLIENTS)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return faults


def resident(processes):
    """Memory of the workers in bytes."""
    return sum(
        4096 * int(Path(f"/proc/{process}/statm").read_text().split()[1]) for process in processes
    )


def test_every_client_has_its_newest_request_answered(explorer):
    processes = explorer.workers.processes
    assert drag_all(explorer, is_over=lambda: True) == []
    assert explorer.workers.processes == processes


@pytest.mark.long
def test_a_minute_of_it_neither_fails_nor_fills_the_memory(explorer):
    if not Path("/proc").is_dir():
        pytest.skip("memory is read from /proc")

    def for_seconds(seconds):
        end = monotonic() + seconds
        return lambda: monotonic() > end

    assert drag_all(explorer, for_seconds(30)) == []
    before = resident(explorer.workers.processes)
    assert drag_all(explorer, for_seconds(60)) == []
    after = resident(explorer.workers.processes)
    # What is remembered is bounded: after half a minute it is full.
    assert after < 1.1 * before
