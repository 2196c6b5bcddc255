/* Stratus for programs in C, and in every language that calls C: tables of multiple scattering,
 * opened from files, bound to a layer and looked up.
 *
 * Conventions are those of the C++ library: R = pi I / (mu0 F0), a white Lambert surface has R = 1,
 * BRDF = R / pi; T is diffuse, the beam that passes straight is exp(-tau / mu). Cosines lie in
 * (0, 1]; azimuths are in radians between the two directions of propagation, 0 = forward side.
 * Vectors are x, y, z in the local frame of the surface, z along its normal, unit length, both
 * pointing away from the layer; they are not normalised. Not-a-number in an argument of a lookup,
 * or an infinite azimuth, gives not-a-number; every other number outside its range counts as the
 * nearest in range: cosines in [1e-6, 1], albedos in [0, 1], optical depths in [0, inf]. R and T are
 * never negative.
 *
 * Errors   Functions that return int return STRATUS_OK or another status, and then leave what they
 *          were to fill as it was, but for handles, which become null; stratus_last_error() says
 *          in words what was wrong. No C++ exception leaves the library.
 * Memory   What an _open or a _bind returns is the caller's, until handed to _close or _free, which
 *          accept null. Arrays are the caller's; only those of one call may not overlap.
 * Threads  Any number may look up one handle. Opening is safe too: it is serialised, because HDF5
 *          is not thread-safe; the program must not call HDF5 itself meanwhile. A handle is closed
 *          by one thread, once, when no other uses it.
 * Colours  A slice is bound for one channel or for three; where it says value[channels] below, one
 *          lookup writes that many.
 * Versions Structs begin with their own size, so that later versions may add to their ends. While
 *          STRATUS_ABI_VERSION stays, programs built against older headers run.
 * Solver   stratus_baker.h adds solving, baking and packing, by another library.
 */
#ifndef STRATUS_STRATUS_H
#define STRATUS_STRATUS_H

#include <stddef.h>

#define STRATUS_ABI_VERSION 1

