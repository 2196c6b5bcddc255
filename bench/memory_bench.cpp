// What tables take in memory as floats and as halves, and how far halves are off.
//
//     memory_bench [TABLE.h5 ...]
//
// Without tables two small ones are baked. Differences between both kinds of samples at random
// points, evenly spread over the cells of the axes, are relative to the total R or T there, but not
// to less than 1 % of the largest value at the same depth and albedo (cosines of at least 0.1), nor
// to less than 1e-8: as the errors that `stratus verify` states.
#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/io/table_file.h>
#include <stratus/runtime/angle.h>
#include <stratus/runtime/half_table.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace stratus;

using Lookup = Scattered (*)(const TableView&, double, double, const Geometry&) noexcept;

constexpr int points = 100000;

/// Least that a difference is relative to at one depth and albedo.
double min_value(Lookup look_up, const TableView& table, double albedo, double depth) {
    double largest = 0;
    for (const double in : floor_cosines())
        for (const double out : floor_cosines())
            for (const double azimuth : {0.0, pi / 2, pi})
                largest =
                    std::max(largest, look_up(table, albedo, depth, {in, out, azimuth}).total());
    return std::max(0.01 * largest, 1e-8);
}

/// Relative differences, ascending.
std::vector<double> differences(Lookup look_up, const TableView& floats, const TableView& halves) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto between = [&](double low, double high) {
        return low + uniform(random) * (high - low);
    };
    const auto cosine = [&](const AxisView& axis) {
        const double root = between(std::sqrt(axis.lowest), std::sqrt(axis.highest));
        return root * root;
    };
    const AxisView &albedos = floats.albedo, &depths = floats.optical_depth;
    std::vector<double> relative;
    for (int i = 0; i < points; ++i) {
        const double root = between(std::sqrt(1 - albedos.lowest), std::sqrt(1 - albedos.highest));
        const double albedo = 1 - root * root;
        const double depth =
            depths.count == 0
                ? HUGE_VAL
                : std::exp2(between(std::log2(depths.lowest), std::log2(depths.highest)));
        const Geometry at{cosine(floats.mu_in), cosine(floats.mu_out), between(0, pi)};
        const double expected = look_up(floats, albedo, depth, at).total();
        const double found = look_up(halves, albedo, depth, at).total();
        relative.push_back(std::abs(found - expected) /
                           std::max(expected, min_value(look_up, floats, albedo, depth)));
    }
    std::sort(relative.begin(), relative.end());
    return relative;
}

void print(const std::string& name, const Table& table) {
    const HalfTable half = halved(table);
    const TableView floats = table.view(), halves = half.view();
    const auto print_side = [&](const char* side, bool exists, Lookup look_up) {
        if (!exists) return;
        const std::vector<double> off = differences(look_up, floats, halves);
        const double megabytes = 1e-6 * static_cast<double>(table.sample_count());
        std::printf("%-20s %-13s %9.2f %9.2f %9.1e %9.1e %9.1e %9.1e\n", name.c_str(), side,
                    megabytes * sizeof(float), megabytes * sizeof(Half), table.tolerance,
                    off[points / 2], off[points - 1 - points / 1000], off.back());
    };
    print_side("reflection", floats.has_reflection(), reflection);
    print_side("transmission", floats.has_transmission(), transmission);
}

Table baked(const std::string& phase_function) {
    return bake(parse_recipe("phase_function = \"" + phase_function +
                             "\"\ntolerance = 1e-3\noptical_depth = { min = 0.01, max = 8.0 }\n"
                             "albedo = { min = 0.0, max = 1.0 }\n"));
}

}  // namespace

int main(int argc, char** argv) {
    try {
        std::printf("%-20s %-13s %9s %9s %9s %9s %9s %9s\n", "table", "side", "float MB", "half MB",
                    "tolerance", "median", "99.9 %", "worst");
        for (int i = 1; i < argc; ++i)
            print(std::filesystem::path(argv[i]).stem().string(), read_table(argv[i]));
        if (argc > 1) return 0;
        for (const char* phase_function : {"isotropic", "henyey_greenstein:g=0.5"})
            print(phase_function, baked(phase_function));
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "memory_bench: %s\n", error.what());
        return 1;
    }
}
