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

/// As seen by an eye, of light from the sun, on a layer with this normal.
Geometry seen_geometry(vec3 normal, vec3 to_sun, vec3 to_eye) {
    float cosine_in = dot(normal, to_sun), cosine_out = dot(normal, to_eye);
    vec3 going_in = cosine_in * normal - to_sun, going_out = to_eye - cosine_out * normal;
    return Geometry(clamp(abs(cosine_in), 1e-6, 1.0), clamp(abs(cosine_out), 1e-6, 1.0),
                    atan(length(cross(going_in, going_out)), dot(going_in, going_out)), -dot(to_sun, to_eye),
                    (cosine_in > 0.0) == (cosine_out > 0.0) ? STRATUS_REFLECTION : STRATUS_TRANSMISSION);
}
