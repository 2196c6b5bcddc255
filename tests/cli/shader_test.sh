#!/usr/bin/env bash
# stratus shader: what it writes, compiled by glslang; its refusals.
# shellcheck source=tests/cli/expect.sh
source "$(dirname "$0")/expect.sh"

"$make_fixture" full full.h5
"$make_fixture" mixed mixed.h5
expect_ok pack full.h5 -o full.stratus --quiet

expect_ok shader full.stratus --language glsl -o glsl
expect_silent "$out"
expect_says "$err" "glsl" "4 files" "MB"
expect_says glsl/stratus_textures.json '"stratus_numbers"' '"type": "float32"' '"reflection": true'
for name in numbers functions; do
    texel=$(sed -n "s/.*stratus_$name.*float\([0-9]*\).*/\1/p" glsl/stratus_textures.json)
    height=$(sed -n "s/.*stratus_$name.*\"height\": \([0-9]*\).*/\1/p" glsl/stratus_textures.json)
    expect_near "$(stat -c %s "glsl/stratus_$name.bin")" $((2048 * height * texel / 2)) 0
done
expect_ok shader full.h5 --language hlsl -o hlsl --quiet
expect_silent "$err"
expect_ok shader full.stratus --language osl -o osl
expect_says "$err" "note: this text was compiled by oslc 1.12, but never run"
expect_says osl/stratus_textures.h 'STRATUS_NUMBERS "stratus_numbers.exr"' 'STRATUS_FUNCTIONS_HEIGHT'
expect_same glsl/stratus_numbers.bin hlsl/stratus_numbers.bin
sed 's,//.*,,' osl/stratus.osl.h >code.osl
grep -q '[0-9]f\b' code.osl && fail "OSL knows no suffix f"
grep -qE '\)\.[a-z]' code.osl && fail "OSL selects components of variables alone"
reserved='bool|case|char|class|const|default|double|enum|extern|false|friend|inline|long|private|protected|short|signed|sizeof'
reserved+='|static|switch|template|this|true|typedef|uniform|union|unsigned|varying|virtual|break|closure|color|continue|matrix'
reserved+='|normal|output|point|public|illuminate|illuminance'
sed -n '/elementary functions/,$p' osl/stratus.osl.h | sed 's,//.*,,; s/\bbool\b//' | grep -wE "$reserved" && fail "a word of OSL's own"

expect_refused 2 --language glsl hlsl osl -- shader full.stratus --language wgsl -o new
expect_refused 2 --at "given for mixed.h5, as in mixture=0" "got nothing" -- shader mixed.h5 --language glsl -o new
expect_refused 2 --at "left out" "got mixture=0.4" -- shader full.stratus --at mixture=0.4 --language glsl -o new
expect_ok shader mixed.h5 --at mixture=0.4 --language glsl -o mixed --quiet
"$make_fixture" family family.h5
expect_refused 2 "--at g" "[0.3, 0.6]" "got 0.9" -- shader family.h5 --at g=0.9 --language glsl -o new
expect_ok shader family.h5 --at g=0.4 --language glsl -o family --quiet
expect_refused 1 absent.stratus -- shader absent.stratus --language glsl -o new

# C++: one header, and the table
expect_ok shader full.stratus --language cpp -o cpp --quiet
expect_same cpp/table.stratus full.stratus
expect_ok shader mixed.h5 --at mixture=0.4 --language cpp -o member --quiet
grep -q family member/table.stratus && fail "a member is no family"
expect_refused 2 "left out for cpp" -- shader full.stratus --language cpp --optical-depth 1 --albedo 0.9 -o new

# compiled: expect_compiled ARGS..., of glslangValidator
command -v glslangValidator >/dev/null || fail "glslangValidator is needed: Debian's package glslang-tools"
expect_compiled() {
    glslangValidator "$@" >"$out" 2>"$err" || fail "glslangValidator $*"
}
all='StratusScattered r = stratus_reflection(0.9, 1.0, 0.5, 0.6, 1.0);
    StratusScattered t = stratus_transmission(0.9, 1.0, 0.5, 0.6, 1.0);
    float f = stratus_bsdf(vec3(0.0, 0.6, 0.8), vec3(0.0, 0.6, -0.8), 0.9, stratus_effective_depth(1.0, 0.1));
    float s = stratus_single(STRATUS_REFLECTION, 0.9, 1.0, 0.5, 0.6, 1.0) * stratus_hapke(0.5, 0.1, 0.2);
    float d = stratus_direct(1.0, 0.5) * stratus_phase(0.5);'
