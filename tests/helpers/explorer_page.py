"""The explorer's page in a browser, driven as a reader would, and what is seen on it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from contextlib import contextmanager

import pytest
from playwright.sync_api import Page, expect

PATIENCE = 90_000
"""Milliseconds to wait for what a busy machine computes; what passes does not wait for them."""

expect.set_options(timeout=PATIENCE)

DIAGRAM = "#diagram .plot"
ORBIT = ".orbit"
PLANE = ".plane-plot"

FOLLOW = """
async (fragment) => {
  if (location.hash.slice(1) === fragment) return;
  const heard = new Promise((resolve) => addEventListener("hashchange", resolve, { once: true }));
  location.hash = fragment;
  await heard;
}
"""
"""Give the page a link, which it may still read."""

CONTROLS = "button, input, select, summary, label, h2, p, figure, .plot, .small-plot, .unit"

PLACES = """
(selector) => {
  const [down, right] = [scrollY, scrollX];
  const named = (node) =>
    node.id || node.getAttribute("aria-label") || node.textContent.slice(0, 30);
  return [...document.querySelectorAll(selector)]
    .filter((node) => !node.closest(".tip, .unseen"))
    .map((node) => [node, node.getBoundingClientRect()])
    .map(([node, { x, y, width, height }]) =>
      [node.tagName, named(node), x + right, y + down, width, height]);
}
"""


def places(explorer, selector=CONTROLS):
    """Where every control and heading is, without its text: the pictures' titles may change."""
    found = explorer.page.evaluate(PLACES, selector)
    return [(tag, *numbers) for tag, _, *numbers in found]


