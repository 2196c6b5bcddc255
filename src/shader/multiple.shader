// ---- the path law of narrow peaks: H less its limit, and dH/ds, over slant depth s and angle

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

// later - earlier, each at two neighbouring angles, at the share between these.
float stratus_path_rise(float share, float earlier, float earlier_next, float later,
                        float later_next) {
    float rise = later - earlier;
    return rise + share * ((later_next - earlier_next) - rise);
}

// Between two neighbouring depths, of the rows from texel first on: H at the upper one at both
// angles, what it gains from there on, dH/ds.
vec4 stratus_path_piece(int side, int first, vec4 angle, float depth) {
    vec4 sheet = stratus_field(side, 12);
    float x = min(depth + 2.0f, stratus_w(stratus_field(side, 11)));
    int exponent = stratus_exponent(x);
    float place = (x * stratus_power_of_two(-exponent) - 1.0f) * 16.0f;
    int row = 2 * int(sheet.z);
    int at = first + ((exponent - 1) * 16 + int(floor(place))) * row + int(angle.x);
    vec4 low = stratus_number(at);
    vec4 high = stratus_number(at + row);
    float width = stratus_power_of_two(exponent - 4);
    float t = place - floor(place);
    float rise = stratus_path_rise(angle.y, low.x, low.z, high.x, high.z);
    float start = (low.y + angle.y * (low.w - low.y)) * width;
    float end = (high.y + angle.y * (high.w - high.y)) * width;
    float b = rise * 3.0f - start * 2.0f - end;
    float c = start + end - rise * 2.0f;
    return vec4(low.x, low.z, t * (start + t * (b + t * c)),
                (start + t * (b * 2.0f + t * c * 3.0f)) / width);
}

float stratus_path_reflection(int first, float depth, vec4 angle, StratusPath path) {
    float both = depth / path.mu_in + depth / path.mu_out;
    vec4 at = stratus_path_piece(STRATUS_REFLECTION, first, angle, both);
    vec4 surface = stratus_number(first + int(angle.x));  // where H is 0
    float gain = stratus_path_rise(angle.y, surface.x, surface.z, at.x, at.y) + at.z;
    return gain * angle.z * 0.25f / (path.mu_in + path.mu_out);
}

float stratus_path_transmission(int first, float depth, vec4 angle, StratusPath path) {
    float steep = 1.0f / max(path.mu_in, path.mu_out);
    float shallow = 1.0f / min(path.mu_in, path.mu_out);
    float least = steep * depth;
    float excess = max((shallow - steep) * depth, 1e-18f);
    if (least + 2.0f >= stratus_w(stratus_field(STRATUS_TRANSMISSION, 11))) return 0.0f;
    float slope;
    if (excess < (least + 1.0f) * 0.01f) {
        slope = stratus_w(
            stratus_path_piece(STRATUS_TRANSMISSION, first, angle, least + excess * 0.5f));
    } else {
        vec4 high = stratus_path_piece(STRATUS_TRANSMISSION, first, angle, least + excess);
        vec4 low = stratus_path_piece(STRATUS_TRANSMISSION, first, angle, least);
        slope = (stratus_path_rise(angle.y, low.x, low.y, high.x, high.y) + (high.z - low.z)) /
                excess;
    }
    return slope * angle.z * least * shallow * 0.25f;
}

// ---- orders n >= 2 that a table holds

// How the orders n >= 2 of layers thinner than all samples outgrow tau^2.
float stratus_thin_growth(float depth, float thinnest) {
    if (depth >= thinnest) return 1.0f;
    return stratus_log2(2.51629f / stratus_clamp(depth, 1e-30f, 4.0f) + 1.0f) /
           stratus_log2(2.51629f / min(thinnest, 4.0f) + 1.0f);
}

// Returns the share of the reflection of infinite depth that diffusion lets a finite one have.
float stratus_deficit(float exponent, float depth) {
    float length = stratus_w(stratus_field(STRATUS_REFLECTION, 10));
    StratusAttenuation edge = stratus_attenuation(exponent * (2.0f * length));
    StratusAttenuation deep = stratus_attenuation(exponent * depth * 2.0f);
    return deep.transmitted * edge.extinguished /
           (edge.extinguished + deep.extinguished - edge.extinguished * deep.extinguished);
}

