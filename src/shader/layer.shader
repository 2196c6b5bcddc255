// ---- one layer, bound: its three colours in one texture, and directions drawn for it.
//
// Define STRATUS_LAYER before this file is included. With STRATUS_FILTERED, which the text of a
// filtered layer defines itself, its orders n >= 2 are four fetches from a 3-D texture.
//
//   stratus_layer_reflection(mu_in, mu_out, azimuth), stratus_layer_transmission   R and diffuse T
//   stratus_layer_bsdf(wi, wo)             BRDF or BTDF, without the cosine
//   stratus_layer_direct(mu)               exp(-tau / mu)
//   stratus_layer_sample(wi, u1, u2, u3)   a direction in proportion to the light scattered into it
//   stratus_layer_pdf(wi, wo)              the density that it is drawn with, per steradian
#ifdef STRATUS_LAYER

// Returns for a colour: optical depth, albedo, diffusion exponent, unit of a filtered texture.
vec4 stratus_layer_colour(int colour) { return stratus_layer_texel(colour); }

#ifdef STRATUS_FILTERED
// Orders n >= 2 of the colours in .x to .z, before the factor.
vec4 stratus_layer_sum(int side, StratusPath path) {
    vec4 sum = stratus_light_sum(side, float(side), 2.0f, 0.0f, 1.0f, 1, path);
    return vec4(sum.x * stratus_w(stratus_layer_colour(0)),
                sum.y * stratus_w(stratus_layer_colour(1)),
                sum.z * stratus_w(stratus_layer_colour(2)), 0.0f);
}
#else
vec4 stratus_layer_sum(int side, StratusPath path) {
    vec4 first = stratus_layer_texel(3);
    return stratus_sum_at(side, 1, int(side == STRATUS_REFLECTION ? first.x : first.y), 1,
                          stratus_directions(side, stratus_places(side, path)));
}
#endif

#ifdef STRATUS_FILTERED_PATH
// Orders n >= 2 of the path law of the colours at a depth, but for the share of each; by one fetch.
vec4 stratus_layer_law(int side, float depth, StratusPath path) {
    vec4 sheet = stratus_field(side, 12);
    float step = stratus_x(stratus_filter(1));  // among the law's angles, a half from its first on
    StratusPathPlace at = stratus_path_place(side, depth, path);
    vec4 angle = stratus_path_angle(side, path);
    float angles = floor((sheet.z - 2.0f) / step) + 2.0f;
    float half_first = angle.x < sheet.z ? 0.0f : 1.0f;
    float place = (angle.x + angle.y - half_first * sheet.z) / step + half_first * angles + 0.5f;
    return stratus_path_law_at(vec3(place / (2.0f * angles), at.row, at.slice)) *
           (angle.z * at.scale);
}

// Orders n >= 2 of the path law of the colours.
vec3 stratus_layer_along_path(int side, StratusPath path) {
    vec4 r = stratus_layer_colour(0);
    vec4 g = stratus_layer_colour(1);
    vec4 b = stratus_layer_colour(2);
    if (stratus_x(stratus_filter(3)) == 0.0f) return vec3(0.0f, 0.0f, 0.0f);
    vec4 red = stratus_layer_law(side, r.x, path);
    vec4 green = red;
    if (g.x != r.x) green = stratus_layer_law(side, g.x, path);
    vec4 blue = green;
    if (b.x != g.x) blue = stratus_layer_law(side, b.x, path);
    return vec3(red.x * stratus_path_share(side, r.y, r.x, path),
                green.y * stratus_path_share(side, g.y, g.x, path),
                blue.z * stratus_path_share(side, b.y, b.x, path));
}
#else
vec3 stratus_layer_along_path(int side, StratusPath path) {
    vec4 r = stratus_layer_colour(0);
    vec4 g = stratus_layer_colour(1);
    vec4 b = stratus_layer_colour(2);
    return vec3(stratus_along_path(side, r.y, r.x, path), stratus_along_path(side, g.y, g.x, path),
                stratus_along_path(side, b.y, b.x, path));
}
#endif

struct StratusColours {
    vec3 single;
    vec3 multiple;
};

