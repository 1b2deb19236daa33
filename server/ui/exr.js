// EXR files as Alder writes them: single part, scanlines, half or float, uncompressed or ZIP.
// Layout: https://openexr.com/en/latest/OpenEXRFileLayout.html

const kHalf = 1, kFloat = 2;

const halfTable = (() => {
  const table = new Float32Array(65536);
  for (let h = 0; h < 65536; ++h) {
    const exponent = (h >> 10) & 31, fraction = h & 1023, sign = h & 0x8000 ? -1 : 1;
    table[h] = exponent === 0 ? sign * fraction * 2 ** -24 : exponent === 31 ? (fraction ? NaN : sign * Infinity) : sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
  }
  return table;
})();

export const halfToFloat = (bits) => halfTable[bits];

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** What ZIP compression did before deflating: differences, and even and odd bytes apart. */
function undoPredictor(data) {
  for (let i = 1; i < data.length; ++i) data[i] = (data[i - 1] + data[i] - 128) & 255;
  const out = new Uint8Array(data.length), half = (data.length + 1) >> 1;
  for (let i = 0; i < half; ++i) out[2 * i] = data[i];
  for (let i = half; i < data.length; ++i) out[2 * (i - half) + 1] = data[i];
  return out;
}

/** {width, height, layers: Map(name -> {channels: [names], planes: [Float32Array]}), attributes}. The beauty is layer "". */
export async function readExr(buffer) {
  const view = new DataView(buffer), bytes = new Uint8Array(buffer);
  if (buffer.byteLength < 8 || view.getUint32(0, true) !== 20000630) throw new Error("not an EXR file");
  if (view.getUint32(4, true) & 0x1a00) throw new Error("an EXR file of tiles, deep data or several parts");
  let at = 8;
  const text = () => {
    let end = at;
    while (bytes[end] !== 0) ++end;
    const s = new TextDecoder().decode(bytes.subarray(at, end));
    at = end + 1;
    return s;
  };
  const channels = [], attributes = {};
  let compression = 0, box = [0, 0, -1, -1];
  for (let name = text(); name; name = text()) {
    const type = text(), size = view.getUint32(at, true), start = at + 4;
    at = start;
    if (name === "channels") {
      for (let channel = text(); channel; channel = text()) {
        channels.push({ name: channel, type: view.getUint32(at, true) });
        at += 16;
      }
    } else if (name === "compression") compression = bytes[at];
    else if (name === "dataWindow") box = [0, 4, 8, 12].map((o) => view.getInt32(start + o, true));
    else if (type === "string") attributes[name] = new TextDecoder().decode(bytes.subarray(start, start + size));
    at = start + size;
  }
  if (compression !== 0 && compression !== 2 && compression !== 3) throw new Error("EXR compression " + compression + " is not read here");
  const width = box[2] - box[0] + 1, height = box[3] - box[1] + 1, rows = compression === 3 ? 16 : 1;
  const planes = channels.map(() => new Float32Array(width * height));
  const lineBytes = width * channels.reduce((sum, c) => sum + (c.type === kHalf ? 2 : 4), 0);
  const blocks = Math.ceil(height / rows);
  for (let block = 0; block < blocks; ++block) {
    const offset = Number(view.getBigUint64(at + 8 * block, true));
    const y0 = view.getInt32(offset, true) - box[1], size = view.getUint32(offset + 4, true);
    const lines = Math.min(rows, height - y0), packed = bytes.subarray(offset + 8, offset + 8 + size);
    const raw = size === lines * lineBytes ? packed.slice() : undoPredictor(await inflate(packed));
    const values = new DataView(raw.buffer, raw.byteOffset, raw.byteLength);
    let from = 0;
    for (let y = y0; y < y0 + lines; ++y)
      channels.forEach((c, k) => {
        const plane = planes[k];
        for (let x = 0; x < width; ++x) {
          if (c.type === kHalf) plane[y * width + x] = halfTable[values.getUint16(from, true)];
          else plane[y * width + x] = c.type === kFloat ? values.getFloat32(from, true) : values.getUint32(from, true);
          from += c.type === kHalf ? 2 : 4;
        }
      });
  }
  const layers = new Map();
  const order = "RXUGYVBZAW";
  channels.forEach((c, k) => {
    const dot = c.name.lastIndexOf(".");
    let layer = dot < 0 ? "" : c.name.slice(0, dot), channel = c.name.slice(dot + 1);
    if (dot < 0 && !"RGBA".includes(c.name)) [layer, channel] = [c.name, ""];
    if (!layers.has(layer)) layers.set(layer, { channels: [], planes: [] });
    const l = layers.get(layer);
    const place = l.channels.findIndex((other) => order.indexOf(other) > order.indexOf(channel));
    l.channels.splice(place < 0 ? l.channels.length : place, 0, channel);
    l.planes.splice(place < 0 ? l.planes.length : place, 0, planes[k]);
  });
  return { width, height, layers, attributes };
}
