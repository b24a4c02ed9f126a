/**
 * What the page shows, as plain data that never changes: each change makes a new view. All numbers
 * are in SI units.
 *
 * @typedef {object} View
 * @property {string} model
 * @property {Record<string, number>} parameters all of them; that which is varied has the value at
 *   which the orbit is shown
 * @property {string} vary the parameter along the diagram
 * @property {[number, number]} span
 * @property {string} show the state or output drawn
 * @property {"max"|"min"|"peak_to_peak"|"modulus"} statistic what is drawn of it
 * @property {{branch: number, y: number}|null} at which of the orbits at that value, if chosen
 * @property {Pin[]} pins
 * @property {{x: Axis, y: Axis}|null} plane
 * @property {Zoom|null} zoom the part of the diagram that is seen
 * @typedef {{id: number, name: string, parameters: Record<string, number>}} Pin
 * @typedef {{name: string, span: [number, number]}} Axis
 * @typedef {{x: [number, number], y: [number, number]}} Zoom
 */

/** Where along a diagram the working point is at first, if the model does not say. */
const FIRST = 0.3;

/** What a diagram may show of an output, with the words for it. */
export const STATISTICS = {
  max: "max",
  min: "min",
  peak_to_peak: "peak to peak",
  modulus: "max |·|",
};

/**
 * The view of a model that was just picked.
 * @param {object} model as the server describes it
 * @returns {View}
 */
export function initialView(model) {
  const { vary, span, show, statistic = "modulus", parameters = {} } = model.default;
  const values = Object.fromEntries(model.parameters.map((item) => [item.name, item.value]));
  const given = { ...values, ...parameters };
  given[vary] = within(given[vary], span);
  return {
    model: model.name,
    parameters: given,
    vary,
    span,
    show,
    statistic,
    at: null,
    pins: [],
    plane: model.plane ?? null,
    zoom: null,
  };
}

/** A view with one parameter changed. */
export function withParameter(view, name, value) {
  return { ...view, parameters: { ...view.parameters, [name]: value } };
}

/** A view along another parameter. */
export function withVaried(view, vary, span) {
  return { ...view, vary, span, at: null, zoom: null };
}

/** A view with one more pinned curve. */
export function withPin(view, name) {
  const id = 1 + Math.max(0, ...view.pins.map((pin) => pin.id));
  return { ...view, pins: [...view.pins, { id, name, parameters: view.parameters }] };
}

/** A view without a pinned curve. */
export function withoutPin(view, id) {
  return { ...view, pins: view.pins.filter((pin) => pin.id !== id) };
}

/** A view with a pinned curve renamed. */
export function withPinName(view, id, name) {
  return { ...view, pins: view.pins.map((pin) => (pin.id === id ? { ...pin, name } : pin)) };
}

/**
 * The request for the diagram of a view.
 * @param {View} view
 * @param {Record<string, number>} [parameters] those of a pinned curve
 */
export function diagramRequest(view, parameters = view.parameters) {
  const { model, vary, span, show, statistic } = view;
  return { kind: "diagram", model, parameters: without(parameters, vary), vary, span, show, statistic };
}

/**
 * The request for an orbit on the diagram of a view.
 * @param {View} view
 * @param {import("../diagram/working_point.js").Place} place
 */
export function orbitRequest(view, { branch, arclength, x, isTurn = false, special }) {
  const { model, vary, span } = view;
  const parameters = without(view.parameters, vary);
  const at = isTurn || special ? { branch, arclength } : { branch, arclength, value: x };
  return { kind: "orbit", model, parameters, vary, span, at };
}

/** The request for the plane of a view. */
export function planeRequest(view) {
  const { x, y } = view.plane;
  const parameters = without(without(view.parameters, x.name), y.name);
  return { kind: "plane", model: view.model, parameters, x, y };
}

/**
 * The request for a simulation at the working point of a view.
 * @param {View} view
 * @param {{start: "rest"|Record<string, number>, nudge?: Record<string, number>, periods: number}} how
 */
export function simulationRequest(view, how) {
  return { kind: "simulation", model: view.model, parameters: view.parameters, ...how };
}

/**
 * The request for the exponents of a motion at the working point of a view.
 * @param {View} view
 * @param {{start: "rest"|Record<string, number>, nudge?: Record<string, number>}} how
 */
export function exponentsRequest(view, how) {
  return { kind: "exponents", model: view.model, parameters: view.parameters, ...how };
}

/**
 * The request for the basins of attraction at the working point of a view.
 * @param {View} view
 * @param {Axis} x of a state
 * @param {Axis} y of another
 */
export function basinsRequest({ model, parameters }, x, y) {
  return { kind: "basins", model, parameters, x, y };
}

/** A value, or the nearest one in a span. */
export function inside(value, [a, b]) {
  return Math.min(Math.max(value, Math.min(a, b)), Math.max(a, b));
}

/** A working point that shows something: not at the very end of the diagram. */
function within(value, [a, b]) {
  const isInner = value > Math.min(a, b) && value < Math.max(a, b);
  return isInner ? value : a + (b - a) * FIRST;
}

function without(values, name) {
  const { [name]: _, ...rest } = values;
  return rest;
}
