/* The solver and the bake for programs in C: libstratus_baker.
 *
 * That library has all functions of stratus.h as well. Link one of the two: programs that only
 * look tables up need libstratus, which has no solver. Conventions, errors, memory and versions are
 * those of stratus.h. In structs, 0 stands for the default wherever there is one.
 *
 * Threads  All functions may be called by any number of threads at once. Callbacks are called by
 *          one thread at a time, not always that of the caller, and must not leave by an exception
 *          or longjmp.
 */
#ifndef STRATUS_STRATUS_BAKER_H
#define STRATUS_STRATUS_BAKER_H

#include <stratus/stratus.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Solving, without a table */

enum {
    STRATUS_NOTHING_BELOW = 0,
    STRATUS_SURFACE_BELOW = 1, /* Lambert */
    STRATUS_LAYER_BELOW = 2,   /* semi-infinite */
    STRATUS_GROUND_BELOW = 3   /* with a law of its own */
};

/* A layer or a stack of them, and what it lies on. */
typedef struct stratus_problem {
    size_t size;                      /* sizeof(stratus_problem), set by the caller */
    size_t layer_count;               /* 1 or more */
    const stratus_layer* layers;      /* top first */
    int below;                        /* one of the above */
    double below_albedo;              /* [0, 1]; not of a ground */
    const char* below_phase_function; /* of a semi-infinite layer */
    double tolerance;                 /* relative error of what is asked, [1e-12, 1]; 0: 1e-4 */
    int nodes;                        /* Gauss nodes, [1, 512], in place of a tolerance; 0: none */
    int orders;                       /* [0, 200]: higher ones are left out; 0: all */
    const char* below_ground;         /* of a ground, as --over has it: "ocean:wind=7" */
} stratus_problem;

typedef struct stratus_geometry {
    double mu_in, mu_out; /* (0, 1] */
    double azimuth;       /* radians */
} stratus_geometry;

/* Light scattered once and more often, and the estimated error of their sum: 99 % of the true ones are
 * below 1.5 times theirs. Beyond the tolerance where 512 nodes would not meet it. */
typedef struct stratus_solved {
    double single, multiple, error;
} stratus_solved;

/* R and diffuse T at `count` geometries: reflection[count], transmission[count], either of which
 * may be null. Over something T is 0: nothing leaves the far side of both. */
int stratus_solve(const stratus_problem* problem, size_t count, const stratus_geometry* geometries,
                  stratus_solved* reflection, stratus_solved* transmission);

/* Under uniform illumination from above, shares of the incident flux. */
typedef struct stratus_fluxes {
    size_t size; /* sizeof(stratus_fluxes), set by the caller */
    double spherical_albedo;
    double total_transmittance; /* beam included; over something: what arrives there */
    double ground_absorptance;  /* 0 where nothing is below */
    double error;               /* the largest that is estimated of any flux asked for */
} stratus_fluxes;

/* Fluxes: of beams at the cosines mu[count], plane_albedo[count] and diffuse_transmittance[count],
 * without the beam, either of which may be null; and under uniform illumination, which may be null
 * as well. Over something, transmittances are what arrives there. */
int stratus_solve_fluxes(const stratus_problem* problem, size_t count, const double* mu,
                         double* plane_albedo, double* diffuse_transmittance,
                         stratus_fluxes* uniform);

/* Inside, over the incident flux of a beam from above. */
typedef struct stratus_level_light {
    double direct_flux;  /* exp(-level / mu) */
    double diffuse_flux; /* downward, without the beam */
    double upward_flux;
    double actinic_flux; /* 4 pi times the mean intensity, the beam included */
    double heating_rate; /* absorbed per unit of depth; between two layers, in the lower */
} stratus_level_light;

/* The light at levels[level_count], optical depths from the top, finite and within the layers, of
 * beams at the cosines mu[count]: light[level_count * count], level after level. The largest error that
 * is estimated of any flux goes to `error`, which may be null. The problem must ask for all orders. */
int stratus_solve_levels(const stratus_problem* problem, size_t level_count, const double* levels,
                         size_t count, const double* mu, stratus_level_light* light, double* error);

/* ---- Baking */

typedef struct stratus_bake_options {
    size_t size;        /* sizeof(stratus_bake_options), set by the caller */
    int threads;        /* [0, 1024]; 0: all */
    const char* folder; /* where files that the recipe names are; null: the working folder */
    /* Called with the stage that the bake is at, "measuring", "baking", "checking", ..., and the
     * share of it that is done, [0, 1]. Anything but 0 ends the bake, with STRATUS_STOPPED, once
     * the pieces of work at hand are done. Null: none. */
    int (*progress)(void* user, double done, const char* stage);
    /* Called with a line on each choice that is made, and why. Null: none. */
    void (*note)(void* user, const char* line);
    void* user; /* given to both */
} stratus_bake_options;

/* Bakes the table of a recipe, or of a stack file, which is given as its TOML text. Null options:
 * none. A table that misses its tolerance is a table all the same: `info` of it has both. */
int stratus_bake(const char* recipe, const stratus_bake_options* options, stratus_table** table);

/* Packs a table that has samples: a handle of its own, for textured lookups. */
int stratus_table_pack(const stratus_table* table, stratus_table** packed);

/* Writes a table that has samples by its file's ending: TABLE.h5, TABLE.exr, or TABLE.stratus,
 * which is packed. A file appears whole or not at all. */
int stratus_table_write(const stratus_table* table, const char* path);

#ifdef __cplusplus
}
#endif

#endif
