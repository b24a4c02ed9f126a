/** The page: puts its parts together and starts them. */

import { BasinsPanel } from "./basins.js";
import { Connection } from "./connection.js";
import { DiagramControls, Elsewhere, Pins, SpecialPoints } from "./diagram_panel.js";
import { DiagramPlot } from "./diagram_plot.js";
import { element, roving } from "./dom.js";
import { ModelEditor, readLink } from "./model/editor.js";
import { FollowMotion } from "./following.js";
import { FrictionPanel } from "./model/friction.js";
import { Announcer, Notices, StatusLine, TextDialog } from "./messages.js";
import { OrbitPanel } from "./orbit.js";
import { ParameterPanel } from "./parameters.js";
import { PlaneControls, PlaneSwitch, Regimes } from "./plane_panel.js";
import { PlanePlot } from "./plane_plot.js";
import { Measurements, MeasurementsControl } from "./measurements.js";
import { Refusals, Session } from "./session.js";
import { Simulation, SimulationPanel } from "./simulation.js";
import { Study, StudyPanel } from "./study.js";
import { pictureOf, sheetOf } from "./svg_file.js";
import { Sweep } from "./sweep.js";
import { loadPlotly, plotly } from "./plot_tools.js";
import { apply, colors } from "./theme.js";
import { ExportMenu, Toolbar } from "./toolbar.js";
import { TOUR_MODEL, Tour, isFirstVisit } from "./tour.js";
import { addressOf, diagramRequest, initialView, planeRequest } from "./view.js";

const PICTURE_SCALE = 2;

start();

async function start() {
  apply();
  forgetToken();
  const answers = await Promise.all(["/api/models", "/api/study"].map((address) => fetch(address)));
  const refused = answers.find(({ ok }) => !ok);
  if (refused) {
    document.getElementById("page").replaceChildren(
      element("p", { class: "notice failure", role: "alert" }, await refused.text()));
    return;
  }
  const [models, study] = await Promise.all(answers.map((answer) => answer.json()));
  build(models, study, await readLink(location.hash.slice(1), models));
}

/** The token has done its work; it must not stay in the address that people copy. */
function forgetToken() {
  const address = new URL(location.href);
  address.searchParams.delete("token");
  history.replaceState(null, "", address);
}

