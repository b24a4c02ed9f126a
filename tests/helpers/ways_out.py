"""What leaves the explorer's page: each item of a panel's menu, held against what is shown."""

import re
from pathlib import Path
from xml.etree import ElementTree

import slipfold as sf
from helpers.copied import has_orbit, run_command, run_python, same_orbit, same_result
from slipfold.interface.explorer.curves import diagram_view, plane_view

KEEP = """
() => {
  Object.assign(window, { answers: {}, swept: [] });
  const parse = JSON.parse;
  JSON.parse = (text) => {
    const message = parse(text);
    const { kind, slot, verdict, samples, more, run, done } = message ?? {};
    if (kind === "sweep" && run) swept.push(message);
    const isWhole = slot === "live" && (verdict || samples || (done && !more));
    if (isWhole) answers[kind] = { ...answers[kind], ...message };
    return message;
  };
}
"""
"""Keep what was answered last about each panel, and all places of a sweep."""

RENDERED = """
async () => {
  const { begun, decoded, lengthOf } = await import("/page/sound.js");
  const { samples, rate, repeats } = answers.sound;
  const sound = { values: decoded(samples), rate, repeats };
  const context = new OfflineAudioContext(1, Math.ceil(lengthOf(sound) * 44100), 44100);
  begun(context, sound);
  const values = (await context.startRendering()).getChannelData(0);
  const rising = values.filter((value, i) => i > 0 && values[i - 1] < 0 && value >= 0).length;
  const peak = values.reduce((largest, value) => Math.max(largest, Math.abs(value)), 0);
  const ends = [values[0], values.at(-1)].map(Math.abs);
  return { rising, peak, ends, seconds: lengthOf(sound) };
}
"""
"""Play what was sent last into a context without a loudspeaker."""

RESULTS = {"diagram": "diagram", "plane": "result", "simulation": "solution"}
"""Names of results in copied scripts."""


def menu(page, panel, item):
    """Open the menu of a panel; return an item of it."""
    page.get_by_label(f"Export the {panel}").first.click()
    return page.locator(f"#{panel} .menu").get_by_text(item, exact=True)


def saved(page, panel, item):
    """Save a panel; return the file's path."""
    with page.expect_download() as waiting:
        menu(page, panel, item).click()
    return waiting.value.path()


def copied(page, panel, item):
    """Copy a panel; return the text."""
    menu(page, panel, item).click()
    return read(page)


def read(page):
    """Read a dialog with a text, and close it."""
    dialog = page.locator(".text-dialog[open]")
    text = dialog.locator("pre").inner_text()
    dialog.get_by_role("button", name="Close").click()
    return text


def leave(page, panel, shown):
    """Take every way out of a panel; return what was saved as netCDF."""
    items = page.locator(f"#{panel} .menu button").all_text_contents()
    files = {item: saved(page, panel, item) for item in items if not item.startswith("Copy")}
    for item, path in files.items():
        if ", " in item:
            is_whole(path.read_bytes(), item.split(", ")[-1])
    result = sf.load(files["netCDF"])
    has_numbers(panel, result, shown)
    names = run_python(copied(page, panel, "Copy as Python"))
    if panel == "orbit":
        same_orbit(names, shown)
        cells = re.split("[,\n]", files["CSV"].read_text())
        assert {*map(repr, result.state.tolist())} <= {*cells}
        return result
    result.to_csv("own.csv")
    assert files["CSV"].read_bytes() == Path("own.csv").read_bytes()
    same_result(names[RESULTS[panel]], result)
    # A curve may end before an end of its own.
    same_result(run_command(copied(page, panel, "Copy as TOML"), ends=(0, 3)), result)
    return result


def has_numbers(panel, result, shown):
    """Compare what was saved with what is shown."""
    match panel:
        case "diagram":
            same_branches(diagram_view(result, shown["y"]["name"], shown["y"]["statistic"]), shown)
        case "plane":
            view = plane_view(result)
            assert {name: shown[name] for name in view} == view
        case "orbit":
            has_orbit(result, shown)
        case "simulation":
            assert result.states[-1].tolist() == [*shown["last"].values()]
            assert result.settlement.message == shown["verdict"]


def same_branches(one, other):
    """Compare two diagrams as they are drawn; where a limit of time ended one, what both have."""
    if one["checked"] and other["checked"]:  # none is without checks but what was ended
        assert one["branches"] == other["branches"]
        return
    drawn = [{(it["statistic"], it["id"]): it for it in view["branches"]} for view in (one, other)]
    shared = set()
    for key in drawn[0].keys() & drawn[1].keys():
        pair = [branches[key] for branches in drawn]
        lines = [[*zip(it["x"], it["y"], strict=True)] for it in pair]
        assert lines[0] == lines[1] or any(map(is_cut, pair))
        shared |= {*lines[0]} & {*lines[1]}
    assert shared


def is_cut(branch):
    return "interrupted" in {branch[end]["kind"] for end in ("started", "stopped")}


def same_bifurcations(one, other):
    """Compare them where other steps lead along the branches."""
    are_whole = bool(one["checked"] and other["checked"])
    for mine, theirs in zip(one["branches"], other["branches"], strict=are_whole):
        if is_cut(mine) or is_cut(theirs):
            continue
        kinds = [[mark["type"] for mark in branch["special"]] for branch in (mine, theirs)]
        assert kinds[0] == kinds[1]
        for first, second in zip(mine["special"], theirs["special"], strict=True):
            apart = abs(first["value"] - second["value"])
            # Each computed uncertainty is a sample of its error.
            assert apart <= 30 * (first["uncertainty"] + second["uncertainty"]) + 1e-13


ENDS = {"PNG": (b"\x89PNG", b"IEND\xaeB`\x82"), "PDF": (b"%PDF", b"%%EOF")}
"""How pictures of a format begin and end."""


def is_whole(picture, form):
    if form == "SVG":
        assert len(ElementTree.fromstring(picture))
        return
    begin, end = ENDS[form]
    assert picture.startswith(begin)
    assert picture.rstrip().endswith(end)
