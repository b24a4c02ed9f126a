"""Twenty pages at once: each gets its newest request answered."""

import threading

import pytest

from helpers.explorer_server import diagram


def drag(explorer, number, faults):
    """Move a slider by three steps; note what goes wrong."""
    try:
        with explorer.client() as client:
            for place in range(3):
                value = 12.4 + 0.001 * (7 * number + place)
                client.send(diagram(place, parameters={"f": value}))
            faults += [item["error"] for item in client.until_done(2) if "error" in item]
    except Exception as error:  # whatever it is, the test shall say it
        faults.append(repr(error))


@pytest.mark.long
def test_every_client_has_its_newest_request_answered(explorer):
    with explorer.client() as client:
        client.ask(diagram())
    processes, faults = explorer.workers.processes, []
    threads = [threading.Thread(target=drag, args=(explorer, n, faults)) for n in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert faults == []
    assert explorer.workers.processes == processes
