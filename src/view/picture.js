// Reads a table for the page itself: its facts, and fluxes, cubic on the table's axes (docs/tables.md).
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

// The pictures: one WebGL2 canvas, light scattered once in its left half, all orders in its right one.
const sceneNames = ["sphere", "rings", "slab", "lobes"];
const textureUnits = ["stratus_numbers", "stratus_functions", "fluxes"];
const infiniteDepth = 1e20;

class Picture {
  /** Null without WebGL2. */
  static contextOf(canvas) {
    return canvas.getContext("webgl2", { antialias: false, alpha: false, preserveDrawingBuffer: true });
  }

  /** Texels of the table's textures in their order. */
  constructor(gl, table, texels) {
    this.gl = gl;
    this.table = table;
    this.program = linked(gl);
    this.places = new Map();
    gl.useProgram(this.program);
    gl.bindVertexArray(gl.createVertexArray());
    textureUnits.forEach((name, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
      gl.uniform1i(this.place(name), unit);
    });
    table.textures.forEach(({ name, width, height, halves }, n) => {
      this.fill(name, width, height, halves, halves ? new Uint16Array(texels[n]) : new Float32Array(texels[n]));
    });
    gl.uniform1i(this.place("cosines"), table.mu.count);
    gl.uniform2f(this.place("cosine_axis"), table.mu.first, table.mu.perUnit);
    this.probed = probeTarget(gl);
  }

  /** Of a uniform. */
  place(name) {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.program, name));
    return this.places.get(name);
  }

  fill(name, width, height, isHalf, values) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0 + textureUnits.indexOf(name));
    const [format, type] = isHalf ? [gl.RGBA16F, gl.HALF_FLOAT] : [gl.RGBA32F, gl.FLOAT];
    gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, gl.RGBA, type, values);
  }

  /** Layers of these depths, each of the albedos of red, green and blue. */
  setLayers(albedos, depths) {
    const { gl } = this, { transmittance, spherical } = this.table.fluxes(albedos, depths[0]);
    this.fill("fluxes", this.table.mu.count, 1, false, transmittance);
    gl.uniform1fv(this.place("depths"), [0, 1, 2, 3].map((zone) => Math.min(depths[zone] ?? 0, infiniteDepth)));
    gl.uniform3fv(this.place("albedo"), albedos);
    gl.uniform3fv(this.place("spherical_albedo"), spherical);
  }

  setView({ scene, camera, toSun, ground, white, opposition }) {
    const { gl } = this;
    gl.uniform1i(this.place("scene"), sceneNames.indexOf(scene));
    for (const name of ["eye", "ahead", "right", "up"]) gl.uniform3fv(this.place(name), camera[name]);
    gl.uniform1f(this.place("half_width"), camera.halfWidth);
    gl.uniform1i(this.place("perspective"), camera.perspective ? 1 : 0);
    gl.uniform3fv(this.place("to_sun"), toSun);
    gl.uniform1f(this.place("ground"), ground);
    gl.uniform1f(this.place("white"), white);
    gl.uniform2f(this.place("opposition"), opposition.amplitude, opposition.width);
  }

  drawHalf(x, width, height, isAll) {
    const { gl } = this;
    gl.viewport(x, 0, width, height);
    gl.uniform2i(this.place("corner"), x, 0);
    gl.uniform1i(this.place("scattered_again"), isAll ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** Both pictures, `size` pixels a side. */
  draw(view, size, samples) {
    const { gl } = this;
    this.setView(view);
    gl.uniform1i(this.place("size"), size);
    gl.uniform1i(this.place("samples"), samples);
    this.drawHalf(0, size, size, false);
    this.drawHalf(gl.canvas.width - size, size, size, true);
  }

  /** Numbers that the shader writes as bytes, `width` by `height` of them. */
  numbers(view, width, height, isAll) {
    const { gl } = this;
    this.setView(view);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.probed);
    gl.uniform1i(this.place("probing"), 1);
    gl.uniform1i(this.place("size"), width);
    this.drawHalf(0, width, height, isAll);
    const bytes = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.uniform1i(this.place("probing"), 0);
    return new Float32Array(bytes.buffer);
  }

  /** What is at a point of a picture, (0, 0) its upper left corner: light and, on a lit layer, directions and R or T. */
  at(view, x, y) {
    this.gl.uniform2f(this.place("pointer"), x, y);
    const numbers = [false, true].map((isAll) => Array.from(this.numbers(view, 12, 1, isAll)));
    const [[oneMoreThanZone, side, muIn, muOut, azimuth, cosine]] = numbers;
    const [once, all] = numbers.map((n) => ({ value: n.slice(6, 9), light: n.slice(9, 12) }));
    if (oneMoreThanZone === 0) return { once, all };
    return { once, all, zone: oneMoreThanZone - 1, side: sides[side], muIn, muOut, azimuth, scatteringAngle: Math.acos(clamped(cosine, -1, 1)) };
  }

  /** R and T in the plane of incidence at `count` angles all around, for red, green and blue. */
  lobes(view, count, isAll) {
    const numbers = this.numbers(view, count, 3, isAll);
    return [0, 1, 2].map((channel) => numbers.subarray(channel * count, (channel + 1) * count));
  }
}

