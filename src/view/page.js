// The page: its controls, what they mean, and values under the pointer.
const byId = (id) => document.getElementById(id);
const radians = (degrees) => degrees * Math.PI / 180;
const degrees = (angle) => angle * 180 / Math.PI;

const table = new Table(JSON.parse(byId("table").textContent), new Float32Array(bytesIn("flux-samples").buffer));

/** Lit from above alone; and what is not to be chosen, with the value that counts. */
const isOneSided = table.is_stack || table.has_ground;
const fixed = {
  ...(isOneSided && { opposition: 0 }),
  ...(table.has_ground && { ground: 0 }),
  ...(table.is_stack && { density: 0, tint: "grey" }),
};
const scenes = ["sphere", "rings", "slab", "lobes"].filter((name) =>
  !(isOneSided && name === "rings") && !(table.has_ground && name === "slab"));

/** The sliders of each group: id, name, ends and step. */
const sliders = {
  layer: [
    ["depth", "Optical depth <var>τ</var>"],
    ["albedo", "Albedo <var>w</var>"],
    ["density", "Density <var>D</var>", 0, 0.5, 0.01],
    ["opposition", "Opposition effect", 0, 1, 0.05],
    ["ground", "Albedo of the ground", 0, 1, 0.01],
  ],
  sun: [
    ["sun-elevation", "Elevation", -90, 90, 0.5],
    ["sun-azimuth", "Azimuth", -180, 180, 0.5],
  ],
  camera: [
    ["camera-elevation", "Elevation", -90, 90, 0.5],
    ["camera-azimuth", "Azimuth", -180, 180, 0.5],
    ["exposure", "Exposure", -2, 6, 0.25],
  ],
};

/** Optical depths of the rings from the inside outward, as shares of the slider's. */
const ringShares = [0.08, 1, 0.04, 0.4];

/** What a scene begins with, and which controls it has no use for. */
const beginnings = {
  sphere: { "sun-elevation": 20, "sun-azimuth": 50, "camera-elevation": 10, "camera-azimuth": 0, ground: 0, exposure: 0, pointer: [0.55, 0.4], unused: [] },
  rings: { "sun-elevation": 16, "sun-azimuth": 40, "camera-elevation": 20, "camera-azimuth": 0, ground: 0.4, exposure: 1, pointer: [0.2, 0.6], unused: [] },
  slab: { "sun-elevation": 35, "sun-azimuth": 120, "camera-elevation": 32, "camera-azimuth": 20, ground: 0.3, exposure: 1, pointer: [0.5, 0.5], unused: [] },
  lobes: { "sun-elevation": 40, pointer: [0.3, 0.3], unused: ["sun-azimuth", "camera-elevation", "camera-azimuth", "ground", "exposure"] },
};

const notes = {
  sphere: table.has_ground ? "A planet covered by the layer and what lies below it."
    : "A planet of Lambert ground under the layer.",
  rings: `Optical depths from the inside outward: ${ringShares.join(", ")} of τ. Light between planet and rings is left out.`,
  slab: "A cloud over squares of ground, of its albedo and half of it.",
  lobes: "Light from the left. Distance from the middle is R above the layer and T below it, in the plane of incidence.",
};

/** Factors of 1 - w for red, green and blue. */
const tints = { grey: [1, 1, 1], warm: [0.6, 1, 2.2], cold: [2.2, 1, 0.6] };