#ifdef __cplusplus
extern "C" {
#endif

enum {
    STRATUS_OK = 0,
    STRATUS_INVALID_ARGUMENT = 1, /* null, out of range, or a text or file name of no known kind */
    STRATUS_FAILED = 2,           /* a file that is missing, damaged or foreign */
    STRATUS_OUT_OF_MEMORY = 3,
    STRATUS_STOPPED = 4 /* a callback of the program asked for it */
};

/* What the last call that failed on this thread had to say, naming function, argument, allowed
 * range and the value met; "" when none has failed. Valid until the next failure on this thread. */
const char* stratus_last_error(void);

/* Version of the library, as "0.1.0", and its STRATUS_ABI_VERSION: equal to the header's, or the
 * program must not go on. */
const char* stratus_version(void);
int stratus_abi_version(void);

/* ---- Tables */

typedef struct stratus_table stratus_table;

/* Reads a table, TABLE.h5 or TABLE.exr, or maps a packed one, TABLE.stratus (docs/packed.md). */
int stratus_table_open(const char* path, stratus_table** table);

/* Refers to the bytes of a packed table's file, aligned to 64 bytes, which stay as they are while
 * the table and the handles of its family are open. */
int stratus_table_open_memory(const void* data, size_t bytes, stratus_table** table);

/* A table of a family of phase functions (docs/recipes.md), seen at one point of it: a handle of its
 * own, which shares the samples and may outlive the other. Lookups and bindings of such tables take
 * no other. There is a value for each axis: lengths in um, of a mixture the share of the first phase
 * function in all that is scattered. Without a family count is 0. Beyond the samples of an axis
 * single scattering is that of the value, orders n >= 2 those of the nearest sample;
 * stratus_slice_bind() refuses such a value.
 *
 * Errors   another number of values, values without a phase function, or none of a discrete axis. */
int stratus_table_at(const stratus_table* table, size_t count, const double* values,
                     stratus_table** chosen);

void stratus_table_close(stratus_table* table);

/* Sampled range of one quantity, and with how many samples; 1 where nothing varies. */
typedef struct stratus_range {
    double lowest, highest; /* highest may be infinity */
    size_t samples;
} stratus_range;

typedef struct stratus_table_info {
    size_t size; /* sizeof(stratus_table_info), set by the caller */
    stratus_range optical_depth, albedo, mu_in, mu_out, azimuth;
    int has_reflection, has_transmission; /* 1 or 0 */
    int has_lower_boundary; /* 1: reflection is that of the layer over its lower boundary */
    int highest_order;      /* of scattering; 0: all */
    double tolerance;       /* relative error asked for at the bake; 0: unknown */
    double measured_error;  /* largest relative error met at the bake's own check */
    stratus_range mixture;  /* share of the first phase function, where that alone varies; 0 samples
                             * elsewhere: stratus_table_family() tells all axes of a family */
    int is_packed;          /* 1: stratus_table_reflection_many() takes it */
    int is_stack;           /* 1: layers on top of one another, see stratus_table_layers() */
} stratus_table_info;

int stratus_table_describe(const stratus_table* table, stratus_table_info* info);

/* An axis of the table's family, counted from 0: "g", "radius", "wavelength", "variance" or
 * "mixture", and what it spans.
 *
 * Errors   an axis that the family does not have. */
int stratus_table_family(const stratus_table* table, size_t axis, const char** name,
                         stratus_range* range);

/* A text kept with the table: "title", "phase_function", "second_phase_function", "recipe",
 * "resolved_recipe", "program_version", ... Null where there is none by that name; valid while the
 * table is open. */
const char* stratus_table_text(const stratus_table* table, const char* name);

/* A homogeneous layer of a stack. */
typedef struct stratus_layer {
    const char* phase_function; /* as in recipes: "rayleigh", "henyey_greenstein:g=0.75", ... */
    double albedo;              /* [0, 1] */
    double optical_depth;       /* [0, inf), of the lowest layer [0, inf] */
} stratus_layer;

/* The layers of a table of a stack, top first, valid while it is open. Null, and count 0, for one
 * of a single layer. A stack is looked up and bound at the one depth and albedo that `info` gives,
 * and lit from above. */
const stratus_layer* stratus_table_layers(const stratus_table* table, size_t* count);

/* Where a table is looked up. */
typedef struct stratus_point {
    double optical_depth; /* [0, inf] */
    double albedo;        /* of single scattering, [0, 1] */
    double mu_in, mu_out; /* (0, 1] */
    double azimuth;       /* radians */
} stratus_point;

/* R or T by origin: light scattered once, and more often. */
typedef struct stratus_scattered {
    double single, multiple;
} stratus_scattered;

/* R or diffuse T at `count` points, for layers that differ from lookup to lookup: cubic along all
 * five axes. A side that the table lacks gives its single scattering. */
int stratus_table_reflection(const stratus_table* table, size_t count, const stratus_point* points,
                             stratus_scattered* values);
int stratus_table_transmission(const stratus_table* table, size_t count,
                               const stratus_point* points, stratus_scattered* values);

/* R or diffuse T in all of a packed table, for textured layers: arrays of `count`, each lookup with
 * a depth and an albedo of its own. total[count]; colours are three calls. The sums of what the
 * functions above give, to 1e-6. */
int stratus_table_reflection_many(const stratus_table* table, size_t count,
                                  const float* optical_depth, const float* albedo,
                                  const float* mu_in, const float* mu_out, const float* azimuth,
                                  float* total);
int stratus_table_transmission_many(const stratus_table* table, size_t count,
                                    const float* optical_depth, const float* albedo,
                                    const float* mu_in, const float* mu_out, const float* azimuth,
                                    float* total);

/* ---- Directions as observers give them */

/* The cosines and the azimuth in [0, pi] of observed angles in degrees: incidence and emission from the
 * normal of the lit side, and the phase angle, 180 degrees less the scattering angle. transmitted: 1 where
 * light leaves on the far side, emission_deg beyond 90; else 0. Nothing may be null.
 *
 * Range    incidence_deg [0, 90), emission_deg [0, 180] without 90; phase_deg as these two allow, to 0.02. */
int stratus_observed_direction(double incidence_deg, double emission_deg, double phase_deg,
                               double* mu_in, double* mu_out, double* azimuth, int* transmitted);

/* ---- Slices: a layer of one optical depth and albedo, bound once so that lookups are short */

typedef struct stratus_slice stratus_slice;

enum {
    STRATUS_NO_OPPOSITION = 0,
    STRATUS_BLINN_OPPOSITION =
        1, /* by the overlap of the ways in and out, of opposition_width alone */
    STRATUS_HAPKE_OPPOSITION = 2 /* amplitude / (1 + tan(a/2) / width) */
};

/* What is asked of a layer; lookups do nothing for what is not. */
typedef struct stratus_effects {
    size_t size;                  /* sizeof(stratus_effects), set by the caller */
    int single, multiple;         /* orders: 1 or 0. `multiple` needs a table */
    int reflection, transmission; /* sides: 1 or 0 */
    double density;               /* volume fraction of particles, [0, 1): depth / (1 - density) */
    int opposition;               /* one of the laws above; acts on single scattering */
    /* > 0, or 0: as the density makes it. Of Blinn's law particle radius over mean free path, which
     * is (3/4) density; of Hapke's in tan(a/2). */
    double opposition_width;
    double opposition_amplitude; /* [0, 1] */
    int background;              /* 1 or 0: scattered light in stratus_slice_background() */
} stratus_effects;

/* Sets everything but `size`, which the caller has set: all orders, both sides, nothing more. */
int stratus_effects_default(stratus_effects* effects);

/* Binds a table to one layer, in some milliseconds. The table may be closed afterwards.
 *
 * Shapes   channels is 1 or 3; optical_depth[channels] and albedo[channels].
 * Range    optical depths [0, inf], albedos [0, 1]; null effects are the default ones. The table
 *          must know the layer: between its samples, or beyond them by law (slice.h); any other is
 *          STRATUS_INVALID_ARGUMENT. */
int stratus_slice_bind(const stratus_table* table, int channels, const double* optical_depth,
                       const double* albedo, const stratus_effects* effects, stratus_slice** slice);

/* The same; orders n >= 2 of a layer that the table does not know are those of the nearest layer
 * that it knows, and stratus_slice_clamped() is then 1. */
int stratus_slice_bind_clamped(const stratus_table* table, int channels,
                               const double* optical_depth, const double* albedo,
                               const stratus_effects* effects, stratus_slice** slice);

/* Single scattering of a layer, with no table. The phase function is a text as in recipes:
 * "rayleigh", "henyey_greenstein:g=0.75", "0.6*lambert_sphere + 0.4*isotropic", ... */
int stratus_slice_bind_single(const char* phase_function, int channels, const double* optical_depth,
                              const double* albedo, const stratus_effects* effects,
                              stratus_slice** slice);

/* The same of a stack, top first, alike in all channels. */
int stratus_slice_bind_single_stack(size_t layer_count, const stratus_layer* layers, int channels,
                                    const stratus_effects* effects, stratus_slice** slice);

void stratus_slice_free(stratus_slice* slice);

/* Channels that a slice was bound for, and the bytes that its lookups read; 0 for null. */
int stratus_slice_channels(const stratus_slice* slice);
size_t stratus_slice_bytes(const stratus_slice* slice);

/* 1 where stratus_slice_bind_clamped() had to clamp; 0 for null. */
int stratus_slice_clamped(const stratus_slice* slice);

/* R or diffuse T; value[channels], 0 for a side that was not asked for or that the table lacks. Over a
 * lower boundary T is 0: nothing leaves the far side of both. */
int stratus_slice_reflection(const stratus_slice* slice, float mu_in, float mu_out, float azimuth,
                             float* value);
int stratus_slice_transmission(const stratus_slice* slice, float mu_in, float mu_out, float azimuth,
                               float* value);

/* BRDF or BTDF, by the hemispheres of the two directions; value[channels]. Light may come from either
 * side, over a lower boundary or of a stack from above alone: 0 for others. Symmetric in wi and wo but
 * for the BTDF of a stack, where wi is that of the incident light. */
int stratus_slice_eval(const stratus_slice* slice, const float wi[3], const float wo[3],
                       float* value);

/* The same, many at once: arrays of `count`, channel c of lookup i in value[c * count + i]. Vectors
 * are three arrays: of x, of y and of z. */
int stratus_slice_reflection_many(const stratus_slice* slice, size_t count, const float* mu_in,
                                  const float* mu_out, const float* azimuth, float* value);
int stratus_slice_transmission_many(const stratus_slice* slice, size_t count, const float* mu_in,
                                    const float* mu_out, const float* azimuth, float* value);
int stratus_slice_eval_many(const stratus_slice* slice, size_t count, const float* const wi[3],
                            const float* const wo[3], float* value);

/* The beam that is transmitted unscattered, exp(-tau / mu); the share of a uniform background that
 * is seen through the layer, which is that beam and the diffuse transmittance, at most 1 (of a table
 * that holds none, narrowed in mu_in or without transmission, the beam and order 1 alone); and, of
 * a small bright source straight behind the layer, the beam and the radiance that is scattered once
 * towards the viewer for each steradian of the source, which may exceed 1. Each value[channels].
 * Over a lower boundary nothing is seen through the layer: 0. */
int stratus_slice_direct(const stratus_slice* slice, float mu, float* value);
int stratus_slice_background(const stratus_slice* slice, float mu, float* value);
int stratus_slice_source_behind(const stratus_slice* slice, float mu, float* value);

/* ---- Sampling: a slice that can also draw directions in proportion to the light they get */

typedef struct stratus_bsdf stratus_bsdf;

/* Works out, in some milliseconds, what drawing needs. Takes the slice over: *slice becomes null,
 * whatever comes of it. */
int stratus_bsdf_build(stratus_slice** slice, stratus_bsdf** bsdf);
void stratus_bsdf_free(stratus_bsdf* bsdf);

/* The slice within, for all the lookups above; it lives as long as the BSDF. Null for null. */
const stratus_slice* stratus_bsdf_slice(const stratus_bsdf* bsdf);

/* Memory that its calls read, the slice's included; 0 for null. */
size_t stratus_bsdf_bytes(const stratus_bsdf* bsdf);

/* Draws wo, on either side, for three random numbers in [0, 1); value[channels] is what
 * stratus_slice_eval says of wi and wo, and pdf the density of wo per steradian. Where pdf is 0
 * nothing is scattered, and wo and value mean nothing. The beam that passes straight is no part. */
int stratus_bsdf_sample(const stratus_bsdf* bsdf, const float wi[3], const float random[3],
                        float wo[3], float* value, float* pdf);

/* The density with which stratus_bsdf_sample draws wo. */
int stratus_bsdf_pdf(const stratus_bsdf* bsdf, const float wi[3], const float wo[3], float* pdf);

/* Light scattered to the side that it came from and to the other, as shares of a beam; each
 * [channels]. */
int stratus_bsdf_albedo(const stratus_bsdf* bsdf, const float wi[3], float* reflected,
                        float* transmitted);

#ifdef __cplusplus
}
#endif

#endif
