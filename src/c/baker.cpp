// The solver without a table, and recipes baked, tables packed and written.
#include <stratus/bake/bake.h>
#include <stratus/base/number_text.h>
#include <stratus/io/file_bytes.h>
#include <stratus/stratus_baker.h>
#include <stratus/table/member_and_ground.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include "handles.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <vector>

namespace stratus::c {
namespace {

struct Problem {
    StackLayers layers;
    LowerBoundary below;
    SolverOptions options;
};

LowerBoundary make_lower_boundary(const stratus_problem& problem, const char* function) {
    require(problem.below >= STRATUS_NOTHING_BELOW && problem.below <= STRATUS_GROUND_BELOW,
            function, "problem.below", "nothing, a surface, a layer or a ground, 0 to 3",
            problem.below);
    if (problem.below == STRATUS_NOTHING_BELOW) return {};
    if (problem.below == STRATUS_GROUND_BELOW) {
        require_given(function, {{problem.below_ground, "problem.below_ground"}});
        return read_ground(problem.below_ground);
    }
    const double albedo = problem.below_albedo;
    require_in("[0, 1]", function, "problem.below_albedo", albedo);
    if (problem.below == STRATUS_SURFACE_BELOW) return LowerBoundary::surface(albedo);
    require_given(function, {{problem.below_phase_function, "problem.below_phase_function"}});
    return LowerBoundary::layer(read_phase_function(problem.below_phase_function), albedo);
}

constexpr std::size_t first_problem_size = offsetof(stratus_problem, below_ground);

Problem make_problem(const stratus_problem* given, const char* function) {
    require_size(*given, function, "problem", first_problem_size);
    const stratus_problem asked = completed(*given);
    Problem problem{make_layers(asked.layers, asked.layer_count, function),
                    make_lower_boundary(asked, function),
                    {}};
    check_layers(problem.layers, problem.below.is_present(), function);
    constexpr double default_tolerance = 1e-4;
    if (asked.nodes != 0)
        problem.options.nodes = asked.nodes;
    else
        problem.options.tolerance = asked.tolerance != 0 ? asked.tolerance : default_tolerance;
    problem.options.orders = asked.orders;
    return problem;
}

std::vector<double> checked_cosines(std::size_t count, const double* mu, const char* function) {
    std::vector<double> cosines(mu, mu + count);
    for (const double cosine : cosines) require_in("(0, 1]", function, "mu", cosine);
    return cosines;
}

stratus_solved in_c(const SolvedValue& value, double error) {
    return {value.single, value.multiple, error};
}

Table baked(const char* recipe, const stratus_bake_options& asked, const char* function) {
    require_in("[0, 1024]", function, "options.threads", asked.threads);
    BakeOptions options;
    options.threads = asked.threads;
    if (asked.note)
        options.note = [&](const std::string& line) { asked.note(asked.user, line.c_str()); };
    std::atomic<bool> stop = false;
    if (asked.progress)
        options.progress = [&](double done, const std::string& stage) {
            if (asked.progress(asked.user, done, stage.c_str()) != 0) stop = true;
        };
    options.log.stop = [&] { return stop.load(); };
    std::vector<std::string> notes;
    const Recipe read = parse_recipe(recipe, asked.folder ? asked.folder : "", &notes);
    if (options.note)
        for (const std::string& note : notes) options.note(note);
    try {
        return bake(read, options);
    } catch (const WorkStopped&) {
        throw Stopped(std::string(function) + ": stopped by the program");
    }
}

/// A table's samples.
const Table& require_samples(const stratus_table* table, const char* function) {
    const AnyTable& own = table->shared->own;
    require(own.packed() == nullptr, function, "table", "one with samples", "a packed one");
    return own.table();
}

}  // namespace
}  // namespace stratus::c

using namespace stratus;
using namespace stratus::c;

