// Stratus: lookups in a packed table, from the textures that lie beside this file.
//
// albedo [0, 1] and optical_depth [0, inf) are those of the layer at this point; mu_in and mu_out,
// (0, 1], are cosines to the normal of the directions to the light and to the eye; azimuth, in
// radians, lies between the two directions of propagation: 0 is forward. R = 1 is a white Lambert
// surface: BRDF = R / pi. Light that goes straight through is stratus_direct alone.
//
//   stratus_reflection(albedo, optical_depth, mu_in, mu_out, azimuth)     R: .single, .multiple
//   stratus_transmission(albedo, optical_depth, mu_in, mu_out, azimuth)   diffuse T, likewise
//   stratus_single(side, albedo, optical_depth, mu_in, mu_out, azimuth)   .single of either
//   stratus_bsdf(wi, wo, albedo, optical_depth)  BRDF or BTDF, without the cosine: unit vectors that
//                                                point away from the layer, z along its normal
//   stratus_direct(optical_depth, mu)            exp(-tau / mu)
//   stratus_phase(cos_theta)                     the phase function, mean 1 over the sphere
//   stratus_effective_depth(optical_depth, density), stratus_hapke(amplitude, width, cos_theta)

#define STRATUS_REFLECTION 0
#define STRATUS_TRANSMISSION 1

struct StratusScattered {
    float single;    // scattered once
    float multiple;  // scattered more often
};

// ---- elementary functions; those that a language has may be too coarse

float stratus_clamp(float x, float low, float high) { return max(min(x, high), low); }

struct StratusAttenuation {
    float transmitted;   // exp(-x)
    float extinguished;  // 1 - exp(-x)
};

StratusAttenuation stratus_attenuation(float x) {
    float most = min(x, 80.0f);
    float n = floor(most * 1.44269504f + 0.5f);
    float r = (n * 0.693359375f - most) + n * -2.12194440e-4f;
    float s = r * r;
    float high = s * (r * 0.000198412698f + 0.00138888889f) +
                 (r * 0.00833333333f + 0.0416666667f);
    float p = s * (s * high + (r * 0.166666667f + 0.5f)) + r;  // exp(r) - 1
    float power = stratus_power_of_two(-int(n));
    StratusAttenuation of;
    of.transmitted = max((power - 1.9e-35f) + power * p, 0.0f);
    of.extinguished = (1.0f - power) - power * p;
    return of;
}

float stratus_log2(float x) {
    int exponent = stratus_exponent(x);
    float mantissa = x * stratus_power_of_two(-exponent);
    float s = (mantissa - 1.41421356f) / (mantissa + 1.41421356f);
    float q = s * s;
    return (float(exponent) + 0.5f) +
           s * (q * (q * (q * 0.41219859f + 0.57707802f) + 0.96179669f) + 2.88539008f);
}

// 2 asin(sqrt(z)), z in [0, 1/2].
float stratus_twice_arcsine(float z) {
    float p = z * 0.084298202f - 0.047614748f;
    p = z * p + 0.04787879f;
    p = z * p + 0.025548843f;
    p = z * p + 0.045064493f;
    p = z * p + 0.074986517f;
    p = z * p + 0.16666674f;
    float u = sqrt(z) * 2.0f;
    return u + u * z * p;
}

// sin(pi x / 2) squared, x in [-1, 1].
float stratus_sine_squared(float x) {
    float y = x * 1.57079633f;
    float q = y * y;
    float sine = y * (q * q * ((q * -0.000198412701f + 0.00833333315f) +
                               q * q * (q * -2.50507e-8f + 2.75573137e-6f)) +
                      (q * -0.166666667f + 1.0f));
    return min(sine * sine, 1.0f);
}

// ---- what the textures hold: a record of 16 texels for each side, then arrays (docs/shaders.md)

vec4 stratus_field(int side, int k) { return stratus_number(side * 16 + k); }