// How transmission falls with depth.
float stratus_fall(float exponent, float depth) {
    float length = stratus_w(stratus_field(STRATUS_TRANSMISSION, 10));
    StratusAttenuation edge = stratus_attenuation(exponent * (2.0f * length));
    StratusAttenuation deep = stratus_attenuation(exponent * depth);
    float twice = deep.extinguished * (deep.transmitted + 1.0f);
    return deep.transmitted * edge.extinguished /
           (edge.extinguished + twice - edge.extinguished * twice);
}

// The divisor of functions and coefficients.
float stratus_factor(int side, float albedo, float depth, float exponent, StratusPath path) {
    vec4 range = stratus_field(side, 9);
    vec4 kind = stratus_field(side, 10);
    float reach = kind.y > 0.0f ? min(depth, kind.x) : depth;
    float into = stratus_extinguished(reach / path.mu_in);
    float back = stratus_extinguished(reach / path.mu_out);
    if (kind.y == 0.0f) {
        float thinnest = stratus_extinguished(range.z / path.mu_in) +
                         stratus_extinguished(range.z / path.mu_out);
        return kind.z > 0.0f ? min((into + back) / thinnest, 1.0f) : 1.0f;
    }
    float scale = 1.0f;  // of the reflection beyond the deepest finite depth
    float within = stratus_clamp(depth, 1e-30f, kind.x);
    if (side == STRATUS_TRANSMISSION) {
        scale = stratus_fall(exponent, within);
    } else if (depth <= range.w || stratus_w(stratus_field(side, 4)) == 0.0f) {
        float d = stratus_deficit(exponent, within);
        scale = 1.0f / (d * (d + 1.0f) + 1.0f);
    }
    return into * back * scale * stratus_thin_growth(depth, range.z) *
           stratus_clamp(albedo, range.x, range.y);
}

// Reflection between the deepest finite sample and infinity, as diffusion has it: the share of the
// finite one at sample l of the cubic in albedo, and that of infinity.
vec4 stratus_deep_weight(StratusPlace albedo, int l, float exponent, float depth) {
    float handed_on = 0.0f;  // by samples whose own deficit has fallen out of reach
    for (int k = 0; k < l; ++k) {
        float inverse = stratus_y(stratus_of_albedo(STRATUS_REFLECTION, int(albedo.first) + k));
        handed_on = inverse == 0.0f ? stratus_component(albedo.weight, k) + handed_on : 0.0f;
    }
    vec4 of = stratus_of_albedo(STRATUS_REFLECTION, int(albedo.first) + l);
    float own = stratus_component(albedo.weight, l);
    float share = (own + handed_on) * stratus_deficit(exponent, depth) * of.y;
    return vec4(0.0f, 0.0f, share * of.z, own - share);
}

// Where a lookup reads functions, and their weights.
struct StratusDirections {
    StratusPlace mu;
    StratusPlace other;
    vec4 azimuth_weight;
    int first_azimuth;
};

// The places of a light path among the samples of mu_in, mu_out and azimuth, from 0 on; of the
// cosines the higher first where the table is symmetric.
vec3 stratus_places(int side, StratusPath path) {
    vec4 axis_in = stratus_field(side, 5);
    vec4 axis_out = stratus_field(side, 6);
    vec4 around = stratus_field(side, 7);
    float root_in = sqrt(path.mu_in);
    float root_out = sqrt(path.mu_out);
    float into = -stratus_twice_arcsine(max(1.0f - path.mu_in, 0.0f) * 0.5f /
                                        ((sqrt(root_in) + 1.0f) * (root_in + 1.0f)));
    float back = -stratus_twice_arcsine(max(1.0f - path.mu_out, 0.0f) * 0.5f /
                                        ((sqrt(root_out) + 1.0f) * (root_out + 1.0f)));
    float along = around.w > 0.0f ? sqrt(path.half_turn) : path.half_turn;
    return vec3(stratus_along_axis(axis_in, axis_in.w > 0.0f ? max(into, back) : into),
                stratus_along_axis(axis_out, axis_in.w > 0.0f ? min(into, back) : back),
                stratus_clamp((along - around.x) * around.y, 0.0f, (around.z - 1.0f) * 0.999999f));
}

