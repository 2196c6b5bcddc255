// The layer as the scenes see it, on the lookups of `stratus shader`; cosines and azimuth are those of docs/conventions.md.
uniform sampler2D fluxes;       // over mu: diffuse transmittance of the first zone; red, green, blue
uniform vec2 cosine_axis;       // of fluxes: first coordinate, samples per unit of it
uniform int cosines;
uniform vec3 spherical_albedo;  // likewise
uniform float depths[4];        // of each zone, as light sees them
uniform vec3 albedo;
uniform vec2 opposition;        // amplitude and width of Hapke's law
uniform bool scattered_again;   // orders n >= 2

const float pi = 3.14159265358979;

/// Directions of one scattering.
struct Geometry {
    float mu_in, mu_out, azimuth;
    float cosine;  // of the scattering angle
    int side;
};

float scattered_in(Geometry at, float depth, float channel_albedo) {
    float light = stratus_single(at.side, channel_albedo, depth, at.mu_in, at.mu_out, at.azimuth);
    if (at.side == STRATUS_REFLECTION && opposition.x > 0.0)
        light *= stratus_hapke(opposition.x, opposition.y, at.cosine);
    if (!scattered_again) return light;
    StratusPath path = stratus_path(at.side, at.mu_in, at.mu_out, at.azimuth);
    return light + stratus_multiple(at.side, channel_albedo, depth, path);
}

/// R or T. Compilers copy it to wherever it is called, and it is long: one place.
vec3 scattered(Geometry at, int zone) {
    vec3 value = vec3(0);
    for (int c = 0; c < 3; ++c) {
        if (depths[zone] == 0.0) break;
        value[c] = c > 0 && albedo[c] == albedo[c - 1] ? value[c - 1] : scattered_in(at, depths[zone], albedo[c]);
    }
    return value;
}

/// Direct and diffuse, of the first zone.
vec3 transmittance(float mu) {
    vec3 value = vec3(stratus_direct(depths[0], mu));
    if (!scattered_again || depths[0] == 0.0) return value;
    float last = float(cosines - 1);
    float place = clamp((asin(sqrt(sqrt(mu))) - cosine_axis.x) * cosine_axis.y, 0.0, last);
    float first = clamp(floor(place) - 1.0, 0.0, last - 3.0);
    vec4 weight = stratus_cubic(place - first);
    for (int i = 0; i < 4; ++i) value += weight[i] * texelFetch(fluxes, ivec2(int(first) + i, 0), 0).rgb;
    return value;
}

/// pi I / F0 of Lambert ground under the layer over mu_in.
vec3 ground_through(float mu_in, float ground) {
    vec3 returned = scattered_again && depths[0] > 0.0 ? spherical_albedo : vec3(0);
    return ground * transmittance(mu_in) / (1.0 - ground * returned);
}

/// Returns the directions on a layer with this normal of light that comes from the sun and goes to an eye.
Geometry seen_geometry(vec3 normal, vec3 to_sun, vec3 to_eye) {
    float cosine_in = dot(normal, to_sun), cosine_out = dot(normal, to_eye);
    vec3 going_in = cosine_in * normal - to_sun, going_out = to_eye - cosine_out * normal;
    return Geometry(clamp(abs(cosine_in), 1e-6, 1.0), clamp(abs(cosine_out), 1e-6, 1.0),
                    atan(length(cross(going_in, going_out)), dot(going_in, going_out)), -dot(to_sun, to_eye),
                    (cosine_in > 0.0) == (cosine_out > 0.0) ? STRATUS_REFLECTION : STRATUS_TRANSMISSION);
}

// The three scenes, as `stratus render` has them: radiance over that of a white Lambert surface that faces the sun.
uniform int scene;  // 0: planet under the layer, 1: rings, 2: slab over ground, 3: lobes
uniform vec3 eye, ahead, right, up, to_sun;
uniform float half_width;      // of a picture, in perspective at distance 1
uniform bool perspective;
uniform float ground;          // albedo
uniform float white;           // radiance shown white
uniform ivec2 corner;          // of the picture, in pixels of the canvas
uniform int size;              // of a side
uniform int samples;           // squared in a pixel
uniform bool probing;
uniform vec2 pointer;          // in the picture, (0, 0) its upper left corner, (1, 1) its lower right one