StratusColours stratus_layer_scattered(int side, StratusPath path) {
    float single[3];
    float multiple[3];
    vec4 kind = stratus_field(side, 14);
    bool blocked = side == STRATUS_TRANSMISSION && kind.y > 0.0f;
    vec4 sum = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    if (kind.x > 0.0f) sum = stratus_layer_sum(side, path);
    vec4 phases = stratus_phases(side, path);
    vec3 along_path = stratus_layer_along_path(side, path);
    for (int c = 0; c < 3; ++c) {
        vec4 of = stratus_layer_colour(c);
        float once = stratus_single_scattering(side, phases, of.y, of.x, path);
        float more = max(stratus_component(sum, c) * stratus_factor(side, of.y, of.x, of.z, path) +
                         (c == 0 ? along_path.x : (c == 1 ? along_path.y : along_path.z)), 0.0f);
        bool dark = blocked || once + more < 0.0f;
        single[c] = dark ? 0.0f : once;
        multiple[c] = dark ? 0.0f : more;
    }
    StratusColours light;
    light.single = vec3(single[0], single[1], single[2]);
    light.multiple = vec3(multiple[0], multiple[1], multiple[2]);
    return light;
}

StratusColours stratus_layer_reflection(float mu_in, float mu_out, float azimuth) {
    return stratus_layer_scattered(STRATUS_REFLECTION,
                                   stratus_path(STRATUS_REFLECTION, mu_in, mu_out, azimuth));
}

StratusColours stratus_layer_transmission(float mu_in, float mu_out, float azimuth) {
    return stratus_layer_scattered(STRATUS_TRANSMISSION,
                                   stratus_path(STRATUS_TRANSMISSION, mu_in, mu_out, azimuth));
}

vec3 stratus_layer_bsdf(vec3 wi, vec3 wo) {
    int side = wi.z * wo.z > 0.0f ? STRATUS_REFLECTION : STRATUS_TRANSMISSION;
    float held = stratus_x(stratus_field(side, 14));  // by the table
    if (held == 0.0f || (wi.z < 0.0f && stratus_is_one_sided())) return vec3(0.0f, 0.0f, 0.0f);
    StratusColours light = stratus_layer_scattered(side, stratus_path_between(side, wi, wo));
    return (light.single + light.multiple) * 0.318309886f;
}

vec3 stratus_layer_direct(float mu) {
    if (stratus_y(stratus_field(STRATUS_TRANSMISSION, 14)) > 0.0f) return vec3(0.0f, 0.0f, 0.0f);
    return vec3(stratus_direct(stratus_x(stratus_layer_colour(0)), mu),
                stratus_direct(stratus_x(stratus_layer_colour(1)), mu),
                stratus_direct(stratus_x(stratus_layer_colour(2)), mu));
}

// ---- directions: the coordinates of src/bsdf/direction_coordinates.h

float stratus_layer_float(float first, int n) {
    return stratus_component(stratus_layer_texel(int(first) + n / 4), n - n / 4 * 4);
}

// v = sqrt(1 - sqrt(mu)), sqrt(mu), mu.
vec4 stratus_cosine_at(float v) {
    float inside = stratus_clamp(v, 1e-6f, 0.99995f);
    float root = (1.0f - inside) * (1.0f + inside);
    return vec4(inside, root, root * root, 0.0f);
}

vec4 stratus_cosine(float mu, float sine_squared) {
    float inside = stratus_clamp(mu, 0.0f, 1.0f);
    return stratus_cosine_at(sqrt(sine_squared / ((1.0f + inside) * (1.0f + sqrt(inside)))));
}

float stratus_sine(vec4 cosine) {
    return cosine.x * sqrt((1.0f + cosine.y) * (1.0f + cosine.z));
}

// A coordinate of distances in [0, 1], linear in the fourth root of blur + distance: blur, the root
// at 0, and the rise to that at 1.
vec4 stratus_fourth_root(float blur) {
    float from = sqrt(sqrt(blur));
    return vec4(blur, from, sqrt(sqrt(1.0f + blur)) - from, 0.0f);
}

float stratus_root_distance(vec4 root, float place) {
    float at = root.y + place * root.z;
    return stratus_clamp(at * at * at * at - root.x, 0.0f, 1.0f);
}

float stratus_root_stretch(vec4 root, float place) {
    float at = root.y + place * root.z;
    return 4.0f * root.z * at * at * at;
}