const times = (s, a) => a.map((x) => s * x);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const normalized = (a) => times(1 / Math.hypot(...a), a);
const direction = (elevation, azimuth) => {
  const [e, a] = [radians(elevation), radians(azimuth)];
  return [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
};

/** As `camera` in scene files: z is up. */
function cameraAt(elevation, azimuth, distance, halfWidth, perspective) {
  const eye = times(distance, direction(elevation, azimuth)), ahead = normalized(times(-1, eye));
  const right = normalized(cross(ahead, Math.abs(ahead[2]) > 1 - 1e-12 ? [0, 1, 0] : [0, 0, 1]));
  return { eye, ahead, right, up: cross(right, ahead), halfWidth, perspective };
}

function formatted(value) {
  if (value === Infinity) return "∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e-3 && size < 1e4 ? String(Number(value.toPrecision(4))) : value.toExponential(2);
}

const state = { scene: null, pointer: [0.42, 0.4], own: {} };
let picture = null;

const setting = (id) => fixed[id] ?? byId(id).value;
const value = (id) => Number(setting(id));

// ---- the layer

/** The slider is log10 of the depth; its end is infinity where the table's is. */
function sliderDepth() {
  const chosen = 10 ** value("depth");
  if (table.depth.endsAtInfinity && chosen > table.depth.highest * 1.001) return Infinity;
  return Math.min(chosen, table.depth.highest);
}

/** The slider is 1 - sqrt(1 - w). */
const sliderAlbedo = () => 1 - (1 - value("albedo")) ** 2;

/** Depths as light sees them: of dense layers tau / (1 - D), no deeper than the table. */
function seenDepths() {
  const depth = sliderDepth() / (1 - value("density"));
  const deepest = table.depth.endsAtInfinity ? Infinity : table.depth.highest;
  const shares = state.scene === "rings" ? ringShares : [1];
  return shares.map((share) => Math.min(share * depth, deepest));
}

function albedos() {
  const range = table.albedo;
  return tints[setting("tint")].map((power) => clamped(1 - (1 - sliderAlbedo()) * power, range.lowest, range.highest));
}

// ---- what is seen

function view() {
  const density = value("density");
  const toSun = direction(value("sun-elevation"), value("sun-azimuth"));
  const shapes = { sphere: [10, 1.1, false], rings: [10, 2.45, false], slab: [12, 0.2, true], lobes: [10, 1, false] };
  return {
    scene: state.scene,
    camera: cameraAt(value("camera-elevation"), value("camera-azimuth"), ...shapes[state.scene]),
    toSun,
    ground: value("ground"),
    white: 2 ** -value("exposure"),
    opposition: { amplitude: density > 0 ? value("opposition") : 0, width: -3 / 8 * Math.log1p(-density) },
  };
}

const drawing = { layers: true, asked: false, finer: 0 };

/** Coarse at once; with smooth edges when nothing has changed for a while, unless that takes long. */
function requestDraw(layersToo) {
  drawing.layers ||= layersToo;
  clearTimeout(drawing.finer);
  if (drawing.asked || !picture) return;
  drawing.asked = true;
  requestAnimationFrame(() => {
    drawing.asked = false;
    const began = performance.now();
    draw(1);
    const isFast = performance.now() - began < 150;  // values read back: the picture is done
    if (isFast && state.scene !== "lobes") drawing.finer = setTimeout(() => draw(2), 200);
  });
}

function draw(samples) {
  if (drawing.layers) picture.setLayers(albedos(), seenDepths());
  drawing.layers = false;
  const isPlot = state.scene === "lobes";
  const canvas = byId(isPlot ? "plot" : "picture");
  const unit = Math.min(window.devicePixelRatio || 1, 2);
  const width = Math.round(byId("frame").clientWidth * unit), gap = Math.round(2 * unit), size = (width - gap) >> 1;
  if (canvas.width !== width || canvas.height !== size) [canvas.width, canvas.height] = [width, size];
  if (isPlot) {
    state.lobes = [false, true].map((all) => picture.lobes(view(), lobeAngles, all));
    drawLobes(canvas, state.lobes, radians(value("sun-elevation")), setting("tint") === "grey");
  } else {
    picture.draw(view(), size, samples);
  }
  showValues();
}

// ---- values under the pointer

const channels = (values) => (values.every((v) => v === values[0]) ? values.slice(0, 1) : values);

const significant = (value, digits) => (value < 1e-3 ? formatted(value) : value.toPrecision(digits));

function cell(id, values, error) {
  const different = values && channels(values);
  const text = values ? different.map((v) => significant(v, different.length > 1 ? 3 : 4)).join(" · ") : "–";
  byId(id).textContent = text;
  if (!values || !error) return;
  const note = document.createElement("small");
  note.textContent = ` ± ${Number((error * Math.max(...values)).toPrecision(1))}`;
  byId(id).append(note);
}

function showValues() {
  if (state.scene === "lobes") return showLobeValues();
  const [x, y] = state.pointer;
  document.querySelectorAll(".mark").forEach((mark, half) => {
    mark.style.left = `${50 * (x + half)}%`;
    mark.style.top = `${100 * y}%`;
  });
  const seen = picture.at(view(), x, y);
  cell("light-once", seen.once.light);
  cell("light-all", seen.all.light);
  const isLayer = seen.side !== undefined;
  byId("value-name").textContent = seen.side === "transmission" ? "Layer: transmission T" : "Layer: reflection R";
  cell("value-once", isLayer && seen.once.value);
  const isThinner = isLayer && seenDepths()[seen.zone] < table.depth.lowest * (1 - 1e-6);  // extrapolated
  cell("value-all", isLayer && seen.all.value, isThinner ? 0 : table.tolerance);
  byId("angles").textContent = isLayer
    ? `incidence ${angle(Math.acos(seen.muIn))}, emission ${angle(Math.acos(seen.muOut))}, azimuth ${angle(seen.azimuth)}, ` +
      `phase angle ${angle(Math.PI - seen.scatteringAngle)}; scattered more often: ${shareAgain(seen)} %` +
      (isThinner ? `; thinner than the table, which begins at depth ${formatted(table.depth.lowest)}` : "")
    : "no lit layer here";
}

const angle = (size) => `${degrees(size).toFixed(1)}°`;

function shareAgain({ once, all }) {
  const total = all.value.reduce((a, b) => a + b, 0), single = once.value.reduce((a, b) => a + b, 0);
  return (total > 0 ? 100 * (1 - single / total) : 0).toFixed(1);
}

function showLobeValues() {
  const [x, y] = state.pointer, turn = Math.atan2(x - 0.5, 0.5 - y);
  const k = Math.floor((turn / (2 * Math.PI) + 1) * lobeAngles) % lobeAngles;
  const [once, all] = state.lobes.map((curves) => curves.map((curve) => curve[k]));
  const isLit = (Math.cos(turn) > 0) === (value("sun-elevation") > 0);
  const muIn = Math.abs(Math.sin(radians(value("sun-elevation"))));
  byId("value-name").textContent = isLit ? "Layer: reflection R" : "Layer: transmission T";
  cell("light-once", times(muIn, once));
  cell("light-all", times(muIn, all));
  cell("value-once", once);
  cell("value-all", all, table.tolerance);
  byId("angles").textContent = `incidence ${angle(Math.acos(muIn))}, direction ${angle(Math.abs(turn))} from the upper normal ` +
    `to the ${turn > 0 ? "forward" : "backward"} side`;
}

// ---- the table's errors

/** The tolerance as a bar and the errors that the bake met as marks, on a logarithmic scale. */
function showErrors() {
  const marks = Object.entries(table.errors).filter(([, error]) => error > 0);
  const place = (error) => 20 + 560 * clamped((Math.log10(error) + 7) / 6, 0, 1);
  const parts = [];
  const part = (name, attributes, text) => parts.push(
    `<${name} ${Object.entries(attributes).map(([k, v]) => `${k}="${v}"`).join(" ")}>${text ?? ""}</${name}>`);
  part("rect", { x: 20, y: 26, width: place(table.tolerance) - 20, height: 14, fill: "var(--bar)", rx: 2 });
  part("text", { x: place(table.tolerance), y: 14, fill: "var(--ink)", "text-anchor": "middle" }, `tolerance ${table.tolerance}`);
  part("path", { d: `M${place(table.tolerance)} 18v26`, stroke: "var(--accent)", "stroke-width": 2 });
  marks.forEach(([, error]) => part("circle", { cx: place(error), cy: 33, r: 4.5, fill: "var(--once)" }));
  for (let power = -7; power <= -1; ++power) {
    part("path", { d: `M${place(10 ** power)} 44v5`, stroke: "var(--soft)" });
    part("text", { x: place(10 ** power), y: 63, fill: "var(--soft)", "text-anchor": "middle" }, `1e${power}`);
  }
  const summary = marks.map(([name, error]) => `${name} ${formatted(Number(error.toPrecision(3)))}`).join(", ") || "0";
  byId("errors").innerHTML = `<svg viewBox="0 0 600 70" role="img" aria-label="Relative errors: tolerance ${table.tolerance}; ${summary}">${parts.join("")}</svg>`;
  const range = (axis) =>
    axis.lowest === axis.highest ? formatted(axis.lowest) : `${formatted(axis.lowest)} to ${formatted(axis.highest)}`;
  byId("facts").textContent = `Relative errors of R and T. Asked for: ${table.tolerance}; met by the bake at random points ` +
    `(dots): ${summary}. ` +
    (table.is_stack ? `In all the optical depth is ${range(table.depth)}, the mean albedo ${range(table.albedo)}; ` :
      `The table covers optical depths ${range(table.depth)}${table.depth.endsAtInfinity ? " and ∞" : ""}, ` +
      `albedos ${range(table.albedo)}; `) +
    `orders ${table.highest_order === 0 ? "all" : "up to " + table.highest_order}.`;
}

function showTitle() {
  const { title, matter } = table;
  byId("title").textContent = title || "A layer that scatters light";
  document.title = `${title || matter} – Stratus`;
  byId("phase-function").textContent = `${matter}. Light is I/F: 1 is a white surface that faces the sun.`;
}

// ---- controls

/** What a slider shows, by id. */
const shown = {
  depth() {
    const depth = sliderDepth(), density = value("density"), seen = depth / (1 - density);
    if (table.depth.endsAtInfinity || seen <= table.depth.highest) return formatted(depth);
    return `${formatted(depth)}, the table ends at ${formatted(table.depth.highest)}`;
  },
  albedo: () => String(Number(sliderAlbedo().toFixed(5))),
  density: () => value("density").toFixed(2),
  opposition: () => (value("density") === 0 && value("opposition") > 0 ? "needs density" : value("opposition").toFixed(2)),
  ground: () => value("ground").toFixed(2),
  exposure: () => `${value("exposure") > 0 ? "+" : ""}${value("exposure")} stops`,
};

function showOutputs() {
  for (const input of document.querySelectorAll("#controls input")) {
    const text = shown[input.id] ? shown[input.id]() : `${Number(input.value).toFixed(1)}°`;
    input.parentElement.querySelector("output").textContent = text;
    input.setAttribute("aria-valuetext", text);
  }
}

/** Sun, camera, ground and exposure are each scene's own. */
function chooseScene(name) {
  const kept = ["sun-elevation", "sun-azimuth", "camera-elevation", "camera-azimuth", "ground", "exposure"];
  if (state.scene) state.own[state.scene] = Object.fromEntries(kept.map((id) => [id, byId(id).value]));
  state.scene = name;
  const { unused, pointer, ...first } = beginnings[name];
  state.pointer = pointer;
  byId("sun-elevation").min = name === "slab" || (name === "lobes" && isOneSided) ? 2 : -90;
  byId("camera-elevation").min = name === "slab" ? 3 : -90;
  for (const [id, start] of Object.entries(state.own[name] ?? first)) byId(id).value = start;
  for (const label of document.querySelectorAll("#controls label")) {
    const { id } = label.querySelector("input, select");
    label.hidden = unused.includes(id) || id in fixed || (table.is_stack && ["depth", "albedo"].includes(id));
  }
  for (const group of document.querySelectorAll("fieldset"))
    group.hidden = [...group.querySelectorAll("label")].every((label) => label.hidden);
  byId("plot").hidden = name !== "lobes";
  byId("picture").hidden = name === "lobes";
  byId("frame").classList.toggle("plotted", name === "lobes");
  byId("hint").hidden = name === "lobes";
  byId("note").textContent = notes[name];
  showOutputs();
  requestDraw(true);
}

function prepareSliders() {
  for (const [group, rows] of Object.entries(sliders))
    byId(group).querySelector("legend").insertAdjacentHTML("afterend", rows.map(([id, name, least = 0, most = 1, step = "any"]) =>
      `<label class="row"><span>${name}</span><output></output>` +
      `<input type="range" id="${id}" min="${least}" max="${most}" step="${step}" value="0"></label>`).join(""));
  const { depth, albedo } = table;
  byId("depth").min = Math.log10(depth.lowest);
  byId("depth").max = Math.log10(depth.highest) + (depth.endsAtInfinity ? 0.1 : 0);
  byId("depth").value = Math.log10(clamped(2, depth.lowest, depth.highest));
  byId("albedo").min = 1 - Math.sqrt(1 - albedo.lowest);
  byId("albedo").max = 1 - Math.sqrt(1 - albedo.highest);
  byId("albedo").value = 1 - Math.sqrt(1 - clamped(0.98, albedo.lowest, albedo.highest));
}

/** Settings after the #: `#scene=rings&depth=0.3`, values as the sliders have them. */
function takeHash() {
  const settings = new URLSearchParams(location.hash.slice(1));
  const scene = settings.get("scene");
  if (scenes.includes(scene)) {
    document.querySelector(`input[name=scene][value=${scene}]`).checked = true;
    chooseScene(scene);
  }
  for (const [id, text] of settings) {
    const control = byId(id);
    if (control && control.matches("#controls input, #controls select")) control.value = text;
  }
  showOutputs();
}

function turn(across, upward) {
  const what = document.querySelector("input[name=drag]:checked").value;
  const sign = what === "camera" ? -1 : 1;
  const azimuth = byId(`${what}-azimuth`), elevation = byId(`${what}-elevation`);
  azimuth.value = (Number(azimuth.value) + sign * across + 540) % 360 - 180;
  elevation.value = Number(elevation.value) + sign * upward;
  showOutputs();
  requestDraw(false);
}

function listenToFrame() {
  const frame = byId("frame");
  let from = null;
  const follow = (event) => {
    const box = frame.getBoundingClientRect(), half = box.width / 2;
    state.pointer = [(event.clientX - box.left) % half / half, (event.clientY - box.top) / box.height];
  };
  frame.addEventListener("pointerdown", (event) => {
    from = [event.clientX, event.clientY];
    frame.setPointerCapture(event.pointerId);
    follow(event);
    if (picture) showValues();
  });
  frame.addEventListener("pointermove", (event) => {
    if (from && state.scene !== "lobes") {
      const degreesPerPixel = 360 / frame.clientWidth;
      turn((event.clientX - from[0]) * degreesPerPixel, -(event.clientY - from[1]) * degreesPerPixel);
      from = [event.clientX, event.clientY];
    } else {
      follow(event);
      if (picture) showValues();
    }
  });
  for (const end of ["pointerup", "pointercancel"]) frame.addEventListener(end, () => { from = null; });
  frame.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: [-3, 0], ArrowRight: [3, 0], ArrowUp: [0, 3], ArrowDown: [0, -3] };
    const step = steps[event.key];
    if (!step || state.scene === "lobes") return;
    event.preventDefault();
    turn(...step);
  });
}