StratusDirections stratus_directions(int side, vec3 places) {
    vec4 window = stratus_field(side, 8);
    StratusDirections at;
    at.mu = stratus_place(stratus_field(side, 5), places.x);
    at.other = stratus_place(stratus_field(side, 6), places.y);
    at.azimuth_weight = vec4(1.0f, 0.0f, 0.0f, 0.0f);
    at.first_azimuth = 0;
    if (stratus_z(stratus_field(side, 7)) > 1.0f) {
        float cell = floor(places.z);
        float first = stratus_clamp(cell - 1.0f, window.x, window.y);
        at.first_azimuth = int(first) + 1;  // a mirrored sample lies before the first
        at.azimuth_weight = stratus_cubic((places.z - cell) + (cell - first));
    }
    return at;
}

// A texel of the functions or of a bound layer.
vec4 stratus_row(int of_layer, int texel) {
#ifdef STRATUS_LAYER
    if (of_layer == 1) return stratus_layer_texel(texel);
#endif
    return stratus_function(texel);
}

// Sum over the directions of texels from the first of a block on, every stride-th: four of the
// functions, or the colours of a bound layer.
vec4 stratus_sum_at(int side, int of_layer, int block, int stride, StratusDirections at) {
    vec4 window = stratus_field(side, 8);
    int azimuths = int(stratus_z(stratus_field(side, 7)));
    int rows = azimuths > 1 ? azimuths + 2 : 1;  // of one pair of cosines
    int around = azimuths > 1 ? 4 : 1;
    bool symmetric = stratus_w(stratus_field(side, 5)) > 0.0f;
    vec4 sum = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    for (int r = 0; r < 4; ++r) {
        int i = int(at.mu.first) + r;
        int row = symmetric ? i * (i + 7) / 2 * rows : i * int(window.z);
        vec4 of_other = vec4(0.0f, 0.0f, 0.0f, 0.0f);
        for (int c = 0; c < 4; ++c) {
            int first = row + (int(at.other.first) + c) * int(window.w) + at.first_azimuth;
            vec4 of_azimuth = vec4(0.0f, 0.0f, 0.0f, 0.0f);
            for (int a = 0; a < around; ++a)
                of_azimuth = of_azimuth + stratus_row(of_layer, block + stride * (first + a)) *
                                              stratus_component(at.azimuth_weight, a);
            of_other = of_other + of_azimuth * stratus_component(at.other.weight, c);
        }
        sum = sum + of_other * stratus_component(at.mu.weight, r);
    }
    return sum;
}

// Where the coefficients of the functions at an albedo and optical depth lie, four functions a word.
struct StratusCoefficients {
    vec4 weight[4];  // over depth, of four albedos
    int first;       // texel, and from one albedo to the next
    int albedo_step;
    int functions;  // first texel of the functions
    int words;
    float exponent;  // of diffusion
};

// Where an albedo lies among the table's samples, from 0 on.
float stratus_along_albedo(int side, float albedo) {
    vec4 axis = stratus_field(side, 3);
    float root = sqrt(max(1.0f - albedo, 0.0f));
    return stratus_along_axis(axis, -(axis.w > 0.0f ? sqrt(root) : root));
}

float stratus_diffusion_exponent(int side, StratusPlace albedo) {
    float exponent = 0.0f;
    for (int k = 0; k < 4; ++k)
        exponent = exponent + stratus_component(albedo.weight, k) *
                                  stratus_x(stratus_of_albedo(side, int(albedo.first) + k));
    return max(exponent, 1e-20f);
}

StratusCoefficients stratus_coefficients(int side, float albedo, float depth) {
    vec4 depth_axis = stratus_field(side, 4);
    StratusPlace in_albedo =
        stratus_place(stratus_field(side, 3), stratus_along_albedo(side, albedo));
    float within = stratus_clamp(depth, 1e-30f, stratus_x(stratus_field(side, 10)));
    StratusPlace in_depth =
        stratus_place(depth_axis, stratus_along_axis(depth_axis, stratus_log2(within)));
    float thinnest = stratus_z(stratus_field(side, 9)), deeper = stratus_w(stratus_field(side, 6));
    if (depth < thinnest && deeper > thinnest) {  // linear in depth, but for the growth
        float share = 0.8f * (depth - thinnest) / (deeper - thinnest);
        in_depth.weight = stratus_cubic(stratus_along_axis(depth_axis, stratus_log2(deeper))) *
                              (share * stratus_thin_growth(thinnest, deeper)) +
                          vec4(1.0f - share, 0.0f, 0.0f, 0.0f);
    }
    StratusCoefficients found;
    found.exponent = stratus_diffusion_exponent(side, in_albedo);
    // first texels of functions and coefficients, depths of a row of these, its first depth
    vec4 cell = stratus_number(int(stratus_y(stratus_field(side, 13))) +
                               int(in_albedo.cell) * int(depth_axis.z + 1.0f) + int(in_depth.cell));
    found.functions = int(cell.x);
    bool beyond = depth > stratus_w(stratus_field(side, 9)) && depth_axis.w > 0.0f;
    int first_depth = beyond ? int(cell.w + cell.z) - 4 : int(in_depth.first);
    found.words = int(stratus_w(stratus_field(side, 14)));
    found.albedo_step = found.words * int(cell.z);
    found.first = int(cell.y) + int(in_albedo.first) * found.albedo_step + found.words * first_depth;
    for (int l = 0; l < 4; ++l) {
        vec4 weight = in_depth.weight * stratus_component(in_albedo.weight, l);
        if (beyond) weight = stratus_deep_weight(in_albedo, l, found.exponent, within);
        found.weight[l] = weight;
    }
    return found;
}