// Of sample k of the albedo: diffusion exponent, 1 / deficit and scale of the deepest finite sample.
vec4 stratus_of_albedo(int side, int k) {
    return stratus_number(int(stratus_field(side, 13).x) + k);
}

float stratus_component(vec4 v, int i) {
    return i < 2 ? (i < 1 ? v.x : v.y) : (i < 3 ? v.z : v.w);
}

struct StratusPlace {
    float cell;   // the sample before a coordinate
    float first;  // first of the cubic's four
    vec4 weight;
};

vec4 stratus_cubic(float t) {
    float a = t - 1.0f;
    float b = t - 2.0f;
    float c = t - 3.0f;
    return vec4(a * b * c * -0.166666667f, t * b * c * 0.5f, t * a * c * -0.5f,
                t * a * b * 0.166666667f);
}

// axis: first coordinate, samples per unit of it, last sample.
StratusPlace stratus_place(vec4 axis, float coordinate) {
    StratusPlace at;
    float place = stratus_clamp((coordinate - axis.x) * axis.y, 0.0f, axis.z);
    at.cell = floor(place);
    at.first = stratus_clamp(at.cell - 1.0f, 0.0f, axis.z - 3.0f);
    at.weight = stratus_cubic(place - at.first);
    return at;
}

// ---- directions

struct StratusPath {
    float mu_in;
    float mu_out;
    float forward;    // 1 - cos Theta
    float backward;   // 1 + cos Theta
    float half_turn;  // |azimuth| / pi, [0, 1]
};

StratusPath stratus_path_of(int side, float mu_in, float mu_out, float half_turn,
                            float half_azimuth) {
    float sine_in = sqrt(max((1.0f - mu_in) * (mu_in + 1.0f), 0.0f));
    float sine_out = sqrt(max((1.0f - mu_out) * (mu_out + 1.0f), 0.0f));
    float sum = mu_in + mu_out;
    float difference = mu_in - mu_out;
    float along = sine_in - sine_out;
    float sines = sine_in * sine_out * 2.0f;
    float apart = (difference * difference + along * along) * 0.5f;
    float opposite = (sum * sum + along * along) * 0.5f;
    StratusPath path;
    path.mu_in = max(mu_in, 1e-6f);
    path.mu_out = max(mu_out, 1e-6f);
    path.forward = (side == STRATUS_REFLECTION ? opposite : apart) + sines * half_azimuth;
    path.backward = (side == STRATUS_REFLECTION ? apart : opposite) + sines * (1.0f - half_azimuth);
    path.half_turn = half_turn;
    return path;
}

StratusPath stratus_path(int side, float mu_in, float mu_out, float azimuth) {
    float turns = abs(azimuth) * 0.159154943f;
    float half_turn = 2.0f * abs(turns - floor(turns + 0.5f));
    return stratus_path_of(side, mu_in, mu_out, half_turn, stratus_sine_squared(half_turn));
}

// Light travels along -wi.
StratusPath stratus_path_between(int side, vec3 wi, vec3 wo) {
    float sines = (wi.x * wi.x + wi.y * wi.y) * (wo.x * wo.x + wo.y * wo.y);
    float half_azimuth = stratus_clamp(
        (wi.x * wo.x + wi.y * wo.y) / sqrt(max(sines, 1e-30f)) * 0.5f + 0.5f, 0.0f, 1.0f);
    float angle = stratus_twice_arcsine(min(half_azimuth, 1.0f - half_azimuth)) * 0.318309886f;
    return stratus_path_of(side, abs(wi.z), abs(wo.z),
                           half_azimuth < 0.5f ? angle : 1.0f - angle, half_azimuth);
}

// ---- single scattering, in closed form

float stratus_lobe(vec4 lobe, StratusPath path) {
    float square = path.forward * lobe.z + (path.backward * lobe.w + lobe.y);
    return lobe.x / (square * sqrt(square));
}

