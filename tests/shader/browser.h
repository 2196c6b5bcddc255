// The GLSL text run by headless Chromium, by WebGL2 in software: points in, light out, by way of a
// page of its own.
#pragma once

#include <stratus/shader/shader.h>

#include "lookups.h"
#include "temporary_folder.h"

#include <array>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {

/// A row of the picture is `points_in_row` lookups; two float textures hold their arguments.
constexpr std::size_t points_in_row = 100;

constexpr const char* page_end = R"page(
window.onerror = (said) => { document.getElementById("light").textContent = said; };
const out = document.getElementById("light");
function tell(text) { out.textContent = text; throw new Error(text); }
function read(name) {
  const request = new XMLHttpRequest();
  request.open("GET", name, false);
  request.overrideMimeType("text/plain; charset=x-user-defined");  // a character a byte
  request.send();
  const bytes = new Uint8Array(request.response.length);
  for (let n = 0; n < bytes.length; ++n) bytes[n] = request.response.charCodeAt(n);
  return bytes.buffer;
}
const gl = document.createElement("canvas").getContext("webgl2");
if (!gl) tell("no WebGL2");
if (!gl.getExtension("EXT_color_buffer_float")) tell("no EXT_color_buffer_float");
const linear = ["stratus_weights", "stratus_path_functions"];
const program = gl.createProgram();
for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
  const shader = gl.createShader(type);
  gl.shaderSource(shader, text);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) tell(gl.getShaderInfoLog(shader));
  gl.attachShader(program, shader);
}
gl.linkProgram(program);
if (!gl.getProgramParameter(program, gl.LINK_STATUS)) tell(gl.getProgramInfoLog(program));
gl.useProgram(program);
textures.forEach(({name, width, height, depth, halves}, unit) => {
  const bytes = read(name);
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.uniform1i(gl.getUniformLocation(program, name), unit);
  if (depth) {
    gl.bindTexture(gl.TEXTURE_3D, gl.createTexture());
    gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R])
      gl.texParameteri(gl.TEXTURE_3D, axis, gl.CLAMP_TO_EDGE);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGBA16F, width, height, depth, 0, gl.RGBA, gl.HALF_FLOAT, new Uint16Array(bytes));
    return;
  }
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  const filter = linear.includes(name) ? gl.LINEAR : gl.NEAREST;
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, axis, gl.CLAMP_TO_EDGE);
  gl.texImage2D(gl.TEXTURE_2D, 0, halves ? gl.RGBA16F : gl.RGBA32F, width, height, 0, gl.RGBA,
                halves ? gl.HALF_FLOAT : gl.FLOAT, halves ? new Uint16Array(bytes) : new Float32Array(bytes));
});
const {width, height} = textures[textures.length - 1];
gl.activeTexture(gl.TEXTURE0 + textures.length);
const target = gl.createTexture();
gl.bindTexture(gl.TEXTURE_2D, target);
gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, width, height);
gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
gl.viewport(0, 0, width, height);
gl.drawArrays(gl.TRIANGLES, 0, 3);
const light = new Float32Array(4 * width * height);
gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, light);
if (gl.getError()) tell("WebGL error");
out.textContent = "light:" + light.join(" ");
</script>
)page";

/// What is drawn: `light`, a vec4, of `layer` (albedo, optical depth) and `along` (mu_in, mu_out,
/// azimuth).
constexpr const char* both_sides = R"glsl(
    StratusScattered r = stratus_reflection(layer.x, layer.y, along.x, along.y, along.z);
    StratusScattered t = stratus_transmission(layer.x, layer.y, along.x, along.y, along.z);
    light = vec4(r.single, r.multiple, t.single, t.multiple);
)glsl";