# expect_table_compiled GLSL HLSL: the texts compile with all that layers of a table have
expect_table_compiled() {
    { echo '#version 300 es'; cat "$1"; echo "out vec4 light; void main() { $all light = vec4(r.single, t.multiple, f, s * d); }"; } >es.frag
    { echo '#version 450'; cat "$1"; echo "layout(location = 0) out vec4 light; void main() { $all light = vec4(r.single, t.multiple, f, s * d); }"; } >core.frag
    { cat "$2"; echo "float4 main() : SV_Target0 { $all return vec4(r.single, t.multiple, f, s * d); }"; } >main.hlsl
    expect_compiled es.frag
    expect_compiled -V core.frag -o core.spv
    expect_compiled -V -D -S frag -e main main.hlsl -o hlsl.spv
}
expect_table_compiled glsl/stratus.glsl hlsl/stratus.hlsl

# one layer, bound
expect_ok shader full.stratus --language glsl --optical-depth 0.5,1,2 --albedo 0.9 -o glsl
expect_says "$err" "5 files"
expect_says glsl/stratus_textures.json '"stratus_layer"'
expect_refused 2 --optical-depth --albedo -- shader full.stratus --language glsl --albedo 0.9 -o new
expect_refused 2 --albedo three -- shader full.stratus --language glsl --optical-depth 1 --albedo 0.9,0.8 -o new
layer='vec3 wi = vec3(0.0, 0.6, 0.8); StratusSample d = stratus_layer_sample(wi, 0.3, 0.6, 0.9);
    vec3 f = stratus_layer_bsdf(wi, d.wo) / stratus_layer_pdf(wi, d.wo) + stratus_layer_direct(0.5);
    StratusColours c = stratus_layer_reflection(0.5, 0.6, 1.0);'
# expect_layer_compiled GLSL HLSL [DEFINITION]: after the definition, the texts compile with all that a layer has
expect_layer_compiled() {
    { echo '#version 300 es'; echo "${3-}"; cat "$1"; echo "out vec4 light; void main() { $layer light = vec4(f + c.single, 1.0); }"; } >es.frag
    { echo '#version 450'; echo "${3-}"; cat "$1"; echo "layout(location = 0) out vec4 light; void main() { $layer light = vec4(f + c.single, 1.0); }"; } >core.frag
    { echo "${3-}"; cat "$2"; echo "float4 main() : SV_Target0 { $layer return vec4(f + c.single, 1.0); }"; } >main.hlsl
    expect_compiled es.frag
    expect_compiled -V core.frag -o core.spv
    expect_compiled -V -D -S frag -e main main.hlsl -o hlsl.spv
}
expect_layer_compiled glsl/stratus.glsl hlsl/stratus.hlsl '#define STRATUS_LAYER'

# the same, filtered
expect_ok shader full.stratus --language glsl --optical-depth 0.5,1,2 --albedo 0.9 --filtered -o filtered
expect_says "$err" "5 files" "stratus_light:" "for all but one in a thousand"
expect_says filtered/stratus_textures.json '"stratus_light"' '"depth":'
size=$(sed -n 's/.*stratus_light.*"width": \([0-9]*\), "height": \([0-9]*\), "depth": \([0-9]*\).*/\1 * \2 * \3 * 8/p' filtered/stratus_textures.json)
expect_near "$(stat -c %s filtered/stratus_light.bin)" $((size)) 0
expect_ok shader full.stratus --language hlsl --optical-depth 0.5,1,2 --albedo 0.9 --filtered -o filtered --quiet
expect_refused 2 --filtered "glsl or hlsl" osl -- shader full.stratus --language osl --optical-depth 1 --albedo 0.9 --filtered -o new
expect_layer_compiled filtered/stratus.glsl filtered/stratus.hlsl

# filtered, of layers that are not bound
expect_ok shader full.stratus --language glsl --filtered -o layers
expect_says "$err" "5 files" "stratus_light:"
expect_says layers/stratus_textures.json '"stratus_weights"'
size=$(sed -n 's/.*stratus_weights.*"width": \([0-9]*\), "height": \([0-9]*\).*/\1 * \2 * 8/p' layers/stratus_textures.json)
expect_near "$(stat -c %s layers/stratus_weights.bin)" $((size)) 0
expect_ok shader full.stratus --language hlsl --filtered -o layers --quiet
expect_table_compiled layers/stratus.glsl layers/stratus.hlsl
finish