// Phase functions side by side: of the layer, of a layer that is its lower boundary.
vec4 stratus_phases(int side, StratusPath path) {
    vec4 polynomial = stratus_field(side, 0);
    if (polynomial.w > 0.0f) {
        float x = (sqrt(path.forward * 0.5f) - sqrt(path.backward * 0.5f)) * 0.5f + 0.5f;
        float place = stratus_clamp(x, 0.0f, 0.999999f) * polynomial.w;
        float sample_before = floor(place);
        float t = place - sample_before;
        vec4 at = stratus_number(int(stratus_field(side, 13).z) + int(sample_before));
        return vec4(at.x + t * (at.z - at.x), at.y + t * (at.w - at.y), 0.0f, 0.0f);
    }
    return vec4(path.forward * (path.forward * polynomial.z + polynomial.y) + polynomial.x +
                    stratus_lobe(stratus_field(side, 1), path) +
                    stratus_lobe(stratus_field(side, 2), path),
                0.0f, 0.0f, 0.0f);
}

float stratus_single_reflection(float albedo, float depth, StratusPath path) {
    vec4 phases = stratus_phases(STRATUS_REFLECTION, path);
    vec4 boundary = stratus_field(STRATUS_REFLECTION, 11);
    StratusAttenuation into = stratus_attenuation(depth / path.mu_in);
    StratusAttenuation back = stratus_attenuation(depth / path.mu_out);
    float beam = into.transmitted * back.transmitted;
    float lost = into.extinguished + back.extinguished - into.extinguished * back.extinguished;
    return (phases.x * lost * albedo * 0.25f + phases.y * beam * boundary.y) /
               (path.mu_in + path.mu_out) +
           beam * boundary.x;
}

float stratus_single_transmission(float albedo, float depth, StratusPath path) {
    float steep = 1.0f / max(path.mu_in, path.mu_out);
    float shallow = 1.0f / min(path.mu_in, path.mu_out);
    float excess = max((shallow - steep) * depth, 1e-18f);
    StratusAttenuation beam = stratus_attenuation(steep * depth);
    StratusAttenuation more = stratus_attenuation(excess);
    return stratus_phases(STRATUS_TRANSMISSION, path).x * beam.transmitted * (steep * depth) *
           shallow * (more.extinguished / excess) * albedo * 0.25f;
}

// ---- the path law of narrow peaks: H and dH/ds over slant depth s and angle

// Texel of a light path's angle in the first row, the share of the way to the next, and a scale.
vec4 stratus_path_angle(int side, StratusPath path) {
    vec4 sheet = stratus_field(side, 12);
    float x = stratus_clamp(min(path.forward, path.backward), 0.0f, 1.0f) + sheet.x;
    int exponent = stratus_exponent(x);
    float place = (x * stratus_power_of_two(-exponent) - 1.0f) * 32.0f;
    float angle = (float(exponent) + 127.0f) * 32.0f + floor(place) - sheet.y;
    return vec4(path.backward < path.forward ? angle + sheet.z : angle, place - floor(place),
                1.0f / x, 0.0f);
}

// H in .x, dH/ds in .y, of the rows from texel first on.
vec4 stratus_path_value(int side, int first, vec4 angle, float depth) {
    vec4 sheet = stratus_field(side, 12);
    float x = min(depth + 1.0f, stratus_field(side, 11).w);
    int exponent = stratus_exponent(x);
    float place = (x * stratus_power_of_two(-exponent) - 1.0f) * 4.0f;
    int row = 2 * int(sheet.z);
    int at = first + (exponent * 4 + int(floor(place))) * row + int(angle.x);
    vec4 low = stratus_number(at);
    vec4 high = stratus_number(at + row);
    float width = stratus_power_of_two(exponent - 2);
    float t = place - floor(place);
    float from = low.x + angle.y * (low.z - low.x);
    float rise = high.x + angle.y * (high.z - high.x) - from;
    float start = (low.y + angle.y * (low.w - low.y)) * width;
    float end = (high.y + angle.y * (high.w - high.y)) * width;
    float b = rise * 3.0f - start * 2.0f - end;
    float c = start + end - rise * 2.0f;
    return vec4(from + t * (start + t * (b + t * c)),
                (start + t * (b * 2.0f + t * c * 3.0f)) / width, 0.0f, 0.0f);
}

