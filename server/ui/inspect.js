// What is known of one pixel: all layers, and what each node made of it (GET .../pixel?explain=1).

const text = (x) => {
  if (typeof x !== "number") return String(x);
  return Math.abs(x) >= 1000 || (x !== 0 && Math.abs(x) < 1e-3) ? x.toExponential(3) : x.toFixed(4);
};
const cells = (v) => (Array.isArray(v) ? v : [v]).map(text);

function row(head, values, onClick) {
  const tr = document.createElement("tr"), th = document.createElement("th");
  if (onClick) {
    const b = Object.assign(document.createElement("button"), { type: "button", className: "link", textContent: head });
    b.addEventListener("click", onClick);
    th.append(b);
  } else th.textContent = head;
  tr.append(th, ...values.map((v) => Object.assign(document.createElement("td"), { textContent: v })));
  return tr;
}

/** Rows of the values in hand: the layers of the picture shown. */
export function localRows(image, x, y, fullX, fullY) {
  return [...image.layers].map(([name, layer]) => row(name || `beauty at ${fullX}, ${fullY}`, layer.planes.map((p) => text(p[y * image.width + x]))));
}

/** Rows of the service's answer; a click on a node chooses it. */
export function pixelRows(pixel, choose) {
  const rows = [row(`pixel ${pixel.x}, ${pixel.y}`, [`${pixel.samples} samples`, pixel.object ?? "", pixel.material ?? ""])];
  for (const [name, value] of Object.entries(pixel.layers)) rows.push(row(name === "rgba" ? "beauty" : name, cells(value)));
  const explain = pixel.explain;
  if (!explain) return rows;
  const wide = (text, className) => {
    const tr = document.createElement("tr");
    tr.append(Object.assign(document.createElement("th"), { textContent: text, colSpan: 5, className }));
    return tr;
  };
  const part = (title) => rows.push(wide(title, "part"));
  if (!explain.hit) return part("the middle of the pixel meets no surface"), rows;
  part("nodes at the first surface");
  for (const [name, node] of Object.entries(explain.nodes))
    for (const [output, value] of Object.entries(node.outputs)) rows.push(row(`${name} · ${output}`, cells(value), () => choose(name)));
  part("closures");
  for (const c of explain.closures) rows.push(row(`${c.node} · ${c.closure}`, cells(c.weight), () => choose(c.node)));
  if (explain.skipped.length) part("not run");
  for (const s of explain.skipped) rows.push(wide(s, ""));
  return rows;
}