@contextmanager
def served(case, workers=2):
    """Run the command on a file; give the address that it prints."""
    command = [sys.executable, "-m", "slipfold.interface.cli", "explore", str(case), "--no-browser"]
    command += ["--workers", str(workers)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            yield next(
                found[0] for line in server.stdout if (found := re.search(r"http://\S+", line))
            )
        finally:
            server.terminate()
            server.communicate()


COLORS = {"runOnly": ["color-contrast", "link-in-text-block"]}


def violations(page, where=None):
    """What axe-core finds: the rule and the elements; of the second theme only what colors decide.

    A test is skipped without it.
    """
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe-core")
    found = []
    for theme, only in (("dark", {}), ("light", COLORS)):
        page.emulate_media(color_scheme=theme, reduced_motion="reduce")
        options = {"resultTypes": ["violations"], **only}
        for item in axe.Axe().run(page, where, options).response["violations"]:
            found.append((theme, item["id"], [node["html"][:120] for node in item["nodes"]]))
    return found


class HeldBack:
    """Answers of the server that wait on their way to the page."""

    def __init__(self, matches=None, instead=None):
        self.matches = matches
        self.instead = instead
        self.is_on = False
        self.asked = []
        self.waiting = []

    def through(self, socket):
        def pass_on(text):
            if self.is_on and self.matches(json.loads(text)):
                self.waiting.append(lambda: socket.send(text))
                if self.instead:
                    socket.send(json.dumps(self.instead(json.loads(text))))
            else:
                socket.send(text)

        self.say = lambda answer: socket.send(json.dumps(answer))

        def ask(text):
            self.asked.append(json.loads(text))
            server.send(text)

        server = socket.connect_to_server()
        server.on_message(pass_on)
        socket.on_message(ask)

    def let_go(self):
        self.is_on = False
        while self.waiting:
            self.waiting.pop(0)()


class ExplorerPage:
    """One tab with the explorer."""

    held = HeldBack()

    def __init__(self, page: Page, address: str):
        self.page = page
        self.address = address
        self.faults: list[str] = []
        self.is_loaded = False
        page.set_default_timeout(PATIENCE)
        page.on("pageerror", lambda error: self.faults.append(str(error)))
        page.on("console", self._note)

    def _note(self, message):
        if message.type in ("error", "warning"):
            self.faults.append(message.text)

    def holding(self, matches, instead=None):
        """Return what holds back answers of the server for which a function is true.

        To be called before the page is loaded. What comes instead is made from what is held back.
        """
        if self.held is ExplorerPage.held:
            self.page.route_web_socket("**/ws", lambda socket: self.held.through(socket))
        self.held = HeldBack(matches, instead)
        return self.held

    def open(self, fragment="model=sliding", plane=False):
        """Open a link to a view, without its plane unless it is requested, and wait for the curve.

        A page that is loaded takes the link over, as if it were pasted.
        """
        self.page.bring_to_front()  # a tab behind another one draws once a second
        suffix = "" if plane or not fragment else "&plane=none"
        if self.is_loaded:
            self.page.evaluate(FOLLOW, fragment + suffix)
        else:
            self.page.goto(f"{self.address}#{fragment}{suffix}")
            self.is_loaded = True
        self.page.wait_for_function(
            "(selector) => document.querySelector(selector)?.ariaBusy === 'false'"
            " && document.querySelector('#page').ariaBusy !== 'true'",
            arg=DIAGRAM,
            polling=50,  # at every frame it takes a twentieth of a processor
        )
        return self

    @contextmanager
    def redrawn(self):
        """Wait until another diagram is on the screen, and it is the whole response."""
        before = self.drawn
        yield
        self.page.wait_for_function(
            "([selector, before]) => { const plot = document.querySelector(selector);"
            " return plot.dataset.drawn !== before && plot.ariaBusy === 'false'; }",
            arg=[DIAGRAM, before],
            polling=50,
        )

    @property
    def drawn(self):
        """Number of the diagram on the screen."""
        return self.page.locator(DIAGRAM).get_attribute("data-drawn")

    def slider(self, name):
        return self.page.locator(f"#parameter-{name}-slider")

    def box(self, name):
        return self.page.locator(f"#parameter-{name}-box")

    def slide(self, name, value, *events):
        """Move a slider and do not let go of it; or go on with further events at once."""
        self.slider(name).evaluate(
            "(slider, [value, ...events]) => { slider.value = value;"
            " events.forEach((name) => slider.dispatchEvent(new Event(name))); }",
            [value, "input", *events],
        )

    def release(self, name):
        """Let go of a slider."""
        self.slider(name).evaluate("(slider) => slider.dispatchEvent(new Event('change'))")

    def type(self, name, value):
        """Write a value into the box of a parameter."""
        self.box(name).fill(str(value))
        self.box(name).press("Enter")

    def specials(self):
        """Texts of the list of special points."""
        return self.page.locator(".specials .chip").all_inner_texts()

    def traces(self):
        """Lines of the diagram that have points: name, dashes, first point."""
        return self.page.evaluate(
            "(selector) => document.querySelector(selector).data"
            ".filter((trace) => trace.mode === 'lines' && trace.x.length > 0)"
            ".map(({ name, line, x, y }) => ({ name, dash: line.dash, x, y }))",
            f"{DIAGRAM} .plot-canvas",
        )

    def strengths(self, name):
        """Opacities of the lines of a curve, once plotly has drawn it."""
        self.page.locator(f"{DIAGRAM}:not(.moving)").wait_for()
        return set(
            self.page.evaluate(
                "([selector, name]) => document.querySelector(selector).data"
                ".filter((trace) => trace.name?.startsWith(`${name}, `))"
                ".map(({ opacity }) => opacity ?? 1)",
                [f"{DIAGRAM} .plot-canvas", name],
            )
        )

    def ranges(self):
        """What the axes of the diagram show."""
        return self.page.evaluate(
            "(selector) => { const { xaxis, yaxis } = document.querySelector(selector).layout;"
            " return [...xaxis.range, ...yaxis.range]; }",
            f"{DIAGRAM} .plot-canvas",
        )

    def pixel(self, x, y):
        """Where data of the diagram are on the screen."""
        box = self.page.locator(f"{DIAGRAM} .nsewdrag").bounding_box()
        left, right, low, high = self.ranges()
        return (
            box["x"] + (x - left) / (right - left) * box["width"],
            box["y"] + (1 - (y - low) / (high - low)) * box["height"],
        )

    def mark(self, text):
        """Where in the diagram a special point is, by what stands beside it."""
        return self.page.evaluate(
            "([selector, text]) => document.querySelector(selector).data"
            ".filter(({ text }) => text)"
            ".flatMap((trace) => trace.text.map((name, i) => [name, trace.x[i], trace.y[i]]))"
            ".find(([name]) => name.trim() === text).slice(1)",
            [f"{DIAGRAM} .plot-canvas", text],
        )

    def orbit_shown(self, period):
        """Wait for an orbit of a period; return the value of the parameter it is at."""
        self.page.wait_for_selector(f"{ORBIT}[data-period='{period}'][aria-busy=false]")
        return float(self.page.locator(ORBIT).get_attribute("data-drawn"))

    def parameter(self, name):
        return float(self.box(name).input_value())