float stratus_path_reflection(int first, float depth, vec4 angle, StratusPath path) {
    float both = depth / path.mu_in + depth / path.mu_out;
    return stratus_path_value(STRATUS_REFLECTION, first, angle, both).x * angle.z * 0.25f /
           (path.mu_in + path.mu_out);
}

float stratus_path_transmission(int first, float depth, vec4 angle, StratusPath path) {
    float steep = 1.0f / max(path.mu_in, path.mu_out);
    float shallow = 1.0f / min(path.mu_in, path.mu_out);
    float least = steep * depth;
    float excess = max((shallow - steep) * depth, 1e-18f);
    if (least + 1.0f >= stratus_field(STRATUS_TRANSMISSION, 11).w) return 0.0f;
    float slope;
    if (excess < (least + 1.0f) * 0.05f) {
        slope = stratus_path_value(STRATUS_TRANSMISSION, first, angle, least + excess * 0.5f).y;
    } else {
        slope = (stratus_path_value(STRATUS_TRANSMISSION, first, angle, least + excess).x -
                 stratus_path_value(STRATUS_TRANSMISSION, first, angle, least).x) /
                excess;
    }
    return slope * angle.z * least * shallow * 0.25f;
}

// Orders n >= 2 of the path law: cubic in the square of the albedo.
float stratus_along_path(int side, float albedo, float depth, StratusPath path) {
    float steps = stratus_field(side, 11).z;
    if (steps == 0.0f) return 0.0f;
    StratusPlace at = stratus_place(vec4(0.0f, steps, steps, 0.0f), albedo * albedo);
    vec4 angle = stratus_path_angle(side, path);
    int channel = int(stratus_field(side, 12).w);
    int first = int(stratus_field(side, 13).w) + int(at.first) * channel;
    float sum = 0.0f;
    for (int k = 0; k < 4; ++k) {
        float value = side == STRATUS_REFLECTION
                          ? stratus_path_reflection(first + k * channel, depth, angle, path)
                          : stratus_path_transmission(first + k * channel, depth, angle, path);
        sum = sum + stratus_component(at.weight, k) * value;
    }
    return sum * albedo * albedo;
}

// ---- orders n >= 2 that a table holds

// What functions and coefficients were divided by.
float stratus_reflection_factor(float albedo, float depth, float exponent, StratusPath path) {
    vec4 range = stratus_field(STRATUS_REFLECTION, 9);
    vec4 kind = stratus_field(STRATUS_REFLECTION, 10);
    float into = stratus_attenuation(depth / path.mu_in).extinguished;
    float back = stratus_attenuation(depth / path.mu_out).extinguished;
    if (kind.y > 0.0f) {
        float within = stratus_clamp(depth, 1e-30f, kind.x);
        StratusAttenuation edge = stratus_attenuation(exponent * (2.0f * kind.w));
        StratusAttenuation deep = stratus_attenuation(exponent * within * 2.0f);
        float d = deep.transmitted * edge.extinguished /
                  (edge.extinguished + deep.extinguished - edge.extinguished * deep.extinguished);
        float scale = depth > range.w && stratus_field(STRATUS_REFLECTION, 4).w > 0.0f
                          ? 1.0f
                          : 1.0f / (d * (d + 1.0f) + 1.0f);
        float clamped = min(depth, kind.x);
        if (depth > kind.x) {
            into = stratus_attenuation(clamped / path.mu_in).extinguished;
            back = stratus_attenuation(clamped / path.mu_out).extinguished;
        }
        return into * back * scale * stratus_clamp(albedo, range.x, range.y);
    }
    if (kind.z == 0.0f) return 1.0f;
    float thinnest = stratus_attenuation(range.z / path.mu_in).extinguished +
                     stratus_attenuation(range.z / path.mu_out).extinguished;
    return min((into + back) / thinnest, 1.0f);
}

