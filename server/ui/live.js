// A live render of the service (POST /v1/renders, "mode": "live"): edits go there as PATCHes, one request at a time with all that
// came meanwhile; pictures come back as tiles, state as server-sent events.
import { halfToFloat } from "./exr.js";

const kHeadBytes = 12; // "ALDT", length of the JSON head, length of the pixels

/** Reads the stream of .../tiles; `take(image, head)` gets every whole picture. Ends when the stream does. */
export async function readTiles(body, take) {
  const reader = body.getReader();
  let bytes = new Uint8Array(0), image = null;
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    const joined = new Uint8Array(bytes.length + value.length);
    joined.set(bytes);
    joined.set(value, bytes.length);
    bytes = joined;
    for (;;) {
      if (bytes.length < kHeadBytes) break;
      const view = new DataView(bytes.buffer, bytes.byteOffset), head = view.getUint32(4, true), pixels = view.getUint32(8, true);
      if (view.getUint32(0, true) !== 0x54444c41) throw new Error("the tile stream is out of step");
      const end = kHeadBytes + head + pixels;
      if (bytes.length < end) break;
      const tile = JSON.parse(new TextDecoder().decode(bytes.subarray(kHeadBytes, kHeadBytes + head)));
      if (image?.pass !== tile.pass) image = newImage(tile);
      putTile(image, tile, bytes.slice(kHeadBytes + head, end));
      bytes = bytes.subarray(end);
      if (image.missing === 0) {
        const whole = image;
        image = null;
        take(whole, tile);
      }
    }
  }
}

function newImage(tile) {
  const size = tile.width * tile.height, layers = new Map();
  for (const l of tile.layers) layers.set(l.name === "rgba" ? "" : l.name, { channels: l.channels, planes: l.channels.map(() => new Float32Array(size)) });
  return { width: tile.width, height: tile.height, pass: tile.pass, layers, missing: size };
}

function putTile(image, tile, bytes) {
  const halves = new Uint16Array(bytes.buffer);
  let from = 0;
  for (const { planes } of image.layers.values())
    for (const plane of planes)
      for (let y = 0; y < tile.h; ++y) {
        const row = (tile.y + y) * image.width + tile.x;
        for (let x = 0; x < tile.w; ++x) plane[row + x] = halfToFloat(halves[from++]);
      }
  image.missing -= tile.w * tile.h;
}

export class Live {
  /** on: frame(image, {samples, divisor, edits, latency}), document(json), answer(json), fault(problem or error), restarted() */
  constructor(ask, on) {
    Object.assign(this, { ask, on, id: null, layer: "", sent: new Map(), graph: null, operations: [], settings: {}, busy: false, whole: false });
    addEventListener("pagehide", () => this.id && fetch(this.path(), { method: "DELETE", keepalive: true }));
  }
  path(more = "") { return `/v1/renders/${this.id}${more}`; }

  /** body: what POST /v1/renders takes. */
  async start(body) {
    this.body = body;
    const edit = this.token;
    const answer = await this.ask("/v1/renders", { method: "POST", body: JSON.stringify({ mode: "live", ...body }), headers: { "Content-Type": "application/json" } });
    const document = await answer.json();
    this.id = document.id;
    this.first = edit;   // what the first picture shows
    this.whole = false;
    this.on.document(document);
    this.watch();
    this.listen();
  }

  /** An edit: {graph} replaces all, {operations} (RFC 6902) part of it, {settings} are members of PATCH /v1/renders/{id}. */
  edit(token, { graph, operations, settings }) {
    this.token = String(token);
    this.sent.set(this.token, performance.now());
    if (this.sent.size > 200) this.sent.delete(this.sent.keys().next().value);
    if (graph) this.graph = graph;
    if (operations) this.operations.push(...operations);
    if (graph && !operations) this.whole = true;
    for (const [name, value] of Object.entries(settings ?? {})) this.settings[name] = name === "mix" ? { ...this.settings.mix, ...value } : value;
    this.flush();
  }

