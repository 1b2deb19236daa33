// The lookdev page: what is edited, and the pictures of it. An edit stops the picture under way and asks for the next: first a
// quarter of the pixels, then all of them with more and more samples.
import { readExr } from "./exr.js";
import { Network } from "./network.js";
import { drawControls } from "./parameters.js";
import { Picture } from "./picture.js";

const $ = (id) => document.getElementById(id);
const state = { graph: { version: 1, nodes: {}, outputs: {} }, undo: [], types: new Map(), exr: null, edit: 0, abort: null };
const picture = new Picture({ canvas: $("canvas"), frame: $("frame"), pixel: $("pixel"), mixer: $("mixer") });

// ---- the service ----------------------------------------------------------------------------------------------------

async function ask(path, options = {}) {
  const token = sessionStorage.getItem("token"), headers = { ...options.headers };
  if (token) headers.Authorization = "Bearer " + token;
  const answer = await fetch(path, { ...options, headers });
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
const request = (side, samples, aovs) => ({ graph: state.graph, stage: $("stage").value, size: side, samples, ...(aovs.length ? { aovs } : {}) });
/** Names of layers asked for beside the beauty. */
const wantedLayers = () => ($("with-layers").checked ? ["shading", "data", "light_groups", ...Object.keys(state.graph.outputs?.aovs ?? {})] : []);

async function refine() {
  state.abort?.abort();
  const abort = (state.abort = new AbortController()), edited = performance.now(), most = Number($("samples").value);
  const steps = [[Math.max(32, size() >> 1), 1, []], [size(), 1, []]];
  for (let n = 4; n < most; n *= 4) steps.push([size(), n, []]);
  steps.push([size(), most, wantedLayers()]);
  let first = 0;
  try {
    for (const [side, samples, aovs] of steps) {
      const body = JSON.stringify(request(side, samples, aovs));
      const answer = await ask("/v1/preview", { method: "POST", body, headers: { "Content-Type": "application/json", Accept: "image/x-exr" }, signal: abort.signal });
      const bytes = await answer.arrayBuffer(), image = await readExr(bytes);
      if (abort.signal.aborted) return;
      if (!first) first = performance.now() - edited;
      state.exr = side === size() ? bytes : state.exr;
      picture.show(image);
      layersMenu(image);
      showErrors([]);
      const warnings = Number(answer.headers.get("Alder-Warnings") ?? 0);
      $("status").textContent = `${side} × ${side}, ${samples} of ${most} samples · first picture ${first.toFixed(0)} ms after the edit` + (warnings ? ` · ${warnings} warnings` : "");
      $("status").dataset.samples = samples;
    }
    $("status").dataset.edit = state.edit;
  } catch (e) {
    if (abort.signal.aborted) return;
    showErrors(e.problem?.errors?.length ? e.problem.errors : [{ detail: e.message }]);
    $("status").textContent = "the picture is of the last graph that could be rendered";
    $("status").dataset.edit = state.edit;
  }
}

function showErrors(errors) {
  $("errors").hidden = errors.length === 0;
  $("errors").textContent = errors.map((e) => {
    const says = e.expected ? `found ${e.found ?? "nothing"}, expected ${e.expected}` : e.detail ?? e.message ?? e.code ?? "";
    return [e.pointer, says, e.suggest ? `did you mean ${e.suggest}?` : ""].filter(Boolean).join(" · ");
  }).join("\n");
}

function layersMenu(image) {
  const names = [...image.layers.keys()];
  const menu = $("layer");
  if ([...menu.options].map((o) => o.value).join() === names.join()) return;
  menu.replaceChildren(...names.map((n) => new Option(n || "beauty", n, false, n === picture.layer)));
  if (!names.includes(picture.layer)) picture.layer = menu.value = "";
  picture.draw();
}

// ---- edits ----------------------------------------------------------------------------------------------------------

const network = new Network($("graph"), (name) => drawNode(name), (type) => {
  const t = state.types.get(type);
  return t?.closure ? "closure" : t?.category === "texture" || t?.category === "input" ? t.category : "other";
});

function edited() {
  ++state.edit;
  refine();
}

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
    node.params ??= {};
    if (value === undefined) delete node.params[parameter];
    else node.params[parameter] = value;
    if (redraw) {
      network.draw(state.graph);
      drawNode(name);
    }
    edited();
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
  edited();
}

function undo() {
  const last = state.undo.pop();
  if (last) setGraph(JSON.parse(last), true);
}

async function openFile(file) {
  try {
    const document = JSON.parse(await file.text());
    setGraph(document.graph ?? document);
  } catch (e) {
    showErrors([{ detail: `${file.name}: ${e.message}` }]);
  }
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
  picture.draw();
}
function keepA() {
  picture.keep();
  $("wipe").disabled = false;
  $("status").textContent = "kept as A: slide A|B to compare";
}
function setWipe(value) {
  $("wipe").value = value;
  picture.wipe = Number(value);
  picture.draw();
}

$("example").addEventListener("change", async () => setGraph(await (await ask("/ui/examples/" + $("example").value)).json()));
for (const id of ["stage", "size", "samples", "with-layers"]) $(id).addEventListener("change", edited);
$("layer").addEventListener("change", () => setLayer($("layer").selectedIndex));
$("exposure").addEventListener("input", () => setExposure($("exposure").value));
$("wipe").addEventListener("input", () => setWipe($("wipe").value));
$("keep").addEventListener("click", keepA);
$("open").addEventListener("click", () => $("file").click());
$("file").addEventListener("change", () => $("file").files[0] && openFile($("file").files[0]));
$("save-json").addEventListener("click", () => save("graph.json", "application/json", JSON.stringify(state.graph, null, 1)));
$("save-exr").addEventListener("click", () => state.exr && save("picture.exr", "image/x-exr", state.exr));
$("copy-curl").addEventListener("click", async () => {
  const body = JSON.stringify(request(size(), Number($("samples").value), wantedLayers())).replaceAll("'", "'\\''");
  await navigator.clipboard.writeText(`curl -sS ${location.origin}/v1/preview -H 'Accept: image/x-exr' -o picture.exr --json '${body}'`);
  $("status").textContent = "copied: a curl command that makes this picture";
});
$("help").addEventListener("click", () => {
  $("help-text").hidden = !$("help-text").hidden;
  $("help").setAttribute("aria-expanded", String(!$("help-text").hidden));
});
$("login").addEventListener("close", () => {
  sessionStorage.setItem("token", $("token").value);
  start();
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
  }[e.key];
  if (!act) return;
  e.preventDefault();
  act();
});

async function start() {
  try {
    const about = await (await ask("/ui/examples")).json();
    await loadTypes();
    $("stage").replaceChildren(...about.stages.map((s) => new Option(s, s)));
    $("example").replaceChildren(...about.examples.map((e) => new Option(e.title, e.file)));
    setGraph(await (await ask("/ui/examples/" + about.examples[0].file)).json());
  } catch (e) {
    showErrors([{ detail: e.message }]);
  }
}
start();