// The coefficients of four functions.
vec4 stratus_coefficients_of_word(StratusCoefficients at, int word) {
    vec4 sum = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    for (int l = 0; l < 4; ++l) {
        int row = at.first + l * at.albedo_step + word;
        for (int k = 0; k < 4; ++k)
            sum = sum + stratus_number(row + k * at.words) * stratus_component(at.weight[l], k);
    }
    return sum;
}

// ---- the path law of layers that are not bound

#ifdef STRATUS_FILTERED_PATH
// A light path in the filtered path law, over the slant depth and what the longer way adds to it: shares
// of the rows and of the slices, the octave of 2 + slant depth, and a scale.
struct StratusPathPlace {
    float row;
    float slice;
    float octave;
    float scale;
};

StratusPathPlace stratus_path_place(int side, float depth, StratusPath path) {
    vec4 grid = stratus_filter(3);
    float steep = max(path.mu_in, path.mu_out);
    float slant = depth / steep;
    float longer = depth / min(path.mu_in, path.mu_out);
    float excess = max(longer - slant, 0.0f);
    StratusPathPlace at;
    at.slice = (grid.z - 2.0f) * excess / (excess + 4.0f) + 0.5f;
    at.scale = 1.0f / steep;
    if (side == STRATUS_REFLECTION) {
        slant = min(slant + longer, stratus_w(stratus_filter(2)));
        longer = slant;
        excess = 0.0f;
        at.slice = grid.z - 0.5f;  // the last one
        at.scale = 1.0f / (path.mu_in + path.mu_out);
    }
    at.slice = at.slice / grid.z;
    float between = slant + 0.5f * excess;
    at.scale = at.scale * (longer / (longer + 1.0f)) * (between / (between + 1.0f)) * grid.w;
    // Octaves have the ends of their rows to themselves.
    float octaves = stratus_log2(slant + 2.0f) - 1.0f;
    at.octave = min(floor(octaves), grid.y - 1.0f);
    at.row = (at.octave * grid.x + min(octaves - at.octave, 1.0f) * (grid.x - 1.0f) + 0.5f) /
             (grid.x * grid.y);
    return at;
}

// The factor of orders n >= 2 of the path law at an albedo.
float stratus_path_share(int side, float albedo, float depth, StratusPath path) {
    float slant = side == STRATUS_REFLECTION ? 0.0f : depth / max(path.mu_in, path.mu_out);
    float lost = albedo * stratus_z(stratus_filter(2)) - albedo + 1.0f;
    return stratus_transmitted(slant * lost) * albedo * albedo;
}