out vec4 colour;

const float ring_edge[5] = float[5](1.24, 1.53, 1.95, 2.03, 2.27);
const float slab_height = 0.4, slab_half = 1.5, ground_half = 20.0;

/// What a ray sees: light, and where it meets a lit layer, mu_in times R or T of that.
struct Seen {
    vec3 light;
    bool of_layer;
    Geometry geometry;
    int zone;
};

struct Ray {
    vec3 origin, direction;
};

Seen nothing() {
    return Seen(vec3(0), false, Geometry(1.0, 1.0, 0.0, 1.0, STRATUS_REFLECTION), 0);
}

/// Negative: nowhere.
float distance_to_globe(Ray ray) {
    float b = dot(ray.origin, ray.direction);
    vec3 nearest = ray.origin - b * ray.direction;
    float under = 1.0 - dot(nearest, nearest);
    return under > 0.0 ? -b - sqrt(under) : -1.0;
}

Seen planet(Ray ray) {
    Seen seen = nothing();
    float far = distance_to_globe(ray);
    if (far < 0.0) return seen;
    vec3 normal = normalize(ray.origin + far * ray.direction);
    if (dot(normal, to_sun) <= 0.0) return seen;
    seen.of_layer = true;
    seen.geometry = seen_geometry(normal, to_sun, -ray.direction);
    float mu = seen.geometry.mu_in;
    if (ground > 0.0) seen.light = mu * transmittance(seen.geometry.mu_out) * ground_through(mu, ground);
    return seen;
}

/// Radius at which a ray crosses the rings' plane, and the distance; negative: nowhere.
vec2 crossing(Ray ray) {
    float far = -ray.origin.z / ray.direction.z;
    if (!(far > 0.0) || far > 1e6) return vec2(-1);
    return vec2(length(ray.origin.xy + far * ray.direction.xy), far);
}

/// -1 between rings.
int ring_zone(float radius) {
    if (radius < ring_edge[0]) return -1;
    for (int zone = 0; zone < 4; ++zone)
        if (radius < ring_edge[zone + 1]) return zone;
    return -1;
}

/// Lambert's law, through the shadow of the rings.
vec3 globe(Ray ray, float far) {
    vec3 normal = normalize(ray.origin + far * ray.direction);
    float mu = dot(normal, to_sun);
    if (mu <= 0.0) return vec3(0);
    int zone = ring_zone(crossing(Ray(normal, to_sun)).x);
    return vec3(ground * mu * (zone < 0 ? 1.0 : stratus_direct(depths[zone], max(abs(to_sun.z), 1e-6))));
}

Seen rings(Ray ray) {
    Seen seen = nothing();
    float to_planet = distance_to_globe(ray);
    vec2 cross_at = crossing(ray);
    vec3 behind = to_planet > 0.0 ? globe(ray, to_planet) : vec3(0);
    int zone = cross_at.y < 0.0 || (to_planet > 0.0 && to_planet < cross_at.y) ? -1 : ring_zone(cross_at.x);
    seen.light = behind;
    if (zone < 0) return seen;
    seen.geometry = seen_geometry(vec3(0, 0, 1), to_sun, -ray.direction);
    seen.zone = zone;
    seen.light *= stratus_direct(depths[zone], seen.geometry.mu_out);
    Ray to_light = Ray(ray.origin + cross_at.y * ray.direction, to_sun);
    seen.of_layer = distance_to_globe(to_light) <= 0.0;
    return seen;
}

/// Squares of the ground's albedo and of half of it; black beyond.
float ground_at(vec2 place) {
    if (max(abs(place.x), abs(place.y)) > ground_half) return 0.0;
    vec2 square = floor(place);
    return ground * (mod(square.x + square.y, 2.0) < 0.5 ? 1.0 : 0.5);
}

