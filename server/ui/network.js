// The network as a drawing: columns by how far a node is from the output, rows by where its consumers are.

const kWidth = 138, kHeight = 38, kColumn = 190, kRow = 52;
const svg = (tag, attributes, ...children) => {
  const e = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
  e.append(...children);
  return e;
};

/** Links of a value: {node} objects, wherever they stand in it. */
export function linksOf(value) {
  if (value === null || typeof value !== "object") return [];
  if (!Array.isArray(value) && typeof value.node === "string") return [value.node];
  return Object.values(value).flatMap(linksOf);
}

export function edgesOf(graph) {
  return Object.entries(graph.nodes ?? {}).flatMap(([to, node]) =>
    Object.values(node.params ?? {}).flatMap(linksOf).filter((from) => from in graph.nodes).map((from) => ({ from, to })));
}

/** Places of all nodes: {name: {x, y, used}}. A node stands left of all that read it; cycles end where they close. */
export function layout(graph) {
  const names = Object.keys(graph.nodes ?? {}), edges = edgesOf(graph), readers = new Map(names.map((n) => [n, []]));
  for (const e of edges) readers.get(e.from).push(e.to);
  const roots = new Set(linksOf(graph.outputs ?? {})), depth = new Map(), open = new Set();
  const depthOf = (n) => {
    if (depth.has(n)) return depth.get(n);
    if (open.has(n)) return 0;
    open.add(n);
    const d = Math.max(0, ...readers.get(n).map((r) => depthOf(r) + 1));
    open.delete(n);
    depth.set(n, d);
    return d;
  };
  const used = new Set(), visit = (n) => {
    if (used.has(n) || !(n in graph.nodes)) return;
    used.add(n);
    Object.values(graph.nodes[n].params ?? {}).flatMap(linksOf).forEach(visit);
  };
  roots.forEach(visit);
  const columns = [];
  for (const n of names) (columns[depthOf(n)] ??= []).push(n);
  const row = new Map();
  columns.forEach((column) => {
    const wish = (n) => {
      const r = readers.get(n).filter((x) => row.has(x));
      return r.length ? r.reduce((s, x) => s + row.get(x), 0) / r.length : 0;
    };
    column.sort((a, b) => wish(a) - wish(b));
    column.forEach((n, i) => row.set(n, i));
  });
  const places = {};
  columns.forEach((column, d) => column.forEach((n, i) => {
    places[n] = { x: (columns.length - 1 - d) * kColumn + 8, y: i * kRow + 8, used: used.has(n), column: d, row: i };
  }));
  return places;
}

export class Network {
  constructor(element, onSelect, kindOf) {
    this.element = element;
    this.onSelect = onSelect;
    this.kindOf = kindOf;  // node type -> css class
    this.selected = null;
    element.addEventListener("keydown", (e) => this.onKey(e));
  }
  draw(graph) {
    this.places = layout(graph);
    const edges = edgesOf(graph), at = this.places, all = Object.values(at);
    this.element.setAttribute("width", Math.max(0, ...all.map((p) => p.x)) + kWidth + 16);
    this.element.setAttribute("height", Math.max(0, ...all.map((p) => p.y)) + kHeight + 16);
    const short = (s, n) => (s.length > n ? s.slice(0, n - 1) + "…" : s);
    const lines = edges.map((e) => {
      const x0 = at[e.from].x + kWidth, y0 = at[e.from].y + kHeight / 2, x1 = at[e.to].x, y1 = at[e.to].y + kHeight / 2, bend = Math.max(30, (x1 - x0) / 2);
      const own = e.from === this.selected || e.to === this.selected;
      return svg("path", { d: `M${x0} ${y0} C${x0 + bend} ${y0} ${x1 - bend} ${y1} ${x1} ${y1}`, class: own ? "of-selected" : "" });
    });
    const boxes = Object.entries(graph.nodes ?? {}).map(([name, node]) => {
      const p = at[name];
      const box = svg("g", { class: `node ${this.kindOf(node.type)}${p.used ? "" : " unused"}`, transform: `translate(${p.x} ${p.y})`, role: "option", "aria-selected": name === this.selected, "data-node": name },
        svg("title", {}, `${name} (${node.type})${p.used ? "" : ": not part of an output"}`),
        svg("rect", { width: kWidth, height: kHeight, rx: 4 }));
      const title = svg("text", { x: 8, y: 16 }, short(name, 20)), type = svg("text", { x: 8, y: 30, class: "type" }, short(node.type.replace("ShaderNode", ""), 24));
      box.append(title, type);
      box.addEventListener("click", () => this.select(name));
      return box;
    });
    this.element.replaceChildren(...lines, ...boxes);
    this.graph = graph;
  }
  select(name) {
    this.selected = name;
    this.draw(this.graph);
    this.onSelect(name);
  }
  onKey(e) {
    const move = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
    const here = this.places?.[this.selected];
    if (!move || !here) return;
    e.preventDefault();
    const target = Object.entries(this.places).filter(([, p]) => (move[0] ? p.column === here.column + move[0] : p.column === here.column && p.row === here.row + move[1]))
      .sort(([, a], [, b]) => Math.abs(a.row - here.row) - Math.abs(b.row - here.row))[0];
    if (target) this.select(target[0]);
  }
}
