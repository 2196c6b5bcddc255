// Writes the sample table of the tests for other programs to open:
//
//     write_sample_table PATH [MIXTURES]
#include <stratus/io/table_file.h>

#include "sample_table.h"

#include <cstdio>
#include <cstdlib>
#include <exception>

int main(int count, char** arguments) {
    if (count != 2 && count != 3) return 2;
    try {
        stratus::test::Shape shape;
        if (count == 3) shape.mixtures = std::atoi(arguments[2]);
        stratus::write_table(stratus::test::sample_table(shape), arguments[1]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