function listen() {
  const layerControls = ["depth", "albedo", "density", "tint"];
  byId("controls").addEventListener("input", (event) => {
    showOutputs();
    requestDraw(layerControls.includes(event.target.id));
  });
  byId("controls").addEventListener("submit", (event) => event.preventDefault());
  byId("scenes").addEventListener("change", (event) => chooseScene(event.target.value));
  listenToFrame();
  new ResizeObserver(() => requestDraw(false)).observe(byId("frame"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => requestDraw(false));
}

function notify(sentence) {
  byId("notice").textContent = sentence;
  byId("notice").hidden = false;
}

/** Without WebGL2, or the means to unpack the table, the page says so. */
async function start() {
  showTitle();
  showErrors();
  prepareSliders();
  for (const radio of document.querySelectorAll("input[name=scene]"))
    radio.parentElement.hidden = !scenes.includes(radio.value);
  const canvas = byId("picture"), gl = Picture.contextOf(canvas);
  if (!gl || typeof DecompressionStream === "undefined") {
    notify(`This browser offers no ${gl ? "DecompressionStream" : "WebGL2"}, without which the page cannot draw. ` +
      (gl ? "A later one does." : "Another browser, or its setting for hardware acceleration, may help."));
    for (const id of ["stage", "controls"]) byId(id).hidden = true;
    return;
  }
  picture = new Picture(gl, table, await Promise.all(table.textures.map(({ name }) => inflated(name))));
  canvas.addEventListener("webglcontextlost", () => notify("The graphics card has stopped drawing this page. Load it again."));
  listen();
  chooseScene("sphere");
  takeHash();
}

const started = start();