float stratus_root_place(vec4 root, float distance) {
    return (sqrt(sqrt(root.x + distance)) - root.y) / root.z;
}

bool stratus_is_peaked() { return stratus_y(stratus_layer_texel(4)) > 0.0f; }

// Returns for a side .x at the same cosine, .y at the horizon: widths of peaks; .z slope.
vec4 stratus_peaks(int side) { return stratus_layer_texel(6 + side); }

vec4 stratus_cosine_root(int side, vec4 into, float reach) {
    float blur = side == STRATUS_TRANSMISSION ? 0.005f / (3.0f * into.y + 0.005f) : 0.5f;
    return stratus_fourth_root(blur / (abs(reach) + blur));
}

// Lobes: tan(azimuth / 2) = .x q / (.y (1 - q)). Sharp peaks: the fourth root along
// tan(azimuth / 4).
vec4 stratus_azimuth_scale(int side, vec4 into, vec4 away) {
    if (stratus_is_peaked()) {
        float sine_in = stratus_sine(into);
        float sine_out = stratus_sine(away);
        float along = sine_in - sine_out;
        float across = side == STRATUS_TRANSMISSION ? into.z - away.z : into.z + away.z;
        float smallest = 0.000025f + along * along + across * across;
        return stratus_fourth_root(sqrt(smallest / (16.0f * sine_in * sine_out + smallest)));
    }
    vec4 peaks = stratus_peaks(side);
    float apart = abs(into.x - away.x);
    float nearer = (peaks.x + apart) * (peaks.y + 1.0f);
    float farther = (peaks.x + (into.x + away.x)) * (peaks.y + (into.z + away.z) * 0.5f);
    if (side == STRATUS_REFLECTION) return vec4(farther, nearer, 0.0f, 0.0f);
    return vec4(nearer, farther, 0.0f, 0.0f);
}

// Cosine and sine of the azimuth at q in [0, 1], and d azimuth / d q.
vec4 stratus_azimuth_at(vec4 scale, float q) {
    if (stratus_is_peaked()) {
        float t = stratus_root_distance(scale, q);
        float half_cosine = (1.0f - t) * (1.0f + t) / (1.0f + t * t);
        float half_sine = 2.0f * t / (1.0f + t * t);
        return vec4((half_cosine - half_sine) * (half_cosine + half_sine),
                    2.0f * half_cosine * half_sine,
                    4.0f / (1.0f + t * t) * stratus_root_stretch(scale, q), 0.0f);
    }
    float x = scale.y * (1.0f - q);
    float y = scale.x * q;
    float square = x * x + y * y;
    return vec4((x - y) * (x + y) / square, 2.0f * x * y / square,
                2.0f * scale.x * scale.y / square, 0.0f);
}

// Returns, for a quarter of the sphere, from mu_in to the normal or, to_horizon 1, to the horizon, at s in
// [0, 1]: the cosine, and |d mu / d s| in .w.
vec4 stratus_outgoing(int side, float to_horizon, vec4 into, float s) {
    float reach = to_horizon - into.x;
    float distance;
    float stretch;
    if (stratus_is_peaked()) {
        vec4 root = stratus_cosine_root(side, into, reach);
        distance = stratus_root_distance(root, s);
        stretch = stratus_root_stretch(root, s);
    } else {
        float slope = stratus_z(stratus_peaks(side));
        distance = s * (slope + (1.0f - slope) * s);
        stretch = slope + 2.0f * (1.0f - slope) * s;
    }
    vec4 away = stratus_cosine_at(into.x + reach * distance);
    return vec4(away.x, away.y, away.z, abs(reach) * stretch * (4.0f * away.x * away.y));
}

// Among the incident cosines of the density.
float stratus_incident_place(vec4 into) {
    return (stratus_is_peaked() ? 2.0f * into.x / (0.1f + sqrt(0.01f + 3.6f * into.x))
                                : into.x - 1e-6f) *
           (stratus_z(stratus_layer_texel(4)) - 1.0f);
}

float stratus_density_place(float at, float count) {
    return stratus_clamp(at, 0.0f, (count - 1.0f) * 0.9999999f);
}

