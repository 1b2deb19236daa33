// Controls of one node, made from its schema (/v1/nodes/TYPE): sliders, colour pickers, menus, links.

const make = (tag, properties = {}, ...children) => {
  const e = Object.assign(document.createElement(tag), properties);
  e.append(...children);
  return e;
};
const toDisplay = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
const toLinear = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
const hex = (rgb) => "#" + rgb.slice(0, 3).map((x) => Math.round(255 * Math.min(Math.max(toDisplay(x), 0), 1)).toString(16).padStart(2, "0")).join("");
const unhex = (s) => [1, 3, 5].map((i) => Number(toLinear(parseInt(s.slice(i, i + 2), 16) / 255).toFixed(5)));

const isLink = (v) => v !== null && typeof v === "object" && !Array.isArray(v) && ("node" in v || "attribute" in v);

/** One number with a slider over its soft range. */
function numberControl(schema, value, set, whole) {
  const low = schema.soft_min ?? schema.min ?? Math.min(0, value), high = schema.soft_max ?? schema.max ?? Math.max(1, 2 * value);
  const step = whole ? 1 : Math.max((high - low) / 200, 1e-5);
  const slider = make("input", { type: "range", min: Math.min(low, value), max: Math.max(high, value), step, value });
  const box = make("input", { type: "number", step: "any", value });
  slider.setAttribute("aria-label", schema.name);
  box.setAttribute("aria-label", schema.name + ", number");
  slider.addEventListener("input", () => set(Number((box.value = Number(Number(slider.value).toPrecision(6))))));
  box.addEventListener("change", () => {
    const v = Number(box.value);
    if (!Number.isFinite(v) || box.value === "") return void (box.value = value);
    slider.max = Math.max(slider.max, v);
    slider.min = Math.min(slider.min, v);
    set(Number((slider.value = whole ? Math.round(v) : v)));
  });
  return [slider, box];
}

function vectorControl(schema, value, set) {
  const now = [...value];
  return now.map((x, i) => {
    const box = make("input", { type: "number", step: "any", value: Number(x.toPrecision(6)) });
    box.setAttribute("aria-label", `${schema.name} ${"xyzw"[i]}`);
    box.addEventListener("change", () => {
      now[i] = Number(box.value) || 0;
      set([...now]);
    });
    return box;
  });
}

function colorControl(schema, value, set) {
  const picker = make("input", { type: "color", value: hex(value) });
  picker.setAttribute("aria-label", schema.name);
  const boxes = vectorControl(schema, value.slice(0, 3), (v) => {
    picker.value = hex(v);
    set(v);
  });
  picker.addEventListener("input", () => {
    const v = unhex(picker.value);
    boxes.forEach((b, i) => (b.value = v[i]));
    set(v);
  });
  return [picker, ...boxes];
}

function jsonControl(schema, value, set) {
  const area = make("textarea", { value: value === undefined || value === null ? "" : JSON.stringify(value), spellcheck: false, title: schema.help ?? "" });
  area.setAttribute("aria-label", schema.name + ", JSON");
  area.addEventListener("change", () => {
    try {
      set(area.value.trim() === "" ? undefined : JSON.parse(area.value));
      area.setCustomValidity("");
    } catch (e) {
      area.setCustomValidity(String(e.message));
    }
    area.reportValidity();
  });
  return [area];
}

function control(schema, value, set) {
  const constant = value ?? schema.default;
  switch (schema.type) {
    case "float": return typeof constant === "number" ? numberControl(schema, constant, set, false) : jsonControl(schema, value, set);
    case "int": return typeof constant === "number" ? numberControl(schema, constant, set, true) : jsonControl(schema, value, set);
    case "color": return Array.isArray(constant) ? colorControl(schema, constant, set) : jsonControl(schema, value, set);
    case "vector": case "point": case "normal":
      return Array.isArray(constant) ? vectorControl(schema, constant, set) : [make("span", { className: "small", textContent: schema.default_global ? `from the surface (${schema.default_global})` : "" })];
    case "bool": {
      const box = make("input", { type: "checkbox", checked: Boolean(constant) });
      box.setAttribute("aria-label", schema.name);
      box.addEventListener("change", () => set(box.checked));
      return [box];
    }
    case "enum": {
      const menu = make("select", {}, ...(schema.enum ?? []).map((o) => make("option", { value: o.name, textContent: o.label ?? o.name, selected: o.name === constant || o.cycles === constant })));
      menu.setAttribute("aria-label", schema.name);
      menu.addEventListener("change", () => set(menu.value));
      return [menu];
    }
    case "string": {
      const box = make("input", { type: "text", value: constant ?? "" });
      box.setAttribute("aria-label", schema.name);
      box.addEventListener("change", () => set(box.value));
      return [box];
    }
    case "closure": return [make("span", { className: "small", textContent: "a link" })];
    default: return jsonControl(schema, value, set);
  }
}

/**
 * Fills `root` with the controls of graph.nodes[name]. change(parameter, value, isDrag): undefined takes the default again.
 * schemas(type) -> schema of a type; go(name) selects another node.
 */
export function drawControls(root, graph, name, schemas, change, go) {
  const node = graph.nodes[name], type = schemas(node.type), params = node.params ?? {};
  if (!type) return root.replaceChildren(make("p", { textContent: "Nothing is known of this type of node." }));
  const others = Object.keys(graph.nodes).filter((n) => n !== name);
  const sections = new Map();
  for (const schema of type.params) {
    const names = [schema.name, ...(schema.aliases ?? [])], key = names.find((n) => n in params) ?? schema.name, value = params[key];
    const row = make("div", { className: "row" + (value === undefined ? "" : " changed"), title: schema.help ?? "" }, make("span", { textContent: schema.label ?? schema.name, title: schema.name }));
    row.dataset.parameter = schema.name;
    const cell = make("div", { className: "control" });
    if (isLink(value)) {
      const text = "node" in value ? `${value.node}${value.output ? "." + value.output : ""}${value.component ? " ." + value.component : ""}` : `attribute ${value.attribute}`;
      const link = make("button", { type: "button", className: "link", textContent: "← " + text });
      if (value.node in graph.nodes) link.addEventListener("click", () => go(value.node));
      const cut = make("button", { type: "button", className: "small", textContent: "unlink" });
      cut.addEventListener("click", () => change(key, undefined, false, true));
      cell.append(link, cut);
    } else {
      cell.append(...control(schema, value, (v) => {
        change(key, v, true);
        row.classList.toggle("changed", v !== undefined);
      }));
      if (value !== undefined) {
        const reset = make("button", { type: "button", className: "small", textContent: "↺", title: "take the default again" });
        reset.addEventListener("click", () => change(key, undefined, false, true));
        cell.append(reset);
      }
      if (schema.links && others.length) {
        const menu = make("select", { className: "small", title: "link to another node" }, make("option", { value: "", textContent: "link" }), ...others.map((n) => make("option", { value: n, textContent: n })));
        menu.style.width = "3.4em";
        menu.setAttribute("aria-label", `link ${schema.name} to`);
        menu.addEventListener("change", () => menu.value && change(key, { node: menu.value }, false, true));
        cell.append(menu);
      }
    }
    row.append(cell);
    const group = schema.group ?? "";
    if (!sections.has(group)) sections.set(group, group ? [make("h3", { textContent: group })] : []);
    sections.get(group).push(row);
  }
  root.replaceChildren(...[...sections.values()].flat());
}