function build(models, study, { view: given, sentence }) {
  const socket = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`;
  const connection = new Connection(socket);
  const session = new Session(models, given ?? initialView(models[0]), connection);
  const refusals = new Refusals(session);
  const notices = new Notices();
  const status = new StatusLine(session, notices);
  const dialog = new TextDialog();
  const announcer = new Announcer(session);
  const say = (...sentence) => notices.say(...sentence);
  const page = { dialog, say, meanwhile: () => session.requests.meanwhile() };
  const measurements = new Measurements(session);
  const sweep = new Sweep(session);
  const diagram = new DiagramPlot(session, measurements, sweep);
  const orbits = new OrbitPanel(session);
  const regimes = new Regimes(session);
  const simulation = new Simulation(session);
  const plane = new PlanePlot(session, regimes, simulation);
  const simulations = new SimulationPanel(session, simulation, sweep, diagram, orbits, page);
  const tour = new Tour(session, { simulation });
  const editor = new ModelEditor(session, page);
  const friction = new FrictionPanel(session, page);
  const menus = {
    diagram: new ExportMenu("diagram", {
      isCommand: true,
      request: () => session.diagram && diagramRequest(session.view),
      picture: (format) => plotted(diagram, format),
      pins: () => session.view.pins.map(({ name, parameters }) =>
        ({ name, parameters: diagramRequest(session.view, parameters).parameters })),
      measurements: () => (measurements.of(session.view) ? measurements.file : null),
    }, page),
    plane: new ExportMenu("plane", {
      isCommand: true,
      request: () => session.view.plane && planeRequest(session.view),
      picture: (format) => plotted(plane, format),
    }, page),
    orbit: new ExportMenu("orbit", {
      request: (format) => orbits.shown && orbits.requestFor(format),
      picture: (format) => drawn(orbits.title.textContent, orbits.figures, format),
    }, page),
    simulation: new ExportMenu("simulation", {
      isCommand: true,
      request: () => (simulation.state.ends.length > 0 ? { ...simulation.request, show: session.view.show } : null),
      picture: (format) => drawn(simulation.title, simulations.figures, format),
    }, page),
  };
  const pins = new Pins(session);
  const measured = new MeasurementsControl(session, measurements);
  const planeControls = new PlaneControls(session);
  const panels = {
    parameters: panel("parameters", "Parameters", [], new ParameterPanel(session, refusals, friction.node).node),
    diagram: panel("diagram", "Response", [roving(element("div", { class: "tools", role: "toolbar", "aria-label": "Response" },
      pins.node, measured.node, new PlaneSwitch(session).node, menus.diagram.node))],
      new DiagramControls(session).node, diagram.node,
      element("div", { class: "below" }, element("div", { class: "legends" }, pins.legend, measured.legend),
        element("div", { class: "foot" }, new SpecialPoints(session).node, new Elsewhere(session).node)), keyHelp()),
    plane: panel("plane", "Plane", [plane.checked.node, planeControls.progress, plane.simulate, menus.plane.node], planeControls.node,
      element("div", { class: "plane-body" }, plane.node, element("div", { class: "plane-side" },
        plane.legend.node, planeControls.note, plane.pointed.node, regimes.node))),
    orbit: panel("orbit", "Orbit", [orbits.title, menus.orbit.node], orbits.node),
    simulation: panel("simulation", "Simulation", [new FollowMotion(session, simulation).node, menus.simulation.node],
      simulations.node),
    basins: panel("basins", "Basins", [], new BasinsPanel(session, simulation).node),
  };
  const studies = study ? [studyPanel(session, new Study(study), page)] : [];
  const curves = element("div", { class: "curves" }, panels.diagram, panels.plane);
  const main = element("main", {}, ...studies, curves, panels.orbit, panels.simulation, panels.basins);
  document.getElementById("page").replaceChildren(
    new Toolbar(session, { status: status.node, say, tour, editor }).node, notices.node, panels.parameters, main,
    editor.node, tour.node, dialog.node, announcer.node);
  const showPlane = () => {
    panels.plane.hidden = !session.view.plane;
    main.classList.toggle("no-plane", !session.view.plane);
  };
  showPlane();
  session.store.changed.subscribe(showPlane);
  keepAddress(session, refusals);
  reportDefects(session);
  session.failed.announce({ kind: "link", sentence });
  connection.changed.subscribe(loadPlotly);
  connection.open();
  session.start();
  refusals.ask();
  friction.ask();
  if (!given && isFirstVisit() && session.view.model === TOUR_MODEL) tour.start();
  plotly.then(() => { document.getElementById("page").dataset.started = ""; });
}

function studyPanel(session, study, page) {
  const shown = new StudyPanel(session, study);
  const picture = (format) => plotted(shown, format);
  const menu = new ExportMenu("study", { picture, table: () => study.table() }, page);
  return panel("study", "Study", [shown.title, menu.node], ...shown.nodes);
}

function panel(id, title, tools, ...children) {
  const heading = `${id}-heading`;
  return element("section", { class: "panel", id, "aria-labelledby": heading },
    element("div", { class: "panel-head" }, element("h2", { id: heading }, title), ...tools),
    ...children);
}

function keyHelp() {
  return element("p", { class: "unseen", id: "diagram-keys" },
    "Left and right arrow keys move the working point, up and down change the branch.");
}

/**
 * The address follows the view, and the view an address that is typed or pasted; of values that the
 * model cannot have there is none.
 */
function keepAddress(session, refusals) {
  let written = "";
  let asked = "";
  let good = null;
  const write = (address) => {
    written = address;
    history.replaceState(null, "", `#${written}`);
  };
  const follow = () => write(addressOf(session.view, session.model));
  session.store.changed.subscribe(({ live }) => live || refusals.isAny || follow());
  refusals.changed.subscribe(() => {
    if (!refusals.isAny) {
      follow();
      good = written;
    } else if (good !== null) write(good);
  });
  window.addEventListener("hashchange", async ({ newURL }) => {
    // What is written before this is heard replaces the link in the address, not in the event.
    const text = new URL(newURL).hash.slice(1);
    if (text === written) return;
    asked = text;
    const page = document.getElementById("page");
    page.setAttribute("aria-busy", "true"); // a model may be built first
    const { view, sentence } = await readLink(text, session.models);
    if (text !== asked) return; // a newer link was read sooner
    page.setAttribute("aria-busy", "false");
    session.failed.announce({ kind: "link", sentence });
    if (view) session.store.commit(view);
  });
}

/** Report errors of a page that has started; start_failure.js reports those before. */
function reportDefects({ failed }) {
  const report = (what) => failed.announce({ kind: "page", sentence: `This is a defect of the page: ${what}.` });
  // A plot whose size changes while sizes are reported is drawn at the next opportunity.
  window.addEventListener("error", ({ error }) => error && report(error));
  window.addEventListener("unhandledrejection", ({ reason }) => report(reason));
}

async function plotted(plot, format) {
  const { data, layout } = plot.figure();
  const { width, height } = layout;
  const scale = format === "png" ? PICTURE_SCALE : 1;
  const address = await window.Plotly.toImage({ data, layout }, { format, width, height, scale });
  if (format === "svg") {
    const text = decodeURIComponent(address.slice(address.indexOf(",") + 1));
    return new Blob([text], { type: "image/svg+xml" });
  }
  const bytes = Uint8Array.from(atob(address.slice(address.indexOf(",") + 1)), (c) => c.charCodeAt(0));
  return new Blob([bytes], { type: "image/png" });
}

async function drawn(title, figures, format) {
  const sheet = sheetOf(title, figures, colors());
  return format === "svg" ? new Blob([sheet.text], { type: "image/svg+xml" }) : pictureOf(sheet);
}