// The density at places among incident cosines, outgoing ones of a quarter, and azimuths.
float stratus_density_at(float at_row, float quarter, float at_line, float at_azimuth) {
    vec4 sizes = stratus_layer_texel(4);
    float azimuths = stratus_x(stratus_layer_texel(5));
    float row = stratus_density_place(at_row, sizes.z);
    float line_place = stratus_density_place(at_line, sizes.w);
    float around = stratus_density_place(at_azimuth, azimuths);
    int first = ((int(row) * 4 + int(quarter)) * int(sizes.w) + int(line_place)) * int(azimuths) +
                int(around);
    float first_texel = stratus_z(stratus_layer_texel(3));
    float sum = 0.0f;
    for (int r = 0; r < 2; ++r)
        for (int l = 0; l < 2; ++l) {
            int at = first + (r * 4 * int(sizes.w) + l) * int(azimuths);
            float low = stratus_layer_float(first_texel, at);
            float high = stratus_layer_float(first_texel, at + 1);
            float past_row = row - floor(row);
            float past_line = line_place - floor(line_place);
            sum = sum + (r == 1 ? past_row : 1.0f - past_row) *
                            (l == 1 ? past_line : 1.0f - past_line) *
                            (low + (around - floor(around)) * (high - low));
        }
    return sum;
}

// Light travels along -wi: cosine and sine of half the azimuth, and its square's sum, as
// BsdfOf::pdf has them.
float stratus_layer_pdf(vec3 wi, vec3 wo) {
    vec4 about = stratus_layer_texel(5);
    if (wi.z * wo.z == 0.0f || (wi.z < 0.0f && about.y > 0.0f)) return 0.0f;
    int side = wi.z * wo.z > 0.0f ? STRATUS_REFLECTION : STRATUS_TRANSMISSION;
    float x_in = wi.x + (wi.x < 0.0f ? -1e-9f : 1e-9f);
    float square_in = x_in * x_in + wi.y * wi.y;
    float square_out = wo.x * wo.x + wo.y * wo.y;
    float along = x_in * wo.x + wi.y * wo.y;
    float cross_part = abs(x_in * wo.y - wi.y * wo.x);
    float m = max(sqrt(square_in * square_out), 1e-18f);
    float larger = m + abs(along);
    float half_cosine = along > 0.0f ? cross_part : larger;
    float half_sine = along > 0.0f ? larger : cross_part;
    float square = 2.0f * m * larger;

    vec4 into = stratus_cosine(abs(wi.z), square_in);
    vec4 away = stratus_cosine(abs(wo.z), square_out);
    float to_horizon = away.x > into.x ? 1.0f : 0.0f;
    float reach = to_horizon - into.x;
    float distance = stratus_clamp(abs(away.x - into.x) / abs(reach), 0.0f, 1.0f);
    vec4 around = stratus_azimuth_scale(side, into, away);
    float s;
    float q;
    float stretch;  // of both coordinates, and one of two signs of the azimuth
    if (stratus_is_peaked()) {
        vec4 root = stratus_cosine_root(side, into, reach);
        float t = stratus_clamp(half_sine / (sqrt(square) + half_cosine), 0.0f, 1.0f);
        s = stratus_root_place(root, distance);
        q = stratus_root_place(around, t);
        stretch = abs(reach) * stratus_root_stretch(root, s) * stratus_root_stretch(around, q) *
                  (32.0f * away.x * away.y) / (1.0f + t * t);
    } else {
        float slope = stratus_z(stratus_peaks(side));
        float slope_here = sqrt(slope * slope + 4.0f * (1.0f - slope) * distance);
        float x = around.x * half_cosine;
        float y = around.y * half_sine;
        s = (slope_here - slope) * stratus_w(stratus_peaks(side));
        q = y / (x + y);
        float sum = (x + y) / sqrt(square);  // first: the square of x + y may be below all numbers
        stretch = abs(reach) * slope_here * 16.0f * away.x * away.y * sum * sum / (around.x * around.y);
    }
    vec4 sizes = stratus_layer_texel(4);
    return stratus_density_at(stratus_incident_place(into), float(2 * side) + to_horizon,
                              s * (sizes.w - 1.0f), q * (about.x - 1.0f)) /
           stretch;
}

