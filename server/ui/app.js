// The lookdev page: what is edited, and a live render that follows. An edit goes to the service as a PATCH, which stops the picture
// under way; the next comes back at once at a part of the resolution, then whole, then with more and more samples.
import { readExr } from "./exr.js";
import { localRows, pixelRows } from "./inspect.js";
import { Live } from "./live.js";
import { drawMixer } from "./mixer.js";
import { Network } from "./network.js";
import { drawControls } from "./parameters.js";
import { Picture } from "./picture.js";

const $ = (id) => document.getElementById(id);
const state = { graph: { version: 1, nodes: {}, outputs: {} }, undo: [], types: new Map(), edit: 0, samples: 0, pinned: null };

// ---- the service ----------------------------------------------------------------------------------------------------

async function ask(path, options = {}) {
  const answer = await fetch(path, options);   // who is logged in has a cookie
  if (answer.status === 401 && !$("login").open) $("login").showModal();
  if (answer.ok) return answer;
  const problem = await answer.json().catch(() => ({ title: "the service answered " + answer.status }));
  throw Object.assign(new Error(problem.title ?? problem.detail), { problem });
}

async function loadTypes() {
  for (let next = ""; next !== null;) {
    const page = await (await ask("/v1/nodes" + (next ? "?cursor=" + encodeURIComponent(next) : ""))).json();
    for (const type of page.items) for (const name of [type.name, ...(type.aliases ?? [])]) state.types.set(name, type);
    next = page.next ?? null;
  }
}

// ---- pictures -------------------------------------------------------------------------------------------------------

const size = () => Number($("size").value);
const most = () => Number($("samples").value);
/** Names of layers recorded beside the beauty. */
const wantedLayers = () => ($("with-layers").checked ? ["shading", "data", ...Object.keys(state.graph.outputs?.aovs ?? {})] : []);
const picture = new Picture({ canvas: $("canvas"), frame: $("frame") }, look, () => !state.pinned && $("pixel").replaceChildren());

const live = new Live(ask, {
  frame(image, { samples, divisor, edits, latency }) {
    picture.full = [size(), size()];
    picture.show(image);
    const shown = Math.max(Number($("status").dataset.shown ?? 0), ...edits.map(Number));
    if (latency !== null) state.latency = latency;
    const part = divisor > 1 ? ` at 1/${divisor} of the resolution` : "";
    $("status").textContent = `${size()} × ${size()}${part}, ${samples} of ${most()} samples · edit to picture ${(state.latency ?? 0).toFixed(0)} ms`;
    Object.assign($("status").dataset, { shown, samples });
    if (divisor === 1 && samples >= most()) $("status").dataset.edit = shown;
    if (state.layersWanted !== undefined && divisor === 1) askLayers();
    if (divisor === 1 && samples >= most() && state.pinned) inspect();
  },
  document(j) {
    drawMixer($("mixer"), j.light_groups, (name, weight) => edited({ settings: { mix: { [name]: weight } } }));
    if (j.layers.length) layersMenu(j.layers);
  },
  answer(j) {
    showErrors([]);
    const warnings = j.warnings ?? [];
    $("warnings").textContent = warnings.length ? `${warnings.length} warnings: ${warnings.map((w) => `${w.pointer}: ${w.found ?? w.code}`).join(" · ")}` : "";
    if (j.render) live.on.document(j.render);
    state.layersWanted = true;
  },
  fault(e, token) {
    showErrors(e.problem?.errors?.length ? e.problem.errors : [{ detail: e.problem?.detail ?? e.message }]);
    $("status").textContent = "the picture is of the last graph that could be rendered";
    $("status").dataset.edit = token;
  },
  restarted() { $("status").textContent = "the service has been started again"; },
});

async function askLayers() {
  state.layersWanted = undefined;
  live.on.document(await live.document());
}

function showErrors(errors) {
  $("errors").hidden = errors.length === 0;
  $("errors").textContent = errors.map((e) => {
    const says = e.expected ? `found ${e.found ?? "nothing"}, expected ${e.expected}` : e.detail ?? e.message ?? e.code ?? "";
    return [e.pointer, says, e.suggest ? `did you mean ${e.suggest}?` : ""].filter(Boolean).join(" · ");
  }).join("\n");
}

function layersMenu(layers) {
  const names = layers.map((n) => (n === "rgba" ? "" : n)), menu = $("layer");
  if ([...menu.options].map((o) => o.value).join() === names.join()) return;
  menu.replaceChildren(...names.map((n) => new Option(n || "beauty", n, false, n === picture.layer)));
  if (!names.includes(picture.layer)) setLayer(0);
}

