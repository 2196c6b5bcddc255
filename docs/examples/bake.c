/* Solves a stack, bakes a small table with a progress line, packs it and looks it up.
 *
 *     cc -std=c99 bake.c $(pkg-config --cflags --libs stratus-c-baker) -o bake && ./bake
 */
#include <stdio.h>
#include <stdlib.h>

#include <stratus/stratus_baker.h>

static void demand(int status) {
    if (status == STRATUS_OK) return;
    fprintf(stderr, "%s\n", stratus_last_error());
    exit(1);
}

/* Anything but 0 would end the bake, with the status STRATUS_STOPPED. */
static int show(void* user, double done, const char* stage) {
    (void)user;
    fprintf(stderr, "\r%3.0f %% %-40s", 100 * done, stage);
    return 0;
}

int main(void) {
    const stratus_layer layers[2] = {{"rayleigh", 1, 0.1}, {"henyey_greenstein:g=0.75", 0.99, 8}};
    const stratus_geometry geometry = {0.8, 0.5, 1}; /* mu_in, mu_out, azimuth */
    const stratus_problem problem = {
        .size = sizeof(stratus_problem), .layer_count = 2, .layers = layers};
    stratus_solved r;
    demand(stratus_solve(&problem, 1, &geometry, &r, NULL));
    printf("a haze over a cloud: R = %.4f, right to %.0e\n", r.single + r.multiple, r.error);

    const char* const recipe =
        "phase_function = 'rayleigh'\n"
        "tolerance = 1e-2\n"
        "optical_depth = { min = 0.25, max = 2.0 }\n"
        "albedo = { min = 0.5, max = 1.0 }\n";
    const stratus_bake_options options = {.size = sizeof(stratus_bake_options), .progress = show};
    stratus_table *table, *packed;
    demand(stratus_bake(recipe, &options, &table));
    demand(stratus_table_write(table, "haze.stratus"));
    stratus_table_close(table);
    fprintf(stderr, "\n");

    const float depth = 1, albedo = 0.9f, mu_in = 0.8f, mu_out = 0.5f, azimuth = 1;
    float total;
    demand(stratus_table_open("haze.stratus", &packed));
    demand(stratus_table_reflection_many(packed, 1, &depth, &albedo, &mu_in, &mu_out, &azimuth,
                                         &total));
    printf("a layer of haze: R = %.3f\n", (double)total);
    stratus_table_close(packed);
    return 0;
}
