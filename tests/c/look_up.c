/* Stratus from C99: a table is opened, described, looked up and bound, against what the C++ program
 * answered.
 *
 *     look_up TABLE.h5 ANSWER.csv
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <stratus/stratus.h>

static const double pi = 3.14159265358979323846;

static void demand(int holds, const char* what) {
    if (holds) return;
    fprintf(stderr, "%s (last error: %s)\n", what, stratus_last_error());
    exit(1);
}

static int is_near(double met, double expected, double relative) {
    return fabs(met - expected) <= relative * fabs(expected);
}

/* A row of the answer, in the order of its columns. */
struct answer {
    double mu_in, mu_out, azimuth_deg, optical_depth, albedo;
    double reflection, transmission;
    double reflection_single, transmission_single, reflection_multiple, transmission_multiple;
};

static int read_answer(FILE* file, struct answer* row) {
    double* const fields = (double*)row;
    int i;
    for (i = 0; i < 11; ++i)
        if (fscanf(file, i < 10 ? "%lf," : "%lf", &fields[i]) != 1) return 0;
    return 1;
}

static void check_table(const stratus_table* table, const struct answer* row) {
    const stratus_point at = {row->optical_depth, row->albedo, row->mu_in, row->mu_out,
                              row->azimuth_deg * pi / 180};
    stratus_scattered r, t;
    demand(stratus_table_reflection(table, 1, &at, &r) == STRATUS_OK, "reflection");
    demand(stratus_table_transmission(table, 1, &at, &t) == STRATUS_OK, "transmission");
    /* The same code on the same numbers, but for the rounding of an angle in degrees. */
    demand(is_near(r.single, row->reflection_single, 1e-14), "R of order 1");
    demand(is_near(r.multiple, row->reflection_multiple, 1e-14), "R of higher orders");
    demand(is_near(t.single, row->transmission_single, 1e-14), "T of order 1");
    demand(is_near(t.multiple, row->transmission_multiple, 1e-14), "T of higher orders");
}

static void check_slice(const stratus_table* table, const struct answer* row) {
    const float mu_in = (float)row->mu_in, mu_out = (float)row->mu_out;
    const float azimuth = (float)(row->azimuth_deg * pi / 180);
    const double slack = 1e-2; /* tolerance of the table, of which binding takes a quarter */
    float r, t;
    stratus_slice* slice;

    demand(stratus_slice_bind(table, 1, &row->optical_depth, &row->albedo, NULL, &slice) == STRATUS_OK, "bind");
    demand(stratus_slice_reflection(slice, mu_in, mu_out, azimuth, &r) == STRATUS_OK, "R");
    demand(stratus_slice_transmission(slice, mu_in, mu_out, azimuth, &t) == STRATUS_OK, "T");
    demand(is_near(r, row->reflection, slack), "R of a slice");
    demand(is_near(t, row->transmission, slack), "T of a slice");
    stratus_slice_free(slice);
}

int main(int argc, char** argv) {
    stratus_table* table;
    stratus_table_info info;
    struct answer row;
    FILE* answers;
    int rows = 0;

    info.size = sizeof info;
    demand(argc == 3, "usage: look_up TABLE ANSWER");
    demand(stratus_abi_version() == STRATUS_ABI_VERSION, "header and library do not match");
    demand(stratus_table_open(argv[1], &table) == STRATUS_OK, "open");
    demand(stratus_table_describe(table, &info) == STRATUS_OK, "describe");
    demand(info.optical_depth.lowest == 0.125 && isinf(info.optical_depth.highest), "its depths");
    demand(info.mu_in.samples == 4 && info.has_transmission && !info.has_lower_boundary,
           "its shape");
    demand(strcmp(stratus_table_text(table, "title"), "Golden, plain") == 0, "its title");

    answers = fopen(argv[2], "r");
    demand(answers != NULL && fscanf(answers, "%*[^\n]") == 0, "the answers");
    for (; read_answer(answers, &row); ++rows) {
        check_table(table, &row);
        check_slice(table, &row);
    }
    demand(rows == 5, "five answers");
    fclose(answers);
    stratus_table_close(table);

    demand(stratus_table_open("absent.h5", &table) == STRATUS_FAILED && table == NULL, "absent");
    demand(strstr(stratus_last_error(), "absent.h5") != NULL, "an error names the file");
    return 0;
}