/** The pointer is over a pixel: the values at hand at once, all of them when it rests there; with what made them when it is chosen. */
function look(x, y, fullX, fullY, chosen) {
  if (chosen) state.pinned = state.pinned && state.pinned[0] === fullX && state.pinned[1] === fullY ? null : [fullX, fullY];
  clearTimeout(state.resting);
  if (state.pinned) return void (chosen && inspect());
  $("pixel").replaceChildren(...localRows(picture.image, x, y, fullX, fullY));
  state.resting = setTimeout(async () => {
    const pixel = live.id && (await live.pixel(fullX, fullY, false).catch(() => null));
    if (pixel && !state.pinned) $("pixel").replaceChildren(...pixelRows(pixel, (n) => network.select(n)));
  }, 120);
}
async function inspect() {
  const [x, y] = state.pinned;
  try {
    $("pixel").replaceChildren(...pixelRows(await live.pixel(x, y, true), (n) => network.select(n)));
    $("pixel").dataset.pinned = `${x},${y}`;
  } catch (e) {
    showErrors([{ detail: e.message }]);
  }
}

// ---- edits ----------------------------------------------------------------------------------------------------------

const network = new Network($("graph"), (name) => drawNode(name), (type) => {
  const t = state.types.get(type);
  return t?.closure ? "closure" : t?.category === "texture" || t?.category === "input" ? t.category : "other";
});

/** what: {graph}, {graph, operations} or {settings}, as Live.edit takes them. */
function edited(what) {
  live.edit(++state.edit, what);
}
const pointer = (...names) => names.map((n) => "/" + n.replaceAll("~", "~0").replaceAll("/", "~1")).join("");

function drawNode(name) {
  const node = state.graph.nodes[name], type = node && state.types.get(node.type);
  $("node-title").textContent = node ? `${name}` : "Parameters";
  $("node-summary").textContent = node ? `${node.type}: ${type?.summary ?? type?.help ?? ""}` : "Choose a node of the network.";
  if (!node) return $("controls").replaceChildren();
  drawControls($("controls"), state.graph, name, (t) => state.types.get(t), (parameter, value, isDrag, redraw) => {
    // One step back for a whole drag of a slider.
    const key = name + "/" + parameter, now = performance.now();
    if (!isDrag || state.lastKey !== key || now - state.lastTime > 800) state.undo.push(JSON.stringify(state.graph));
    Object.assign(state, { lastKey: key, lastTime: now });
    const operations = [], path = pointer("nodes", name, "params", parameter);
    if (!node.params) operations.push({ op: "add", path: pointer("nodes", name, "params"), value: {} });
    node.params ??= {};
    if (value !== undefined) operations.push({ op: "add", path, value });
    else if (parameter in node.params) operations.push({ op: "remove", path });
    if (value === undefined) delete node.params[parameter];
    else node.params[parameter] = value;
    if (redraw) {
      network.draw(state.graph);
      drawNode(name);
    }
    edited({ graph: state.graph, operations });
  }, (other) => network.select(other));
}

function setGraph(graph, keepUndo) {
  if (!graph || typeof graph.nodes !== "object" || graph.nodes === null) throw new Error("not a graph document: it has no nodes");
  if (!keepUndo) state.undo = [];
  state.graph = graph;
  const root = graph.outputs?.surface?.node ?? Object.keys(graph.nodes)[0] ?? null;
  network.selected = keepUndo && network.selected in graph.nodes ? network.selected : root;
  network.draw(graph);
  drawNode(network.selected);
  // Layers that only this graph has.
  const aovs = wantedLayers(), more = live.id && aovs.join() !== live.aovs ? { settings: { aovs } } : {};
  live.aovs = aovs.join();
  edited({ graph, ...more });
}

function undo() {
  const last = state.undo.pop();
  if (last) setGraph(JSON.parse(last), true);
}

async function openFile(file) {
  try {
    if (file.name.toLowerCase().endsWith(".exr")) {   // a picture to compare with
      picture.kept = await readExr(await file.arrayBuffer());
      keptA(file.name);
      return;
    }
    const document = JSON.parse(await file.text());
    setGraph(document.graph ?? document);
  } catch (e) {
    showErrors([{ detail: `${file.name}: ${e.message}` }]);
  }
}

/** A link that leads back to this graph: kept by the service under its digest. */
async function copyLink() {
  const bytes = new TextEncoder().encode(JSON.stringify(state.graph)), digest = await crypto.subtle.digest("SHA-256", bytes);
  const name = "sha256:" + [...new Uint8Array(digest)].map((b) => b.toString(16).padStart(2, "0")).join("");
  await ask("/v1/assets/" + name, { method: "PUT", body: bytes, headers: { "Content-Type": "application/octet-stream" } });
  location.hash = name;
  await navigator.clipboard.writeText(location.href);
  $("status").textContent = "copied: a link to this graph";
}