float stratus_transmission_factor(float albedo, float depth, float exponent, StratusPath path) {
    vec4 range = stratus_field(STRATUS_TRANSMISSION, 9);
    vec4 kind = stratus_field(STRATUS_TRANSMISSION, 10);
    float within = stratus_clamp(depth, 1e-30f, kind.x);
    float into = stratus_attenuation(min(depth, kind.x) / path.mu_in).extinguished;
    float out_of = stratus_attenuation(min(depth, kind.x) / path.mu_out).extinguished;
    StratusAttenuation edge = stratus_attenuation(exponent * (2.0f * kind.w));
    StratusAttenuation deep = stratus_attenuation(exponent * within);
    float twice = deep.extinguished * (deep.transmitted + 1.0f);
    return into * out_of * deep.transmitted * edge.extinguished /
           (edge.extinguished + twice - edge.extinguished * twice) *
           stratus_clamp(albedo, range.x, range.y);
}

// Reflection between the deepest finite sample and infinity, as diffusion has it: the share of the
// finite one at sample l of the cubic in albedo, and that of infinity.
vec4 stratus_deep_weight(StratusPlace albedo, int l, float exponent, float depth) {
    float length = stratus_field(STRATUS_REFLECTION, 10).w;
    StratusAttenuation edge = stratus_attenuation(exponent * (2.0f * length));
    StratusAttenuation deep = stratus_attenuation(exponent * depth * 2.0f);
    float deficit =
        deep.transmitted * edge.extinguished /
        (edge.extinguished + deep.extinguished - edge.extinguished * deep.extinguished);
    float handed_on = 0.0f;  // by samples whose own deficit has fallen out of reach
    for (int k = 0; k < l; ++k) {
        float inverse_before = stratus_of_albedo(STRATUS_REFLECTION, int(albedo.first) + k).y;
        handed_on = inverse_before == 0.0f ? stratus_component(albedo.weight, k) + handed_on : 0.0f;
    }
    vec4 of = stratus_of_albedo(STRATUS_REFLECTION, int(albedo.first) + l);
    float own = stratus_component(albedo.weight, l);
    float share = (own + handed_on) * deficit * of.y;
    return vec4(0.0f, 0.0f, share * of.z, own - share);
}

// Where a lookup reads functions, and their weights.
struct StratusDirections {
    StratusPlace mu;
    StratusPlace other;
    vec4 azimuth_weight;
    int first_azimuth;
};

StratusDirections stratus_directions(int side, StratusPath path) {
    vec4 axis_in = stratus_field(side, 5);
    vec4 axis_out = stratus_field(side, 6);
    vec4 around = stratus_field(side, 7);
    vec4 window = stratus_field(side, 8);
    float root_in = sqrt(path.mu_in);
    float root_out = sqrt(path.mu_out);
    float into = -stratus_twice_arcsine(max(1.0f - path.mu_in, 0.0f) * 0.5f /
                                        ((sqrt(root_in) + 1.0f) * (root_in + 1.0f)));
    float back = -stratus_twice_arcsine(max(1.0f - path.mu_out, 0.0f) * 0.5f /
                                        ((sqrt(root_out) + 1.0f) * (root_out + 1.0f)));
    StratusDirections at;
    at.mu = stratus_place(axis_in, axis_in.w > 0.0f ? max(into, back) : into);
    at.other = stratus_place(axis_out, axis_in.w > 0.0f ? min(into, back) : back);
    at.azimuth_weight = vec4(1.0f, 0.0f, 0.0f, 0.0f);
    at.first_azimuth = 0;
    if (around.z > 1.0f) {
        float along = around.w > 0.0f ? sqrt(path.half_turn) : path.half_turn;
        float place = stratus_clamp((along - around.x) * around.y, 0.0f,
                                    (around.z - 1.0f) * 0.999999f);
        float cell = floor(place);
        float first = stratus_clamp(cell - 1.0f, window.x, window.y);
        at.first_azimuth = int(first) + 1;  // a mirrored sample lies before the first
        at.azimuth_weight = stratus_cubic((place - cell) + (cell - first));
    }
    return at;
}

