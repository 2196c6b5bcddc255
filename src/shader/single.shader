// Stratus: lookups in a packed table, from the textures that lie beside this file.
//
// albedo [0, 1] and optical_depth [0, inf) are those of the layer at this point; mu_in and mu_out,
// (0, 1], are cosines to the normal of the directions to the light and to the eye; azimuth, in
// radians, lies between the two directions of propagation: 0 is forward. R = 1 is a white Lambert
// surface: BRDF = R / pi. Light that goes straight through is stratus_direct alone. Over a lower
// boundary R is that of both, and T is 0. A stack has an albedo and a depth of its own: those given
// count for nothing. Both are lit from above.
//
//   stratus_reflection(albedo, optical_depth, mu_in, mu_out, azimuth)     R: .single, .multiple
//   stratus_transmission(albedo, optical_depth, mu_in, mu_out, azimuth)   diffuse T, likewise
//   stratus_single(side, albedo, optical_depth, mu_in, mu_out, azimuth)   .single of either
//   stratus_bsdf(wi, wo, albedo, optical_depth)  BRDF or BTDF, without the cosine: unit vectors that
//                                                point away from the layer, z along its normal
//   stratus_bsdf_rgb(wi, wo, albedo, optical_depth)  of three albedos, with fewer fetches than thrice
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

float stratus_transmitted(float x) {
    StratusAttenuation of = stratus_attenuation(x);
    return of.transmitted;
}