int stratus_solve(const stratus_problem* problem, size_t count, const stratus_geometry* geometries,
                  stratus_solved* reflection, stratus_solved* transmission) {
    return run_guarded(__func__, {{problem, "problem"}}, [&, function = __func__] {
        const Problem asked = make_problem(problem, function);
        if (count == 0) return;
        require_given(function, {{geometries, "geometries"}});
        std::vector<Geometry> all;
        for (std::size_t i = 0; i < count; ++i) {
            const auto& [mu_in, mu_out, azimuth] = geometries[i];
            require_in("(0, 1]", function, "mu_in", mu_in);
            require_in("(0, 1]", function, "mu_out", mu_out);
            require(std::isfinite(azimuth), function, "azimuth", "finite", azimuth);
            all.push_back({mu_in, mu_out, azimuth});
        }
        const SolvedGeometries solved =
            solve_geometries(asked.layers, asked.below, all, asked.options);
        for (std::size_t i = 0; i < count; ++i) {
            const SolvedGeometry& at = solved.at[i];
            if (reflection != nullptr) reflection[i] = in_c(at.reflection, at.reflection_error);
            if (transmission != nullptr)
                transmission[i] = in_c(at.transmission, at.transmission_error);
        }
    });
}

int stratus_solve_fluxes(const stratus_problem* problem, size_t count, const double* mu,
                         double* plane_albedo, double* diffuse_transmittance,
                         stratus_fluxes* uniform) {
    return run_guarded(__func__, {{problem, "problem"}}, [&, function = __func__] {
        const Problem asked = make_problem(problem, function);
        if (uniform != nullptr) require_size(*uniform, function, "uniform");
        require_arrays(count, {mu}, function);
        const SolvedFluxes solved = solve_fluxes(
            asked.layers, asked.below, checked_cosines(count, mu, function), asked.options);
        if (plane_albedo != nullptr) std::copy_n(solved.plane_albedo.data(), count, plane_albedo);
        if (diffuse_transmittance != nullptr)
            std::copy_n(solved.diffuse_transmittance.data(), count, diffuse_transmittance);
        if (uniform != nullptr)
            fill(*uniform,
                 {sizeof(stratus_fluxes), solved.spherical_albedo, solved.total_transmittance,
                  solved.spherical_ground_absorptance, solved.error});
    });
}

int stratus_solve_levels(const stratus_problem* problem, size_t level_count, const double* levels,
                         size_t count, const double* mu, stratus_level_light* light,
                         double* error) {
    return run_guarded(__func__, {{problem, "problem"}}, [&, function = __func__] {
        const Problem asked = make_problem(problem, function);
        require_arrays(level_count * count, {levels, mu, light}, function);
        if (level_count * count == 0) return;
        const SolvedInside solved =
            solve_fluxes_inside(asked.layers, asked.below, {levels, levels + level_count},
                                checked_cosines(count, mu, function), asked.options);
        for (const FluxesAtLevel& at : solved.levels)
            for (size_t i = 0; i < count; ++i)
                *light++ = {at.direct[i], at.diffuse[i], at.upward[i], at.actinic[i],
                            at.heating_rate[i]};
        if (error != nullptr) *error = solved.error;
    });
}

int stratus_bake(const char* recipe, const stratus_bake_options* options, stratus_table** table) {
    return make_guarded(__func__, table, "table", {{recipe, "recipe"}}, [&, function = __func__] {
        if (options != nullptr) require_size(*options, function, "options");
        return make_handle(baked(recipe, options ? *options : stratus_bake_options{}, function));
    });
}

int stratus_table_pack(const stratus_table* table, stratus_table** packed) {
    return make_guarded(__func__, packed, "packed", {{table, "table"}}, [&, function = __func__] {
        return make_handle(PackedTable(pack(require_samples(table, function))));
    });
}

int stratus_table_write(const stratus_table* table, const char* path) {
    return run_guarded(__func__, {{table, "table"}}, [&, function = __func__] {
        const Table& samples = require_samples(table, function);
        require_given(function, {{path, "path"}});
        if (std::filesystem::path(path).extension() == packed_ending)
            return write_content_atomically(path, pack(samples));
        const std::unique_lock lock = hdf5_lock();
        write_table(samples, path);
    });
}