  async flush() {
    if (this.busy) return;
    this.busy = true;
    while (this.whole || this.operations.length || Object.keys(this.settings).length) {
      const token = this.token, operations = this.operations, settings = this.settings, whole = this.whole;
      Object.assign(this, { operations: [], settings: {}, whole: false });
      try {
        if (!this.id) {
          await this.start({ ...this.body, graph: this.graph, ...settings });
          continue;
        }
        // What is sent last carries the token: its picture shows both.
        const last = Object.keys(settings).length > 0, header = (mine) => (mine ? { "Alder-Edit-Id": token } : {});
        if (whole) await this.send("/graph", "PUT", this.graph, { "Content-Type": "application/json", "If-Match": "*", ...header(!last) });
        else if (operations.length) await this.send("/graph", "PATCH", operations, { "Content-Type": "application/json-patch+json", "If-Match": "*", ...header(!last) });
        if (last) await this.send("", "PATCH", settings, { "Content-Type": "application/json", ...header(true) });
      } catch (e) {
        if (e.problem?.status === 404) {   // the daemon was started again, or it has forgotten the render
          this.id = null;
          this.whole = true;
          Object.assign(this.settings, { ...settings, ...this.settings });
          this.on.restarted();
          continue;
        }
        this.whole = this.operations.length > 0;   // the service has the graph from before: the next edit sends all of it
        this.broken = whole || operations.length > 0;
        this.on.fault(e, token);
      }
    }
    this.busy = false;
  }

  async send(more, method, value, headers) {
    if (more === "/graph" && this.broken && method === "PATCH") [method, value, headers] = ["PUT", this.graph, { ...headers, "Content-Type": "application/json" }];
    const answer = await (await this.ask(this.path(more), { method, body: JSON.stringify(value), headers })).json();
    if (more === "/graph") this.broken = false;
    this.on.answer(answer);
  }

  /** Pictures of this layer from now on. */
  show(layer) {
    if (layer === this.layer) return;
    this.layer = layer;
    if (this.id) this.watch();
  }

  async watch() {
    this.stop?.abort();
    const stop = (this.stop = new AbortController()), id = this.id;
    while (!stop.signal.aborted && id === this.id) {
      try {
        const answer = await this.ask(this.path("/tiles?type=half" + (this.layer ? "&aovs=" + encodeURIComponent("rgba," + this.layer) : "")), { signal: stop.signal });
        await readTiles(answer.body, (image, head) => {
          if (stop.signal.aborted) return;
          const edits = [...head.edits];
          if (this.first !== undefined) edits.push(this.first);
          this.first = undefined;
          const times = edits.filter((e) => this.sent.has(e)).map((e) => performance.now() - this.sent.get(e));
          for (const e of edits) this.sent.delete(e);
          this.on.frame(image, { samples: head.samples, divisor: 1 << head.level, edits, latency: times.length ? Math.min(...times) : null });
        });
      } catch (e) {
        if (stop.signal.aborted) return;
        if (!e.problem && e.name !== "TypeError" && e.name !== "NetworkError") console.error(e);   // TypeError: fetch's for a lost connection
        if (e.problem?.status === 404 && id === this.id) {
          this.id = null;
          this.whole = true;
          this.on.restarted();
          return void this.flush();
        }
      }
      if (!stop.signal.aborted) await new Promise((done) => setTimeout(done, 1000));   // the connection was lost
    }
  }

  listen() {
    this.events?.close();
    const events = (this.events = new EventSource(this.path("/events")));
    events.addEventListener("state", (e) => this.on.document(JSON.parse(e.data)));
    events.addEventListener("end", () => events.close());
  }

  async document() { return (await this.ask(this.path())).json(); }
  async pixel(x, y, explain) { return (await this.ask(this.path(`/pixel?x=${x}&y=${y}${explain ? "&explain=1" : ""}`))).json(); }
  async exr() { return (await this.ask(this.path("/snapshot.exr"))).arrayBuffer(); }
}
