// The picture: a layer of the decoded EXR on a canvas, with exposure, light mixer, wipe against picture A, zoom and pixel values.

const curve = new Uint8Array(4096 + 1);  // linear 0..1 -> sRGB (IEC 61966-2-1), by the square root of the value
for (let i = 0; i <= 4096; ++i) {
  const x = (i / 4096) ** 2;
  curve[i] = Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
}
const display = (x) => (x > 0 ? curve[Math.round(4096 * Math.sqrt(Math.min(x, 1)))] : 0);
const number = (x) => (Number.isFinite(x) ? (Math.abs(x) >= 1000 || (x !== 0 && Math.abs(x) < 1e-3) ? x.toExponential(3) : x.toFixed(4)) : String(x));

export class Picture {
  constructor(elements) {
    Object.assign(this, elements);  // canvas, frame, pixel, mixer
    this.image = null;
    this.kept = null;
    this.layer = "";
    this.exposure = 0;
    this.wipe = 0;
    this.zoom = 1;
    this.pan = [0, 0];
    this.gains = new Map();
    this.frame.addEventListener("pointermove", (e) => this.onMove(e));
    this.frame.addEventListener("pointerleave", () => (this.pixel.innerHTML = ""));
    this.frame.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.setZoom(this.zoom * (e.deltaY < 0 ? 1.25 : 0.8));
    }, { passive: false });
    this.frame.addEventListener("keydown", (e) => {
      const step = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] }[e.key];
      if (!step) return;
      e.preventDefault();
      this.pan = [this.pan[0] + step[0], this.pan[1] + step[1]];
      this.place();
    });
    new ResizeObserver(() => this.place()).observe(this.frame);
  }
  show(image) {
    this.image = image;
    const groups = [...image.layers.keys()].filter((n) => n.startsWith("light_group_"));
    this.drawMixer(groups);
    this.draw();
  }
  keep() { this.kept = this.image; }
  setZoom(zoom) {
    this.zoom = Math.min(Math.max(zoom, 1), 40);
    if (this.zoom === 1) this.pan = [0, 0];
    this.place();
  }
  place() {
    const fit = Math.min(this.frame.clientWidth / this.canvas.width, this.frame.clientHeight / this.canvas.height);
    const scale = fit * this.zoom;
    this.canvas.style.width = this.canvas.width * scale + "px";
    this.canvas.style.height = this.canvas.height * scale + "px";
    this.canvas.style.transform = `translate(${this.pan[0]}px, ${this.pan[1]}px)`;
  }
  /** Sliders on the light groups act on their layers: no ray is traced. */
  drawMixer(groups) {
    const names = groups.join();
    this.mixer.hidden = groups.length < 2;
    if (this.mixer.dataset.groups === names) return;
    this.mixer.dataset.groups = names;
    this.mixer.replaceChildren(...groups.map((g) => {
      const label = document.createElement("label"), input = document.createElement("input"), span = document.createElement("span");
      Object.assign(input, { type: "range", min: 0, max: 4, step: 0.05, value: this.gains.get(g) ?? 1 });
      span.textContent = g.replace("light_group_", "light group ");
      input.addEventListener("input", () => {
        this.gains.set(g, Number(input.value));
        this.draw();
      });
      label.append(span, input);
      return label;
    }));
  }
  /** Planes of the layer shown; the beauty is the sum of the light groups where one of them has been turned. */
  planesOf(image) {
    const layer = image.layers.get(this.layer) ?? image.layers.get("");
    if (this.layer !== "" || !image.layers.has("light_group_default")) return layer.planes;
    const turned = [...this.gains].filter(([g, gain]) => gain !== 1 && image.layers.has(g));
    if (!turned.length) return layer.planes;
    return [0, 1, 2].map((c) => {
      const plane = Float32Array.from(layer.planes[c]);
      for (const [g, gain] of turned) {
        const group = image.layers.get(g).planes[c];
        for (let i = 0; i < plane.length; ++i) plane[i] += (gain - 1) * group[i];
      }
      return plane;
    });
  }
  draw() {
    if (!this.image) return;
    const { width, height } = this.image;
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    const out = new ImageData(width, height), scale = 2 ** this.exposure;
    const paint = (image, x0, x1) => {
      const planes = this.planesOf(image), [r, g, b] = planes.length >= 3 ? planes : [planes[0], planes[1] ?? planes[0], planes.length === 2 ? null : planes[0]];
      for (let y = 0; y < height; ++y) {
        const row = Math.floor((y * image.height) / height) * image.width;
        for (let x = x0; x < x1; ++x) {
          const from = row + Math.floor((x * image.width) / width), to = 4 * (y * width + x);
          out.data[to] = display(r[from] * scale);
          out.data[to + 1] = display(g[from] * scale);
          out.data[to + 2] = b ? display(b[from] * scale) : 0;
          out.data[to + 3] = 255;
        }
      }
    };
    const cut = this.kept ? Math.round((width * this.wipe) / 100) : 0;
    if (cut > 0) paint(this.kept, 0, cut);
    paint(this.image, cut, width);
    this.canvas.getContext("2d").putImageData(out, 0, 0);
    this.place();
  }
  onMove(e) {
    if (e.buttons & 1) {
      this.pan = [this.pan[0] + e.movementX, this.pan[1] + e.movementY];
      this.place();
      return;
    }
    if (!this.image) return;
    const box = this.canvas.getBoundingClientRect();
    const x = Math.floor(((e.clientX - box.left) / box.width) * this.image.width), y = Math.floor(((e.clientY - box.top) / box.height) * this.image.height);
    this.inspect(x, y);
  }
  inspect(x, y) {
    if (!this.image || x < 0 || y < 0 || x >= this.image.width || y >= this.image.height) return;
    this.pixel.replaceChildren(...[...this.image.layers].map(([name, layer]) => {
      const row = document.createElement("tr"), head = document.createElement("th");
      head.textContent = name || `beauty at ${x}, ${y}`;
      row.append(head, ...layer.planes.map((p) => {
        const cell = document.createElement("td");
        cell.textContent = number(p[y * this.image.width + x]);
        return cell;
      }));
      return row;
    }));
  }
}
