// Writes the table that the tests of the command line work on: made-up samples, no solver needed.
//
//     make_fixture_table full|endless TABLE.h5
//
// `full` has both sides and every axis; `endless` reflection only, at one albedo and infinite
// depth.
#include "synthetic_table.h"

#include <stratus/io/table_file.h>

#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>

namespace {

stratus::test::SyntheticOptions options_of(const std::string& kind) {
    stratus::test::SyntheticOptions options;
    if (kind == "full") {
        options.and_infinity = true;
    } else if (kind == "endless") {
        options.phase_function = "isotropic";
        options.azimuths = options.albedos = 1;
        options.lowest_albedo = options.highest_albedo = 0.9;
        options.finite_depths = 0;
        options.and_infinity = true;
        options.transmission = false;
    } else {
        throw std::invalid_argument("kind must be full or endless, got " + kind);
    }
    return options;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        if (argc != 3) throw std::invalid_argument("two arguments are needed: KIND TABLE");
        stratus::write_table(stratus::test::make_synthetic_table(options_of(argv[1])), argv[2]);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "make_fixture_table: " << error.what() << '\n';
        return 1;
    }
}