inline void write_page(const std::vector<ShaderTexture>& textures,
                       const std::vector<Lookup>& lookups, const std::string& drawn,
                       const FilteredLight* filtered, const std::filesystem::path& path) {
    std::vector<float> layers, directions;
    for (const Lookup& at : lookups) {
        layers.insert(layers.end(), {at.albedo, at.optical_depth, 0, 0});
        directions.insert(directions.end(), {at.mu_in, at.mu_out, at.azimuth, 0});
    }
    const int rows = static_cast<int>(lookups.size() / points_in_row);
    std::ofstream page(path);
    page.exceptions(std::ios::failbit | std::ios::badbit);
    page << "<!doctype html><meta charset=utf-8><pre id=light></pre><script>\n"
         << "const vertex = `#version 300 es\nvoid main() { gl_Position = vec4(gl_VertexID == 1 ? "
            "3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }`;\n"
         << "const fragment = `#version 300 es\n"
         << (textures.size() > 2 && !filtered ? "#define STRATUS_LAYER\n" : "")
         << shader_text(ShaderLanguage::glsl, filtered)
         << "uniform sampler2D layers, directions;\nout vec4 light;\nvoid main() {\n"
            "    vec4 layer = texelFetch(layers, ivec2(gl_FragCoord.xy), 0);\n"
            "    vec4 along = texelFetch(directions, ivec2(gl_FragCoord.xy), 0);\n"
         << drawn << "}`;\nconst textures = [\n";
    const auto put = [&](const std::string& name, int width, int height, bool halves,
                         const void* data, std::size_t bytes, int depth = 0) {
        page << "{name: '" << name << "', width: " << width << ", height: " << height
             << ", depth: " << depth << ", halves: " << (halves ? "true" : "false") << "},\n";
        std::ofstream(path.parent_path() / name, std::ios::binary)
            .write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
    };
    for (const ShaderTexture& of : textures)
        put(of.name, of.width, of.height, of.halves, of.bytes.data(), of.bytes.size(), of.depth);
    for (const auto& [name, numbers] : {std::pair{"layers", &layers}, {"directions", &directions}})
        put(name, points_in_row, rows, false, numbers->data(), numbers->size() * sizeof(float));
    page << "];" << page_end;
}

/// What a page says once it has run.
inline std::string run_in_chromium(const std::filesystem::path& page,
                                   const std::filesystem::path& profile) {
    const std::string command =
        "env -u GLIBC_TUNABLES chromium --headless --no-sandbox --disable-gpu-sandbox --use-angle=swiftshader "
        "--enable-unsafe-swiftshader --allow-file-access-from-files --user-data-dir='" +
        profile.string() + "' --dump-dom 'file://" + page.string() + "' 2>'" + profile.string() +
        ".log'";
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen(command.c_str(), "r"),
                                                               ::pclose);
    std::string text;
    std::array<char, 65536> some;
    while (const std::size_t count = std::fread(some.data(), 1, some.size(), pipe.get()))
        text.append(some.data(), count);
    return text;
}

/// What the shader draws for lookups, as many as fill rows.
///
/// Errors   std::runtime_error with what Chromium, or the page, said.
inline std::vector<Light> by_browser(const std::vector<ShaderTexture>& textures,
                                     const std::vector<Lookup>& lookups,
                                     const std::string& drawn = both_sides,
                                     const FilteredLight* filtered = nullptr) {
    const TemporaryFolder folder;
    write_page(textures, lookups, drawn, filtered, folder / "page.html");
    const std::string said = run_in_chromium(folder / "page.html", folder / "profile");
    const std::string begin = "light:";
    const std::size_t at = said.find(">" + begin) + 1;
    if (at == 0) {
        std::ostringstream log;
        log << std::ifstream(folder / "profile.log").rdbuf();
        throw std::runtime_error(
            "the shader did not run in headless Chromium (Debian's package chromium): " +
            (said + log.str()).substr(0, 2000));
    }
    std::vector<Light> light(lookups.size());
    const char* next = said.c_str() + at + begin.size();
    for (Light& each : light)
        for (float& number : each) {
            char* end = nullptr;
            number = std::strtof(next, &end);
            if (end == next) throw std::runtime_error("light is missing");
            next = end;
        }
    return light;
}

}  // namespace stratus::test
