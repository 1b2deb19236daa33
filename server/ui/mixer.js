// Light groups: a slider and a colour each. They weigh what has been rendered already, so a change shows without a ray traced.

const toLinear = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
const linear = (hex) => [1, 3, 5].map((i) => Number(toLinear(parseInt(hex.slice(i, i + 2), 16) / 255).toFixed(4)));

/** groups: {NAME: {lights: [...]}} of a live render's document. set(NAME, {intensity, color}). */
export function drawMixer(element, groups, set) {
  const names = Object.keys(groups ?? {});
  element.hidden = names.length === 0;
  if (element.dataset.groups === names.join()) return;
  element.dataset.groups = names.join();
  element.replaceChildren(...names.map((name) => {
    const lights = groups[name].lights.join(", "), title = name === "default" ? "world" + (lights ? ", " + lights : "") : lights || "group " + name;
    const line = document.createElement("div"), label = document.createElement("label"), span = document.createElement("span");
    const slider = Object.assign(document.createElement("input"), { type: "range", min: 0, max: 4, step: 0.05, value: 1 });
    const color = Object.assign(document.createElement("input"), { type: "color", value: "#ffffff" }), shown = document.createElement("output");
    slider.dataset.group = name;
    color.setAttribute("aria-label", title + ", colour");
    span.textContent = title;
    shown.textContent = "1";
    const change = () => {
      shown.textContent = slider.value;
      set(name, { intensity: Number(slider.value), color: linear(color.value) });
    };
    slider.addEventListener("input", change);
    color.addEventListener("input", change);
    const reset = Object.assign(document.createElement("button"), { type: "button", className: "small", textContent: "↺", title: "as it was" });
    reset.setAttribute("aria-label", title + ", as it was");
    reset.addEventListener("click", () => {
      slider.value = 1;
      color.value = "#ffffff";
      change();
    });
    line.className = "row";
    label.append(span, slider);
    line.append(label, shown, color, reset);
    return line;
  }));
}
