// Writes the tests' sample table to the path given, for the programs of others to open.
#include <cstdio>
#include <exception>

#include <stratus/io/table_file.h>

#include "sample_table.h"

int main(int count, char** arguments) {
    if (count != 2) return 2;
    try {
        stratus::write_table(stratus::test::sample_table(), arguments[1]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