// Four of the sixteen functions, the wordth, at the directions; block: first texel.
vec4 stratus_functions_at(int side, int block, int word, StratusDirections at) {
    vec4 window = stratus_field(side, 8);
    int azimuths = int(stratus_field(side, 7).z);
    int rows = azimuths > 1 ? azimuths + 2 : 1;  // of one pair of cosines
    int around = azimuths > 1 ? 4 : 1;
    bool symmetric = stratus_field(side, 5).w > 0.0f;
    vec4 sum = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    for (int r = 0; r < 4; ++r) {
        int i = int(at.mu.first) + r;
        int row = symmetric ? i * (i + 7) / 2 * rows : i * int(window.z);
        vec4 of_other = vec4(0.0f, 0.0f, 0.0f, 0.0f);
        for (int c = 0; c < 4; ++c) {
            int texel = block + 4 * (row + (int(at.other.first) + c) * int(window.w) +
                                     at.first_azimuth) + word;
            vec4 of_azimuth = vec4(0.0f, 0.0f, 0.0f, 0.0f);
            for (int a = 0; a < around; ++a)
                of_azimuth = of_azimuth + stratus_function(texel + 4 * a) *
                                              stratus_component(at.azimuth_weight, a);
            of_other = of_other + of_azimuth * stratus_component(at.other.weight, c);
        }
        sum = sum + of_other * stratus_component(at.mu.weight, r);
    }
    return sum;
}

float stratus_multiple(int side, float albedo, float depth, StratusPath path) {
    float along_path = stratus_along_path(side, albedo, depth, path);
    if (stratus_field(side, 14).x == 0.0f) return along_path;  // the table does not have this side
    vec4 albedo_axis = stratus_field(side, 3);
    vec4 depth_axis = stratus_field(side, 4);
    float root = sqrt(max(1.0f - albedo, 0.0f));
    StratusPlace in_albedo =
        stratus_place(albedo_axis, -(albedo_axis.w > 0.0f ? sqrt(root) : root));
    float within = stratus_clamp(depth, 1e-30f, stratus_field(side, 10).x);
    StratusPlace in_depth = stratus_place(depth_axis, stratus_log2(within));
    float exponent = 0.0f;
    for (int k = 0; k < 4; ++k)
        exponent = exponent + stratus_component(in_albedo.weight, k) *
                                  stratus_of_albedo(side, int(in_albedo.first) + k).x;
    exponent = max(exponent, 1e-20f);
    float factor = side == STRATUS_REFLECTION
                       ? stratus_reflection_factor(albedo, depth, exponent, path)
                       : stratus_transmission_factor(albedo, depth, exponent, path);
    // first texels of functions and coefficients, depths of a row of these, its first depth
    vec4 cell = stratus_number(int(stratus_field(side, 13).y) +
                               int(in_albedo.cell) * int(depth_axis.z + 1.0f) + int(in_depth.cell));
    bool beyond = depth > stratus_field(side, 9).w && depth_axis.w > 0.0f;
    int first_depth = beyond ? int(cell.w + cell.z) - 4 : int(in_depth.first);
    vec4 weight[4];
    for (int l = 0; l < 4; ++l) {
        weight[l] = in_depth.weight * stratus_component(in_albedo.weight, l);
        if (beyond) weight[l] = stratus_deep_weight(in_albedo, l, exponent, within);
    }
    StratusDirections directions = stratus_directions(side, path);
    float sum = 0.0f;
    for (int word = 0; word < 4; ++word) {
        vec4 coefficient = vec4(0.0f, 0.0f, 0.0f, 0.0f);
        for (int l = 0; l < 4; ++l) {
            int row = int(cell.y) + 4 * ((int(in_albedo.first) + l) * int(cell.z) + first_depth);
            for (int k = 0; k < 4; ++k)
                coefficient = coefficient + stratus_number(row + 4 * k + word) *
                                                stratus_component(weight[l], k);
        }
        sum = sum + dot(coefficient, stratus_functions_at(side, int(cell.x), word, directions));
    }
    return sum * factor + along_path;
}