function save(name, type, content) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([content], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// ---- controls of the page -------------------------------------------------------------------------------------------

function setExposure(value) {
  $("exposure").value = value;
  picture.exposure = Number($("exposure").value);
  $("exposure-value").textContent = picture.exposure;
  picture.draw();
}
function setLayer(index) {
  const menu = $("layer");
  menu.selectedIndex = (index + menu.options.length) % menu.options.length;
  picture.layer = menu.value;
  live.show(picture.layer);
  picture.draw();
}
function keptA(what) {
  $("wipe").disabled = false;
  $("status").textContent = `${what} is A: slide A|B to compare`;
}
function keepA() {
  picture.keep();
  keptA("this picture");
}
function setWipe(value) {
  $("wipe").value = value;
  picture.wipe = Number(value);
  picture.draw();
}

$("example").addEventListener("change", async () => setGraph(await (await ask("/ui/examples/" + $("example").value)).json()));
$("stage").addEventListener("change", () => edited({ settings: { stage: $("stage").value } }));
$("size").addEventListener("change", () => edited({ settings: { resolution: [size(), size()] } }));
$("samples").addEventListener("change", () => edited({ settings: { max_samples: most() } }));
$("with-layers").addEventListener("change", () => {
  live.aovs = wantedLayers().join();
  edited({ settings: { aovs: wantedLayers() } });
});
$("layer").addEventListener("change", () => setLayer($("layer").selectedIndex));
$("exposure").addEventListener("input", () => setExposure($("exposure").value));
$("wipe").addEventListener("input", () => setWipe($("wipe").value));
$("keep").addEventListener("click", keepA);
$("open").addEventListener("click", () => $("file").click());
$("file").addEventListener("change", () => $("file").files[0] && openFile($("file").files[0]));
$("save-json").addEventListener("click", () => save("graph.json", "application/json", JSON.stringify(state.graph, null, 1)));
$("save-exr").addEventListener("click", async () => live.id && save("picture.exr", "image/x-exr", await live.exr()));
$("copy-link").addEventListener("click", () => copyLink().catch((e) => showErrors([{ detail: e.message }])));
$("copy-curl").addEventListener("click", async () => {
  const aovs = wantedLayers(), request = { graph: state.graph, stage: $("stage").value, size: size(), samples: most(), ...(aovs.length ? { aovs } : {}) };
  const body = JSON.stringify(request).replaceAll("'", "'\\''");
  await navigator.clipboard.writeText(`curl -sS ${location.origin}/v1/preview -H 'Accept: image/x-exr' -o picture.exr --json '${body}'`);
  $("status").textContent = "copied: a curl command that makes this picture";
});
$("help").addEventListener("click", () => {
  $("help-text").hidden = !$("help-text").hidden;
  $("help").setAttribute("aria-expanded", String(!$("help-text").hidden));
});
$("login").addEventListener("close", async () => {
  try {
    await ask("/v1/login", { method: "POST", body: JSON.stringify({ token: $("token").value }), headers: { "Content-Type": "application/json" } });
    $("token").value = "";
    start();
  } catch (e) {
    showErrors([{ detail: e.message }]);
  }
});
document.addEventListener("dragover", (e) => e.preventDefault());
document.addEventListener("drop", (e) => {
  e.preventDefault();
  if (e.dataTransfer.files[0]) openFile(e.dataTransfer.files[0]);
});
document.addEventListener("keydown", (e) => {
  if (e.key === "z" && (e.ctrlKey || e.metaKey) && e.target.tagName !== "TEXTAREA") {
    e.preventDefault();
    return undo();
  }
  if (e.ctrlKey || e.metaKey || e.altKey || ["INPUT", "SELECT", "TEXTAREA"].includes(e.target.tagName)) return;
  const act = {
    "+": () => picture.setZoom(picture.zoom * 1.25), "=": () => picture.setZoom(picture.zoom * 1.25), "-": () => picture.setZoom(picture.zoom * 0.8), 0: () => picture.setZoom(1),
    "[": () => setExposure(picture.exposure - 0.25), "]": () => setExposure(picture.exposure + 0.25),
    ",": () => setLayer($("layer").selectedIndex - 1), ".": () => setLayer($("layer").selectedIndex + 1),
    a: keepA, w: () => picture.kept && setWipe(picture.wipe > 0 ? 0 : 50),
    i: () => picture.lookAt(0.5, 0.5, true),
  }[e.key];
  if (!act) return;
  e.preventDefault();
  act();
});

/** The graph that the address names, else the first example. */
async function firstGraph(examples) {
  const name = location.hash.slice(1);
  return (await ask(/^sha256:[0-9a-f]{64}$/.test(name) ? "/v1/assets/" + name : "/ui/examples/" + examples[0].file)).json();
}

async function start() {
  try {
    const about = await (await ask("/ui/examples")).json();
    await loadTypes();
    $("stage").replaceChildren(...about.stages.map((s) => new Option(s, s)));
    $("example").replaceChildren(...about.examples.map((e) => new Option(e.title, e.file)));
    const graph = await firstGraph(about.examples);
    live.body = { stage: $("stage").value, resolution: [size(), size()], max_samples: most(), aovs: wantedLayers() };
    setGraph(graph);
  } catch (e) {
    showErrors([{ detail: e.message }]);
  }
}
start();