// Orders n >= 2 of the path law: functions of the scattering angle, four of reflection and eight of
// transmission, times the law itself at as many angles.
float stratus_along_path(int side, float albedo, float depth, StratusPath path) {
    vec4 weights = stratus_filter(1);
    vec4 grid = stratus_filter(3);
    if (grid.x == 0.0f) return 0.0f;
    StratusPathPlace at = stratus_path_place(side, depth, path);
    vec4 angle = stratus_path_angle(side, path);
    float at_angle = (angle.x + angle.y + 0.5f) / (2.0f * stratus_z(stratus_field(side, 12)));
    float column = (stratus_along_albedo(side, albedo) * weights.y + 0.5f) * 6.0f / weights.w;
    float sum = 0.0f;
    for (int word = 0; word < (side == STRATUS_REFLECTION ? 1 : 2); ++word) {
        float of_word = 4.0f * at.octave + float(2 * side + word) + 0.5f;
        sum = sum + dot(stratus_path_functions_at(at_angle, of_word / (4.0f * grid.y)),
                        stratus_path_law_at(
                            vec3(column, (at.row + float(word)) * 0.5f, at.slice)));
    }
    return sum * angle.z * at.scale * stratus_path_share(side, albedo, depth, path);
}
#else
// Orders n >= 2 of the path law: cubic in v = (w + w^2) / 2, with which transmission grows about as
// exp(growth s^2 / (s + 8) v), s the slant depth: the cubic is of what is left.
float stratus_along_path(int side, float albedo, float depth, StratusPath path) {
    float steps = stratus_z(stratus_field(side, 11));
    if (steps == 0.0f) return 0.0f;
    float held = max(albedo, stratus_x(stratus_field(side, 9)));  // from the least albedo on
    float place = 0.5f * (held + held * held) * steps;
    StratusPlace at = stratus_place(vec4(0.0f, steps, steps, 0.0f), place);
    vec4 angle = stratus_path_angle(side, path);
    int channel = int(stratus_w(stratus_field(side, 12)));
    int first = int(stratus_w(stratus_field(side, 13))) + int(at.first) * channel;
    float sum = 0.0f;
    if (side == STRATUS_REFLECTION) {
        for (int k = 0; k < 4; ++k)
            sum = sum + stratus_component(at.weight, k) *
                            stratus_path_reflection(first + k * channel, depth, angle, path);
    } else {
        float growth = stratus_z(stratus_field(side, 14));
        float slant = depth / max(path.mu_in, path.mu_out);
        float rate = min(slant * (slant / (slant + 8.0f)) * (growth / steps), 8.0f);  // over a step
        float shrunk = stratus_transmitted(rate);
        for (int k = 3; k >= 0; --k)
            sum = sum * shrunk + stratus_component(at.weight, k) *
                                     stratus_path_transmission(first + k * channel, depth, angle,
                                                               path);
        sum = sum / stratus_transmitted(rate * (place - at.first));
    }
    return sum * albedo * albedo;
}
#endif

#ifdef STRATUS_FILTERED
// ---- filtered textures (docs/shaders.md)

// A cubic spline at a place among samples, from 0 on, by two filtered fetches: where they lie among
// the texels, the first of which is the spline's own, and the share of the second.
vec3 stratus_spline(float place) {
    float cell = floor(place);
    float t = place - cell;
    float s = 1.0f - t;
    float before = (s * (s * t + 1.0f) * 3.0f + 1.0f) * 0.166666667f;
    float after = (t * (s * t + 1.0f) * 3.0f + 1.0f) * 0.166666667f;
    float share = after + t * t * t * 0.166666667f;
    return vec3(cell + 0.5f + before / (1.0f - share), cell + 3.5f - after / share, share);
}

// Light of one of the blocks, which lie one behind the other, and one of its words, which lie side by
// side: four functions of the directions, or the colours of a bound layer, whose azimuths the filter
// itself joins by straight lines.
vec4 stratus_light_sum(int side, float block, float blocks, float word, float words,
                       int bound, StratusPath path) {
    vec3 places = stratus_places(side, path);
    vec4 finer = stratus_filter(0);
    vec3 in_mu = stratus_spline(places.x * finer.x);
    vec3 in_other = stratus_spline(places.y * finer.x);
    vec3 in_azimuth = stratus_spline(places.z * finer.y);
    float width = stratus_z(stratus_field(side, 5)) * finer.x + 3.0f;
    float height = stratus_z(stratus_field(side, 6)) * finer.x + 3.0f;
    float azimuths = stratus_z(stratus_field(side, 7));
    bool cubic = azimuths > 1.0f && bound == 0;
    float depth = (azimuths - 1.0f) * finer.y + (cubic ? 3.0f : 1.0f);  // of a block
    vec4 sum = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    for (int k = 0; k < (cubic ? 2 : 1); ++k) {
        float at = cubic ? (k == 0 ? in_azimuth.x : in_azimuth.y) : places.z * finer.y + 0.5f;
        float z = (at + block * depth) / (blocks * depth);
        float share = cubic ? (k == 0 ? 1.0f - in_azimuth.z : in_azimuth.z) : 1.0f;
        for (int j = 0; j < 2; ++j) {
            float y = ((j == 0 ? in_other.x : in_other.y) + word * height) / (words * height);
            float of_row = share * (j == 0 ? 1.0f - in_other.z : in_other.z);
            vec4 low = stratus_light_at(vec3(in_mu.x / width, y, z));
            vec4 high = stratus_light_at(vec3(in_mu.y / width, y, z));
            sum = sum + low * (of_row * (1.0f - in_mu.z)) + high * (of_row * in_mu.z);
        }
    }
    return sum;
}

