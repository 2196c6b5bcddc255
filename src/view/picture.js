// The pictures: one WebGL2 canvas, light scattered once in its left half, all orders in its right one.
const sceneNames = ["sphere", "rings", "slab", "lobes"];

/** Null without WebGL2. */
function makePicture(canvas, table) {
  const gl = canvas.getContext("webgl2", { antialias: false, alpha: false, preserveDrawingBuffer: true });
  if (!gl) return null;
  const program = linked(gl);
  const places = new Map();
  const place = (name) => {
    if (!places.has(name)) places.set(name, gl.getUniformLocation(program, name));
    return places.get(name);
  };
  gl.useProgram(program);
  gl.bindVertexArray(gl.createVertexArray());
  const units = ["stratus_numbers", "stratus_functions", "fluxes"];
  units.forEach((name, unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    gl.uniform1i(place(name), unit);
  });
  const fill = (name, width, height, isHalf, values) => {
    gl.activeTexture(gl.TEXTURE0 + units.indexOf(name));
    const [format, type] = isHalf ? [gl.RGBA16F, gl.HALF_FLOAT] : [gl.RGBA32F, gl.FLOAT];
    gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, gl.RGBA, type, values);
  };
  for (const { name, width, height, halves } of table.textures) {
    const { buffer } = bytesIn(name);
    fill(name, width, height, halves, halves ? new Uint16Array(buffer) : new Float32Array(buffer));
  }
  gl.uniform1i(place("cosines"), table.mu.count);
  gl.uniform2f(place("cosine_axis"), table.mu.first, table.mu.perUnit);
  const probed = probeTarget(gl);

  function setView(view) {
    gl.uniform1i(place("scene"), sceneNames.indexOf(view.scene));
    for (const name of ["eye", "ahead", "right", "up"]) gl.uniform3fv(place(name), view.camera[name]);
    gl.uniform1f(place("half_width"), view.camera.halfWidth);
    gl.uniform1i(place("perspective"), view.camera.perspective ? 1 : 0);
    gl.uniform3fv(place("to_sun"), view.toSun);
    gl.uniform1f(place("ground"), view.ground);
    gl.uniform1f(place("white"), view.white);
    gl.uniform2f(place("opposition"), view.opposition.amplitude, view.opposition.width);
  }

  function drawHalf(x, y, width, height, all) {
    gl.viewport(x, y, width, height);
    gl.uniform2i(place("corner"), x, y);
    gl.uniform1i(place("scattered_again"), all ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** Numbers that the shader writes as bytes, `width` by `height` of them. */
  function probe(view, width, height, all) {
    setView(view);
    gl.bindFramebuffer(gl.FRAMEBUFFER, probed);
    gl.uniform1i(place("probing"), 1);
    gl.uniform1i(place("size"), width);
    drawHalf(0, 0, width, height, all);
    const bytes = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.uniform1i(place("probing"), 0);
    return new Float32Array(bytes.buffer);
  }

  return {
    gl,

    setLayers(albedos, depths) {
      const { transmittance, spherical } = table.fluxes(albedos, depths[0]);
      fill("fluxes", table.mu.count, 1, false, transmittance);
      const deepest = 1e20;  // as infinity
      gl.uniform1fv(place("depths"), [0, 1, 2, 3].map((zone) => Math.min(depths[zone] ?? 0, deepest)));
      gl.uniform3fv(place("albedo"), albedos);
      gl.uniform3fv(place("spherical_albedo"), spherical);
    },

    /** Both pictures, `size` pixels a side. */
    draw(view, size, samples) {
      setView(view);
      gl.uniform1i(place("size"), size);
      gl.uniform1i(place("samples"), samples);
      drawHalf(0, 0, size, size, false);
      drawHalf(canvas.width - size, 0, size, size, true);
    },

    /** What is at a point of a picture, (0, 0) its upper left corner; null beside the layer. */
    at(view, x, y) {
      const numbers = [false, true].map((all) => {
        gl.uniform2f(place("pointer"), x, y);
        return Array.from(probe(view, 12, 1, all));
      });
      const [[ofLayer, side, muIn, muOut, azimuth, cosine]] = numbers;
      const [once, all] = numbers.map((n) => ({ value: n.slice(6, 9), light: n.slice(9, 12) }));
      if (ofLayer === 0) return { once, all };
      return { once, all, side: sides[side], muIn, muOut, azimuth, scatteringAngle: Math.acos(clamped(cosine, -1, 1)) };
    },

    /** R and T in the plane of incidence at `count` angles all around, for red, green and blue. */
    lobes(view, count, all) {
      const numbers = probe(view, count, 3, all);
      return [0, 1, 2].map((channel) => numbers.subarray(channel * count, (channel + 1) * count));
    },
  };
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