bool on_slab(vec2 place) {
    return max(abs(place.x), abs(place.y)) <= slab_half;
}

Seen slab(Ray ray) {
    Seen seen = nothing();
    if (ray.direction.z >= 0.0 || to_sun.z <= 0.0) return seen;
    float far = -ray.origin.z / ray.direction.z;
    vec3 above = ray.origin + far * ray.direction;
    vec3 below = above - slab_height / ray.direction.z * ray.direction;
    vec3 lit_through = below + slab_height / to_sun.z * to_sun;
    seen.geometry = seen_geometry(vec3(0, 0, 1), to_sun, -ray.direction);
    float mu = seen.geometry.mu_in, own = ground_at(below.xy);
    seen.light = mu * (on_slab(lit_through.xy) ? ground_through(mu, own) : vec3(own));
    if (!on_slab(above.xy)) return seen;
    seen.of_layer = true;
    seen.light *= transmittance(seen.geometry.mu_out);
    return seen;
}

/// Through a point of the picture, in [-1, 1], x to the right and y upward.
Seen seen_at(vec2 place) {
    vec3 aside = half_width * (place.x * right + place.y * up);
    Ray ray = Ray(eye + aside, ahead);
    if (perspective) ray = Ray(eye, normalize(ahead + aside));
    if (scene == 0) return planet(ray);
    if (scene == 1) return rings(ray);
    return slab(ray);
}

vec3 srgb(vec3 light) {
    vec3 clipped = clamp(light, 0.0, 1.0);
    return mix(12.92 * clipped, 1.055 * pow(clipped, vec3(1.0 / 2.4)) - 0.055,
               vec3(greaterThan(clipped, vec3(0.0031308))));
}

vec4 float_bytes(float value) {
    uint bits = floatBitsToUint(value);
    return vec4(bits & 255u, bits >> 8 & 255u, bits >> 16 & 255u, bits >> 24) / 255.0;
}

/// In the plane of incidence, at one of `size` angles from the upper normal, towards the forward side.
Seen lobe(int angle) {
    float turn = 2.0 * pi * (float(angle) + 0.5) / float(size);
    vec3 light = vec3(-sqrt(1.0 - to_sun.z * to_sun.z), 0, to_sun.z);
    return Seen(vec3(0), true, seen_geometry(vec3(0, 0, 1), light, vec3(sin(turn), 0, cos(turn))), 0);
}

/// Numbers instead of a picture, one a pixel, as the bytes of a float: of lobes over angle and colour, else of the
/// pointer's place.
float number_at(ivec2 pixel, Seen seen, vec3 value, vec3 light) {
    if (scene == 3) return value[pixel.y];
    float numbers[12] = float[12](seen.of_layer ? float(1 + seen.zone) : 0.0, float(seen.geometry.side), seen.geometry.mu_in,
                                  seen.geometry.mu_out, seen.geometry.azimuth, seen.geometry.cosine, value.r,
                                  value.g, value.b, light.r, light.g, light.b);
    return numbers[pixel.x];
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy) - corner;
    int count = probing ? 1 : samples * samples;
    Seen seen;
    vec3 light = vec3(0), value;
    for (int k = 0; k < count; ++k) {
        float n = float(samples), i = float(k % samples), j = float(k / samples);
        vec2 within = vec2((i + (j + 0.5) / n) / n, 1.0 - (j + (n - i - 0.5) / n) / n);
        vec2 place = (vec2(pixel) + within) / float(size) * 2.0 - 1.0;
        if (probing) place = vec2(2.0 * pointer.x - 1.0, 1.0 - 2.0 * pointer.y);
        if (scene == 3) seen = lobe(pixel.x);
        else seen = seen_at(place);
        value = vec3(0);
        if (seen.of_layer) value = scattered(seen.geometry, seen.zone);
        light += seen.light + seen.geometry.mu_in * value;
    }
    if (probing) colour = float_bytes(number_at(pixel, seen, value, light));
    else colour = vec4(srgb(light / (white * float(count))), 1);
}
