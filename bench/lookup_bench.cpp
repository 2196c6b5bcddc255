// Lookups at random points of baked tables, one thread, beside the floor: reading the same memory
// and doing nothing with it.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include <stratus/bake/bake.h>
#include <stratus/runtime/half_table.h>
#include <stratus/runtime/lookup.h>

namespace {

using stratus::Table;

struct Point {
    double albedo, optical_depth;
    stratus::Geometry geometry;
    std::size_t sample;  // somewhere in the table, for the floor
};

Table bake(const char* phase) {
    return stratus::bake(
        stratus::parse_recipe(std::string("phase_function = \"") + phase +
                              "\"\ntolerance = 1e-3\noptical_depth = { min = 0.01, max = 8.0 }\n"
                              "albedo = { min = 0.0, max = 1.0 }\n"));
}

/// Each table is baked once, when first asked for.
const Table& isotropic() {
    static const Table table = bake("isotropic");
    return table;
}

const Table& rings() {
    static const Table table =
        bake("0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5");
    return table;
}

std::vector<Point> random_points(const Table& table) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::vector<Point> points(1 << 16);
    for (Point& point : points) {
        point.albedo = uniform(random);
        point.optical_depth = 0.01 * std::pow(800, uniform(random));
        point.geometry = {1 - uniform(random), 1 - uniform(random), 3.14159265 * uniform(random)};
        point.sample = static_cast<std::size_t>(uniform(random) *
                                                static_cast<double>(table.sample_count() - 1));
    }
    return points;
}

template <class Read>
void at_random_points(benchmark::State& state, const Table& table, Read read) {
    const std::vector<Point> points = random_points(table);
    std::size_t next = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(read(points[next]));
        next = (next + 1) & (points.size() - 1);
    }
    state.counters["MB_a_side"] = static_cast<double>(table.sample_count()) * 4e-6;
}

void reflection(benchmark::State& state, const Table& (*table)()) {
    const stratus::TableView view = table().view();
    at_random_points(state, table(), [&](const Point& at) {
        return stratus::reflection(view, at.albedo, at.optical_depth, at.geometry).total();
    });
}

void transmission(benchmark::State& state, const Table& (*table)()) {
    const stratus::TableView view = table().view();
    at_random_points(state, table(), [&](const Point& at) {
        return stratus::transmission(view, at.albedo, at.optical_depth, at.geometry).total();
    });
}

/// The same from samples in half the memory.
void reflection_of_halves(benchmark::State& state, const Table& (*table)()) {
    const stratus::HalfTable half = stratus::halved(table());
    const stratus::TableView view = half.view();
    at_random_points(state, table(), [&](const Point& at) {
        return stratus::reflection(view, at.albedo, at.optical_depth, at.geometry).total();
    });
}

/// Single scattering alone: what every lookup adds in closed form.
void closed_form(benchmark::State& state, const Table& (*table)()) {
    stratus::TableView view = table().view();
    view.reflection_multiple = {};
    at_random_points(state, table(), [&](const Point& at) {
        return stratus::reflection(view, at.albedo, at.optical_depth, at.geometry).total();
    });
}

/// One float anywhere in the table.
void plain_read(benchmark::State& state, const Table& (*table)()) {
    const Table& of = table();
    at_random_points(state, of, [&](const Point& at) { return of.reflection_multiple[at.sample]; });
}

/// One float of each of the 256 rows that a lookup touches.
void plain_read_256_rows(benchmark::State& state, const Table& (*table)()) {
    const Table& of = table();
    const std::size_t azimuths = of.azimuth.values.size(), mus = of.mu_in.values.size();
    const std::size_t out = azimuths, in = out * mus, depth = in * mus,
                      albedo = depth * of.optical_depth.values.size();
    const std::size_t reach = 3 * (albedo + depth + in + out);
    at_random_points(state, of, [&](const Point& at) {
        const float* first =
            of.reflection_multiple.data() + at.sample % (of.sample_count() - reach);
        float sum = 0;
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t d = 0; d < 4; ++d)
                for (std::size_t i = 0; i < 4; ++i)
                    for (std::size_t j = 0; j < 4; ++j)
                        sum += first[a * albedo + d * depth + i * in + j * out];
        return sum;
    });
}

BENCHMARK_CAPTURE(reflection, isotropic, isotropic);
BENCHMARK_CAPTURE(transmission, isotropic, isotropic);
BENCHMARK_CAPTURE(reflection_of_halves, isotropic, isotropic);
BENCHMARK_CAPTURE(closed_form, isotropic, isotropic);
BENCHMARK_CAPTURE(plain_read, isotropic, isotropic);
BENCHMARK_CAPTURE(plain_read_256_rows, isotropic, isotropic);
BENCHMARK_CAPTURE(reflection, rings, rings);
BENCHMARK_CAPTURE(transmission, rings, rings);
BENCHMARK_CAPTURE(reflection_of_halves, rings, rings);
BENCHMARK_CAPTURE(closed_form, rings, rings);
BENCHMARK_CAPTURE(plain_read, rings, rings);
BENCHMARK_CAPTURE(plain_read_256_rows, rings, rings);

}  // namespace
