// Lookups at random points of baked tables, one thread, beside plain reads of the same memory.
#include <stratus/bake/bake.h>
#include <stratus/base/constants.h>
#include <stratus/bsdf/bsdf.h>
#include <stratus/bsdf/slice.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using stratus::Table;

struct Point {
    double albedo, optical_depth;
    stratus::Geometry geometry;
    std::size_t sample;  // somewhere in the table, for the floor
};

/// A table, baked once, when it is first asked for.
const Table& baked(const std::string& phase) {
    static std::map<std::string, Table> all;
    Table& table = all[phase];
    if (table.reflection_multiple.empty())
        table = stratus::bake(
            stratus::parse_recipe("phase_function = '" + phase +
                                  "'\ntolerance = 1e-3\noptical_depth = { min = 0.01, max = 8.0 }\n"
                                  "albedo = { min = 0.0, max = 1.0 }\n"));
    return table;
}

const Table& isotropic() { return baked("isotropic"); }
const Table& rayleigh() { return baked("rayleigh"); }
const Table& forward() { return baked("henyey_greenstein:g=0.75"); }
const Table& rings() {
    return baked("0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5");
}

/// The same samples as of a finer tolerance, for which slices interpolate cosines by cubics.
const Table& fine_rings() {
    static const Table table = [] {
        Table fine = rings();
        fine.tolerance = 1e-4;
        return fine;
    }();
    return table;
}

/// Droplets, whose phase function is sampled, for single scattering alone: nothing is baked.
const Table& droplets() {
    static const Table table = [] {
        Table of_droplets;
        of_droplets.phase_function = stratus::parse_phase_function("mie:radius=5um");
        return of_droplets;
    }();
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

/// Times one call after another, at each of `count` places, a power of two, over and over.
template <class Call>
void at_each(benchmark::State& state, std::size_t count, Call call) {
    std::size_t next = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(call(next));
        next = (next + 1) & (count - 1);
    }
}

constexpr std::size_t batch = 1024;

/// Times calls for a batch each, of `count` places over and over; the time is that of one place.
template <class Call>
void at_each_batch(benchmark::State& state, std::size_t count, Call call) {
    std::size_t next = 0;
    while (state.KeepRunningBatch(batch)) {
        call(next);
        benchmark::ClobberMemory();
        next = (next + batch) % count;
    }
}

