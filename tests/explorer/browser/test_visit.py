"""The first visit is guided; anyone can read the page; a lost connection comes back."""

import re

from playwright.sync_api import expect

from helpers.explorer_page import DIAGRAM, places, violations

WIDTHS = {"light": (900,), "dark": (1920,)}
PLOTS = "#diagram .plot, #plane .plot, #orbit .stage, #orbit .smalls"

ON_ITS_LINE = """
() => {
  const [line, dot] = ["path.line", ".cursors .dot"]
    .map((what) => document.querySelector(`#plot-phase ${what}`));
  const [x, y] = dot.getAttribute("d").match(/[\\d.]+/g).map(Number);
  return line.isPointInStroke(new DOMPoint(x, y));
}
"""
"""Whether the moving dot of the phase portrait is where the orbit is drawn."""


def without_a_file(route):
    """Answer as if the command had been given no model of one's own, which else comes first."""
    models = route.fetch().json()
    route.fulfill(json=sorted(models, key=lambda model: model["name"] != "sliding"))


FORGETS = """
if (!sessionStorage.visited) localStorage.removeItem("slipfold-tour-seen");
sessionStorage.visited = "yes";
"""
"""Before the page is loaded first, as if nobody had seen the tour."""


def test_the_first_visit_is_guided(own_tab):
    explorer, page = own_tab, own_tab.page
    page.set_viewport_size({"width": 1366, "height": 768})
    page.add_init_script(FORGETS)
    page.route("**/api/models", without_a_file)
    page.goto(explorer.address)
    page.wait_for_selector(f"{DIAGRAM}[aria-busy=false]")
    assert explorer.specials()[0] == "PD 0.04358\u202fN supercritical"
    assert "token" not in page.url
    tour = page.get_by_role("dialog")
    expect(tour.locator("h2")).to_have_text("A tip on a moving plate")
    expect(tour).to_be_in_viewport(ratio=1)
    undo = page.get_by_label("Undo (Ctrl+Z)")
    expect(undo).to_be_enabled()  # it leaves the tour
    steps = int(tour.locator(".count").inner_text().split()[-1])
    texts, rest = [], places(explorer, PLOTS)
    for step in range(1, steps + 1):
        expect(tour.locator(".count")).to_have_text(f"{step} of {steps}")
        assert places(explorer, PLOTS) == rest
        if tour.locator("h2").inner_text() in ("The threshold", "Criticality"):
            expect(tour).to_contain_text("= 0.")
        texts.append(tour.locator("p").inner_text())
        if tour.locator("h2").inner_text() == "Speed of the plate":
            pinned = [p.input_value() for p in page.get_by_label("Name of the pinned curve").all()]
            assert len(pinned) == 3
            assert ", ".join(pinned) in texts[-1]
        tour.locator(".main").click()
    expect(tour).to_be_hidden()
    assert places(explorer, PLOTS) == rest
    assert "Nd = 0.0436" in texts[1] or "Nd = 0.04358" in texts[1]
    # It is not forced on anyone twice, but it can be had again, and left.
    assert page.evaluate("localStorage.getItem('slipfold-tour-seen')") == "yes"
    page.reload()
    page.wait_for_selector(f"{DIAGRAM}[data-drawn]")
    expect(tour).to_be_hidden()
    page.get_by_role("button", name="Tour").click()
    page.get_by_role("button", name="Next").click()
    page.get_by_role("button", name="Skip the tour").click()
    expect(tour).to_be_hidden()
    shown = page.url
    undo.click()
    page.wait_for_url(lambda address: address != shown)  # what was there before the tour
    expect(undo).to_be_disabled()
    page.get_by_role("button", name="Tour").click()
    undo.click()
    expect(tour).to_be_hidden()
    page.get_by_role("button", name="Tour").click()
    assert violations(page, ".tour") == []  # last, since it skips what follows