// Albedos share this: light of the block that a depth lies in, and its column of the weights.
struct StratusSeen {
    vec4 word[3];
    float column;
};

StratusSeen stratus_seen(int side, float depth, StratusPath path) {
    vec4 blocks = stratus_filter(0);
    float offset = stratus_x(stratus_filter(1));
    float within = stratus_clamp(depth, stratus_z(stratus_field(side, 9)),
                                 stratus_x(stratus_field(side, 10)));
    float place = stratus_log2(within / (within + offset));
    int last = int(side == STRATUS_REFLECTION ? blocks.z : blocks.w) - 1;
    int block = 0;
    for (int k = 0; k < last; ++k)
        if (place > stratus_x(stratus_filter(4 + 24 * side + k))) block = k + 1;
    vec4 columns = stratus_filter(4 + 24 * side + block);  // blocks have their ends to themselves
    StratusSeen seen;
    // A layer of a sixteenth of the first depth stands before it.
    float share = depth / max(stratus_z(stratus_field(side, 9)), 1e-30f);
    seen.column = columns.y + place * columns.z -
                  stratus_clamp((1.0f - share) / 0.9375f, 0.0f, 1.0f);
    for (int word = 0; word < 3; ++word) {
        seen.word[word] = vec4(0.0f, 0.0f, 0.0f, 0.0f);
        if (stratus_x(stratus_field(side, 14)) > 0.0f)  // the table has this side
            seen.word[word] = stratus_light_sum(
                side, float(block) + (side == STRATUS_REFLECTION ? 0.0f : blocks.z),
                blocks.z + blocks.w, float(word), 3.0f, 0, path);
    }
    return seen;
}

// Orders n >= 2 before the factor: twelve functions times their weights. And the exponent of diffusion.
vec4 stratus_held_of(int side, float albedo, StratusSeen seen) {
    vec4 weights = stratus_filter(1);
    vec4 units = stratus_filter(2);
    float along_albedo = stratus_along_albedo(side, albedo);
    float row = along_albedo * weights.y + 0.5f;
    float sum = 0.0f;
    for (int word = 0; word < 3; ++word)
        sum = sum + dot(seen.word[word],
                        stratus_weights_at(seen.column / weights.z,
                                           row / weights.w + float(3 * side + word) * 0.166666667f));
    StratusPlace in_albedo = stratus_place(stratus_field(side, 3), along_albedo);
    return vec4(sum * (side == STRATUS_REFLECTION ? units.x : units.y),
                stratus_diffusion_exponent(side, in_albedo), 0.0f, 0.0f);
}

vec4 stratus_held_orders(int side, float albedo, float depth, StratusPath path) {
    return stratus_held_of(side, albedo, stratus_seen(side, depth, path));
}
#else
// Orders n >= 2 before the factor, and the exponent of diffusion.
vec4 stratus_held_orders(int side, float albedo, float depth, StratusPath path) {
    StratusCoefficients of = stratus_coefficients(side, albedo, depth);
    StratusDirections directions = stratus_directions(side, stratus_places(side, path));
    float sum = 0.0f;
    for (int word = 0; word < of.words; ++word)
        sum = sum + dot(stratus_coefficients_of_word(of, word),
                        stratus_sum_at(side, 0, of.functions + word, of.words, directions));
    return vec4(sum, of.exponent, 0.0f, 0.0f);
}
#endif

float stratus_multiple(int side, float albedo, float depth, StratusPath path) {
    float along_path = stratus_along_path(side, albedo, depth, path);
    if (stratus_x(stratus_field(side, 14)) == 0.0f) return along_path;  // the table lacks this side
    vec4 of = stratus_held_orders(side, albedo, depth, path);
    return of.x * stratus_factor(side, albedo, depth, of.y, path) + along_path;
}

// ---- what is called

