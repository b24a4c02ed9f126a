"""From moving a slider of the explorer to the new curve on the screen, in headless Chromium.

    python bench/latency.py --moves 60

The base case (Fig. 2 of the paper) with all special points; each move waits until the one before is
on the screen, as a reader's eye does. The first curve after a move may be the one before, moved
there: see docs/how-to/explorer.md. "followed" is the time until the one that continuation follows;
"locus" and "plane" are those from opening the page until its plane has a curve, and all of them.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time

import machine
from slipfold.version import package_version

PLOT = "#diagram .plot"

MOVE = """
([selector, name, values]) => {
  const plot = document.querySelector(selector);
  const slider = document.querySelector(`#parameter-${name}-slider`);
  const painted = (isWanted) => new Promise((resolve) => {
    const listen = ({ detail }) => {
      if (!isWanted(detail)) return;
      plot.removeEventListener("painted", listen);
      resolve(detail);
    };
    plot.addEventListener("painted", listen);
  });
  const move = async (value) => {
    const last = Number(plot.dataset.drawn), before = slider.value;
    const start = performance.now();
    const next = painted(({ id }) => id > last);
    slider.value = value;
    slider.dispatchEvent(new Event("input"));
    if (slider.value === before) return null; // less than a pixel
    const { id, moved } = await next;
    return { id, moved, first: performance.now() - start, start };
  };
  return (async () => {
    const moves = [];
    for (const value of values) moves.push(await move(value));
    while (moves.includes(null)) moves.splice(moves.indexOf(null), 1);
    const last = moves.at(-1);
    if (last.moved) await painted(({ id, moved }) => id > last.id && !moved);
    const followed = performance.now() - last.start;
    const back = painted(({ id, moved }) => id > last.id && !moved);
    slider.dispatchEvent(new Event("change"));
    document.querySelector(`.parameter[data-name=${name}] .back`).click();
    await back;
    return { moves, followed };
  })();
}
"""

DRAGS = {"f": (12.3, 12.7), "Vd": (0.5, 0.7), "mu": (0.42, 0.58)}
"""Sliders, and between which values they are moved."""


def measure(page, count):
    """Times in ms until the first curve after each move, how many were moved, until the rest."""
    first, moved, followed = [], 0, []
    for name, (low, high) in DRAGS.items():
        steps = [low + (high - low) * i / (count - 1) for i in range(count)]
        result = page.evaluate(MOVE, [PLOT, name, steps])
        first += [move["first"] for move in result["moves"]]
        moved += sum(move["moved"] for move in result["moves"])
        followed.append(result["followed"])
    return first, moved, followed


SPEEDS = (0.6, 0.62, 0.64)
"""Values of Vd with which the page is opened with its plane: the server keeps those it computed."""

HAS_LOCUS = "() => document.querySelector('.plane-legend li')"
IS_WHOLE = "() => Number(document.querySelector('.plane-plot')?.dataset.loci)"


def measure_planes(browser, address):
    """Times in ms from opening a page until its plane has a curve, and until it is whole."""
    locus, whole = [], []
    for speed in SPEEDS:
        page = page_of(browser)
        start = time.perf_counter()
        page.goto(f"{address}#model=sliding&p.Vd={speed}")
        for seen, times in ((HAS_LOCUS, locus), (IS_WHOLE, whole)):
            page.wait_for_function(seen, timeout=300_000)
            times.append(1000 * (time.perf_counter() - start))
        page.close()
    return locus, whole


def page_of(browser):
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.add_init_script("localStorage.setItem('slipfold-tour-seen', 'yes')")
    return page


def address_of(server):
    return next(found[0] for line in server.stdout if (found := re.search(r"http://\S+", line)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--moves", type=int, default=60, help="moves of each slider")
    count = parser.parse_args().moves
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        raise SystemExit("there is no chromium (on Debian: apt-get install chromium).")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise SystemExit("playwright is not installed: pip install playwright.") from None
    as_root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    command = [sys.executable, "-m", "slipfold.interface.cli", "explore", "--no-browser"]
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server,
        sync_playwright() as playwright,
    ):
        try:
            browser = playwright.chromium.launch(executable_path=chromium, args=as_root)
            page, address = page_of(browser), address_of(server)
            page.goto(f"{address}#model=sliding&plane=none")
            page.wait_for_selector(f"{PLOT}[data-drawn]")
            measure(page, 5)
            first, moved, followed = measure(page, count)
            locus, plane = measure_planes(browser, address)
            browser.close()
        finally:
            server.terminate()
    seconds = {"first": first, "followed": followed, "locus": locus, "plane": plane}
    record = {
        "version": package_version(),
        "machine": machine.description(),
        "sliders": list(DRAGS),
        "moved": moved,
        "seconds": {name: [took / 1000 for took in found] for name, found in seconds.items()},
    }
    print(json.dumps(record))


if __name__ == "__main__":
    main()