def test_it_can_be_read_in_both_themes_and_every_width(new_tab):
    explorer, page = new_tab, new_tab.page
    explorer.open("model=sliding&p.Nd=0.3")
    explorer.orbit_shown(2)
    for theme, widths in WIDTHS.items():
        page.emulate_media(color_scheme=theme, reduced_motion="reduce")
        page.wait_for_function(
            "(name) => document.documentElement.dataset.theme === name", arg=theme
        )
        for width in widths:
            page.set_viewport_size({"width": width, "height": 900})
            page.wait_for_function(
                "([selector, width]) => { const plot = document.querySelector(selector); return"
                " innerWidth === width && plot.layout.width === plot.parentNode.clientWidth; }",
                arg=[f"{DIAGRAM} .plot-canvas", width],
            )
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert page.evaluate(ON_ITS_LINE)
    page.get_by_role("button", name="Edit the model").click()
    page.set_viewport_size({"width": 400, "height": 800})
    editor = page.locator("#editor")
    for button in editor.get_by_role("button").all():
        box = button.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 400
    page.get_by_role("button", name="Equations").click()
    assert violations(page, "#editor") == []  # last, since it skips what follows


def test_a_lost_connection_comes_back(own_tab):
    explorer, sockets = own_tab, []

    def through(socket):
        sockets.append(socket)
        socket.connect_to_server()

    explorer.page.route_web_socket("**/ws", through)
    explorer.open()
    state = explorer.page.locator(".connection")
    expect(state).to_have_text("connected")
    states = explorer.page.evaluate_handle(
        "() => { const seen = []; const node = document.querySelector('.connection');"
        " const look = new MutationObserver(() => seen.push(node.textContent));"
        " look.observe(node, { childList: true });"
        " return seen; }"
    )
    sockets[0].close()
    explorer.page.wait_for_function("(seen) => seen.at(-1) === 'connected'", arg=states)
    assert "reconnecting" in states.json_value()
    assert len(sockets) == 2
    with explorer.redrawn():
        explorer.type("f", 12.2)
    assert explorer.specials()[0] == "PD 0.1398\u202fN subcritical"


def test_a_stopped_server_is_said_and_not_waited_for(own_tab):
    explorer, page, sockets = own_tab, own_tab.page, []
    server = {"is there": True}

    def through(socket):
        sockets.append(socket)
        if server["is there"]:
            socket.connect_to_server()
        else:
            socket.close()

    page.route_web_socket("**/ws", through)
    # Attempts are farther and farther apart: a fifth of the time is long enough.
    page.add_init_script(
        "const wait = setTimeout; window.setTimeout = (what, time) => wait(what, time / 5);"
    )
    explorer.open()
    state, notice = page.locator(".connection"), page.get_by_role("alert")
    server["is there"] = False
    page.route("**/api/models", lambda route: route.abort())
    sockets[-1].close()
    expect(state).to_have_text("no server")
    expect(notice).to_contain_text("Start it again and open the address that it prints")
    explorer.type("f", 12.2)
    expect(page.locator(f"{DIAGRAM} .waiting")).to_contain_text("Not computed")
    # It was started anew: its token is another one, until its address is opened.
    page.unroute("**/api/models")
    page.route("**/api/models", lambda route: route.fulfill(status=401))
    expect(state).to_have_text("not let in")
    expect(notice).to_contain_text("Open the address that it printed")
    page.unroute("**/api/models")
    server["is there"] = True
    with explorer.redrawn():
        expect(state).to_have_text("connected")
    expect(notice).to_have_count(0)
    assert explorer.specials()[0] == "PD 0.1398\u202fN subcritical"
    assert all("ERR_FAILED" in fault or "401" in fault for fault in explorer.faults)
    explorer.faults.clear()


def test_what_takes_long_says_how_far_it_is(new_tab):
    def slow(answer):
        head = {name: answer[name] for name in ("kind", "id", "slot")}
        words = {"progress": "branch 2, 37 points", "value": 0.25}
        return {**head, **words, "done": False}

    answers = new_tab.holding(lambda answer: answer["kind"] == "diagram", slow)
    explorer = new_tab.open()
    answers.is_on = True
    explorer.slide("Vd", 0.66)
    explorer.release("Vd")
    waiting = explorer.page.locator(f"{DIAGRAM} .waiting")
    # The branches may be there already, and those of other motions be sought.
    stages = "Computing the (rest of the )?response|Following what motions settle on elsewhere"
    expect(waiting).to_have_text(re.compile(f"({stages})… branch 2, 37 points, Nd = 0.25\u202fN"))
    explorer.page.get_by_label("Vary", exact=True).select_option("f")
    explorer.page.locator(".specials .chip").first.click()  # of the diagram over Nd, still there
    assert explorer.parameter("f") == 12.5
    answers.let_go()
    expect(waiting).to_be_hidden()