// A place in [0, last] with the density of a tent around a sample, folded back at both ends.
float stratus_around_sample(float at, float last, float u) {
    float w = 2.0f * u - 1.0f;
    float tent = 1.0f - sqrt(stratus_clamp(1.0f - abs(w), 0.0f, 1.0f));
    float place = abs(at + (w < 0.0f ? -tent : tent));
    return min(place, 2.0f * last - place);
}

struct StratusSample {
    vec3 wo;
    vec3 value;  // stratus_layer_bsdf(wi, wo)
    float pdf;   // 0: nothing is scattered, and the rest is not to be used
};

// Which of count events, of cumulative probabilities from 0 on, and the random number made uniform
// again.
vec4 stratus_event(float first_texel, int first, int count, float u) {
    int low = 0;
    int high = count;
    for (int step = 0; step < 8; ++step) {
        int middle = (low + high) / 2;
        if (middle > low) {
            if (stratus_layer_float(first_texel, first + middle) <= u)
                low = middle;
            else
                high = middle;
        }
    }
    float before = stratus_layer_float(first_texel, first + low);
    float after = stratus_layer_float(first_texel, first + low + 1);
    return vec4(float(low), (u - before) / max(after - before, 1e-30f), 0.0f, 0.0f);
}

// u1, u2 and u3, in [0, 1): the cosine and its side, the azimuth, one of two tabulated cosines.
StratusSample stratus_layer_sample(vec3 wi, float u1, float u2, float u3) {
    StratusSample drawn;
    drawn.wo = vec3(0.0f, 0.0f, 1.0f);
    drawn.value = vec3(0.0f, 0.0f, 0.0f);
    drawn.pdf = 0.0f;
    vec4 offsets = stratus_layer_texel(3);
    vec4 sizes = stratus_layer_texel(4);
    vec4 about = stratus_layer_texel(5);
    if (wi.z == 0.0f || (wi.z < 0.0f && about.y > 0.0f)) return drawn;
    float x_in = wi.x + (wi.x < 0.0f ? -1e-9f : 1e-9f);
    float square_in = x_in * x_in + wi.y * wi.y;
    vec4 into = stratus_cosine(abs(wi.z), square_in);
    float at_row = stratus_incident_place(into);
    float low_row = floor(stratus_clamp(at_row, 0.0f, sizes.z - 2.0f));
    int row = int(low_row) + (u3 < at_row - low_row ? 1 : 0);
    int lines = 4 * int(sizes.w);
    if (!(stratus_layer_float(sizes.x, row * (lines + 1) + lines) > 0.0f)) return drawn;
    vec4 along = stratus_event(sizes.x, row * (lines + 1), lines,
                               stratus_clamp(u1, 0.0f, 0.99999994f));
    int quarter = int(along.x) / int(sizes.w);
    int side = quarter / 2;
    float last = sizes.w - 1.0f;
    float at_line = stratus_around_sample(along.x - float(quarter) * sizes.w, last, along.y);
    vec4 away = stratus_outgoing(side, float(quarter - 2 * side), into, at_line / last);

    float turn = stratus_clamp(u2, 0.0f, 0.99999994f) * 2.0f - 1.0f;
    int azimuths = int(about.x);
    vec4 around = stratus_event(offsets.w, (row * lines + int(along.x)) * (azimuths + 1), azimuths,
                                stratus_clamp(abs(turn), 0.0f, 0.99999994f));
    float at_azimuth = stratus_around_sample(around.x, about.x - 1.0f, around.y);
    float q = at_azimuth / (about.x - 1.0f);
    vec4 scale = stratus_azimuth_scale(side, into, away);
    vec4 azimuth = stratus_azimuth_at(scale, q);
    float sine = turn < 0.0f ? -azimuth.y : azimuth.y;
    float aside = stratus_sine(away) / sqrt(square_in);
    float forward = -aside * azimuth.x;
    float sideways = -aside * sine;
    float up = (wi.z > 0.0f) == (side == STRATUS_REFLECTION) ? away.z : -away.z;
    drawn.wo = vec3(forward * x_in - sideways * wi.y, forward * wi.y + sideways * x_in, up);
    drawn.pdf = stratus_density_at(at_row, float(quarter), at_line, at_azimuth) /
                (away.w * azimuth.z * 2.0f);
    drawn.value = stratus_layer_bsdf(wi, drawn.wo);
    return drawn;
}

#endif  // STRATUS_LAYER