template <class Read>
void at_random_points(benchmark::State& state, const Table& table, Read read) {
    const std::vector<Point> points = random_points(table);
    at_each(state, points.size(), [&](std::size_t n) { return read(points[n]); });
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

/// Each table is packed once, when first asked for.
const stratus::PackedTable& packed_once(const Table& (*table)()) {
    static std::map<const Table*, stratus::PackedTable> all;
    const auto known = all.find(&table());
    return known != all.end() ? known->second : all.emplace(&table(), pack(table())).first->second;
}

/// Fast lookups where albedo and optical depth vary too, one at a time.
void packed(benchmark::State& state, const Table& (*table)(), stratus::Side side) {
    const stratus::PackedTable& packed = packed_once(table);
    at_random_points(state, table(), [&](const Point& at) {
        return packed.scattering(side, at.albedo, at.optical_depth, at.geometry).total();
    });
    state.counters["MB_both_sides"] = static_cast<double>(packed.file().size()) * 1e-6;
}

/// The same, many at once; the time is that of one.
void packed_batch(benchmark::State& state, const Table& (*table)(), stratus::Side side) {
    const stratus::PackedTable& packed = packed_once(table);
    std::vector<float> of[5];
    for (const Point& at : random_points(table())) {
        const double quantities[] = {at.albedo, at.optical_depth, at.geometry.mu_in,
                                     at.geometry.mu_out, at.geometry.azimuth};
        for (int q = 0; q < 5; ++q) of[q].push_back(static_cast<float>(quantities[q]));
    }
    std::vector<float> total(batch);
    at_each_batch(state, of[0].size(), [&](std::size_t n) {
        packed.scattering(side, {&of[0][n], &of[1][n], &of[2][n], &of[3][n], &of[4][n], batch},
                          total.data());
        benchmark::DoNotOptimize(total.data());
    });
}

/// Making the file of one.
void packing(benchmark::State& state, const Table& (*table)()) {
    for (auto _ : state) benchmark::DoNotOptimize(stratus::pack(table()).size());
}

/// Opening it, already in memory.
void packed_open(benchmark::State& state, const Table& (*table)()) {
    const std::vector<char> bytes = stratus::pack(table());
    for (auto _ : state) benchmark::DoNotOptimize(stratus::PackedTable(bytes).file());
}

/// Binding a layer of one.
void packed_bind(benchmark::State& state, const Table& (*table)()) {
    const stratus::PackedTable packed(stratus::pack(table()));
    for (auto _ : state) benchmark::DoNotOptimize(stratus::bind(packed.view(), 1, 0.9).bytes());
}

BENCHMARK_CAPTURE(reflection, isotropic, isotropic);
BENCHMARK_CAPTURE(transmission, isotropic, isotropic);
BENCHMARK_CAPTURE(closed_form, isotropic, isotropic);
BENCHMARK_CAPTURE(plain_read, isotropic, isotropic);
BENCHMARK_CAPTURE(plain_read_256_rows, isotropic, isotropic);
BENCHMARK_CAPTURE(reflection, rings, rings);
BENCHMARK_CAPTURE(transmission, rings, rings);
BENCHMARK_CAPTURE(closed_form, rings, rings);
BENCHMARK_CAPTURE(plain_read, rings, rings);
BENCHMARK_CAPTURE(plain_read_256_rows, rings, rings);

// ---- BSDFs: any two directions, any random numbers

struct Pair {
    stratus::Vector wi, wo;
    float u[3];
};

std::vector<Pair> random_pairs() {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto vector = [&] {
        const float z = 2 * uniform(random) - 1, azimuth = 6.2831853f * uniform(random);
        const float sine = std::sqrt((1 - z) * (1 + z));
        return stratus::Vector{sine * std::cos(azimuth), sine * std::sin(azimuth), z};
    };
    std::vector<Pair> pairs(1 << 14);
    for (Pair& pair : pairs) {
        pair.wi = vector();
        pair.wo = vector();
        for (float& u : pair.u) u = uniform(random);
    }
    return pairs;
}

template <class Ask>
void ask_at_random_pairs(benchmark::State& state, const stratus::Bsdf& bsdf, Ask ask) {
    const std::vector<Pair> pairs = random_pairs();
    at_each(state, pairs.size(), [&](std::size_t n) { return ask(bsdf, pairs[n]); });
    state.counters["kB"] = static_cast<double>(bsdf.bytes()) * 1e-3;
}

template <class Ask>
void bsdf(benchmark::State& state, const Table& (*table)(), Ask ask) {
    ask_at_random_pairs(state, stratus::Bsdf(stratus::bind(table().view(), 1, 0.99)), ask);
}

const auto evaluate = [](const stratus::Bsdf& bsdf, const Pair& at) {
    return bsdf.eval(at.wi, at.wo);
};
const auto pdf = [](const stratus::Bsdf& bsdf, const Pair& at) { return bsdf.pdf(at.wi, at.wo); };
const auto sample = [](const stratus::Bsdf& bsdf, const Pair& at) {
    return bsdf.sample(at.wi, at.u[0], at.u[1], at.u[2]);
};
const auto sample_and_pdf = [](const stratus::Bsdf& bsdf, const Pair& at) {
    stratus::Bsdf::Sample drawn = sample(bsdf, at);
    drawn.pdf += pdf(bsdf, at);
    return drawn;
};

/// The same of a peak too sharp for the usual samples: single scattering of g = 0.99.
stratus::Slice sharp() { return {stratus::PhaseFunction::henyey_greenstein(0.99), {{1}, {0.99}}}; }

template <class Ask>
void bsdf_of_sharp_peak(benchmark::State& state, Ask ask) {
    const stratus::Bsdf bsdf(sharp());
    ask_at_random_pairs(state, bsdf, ask);
}

void build_bsdf_of_sharp_peak(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(stratus::Bsdf(sharp()).bytes());
}

/// Without binding the slice.
void build_bsdf(benchmark::State& state, const Table& (*table)()) {
    for (auto _ : state) {
        state.PauseTiming();
        stratus::Slice slice = stratus::bind(table().view(), 1, 0.99);
        state.ResumeTiming();
        benchmark::DoNotOptimize(stratus::Bsdf(std::move(slice)).bytes());
    }
}

/// As many random reads as `pdf` makes, four pairs of floats, of as much memory as it reads from.
void plain_read_of_bsdf(benchmark::State& state) {
    const std::vector<float> memory(15000, 1.0f);
    std::mt19937 random(1);
    std::vector<std::size_t> places(1 << 14);
    for (std::size_t& place : places) place = random() % (memory.size() - 2000);
    at_each(state, places.size(), [&](std::size_t n) {
        const float* const at = memory.data() + places[n];
        float sum = 0;
        for (const std::size_t row : {0u, 12u, 576u, 588u}) sum += at[row] + at[row + 1];
        return sum;
    });
}

// ---- slices

/// Directions, structure of arrays.
struct Directions {
    std::vector<float> mu_in, mu_out, azimuth;

    Directions() {
        std::mt19937 random(1);
        std::uniform_real_distribution<float> uniform(0, 1);
        for (int i = 0; i < 1 << 14; ++i) {
            mu_in.push_back(1 - uniform(random));
            mu_out.push_back(1 - uniform(random));
            azimuth.push_back(3.1415926f * uniform(random));
        }
    }
};

stratus::Effects reflection_alone() {
    stratus::Effects effects;
    effects.transmission = false;
    return effects;
}

const auto bound = [](const Table& table) {
    return stratus::bind(table.view(), 2, 0.95, reflection_alone());
};
const auto bound_both = [](const Table& table) { return stratus::bind(table.view(), 2, 0.95); };
const auto bound_rgb = [](const Table& table) {
    return stratus::bind_rgb(table.view(), {2, 2, 2}, {0.95, 0.9, 0.8}, reflection_alone());
};
const auto bound_both_rgb = [](const Table& table) {
    return stratus::bind_rgb(table.view(), {2, 2, 2}, {0.95, 0.9, 0.8});
};
/// Closed form alone: no table.
const auto single = [](const Table& table) {
    return stratus::Slice(table.phase_function, {{2}, {0.95}}, reflection_alone());
};

/// The same with opposition as wide as a density of 0.1 makes it.
stratus::Effects with_opposition() {
    stratus::Effects effects = reflection_alone();
    effects.opposition = stratus::Opposition::blinn(0.1);
    return effects;
}
const auto opposition = [](const Table& table) {
    return stratus::bind(table.view(), 2, 0.95, with_opposition());
};
const auto rgb_opposition = [](const Table& table) {
    return stratus::bind_rgb(table.view(), {2, 2, 2}, {0.95, 0.9, 0.8}, with_opposition());
};
const auto single_opposition = [](const Table& table) {
    return stratus::Slice(table.phase_function, {{2}, {0.95}}, with_opposition());
};

/// Light that a slice reflects, one lookup at a time.
template <class Make>
void slice(benchmark::State& state, const Table& (*table)(), Make make) {
    const auto slice = make(table());
    const Directions at;
    at_each(state, at.mu_in.size(), [&](std::size_t n) {
        return slice.reflection(at.mu_in[n], at.mu_out[n], at.azimuth[n]);
    });
    state.counters["kB"] = static_cast<double>(slice.bytes()) * 1e-3;
}

/// The same, many at once; the time is that of one.
template <class Make>
void slice_batch(benchmark::State& state, const Table& (*table)(), Make make) {
    const auto slice = make(table());
    const Directions at;
    std::vector<float> value(3 * batch);
    at_each_batch(state, at.mu_in.size(), [&](std::size_t n) {
        slice.reflection(batch, &at.mu_in[n], &at.mu_out[n], &at.azimuth[n], value.data());
    });
}

/// Between vectors of which a share lies on either side of the layer, in random order.
struct Vectors {
    std::vector<stratus::Vector> in, out;

    explicit Vectors(double share_below) {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> uniform;
        const auto vector = [&](bool below) {
            const double z = 1 - uniform(random), angle = 2 * stratus::pi * uniform(random);
            const double across = std::sqrt(1 - z * z);
            return stratus::Vector{static_cast<float>(across * std::cos(angle)),
                                   static_cast<float>(across * std::sin(angle)),
                                   static_cast<float>(below ? -z : z)};
        };
        for (int i = 0; i < 1 << 14; ++i) {
            in.push_back(vector(false));
            out.push_back(vector(uniform(random) < share_below));
        }
    }
};

template <class Make>
void slice_eval(benchmark::State& state, const Table& (*table)(), Make make, double share_below) {
    const auto slice = make(table());
    const Vectors at(share_below);
    at_each(state, at.in.size(), [&](std::size_t n) { return slice.eval(at.in[n], at.out[n]); });
}

template <class Make>
void slice_eval_batch(benchmark::State& state, const Table& (*table)(), Make make,
                      double share_below) {
    const auto slice = make(table());
    const Vectors at(share_below);
    std::vector<float> of[6], value(3 * batch);
    for (std::size_t i = 0; i < at.in.size(); ++i) {
        const float numbers[] = {at.in[i].x,  at.in[i].y,  at.in[i].z,
                                 at.out[i].x, at.out[i].y, at.out[i].z};
        for (int d = 0; d < 6; ++d) of[d].push_back(numbers[d]);
    }
    at_each_batch(state, of[0].size(), [&](std::size_t n) {
        const float* wi[3] = {&of[0][n], &of[1][n], &of[2][n]};
        const float* wo[3] = {&of[3][n], &of[4][n], &of[5][n]};
        slice.eval(batch, wi, wo, value.data());
    });
}

void bind(benchmark::State& state, const Table& (*table)()) {
    for (auto _ : state) benchmark::DoNotOptimize(bound(table()).bytes());
}

/// Single scattering alone.
template <class Make>
void bind_single(benchmark::State& state, const Table& (*table)(), Make make) {
    for (auto _ : state) benchmark::DoNotOptimize(make(table()).bytes());
}

/// The floor: a plain table of 32^3 floats, linear.
void plain_trilinear(benchmark::State& state) {
    const Directions at;
    const std::vector<float> table(32 * 32 * 32, 1.0f);
    at_each(state, at.mu_in.size(), [&](std::size_t n) {
        const float place[3] = {at.mu_in[n] * 30.9f, at.mu_out[n] * 30.9f, at.azimuth[n] * 9.8f};
        const auto i = static_cast<int>(place[0]), j = static_cast<int>(place[1]),
                   k = static_cast<int>(place[2]);
        const float x = place[0] - static_cast<float>(i), y = place[1] - static_cast<float>(j),
                    z = place[2] - static_cast<float>(k);
        const float* const corner = table.data() + (i * 32 + j) * 32 + k;
        const auto along = [&](int row) {
            return corner[row] + z * (corner[row + 1] - corner[row]);
        };
        const float near = along(0) + y * (along(32) - along(0));
        const float far = along(1024) + y * (along(1056) - along(1024));
        return near + x * (far - near);
    });
}

// ---- of every table

template <class Run>
auto add(const std::string& name, Run run) {
    return benchmark::RegisterBenchmark(name.c_str(), run);
}

using Function = void (*)(benchmark::State&, const Table& (*)());

const bool all_are_added = [] {
    const std::pair<std::string, const Table& (*)()> tables[] = {
        {"isotropic", isotropic}, {"rayleigh", rayleigh}, {"forward", forward}, {"rings", rings}};
    for (const auto& [name, table] : tables) {
        const auto add_slices = [&, table = table](const std::string& of, auto make) {
            add("slice/" + of, [=](auto& state) { slice(state, table, make); });
            add("slice_batch/" + of, [=](auto& state) { slice_batch(state, table, make); });
        };
        add_slices(name, bound);
        add_slices("rgb_" + name, bound_rgb);
        add_slices("single_" + name, single);
        for (const stratus::Side side : stratus::both_sides) {
            const std::string of = name + (side == stratus::Side::reflection ? "_R" : "_T");
            add("packed/" + of, [=, table = table](auto& state) { packed(state, table, side); });
            add("packed_batch/" + of,
                [=, table = table](auto& state) { packed_batch(state, table, side); });
        }
        for (const auto& [made, run] :
             std::initializer_list<std::pair<const char*, Function>>{{"bind/", bind},
                                                                     {"packing/", packing},
                                                                     {"packed_open/", packed_open},
                                                                     {"packed_bind/", packed_bind}})
            add(made + name, [run = run, table = table](auto& state) {
                run(state, table);
            })->Unit(benchmark::kMillisecond);
    }
    return true;
}();

// ---- of some

BENCHMARK(plain_trilinear);
BENCHMARK_CAPTURE(slice_eval, rings_reflected, rings, bound_both, 0.0);
BENCHMARK_CAPTURE(slice_eval, rings_mixed, rings, bound_both, 0.5);
BENCHMARK_CAPTURE(slice_eval, rings_transmitted, rings, bound_both, 1.0);
BENCHMARK_CAPTURE(slice_eval_batch, rings_reflected, rings, bound_both, 0.0);
BENCHMARK_CAPTURE(slice_eval_batch, rings_mixed, rings, bound_both, 0.5);
BENCHMARK_CAPTURE(slice_eval_batch, rings_transmitted, rings, bound_both, 1.0);
BENCHMARK_CAPTURE(slice_eval_batch, rgb_rings_reflected, rings, bound_both_rgb, 0.0);
BENCHMARK_CAPTURE(slice_eval_batch, rgb_rings_mixed, rings, bound_both_rgb, 0.5);
BENCHMARK_CAPTURE(slice, fine_rings, fine_rings, bound);
BENCHMARK_CAPTURE(slice_batch, fine_rings, fine_rings, bound);
BENCHMARK_CAPTURE(slice_batch, single_droplets, droplets, single);
BENCHMARK_CAPTURE(slice, opposition_rings, rings, opposition);
BENCHMARK_CAPTURE(slice_batch, opposition_rings, rings, opposition);
BENCHMARK_CAPTURE(slice, rgb_opposition_rings, rings, rgb_opposition);
BENCHMARK_CAPTURE(slice_batch, rgb_opposition_rings, rings, rgb_opposition);
BENCHMARK_CAPTURE(slice, single_opposition_rings, rings, single_opposition);
BENCHMARK_CAPTURE(slice_batch, single_opposition_rings, rings, single_opposition);
BENCHMARK_CAPTURE(bind_single, rings, rings, single)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bind_single, opposition_rings, rings, single_opposition)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(plain_read_of_bsdf);
BENCHMARK_CAPTURE(bsdf, eval_isotropic, isotropic, evaluate);
BENCHMARK_CAPTURE(bsdf, pdf_isotropic, isotropic, pdf);
BENCHMARK_CAPTURE(bsdf, sample_isotropic, isotropic, sample);
BENCHMARK_CAPTURE(bsdf, sample_and_pdf_isotropic, isotropic, sample_and_pdf);
BENCHMARK_CAPTURE(bsdf, eval_rings, rings, evaluate);
BENCHMARK_CAPTURE(bsdf, pdf_rings, rings, pdf);
BENCHMARK_CAPTURE(bsdf, sample_rings, rings, sample);
BENCHMARK_CAPTURE(bsdf, sample_and_pdf_rings, rings, sample_and_pdf);
BENCHMARK_CAPTURE(build_bsdf, rings, rings)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bsdf_of_sharp_peak, eval, evaluate);
BENCHMARK_CAPTURE(bsdf_of_sharp_peak, pdf, pdf);
BENCHMARK_CAPTURE(bsdf_of_sharp_peak, sample, sample);
BENCHMARK_CAPTURE(bsdf_of_sharp_peak, sample_and_pdf, sample_and_pdf);
BENCHMARK(build_bsdf_of_sharp_peak)->Unit(benchmark::kMillisecond);

}  // namespace