// ---- what is called

StratusScattered stratus_scattered(int side, float albedo, float optical_depth, StratusPath path) {
    float depth = stratus_clamp(optical_depth, 0.0f, 1e30f);
    StratusScattered light;
    light.single = 0.0f;
    light.multiple = 0.0f;
    if (side == STRATUS_REFLECTION) {
        light.single = stratus_single_reflection(albedo, depth, path);
        light.multiple = stratus_multiple(side, albedo, depth, path);
    } else if (stratus_field(side, 14).y == 0.0f) {  // nothing passes a lower boundary
        light.single = stratus_single_transmission(albedo, depth, path);
        light.multiple = stratus_multiple(side, albedo, depth, path);
    }
    return light;
}

StratusScattered stratus_reflection(float albedo, float optical_depth, float mu_in, float mu_out,
                                    float azimuth) {
    return stratus_scattered(STRATUS_REFLECTION, albedo, optical_depth,
                             stratus_path(STRATUS_REFLECTION, mu_in, mu_out, azimuth));
}

StratusScattered stratus_transmission(float albedo, float optical_depth, float mu_in, float mu_out,
                                      float azimuth) {
    return stratus_scattered(STRATUS_TRANSMISSION, albedo, optical_depth,
                             stratus_path(STRATUS_TRANSMISSION, mu_in, mu_out, azimuth));
}

float stratus_single(int side, float albedo, float optical_depth, float mu_in, float mu_out,
                     float azimuth) {
    float depth = stratus_clamp(optical_depth, 0.0f, 1e30f);
    StratusPath path = stratus_path(side, mu_in, mu_out, azimuth);
    if (side == STRATUS_REFLECTION) return stratus_single_reflection(albedo, depth, path);
    if (stratus_field(side, 14).y > 0.0f) return 0.0f;
    return stratus_single_transmission(albedo, depth, path);
}

float stratus_bsdf(vec3 wi, vec3 wo, float albedo, float optical_depth) {
    int side = wi.z * wo.z > 0.0f ? STRATUS_REFLECTION : STRATUS_TRANSMISSION;
    StratusScattered light =
        stratus_scattered(side, albedo, optical_depth, stratus_path_between(side, wi, wo));
    return (light.single + light.multiple) * 0.318309886f;
}

float stratus_direct(float optical_depth, float mu) {
    return stratus_attenuation(optical_depth / max(mu, 1e-6f)).transmitted;
}

float stratus_phase(float cos_theta) {
    StratusPath path;
    path.mu_in = 1.0f;
    path.mu_out = 1.0f;
    path.forward = 1.0f - cos_theta;
    path.backward = 1.0f + cos_theta;
    path.half_turn = 0.0f;
    return stratus_phases(STRATUS_TRANSMISSION, path).x;
}

// Optical depth of particles that fill the share density of the volume, [0, 1). [Blinn82] 5.1
float stratus_effective_depth(float optical_depth, float density) {
    return optical_depth / (1.0f - density);
}

// Hapke's opposition, by which single scattering on the lit side is to be multiplied:
// 1 + amplitude / (1 + tan(a/2) / width), a the phase angle.
float stratus_hapke(float amplitude, float width, float cos_theta) {
    float cosine = sqrt(max(1.0f - cos_theta, 0.0f));
    float sine = sqrt(max(1.0f + cos_theta, 0.0f));
    return 1.0f + amplitude * width * cosine / max(width * cosine + sine, 1e-30f);
}