float stratus_extinguished(float x) {
    StratusAttenuation of = stratus_attenuation(x);
    return of.extinguished;
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
    float high = z * (z * (z * 0.084298202f - 0.047614748f) + 0.04787879f) + 0.025548843f;
    float p = z * (z * (z * high + 0.045064493f) + 0.074986517f) + 0.16666674f;
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

// ---- components of what functions return: OSL selects those of variables alone

float stratus_x(vec4 v) { return v.x; }
float stratus_y(vec4 v) { return v.y; }
float stratus_z(vec4 v) { return v.z; }
float stratus_w(vec4 v) { return v.w; }

// ---- what the textures hold: a record of 16 texels for each side, then arrays (docs/shaders.md)

vec4 stratus_field(int side, int k) { return stratus_number(side * 16 + k); }

// Numbers of filtered textures. 0: how much finer than the table the light is along cosines and along the
// azimuth; blocks of depths of reflection and of transmission. 1: a depth, rows of weights from one albedo
// to the next, width and height of the weights; of a bound layer how many of the path law's angles are one
// step. 2: the factors of sums of either side; of the path law what a unit of slant depth takes at albedo 1,
// and the deepest. 3: of its texture rows to an octave of 2 + slant depth, octaves, slices, the factor of
// sums. From 4 + 24 side on of each block: where it ends, the column of the weights at 0, columns per unit.
vec4 stratus_filter(int k) {
    return stratus_number(32 + k);
}

// Texel of sample k of the albedo: diffusion exponent, 1 / deficit and scale of the deepest finite sample.
vec4 stratus_of_albedo(int side, int k) {
    return stratus_number(int(stratus_x(stratus_field(side, 13))) + k);
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
float stratus_along_axis(vec4 axis, float coordinate) {
    return stratus_clamp((coordinate - axis.x) * axis.y, 0.0f, axis.z);
}

StratusPlace stratus_place(vec4 axis, float along) {
    StratusPlace at;
    at.cell = floor(along);
    at.first = stratus_clamp(at.cell - 1.0f, 0.0f, axis.z - 3.0f);
    at.weight = stratus_cubic(along - at.first);
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

StratusPath stratus_path_of(int side, float cosine_in, float cosine_out, float half_turn,
                            float half_azimuth) {
    float mu_in = stratus_clamp(cosine_in, 1e-6f, 1.0f);
    float mu_out = stratus_clamp(cosine_out, 1e-6f, 1.0f);
    float sine_in = sqrt((1.0f - mu_in) * (mu_in + 1.0f));
    float sine_out = sqrt((1.0f - mu_out) * (mu_out + 1.0f));
    float sum = mu_in + mu_out;
    float difference = mu_in - mu_out;
    float along = sine_in - sine_out;
    float sines = sine_in * sine_out * 2.0f;
    float apart = (difference * difference + along * along) * 0.5f;
    float opposite = (sum * sum + along * along) * 0.5f;
    StratusPath path;
    path.mu_in = mu_in;
    path.mu_out = mu_out;
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

// Phase functions side by side: of the layer, of a layer that is its lower boundary. Texel curve is
// the first of three; texel samples is that of their samples, if there are any.
vec4 stratus_phases_of(int curve, int samples, StratusPath path) {
    vec4 polynomial = stratus_number(curve);
    if (polynomial.w > 0.0f) {
        float x = (sqrt(path.forward * 0.5f) - sqrt(path.backward * 0.5f)) * 0.5f + 0.5f;
        float place = stratus_clamp(x, 0.0f, 0.999999f) * polynomial.w;
        float sample_before = floor(place);
        float t = place - sample_before;
        vec4 at = stratus_number(samples + int(sample_before));
        return vec4(at.x + t * (at.z - at.x), at.y + t * (at.w - at.y), 0.0f, 0.0f);
    }
    return vec4(path.forward * (path.forward * polynomial.z + polynomial.y) + polynomial.x +
                    stratus_lobe(stratus_number(curve + 1), path) +
                    stratus_lobe(stratus_number(curve + 2), path),
                0.0f, 0.0f, 0.0f);
}

float stratus_once_transmitted(float phase, float albedo, float depth, StratusPath path) {
    float steep = 1.0f / max(path.mu_in, path.mu_out);
    float shallow = 1.0f / min(path.mu_in, path.mu_out);
    float excess = max((shallow - steep) * depth, 1e-18f);
    StratusAttenuation beam = stratus_attenuation(steep * depth);
    StratusAttenuation more = stratus_attenuation(excess);
    return phase * beam.transmitted * (steep * depth) * shallow * (more.extinguished / excess) *
           albedo * 0.25f;
}

// Sums over the layers of a stack: each one's own light, through those above it and, where light leaves
// below, those beneath it.
float stratus_single_of_layers(int side, StratusPath path) {
    vec4 stack = stratus_field(side, 15);
    float above = 0.0f;
    float sum = 0.0f;
    for (int k = 0; k < int(stack.y); ++k) {
        int curve = int(stack.x) + 4 * k;
        vec4 of = stratus_number(curve + 3);  // albedo, depth, first of its phase samples
        float phase = stratus_x(stratus_phases_of(curve, int(of.z), path));
        float outgoing = side == STRATUS_REFLECTION ? above : max(stack.z - above - of.y, 0.0f);
        float through = stratus_transmitted(above / path.mu_in + outgoing / path.mu_out);
        float lost = stratus_extinguished(of.y / path.mu_in + of.y / path.mu_out);
        float once = side == STRATUS_REFLECTION
                         ? phase * lost * of.x * 0.25f / (path.mu_in + path.mu_out)
                         : stratus_once_transmitted(phase, of.x, of.y, path);
        sum = sum + through * once;
        above = above + of.y;
    }
    return sum;
}

bool stratus_is_stack() { return stratus_y(stratus_field(STRATUS_REFLECTION, 15)) > 0.0f; }

// Optical depth, [0, 1e30], of the layer or of all layers of a stack.
float stratus_depth(float optical_depth) {
    vec4 stack = stratus_field(STRATUS_REFLECTION, 15);
    return stratus_clamp(stack.y > 0.0f ? stack.z : optical_depth, 0.0f, 1e30f);
}

// All that single scattering needs to know of the directions: phase functions of the layer and of a
// layer below it; of a stack, in .z, the light itself.
vec4 stratus_phases(int side, StratusPath path) {
    vec4 phases = stratus_phases_of(side * 16, int(stratus_z(stratus_field(side, 13))), path);
    if (stratus_is_stack()) phases.z = stratus_single_of_layers(side, path);
    return phases;
}

float stratus_single_reflection(vec4 phases, float albedo, float depth, StratusPath path) {
    vec4 boundary = stratus_field(STRATUS_REFLECTION, 11);
    StratusAttenuation into = stratus_attenuation(depth / path.mu_in);
    StratusAttenuation back = stratus_attenuation(depth / path.mu_out);
    float beam = into.transmitted * back.transmitted;
    float sum = path.mu_in + path.mu_out;
    float below = phases.y * beam * boundary.y / sum + beam * boundary.x;
    if (stratus_is_stack()) return phases.z + below;
    float lost = into.extinguished + back.extinguished - into.extinguished * back.extinguished;
    return phases.x * lost * albedo * 0.25f / sum + below;
}

float stratus_single_scattering(int side, vec4 phases, float albedo, float depth,
                                StratusPath path) {
    if (side == STRATUS_REFLECTION) return stratus_single_reflection(phases, albedo, depth, path);
    if (stratus_is_stack()) return phases.z;
    return stratus_once_transmitted(phases.x, albedo, depth, path);
}