function linked(gl) {
  const program = gl.createProgram();
  const sources = [
    [gl.VERTEX_SHADER, "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }"],
    [gl.FRAGMENT_SHADER, document.getElementById("shader").textContent],
  ];
  for (const [kind, text] of sources) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, "#version 300 es\n" + text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

/** Where numbers are drawn that are read back. */
function probeTarget(gl) {
  const target = gl.createFramebuffer(), pixels = gl.createRenderbuffer();
  gl.bindRenderbuffer(gl.RENDERBUFFER, pixels);
  gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA8, 1024, 4);
  gl.bindFramebuffer(gl.FRAMEBUFFER, target);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, pixels);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return target;
}

// Lobes: R above and T below the layer in the plane of incidence, as polar curves of one scale.
const lobeAngles = 720;

/** Draws into both halves of a canvas; `curves` are [once, all], each of red, green and blue. */
function drawLobes(canvas, curves, elevation, isGrey) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const pen = canvas.getContext("2d");
  const half = canvas.width / 2, middle = { y: canvas.height / 2 }, radius = 0.4 * Math.min(half, canvas.height);
  const unit = canvas.width / canvas.clientWidth;
  const largest = Math.max(1e-12, ...curves.flat().map((curve) => Math.max(...curve)));
  const grid = roundBelow(largest);
  const scale = radius / Math.max(largest, grid);
  pen.clearRect(0, 0, canvas.width, canvas.height);
  pen.font = `${12 * unit}px system-ui, sans-serif`;
  curves.forEach((channels, panel) => {
    middle.x = half * (panel + 0.5);
    pen.lineWidth = unit;
    pen.strokeStyle = colour("--line");
    for (const value of [grid / 2, grid]) circle(pen, middle, value * scale);
    line(pen, middle.x - half * 0.46, middle.y, middle.x + half * 0.46, middle.y, colour("--soft"), 2 * unit);
    pen.fillStyle = colour("--soft");
    pen.fillText(formatted(grid), middle.x + 4 * unit, middle.y - grid * scale - 4 * unit);
    incidentRay(pen, middle, radius, elevation, colour("--once"), unit);
    channels.slice(0, isGrey ? 1 : 3).forEach((curve, channel) => {
      const own = isGrey ? colour(panel === 0 ? "--once" : "--accent") : ["#d1495b", "#3a9d5d", "#3d7dd8"][channel];
      lobe(pen, middle, scale, curve, own, isGrey, unit);
    });
  });
}

/** The largest of 1, 2, 5 times a power of ten that is not above a value. */
function roundBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].find((digit) => digit * power <= value * (1 + 1e-9)) * power;
}

function circle(pen, middle, radius) {
  pen.beginPath();
  pen.arc(middle.x, middle.y, radius, 0, 2 * Math.PI);
  pen.stroke();
}

function line(pen, x0, y0, x1, y1, colour, width) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}

/** Light comes from the left. */
function incidentRay(pen, middle, radius, elevation, colour, unit) {
  const x = -Math.cos(elevation), y = -Math.sin(elevation), far = 1.1 * radius;
  pen.setLineDash([6 * unit, 5 * unit]);
  line(pen, middle.x + far * x, middle.y + far * y, middle.x, middle.y, colour, 1.5 * unit);
  pen.setLineDash([]);
  pen.fillStyle = colour;
  pen.beginPath();
  pen.arc(middle.x + far * x, middle.y + far * y, 5 * unit, 0, 2 * Math.PI);
  pen.fill();
}

function lobe(pen, middle, scale, curve, colour, isFilled, unit) {
  pen.beginPath();
  curve.forEach((value, k) => {
    const turn = 2 * Math.PI * (k + 0.5) / curve.length;
    pen.lineTo(middle.x + value * scale * Math.sin(turn), middle.y - value * scale * Math.cos(turn));
  });
  pen.closePath();
  pen.strokeStyle = colour;
  pen.lineWidth = 2 * unit;
  pen.stroke();
  if (!isFilled) return;
  pen.globalAlpha = 0.15;
  pen.fillStyle = colour;
  pen.fill();
  pen.globalAlpha = 1;
}
