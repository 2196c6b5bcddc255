// What the page itself reads of a table: its facts, and fluxes, cubic on the table's axes (docs/tables.md).
const sides = ["reflection", "transmission"];

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/** What was deflated. */
const inflated = (id) =>
  new Response(new Blob([bytesIn(id)]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();

const bytesIn = (id) => bytesOf(document.getElementById(id).textContent);

/** What samples of an axis are even in. */
const coordinates = {
  logarithmic: (x) => Math.log2(x),
  arcsine_of_fourth_root: (x) => Math.asin(Math.sqrt(Math.sqrt(x))),
  square_root_of_complement: (x) => -Math.sqrt(1 - x),
  fourth_root_of_complement: (x) => -Math.sqrt(Math.sqrt(1 - x)),
};

const clamped = (x, least, most) => Math.min(Math.max(x, least), most);

/** Lagrange's weights of `count` samples at a place counted from the first. */
function lagrange(place, count) {
  return Array.from({ length: count }, (_, own) => {
    let weight = 1;
    for (let other = 0; other < count; ++other) if (other !== own) weight *= (place - other) / (own - other);
    return weight;
  });
}

class Axis {
  constructor({ values, scale, ends_at_infinity: endsAtInfinity }) {
    this.coordinate = coordinates[scale];
    this.endsAtInfinity = endsAtInfinity;
    this.count = values.length;
    this.size = values.length + (endsAtInfinity ? 1 : 0);
    this.lowest = values[0];
    this.highest = values.at(-1);
    this.first = this.coordinate(this.lowest);
    this.perUnit = this.count > 1 ? (this.count - 1) / (this.coordinate(this.highest) - this.first) : 0;
  }

  /** The first sample of a cubic, and weights. */
  window(value) {
    if (value === Infinity) return { first: this.size - 1, weights: [1] };
    const place = clamped((this.coordinate(value) - this.first) * this.perUnit, 0, this.count - 1);
    const width = Math.min(4, this.count), first = clamped(Math.floor(place) - 1, 0, this.count - width);
    return { first, weights: lagrange(place - first, width) };
  }
}

class Table {
  constructor(facts, fluxes) {
    Object.assign(this, facts);  // title, matter, is_stack, has_ground, tolerance, errors, highest_order, textures
    this.albedo = new Axis(facts.albedo);
    this.depth = new Axis(facts.optical_depth);
    this.mu = new Axis(facts.mu_in);
    const rows = this.albedo.count * this.depth.size;
    this.diffuseTransmittance = fluxes.subarray(0, rows * this.mu.count);
    this.sphericalAlbedo = fluxes.subarray(rows * this.mu.count);
  }

  /** A flux of `width` numbers; in proportion to the depth of layers thinner than the table's. */
  flux(values, width, albedo, depth) {
    const sum = new Array(width).fill(0);
    if (values.length === 0) return sum;
    const inAlbedo = this.albedo.window(albedo), inDepth = this.depth.window(depth);
    const thinner = Math.min(1, depth / this.depth.lowest);
    inAlbedo.weights.forEach((w, a) => inDepth.weights.forEach((v, d) => {
      const row = (inAlbedo.first + a) * this.depth.size + inDepth.first + d;
      for (let i = 0; i < width; ++i) sum[i] += thinner * w * v * values[row * width + i];
    }));
    return sum;
  }

  /** Of a layer with albedos of red, green and blue. */
  fluxes(albedos, depth) {
    const n = this.mu.count, transmittance = new Float32Array(4 * n);
    const spherical = albedos.map((albedo, channel) => {
      this.flux(this.diffuseTransmittance, n, albedo, depth).forEach((t, i) => { transmittance[4 * i + channel] = t; });
      return this.flux(this.sphericalAlbedo, 1, albedo, depth)[0];
    });
    return { transmittance, spherical };
  }
}
