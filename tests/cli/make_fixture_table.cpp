// Writes the table that the tests of the command line work on: made-up samples, no solver needed.
//
//     make_fixture_table full|endless|mixed|family TABLE.h5
//
// `full` has both sides and every axis; `endless` reflection only, at one albedo and infinite
// depth; `mixed` is `full` at mixture 1 and the same samples with isotropic scattering at 0; `family`
// has these samples at g from 0.3 to 0.6.
#include <stratus/io/table_file.h>

#include "small_table.h"
#include "synthetic_table.h"

#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>

namespace {

using stratus::test::make_synthetic_table;

stratus::test::SyntheticOptions make_options(const std::string& kind) {
    stratus::test::SyntheticOptions options;
    if (kind == "full" || kind == "mixed" || kind == "family") {
        options.and_infinity = true;
    } else if (kind == "endless") {
        options.phase_function = "isotropic";
        options.azimuths = options.albedos = 1;
        options.lowest_albedo = options.highest_albedo = 0.9;
        options.finite_depths = 0;
        options.and_infinity = true;
        options.transmission = false;
    } else {
        throw std::invalid_argument("kind must be full, endless, mixed or family, got " + kind);
    }
    return options;
}

stratus::Table table_of(const std::string& kind) {
    stratus::test::SyntheticOptions options = make_options(kind);
    const stratus::Table table = make_synthetic_table(options);
    if (kind != "mixed" && kind != "family") return table;
    options.phase_function = "isotropic";
    stratus::Table mixed = stratus::mixed(table, make_synthetic_table(options));
    if (kind == "mixed") return mixed;
    mixed.phase_function = stratus::PhaseFunction::henyey_greenstein(0.5);
    mixed.second_phase_function = {};
    const stratus::PhaseParameter g = stratus::PhaseParameter::g;
    mixed.family = {{g, stratus::make_axis(stratus::parameter_scale(g), 0.3, 0.6, 2), false}};
    prepare(mixed);
    return mixed;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        if (argc != 3) throw std::invalid_argument("two arguments are needed: KIND TABLE");
        stratus::write_table(table_of(argv[1]), argv[2]);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "make_fixture_table: " << error.what() << '\n';
        return 1;
    }
}
