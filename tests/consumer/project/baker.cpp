// Bakes a small table, writes it and reads it back.
#include <stratus/bake/bake.h>
#include <stratus/base/constants.h>
#include <stratus/io/table_file.h>
#include <stratus/table/lookup.h>

#include <cstdio>

int main() {
    const stratus::Recipe recipe = stratus::parse_recipe(
        "phase_function = 'isotropic'\n"
        "sides = ['reflection']\n"
        "tolerance = 1e-3\n"
        "optical_depth = { min = inf, max = inf }\n"
        "albedo = { min = 0.9, max = 0.9 }\n");
    stratus::write_table(stratus::bake(recipe), "table.h5");
    const stratus::Table table = stratus::read_table("table.h5");
    std::printf("R = %.3f\n",
                stratus::reflection(table.view(), 0.9, stratus::infinity, {1, 1, 0}).total());
}
