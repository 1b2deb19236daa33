// The picture: a layer on a canvas, with exposure, wipe against picture A, zoom, and which pixel is looked at.

const curve = new Uint8Array(4096 + 1);  // linear 0..1 -> sRGB (IEC 61966-2-1), by the square root of the value
for (let i = 0; i <= 4096; ++i) {
  const x = (i / 4096) ** 2;
  curve[i] = Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
}
const display = (x) => (x > 0 ? curve[Math.round(4096 * Math.sqrt(Math.min(x, 1)))] : 0);

export class Picture {
  /** onLook(x, y, fullX, fullY, chosen): the pointer is over this pixel of the picture, or has chosen it. */
  constructor(elements, onLook, onLeave) {
    Object.assign(this, elements, { onLook });  // canvas, frame
    this.image = null;
    this.kept = null;
    this.layer = "";
    this.exposure = 0;
    this.wipe = 0;
    this.zoom = 1;
    this.pan = [0, 0];
    this.full = [256, 256];   // pixels at full resolution: the first pictures after an edit have fewer
    this.frame.addEventListener("pointermove", (e) => this.onMove(e));
    this.frame.addEventListener("pointerdown", (e) => (this.pressed = [e.clientX, e.clientY]));
    this.frame.addEventListener("click", (e) => {
      const [x, y] = this.pressed ?? [e.clientX, e.clientY];
      if (Math.hypot(e.clientX - x, e.clientY - y) < 4) this.look(e, true);   // not the end of a drag
    });
    this.frame.addEventListener("pointerleave", onLeave);
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
  planesOf(image) { return (image.layers.get(this.layer) ?? image.layers.get("")).planes; }
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
    this.look(e, false);
  }
  look(e, chosen) {
    const box = this.canvas.getBoundingClientRect();
    this.lookAt((e.clientX - box.left) / box.width, (e.clientY - box.top) / box.height, chosen);
  }
  /** u, v: 0..1 from the upper left. */
  lookAt(u, v, chosen) {
    if (!this.image || !(u >= 0 && v >= 0 && u < 1 && v < 1)) return;
    this.onLook(Math.floor(u * this.image.width), Math.floor(v * this.image.height), Math.floor(u * this.full[0]), Math.floor(v * this.full[1]), chosen);
  }
}