// Arguments out of range count as the nearer end of it.
StratusScattered stratus_scattered(int side, float any_albedo, float optical_depth,
                                   StratusPath path) {
    float albedo = stratus_clamp(any_albedo, 0.0f, 1.0f);
    float depth = stratus_depth(optical_depth);
    StratusScattered light;
    light.single = 0.0f;
    light.multiple = 0.0f;
    // Nothing passes a lower boundary.
    if (side == STRATUS_TRANSMISSION && stratus_y(stratus_field(side, 14)) > 0.0f) return light;
    float once = stratus_single_scattering(side, stratus_phases(side, path), albedo, depth, path);
    float more = max(stratus_multiple(side, albedo, depth, path), 0.0f);
    if (once + more < 0.0f) return light;
    light.single = once;
    light.multiple = more;
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
    float depth = stratus_depth(optical_depth);
    StratusPath path = stratus_path(side, mu_in, mu_out, azimuth);
    if (side == STRATUS_TRANSMISSION && stratus_y(stratus_field(side, 14)) > 0.0f) return 0.0f;
    return stratus_single_scattering(side, stratus_phases(side, path),
                                     stratus_clamp(albedo, 0.0f, 1.0f), depth, path);
}

// Over a lower boundary, or of a stack: lit from above alone.
bool stratus_is_one_sided() {
    return stratus_is_stack() || stratus_y(stratus_field(STRATUS_REFLECTION, 14)) > 0.0f;
}

float stratus_bsdf(vec3 wi, vec3 wo, float albedo, float optical_depth) {
    int side = wi.z * wo.z > 0.0f ? STRATUS_REFLECTION : STRATUS_TRANSMISSION;
    float held = stratus_x(stratus_field(side, 14));  // by the table
    if (held == 0.0f || (wi.z < 0.0f && stratus_is_one_sided())) return 0.0f;
    StratusPath path = stratus_path_between(side, wi, wo);
    StratusScattered light = stratus_scattered(side, albedo, optical_depth, path);
    return (light.single + light.multiple) * 0.318309886f;
}

#ifdef STRATUS_FILTERED
vec3 stratus_bsdf_rgb(vec3 wi, vec3 wo, vec3 albedo, float optical_depth) {
    int side = wi.z * wo.z > 0.0f ? STRATUS_REFLECTION : STRATUS_TRANSMISSION;
    float held = stratus_x(stratus_field(side, 14));
    if (held == 0.0f || (wi.z < 0.0f && stratus_is_one_sided())) return vec3(0.0f, 0.0f, 0.0f);
    float light[3];
    StratusPath path = stratus_path_between(side, wi, wo);
    float depth = stratus_depth(optical_depth);
    vec4 phases = stratus_phases(side, path);
    StratusSeen seen = stratus_seen(side, depth, path);
    for (int c = 0; c < 3; ++c) {
        float any = c == 0 ? albedo.x : (c == 1 ? albedo.y : albedo.z);
        float of = stratus_clamp(any, 0.0f, 1.0f);
        vec4 held = stratus_held_of(side, of, seen);
        float more = held.x * stratus_factor(side, of, depth, held.y, path) +
                     stratus_along_path(side, of, depth, path);
        float once = stratus_single_scattering(side, phases, of, depth, path);
        light[c] = max(once + max(more, 0.0f), 0.0f) * 0.318309886f;
    }
    return vec3(light[0], light[1], light[2]);
}
#else
vec3 stratus_bsdf_rgb(vec3 wi, vec3 wo, vec3 albedo, float optical_depth) {
    return vec3(stratus_bsdf(wi, wo, albedo.x, optical_depth),
                stratus_bsdf(wi, wo, albedo.y, optical_depth),
                stratus_bsdf(wi, wo, albedo.z, optical_depth));
}
#endif

float stratus_direct(float optical_depth, float mu) {
    return stratus_transmitted(max(optical_depth, 0.0f) / stratus_clamp(mu, 1e-6f, 1.0f));
}

float stratus_phase(float cos_theta) {
    float cosine = stratus_clamp(cos_theta, -1.0f, 1.0f);
    StratusPath path;
    path.mu_in = 1.0f;
    path.mu_out = 1.0f;
    path.forward = 1.0f - cosine;
    path.backward = 1.0f + cosine;
    path.half_turn = 0.0f;
    return stratus_x(stratus_phases(STRATUS_TRANSMISSION, path));
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
