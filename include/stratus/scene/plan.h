// Plans: which effects of a scene are left out because they change less than its tolerance, and,
// for people, what each effect changes and costs.
//
// Only two effects are worth leaving out to save time: the orders n >= 2, which need a table, and
// their azimuth. What the scene cannot see (the far side of its layer) is not in its recipe either
// way. An effect is left out on a bound over all that the scene contains (order_bounds.h), never on
// a sample, and not where the scene names it.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/scene/layer_tables.h>
#include <stratus/scene/order_bounds.h>
#include <stratus/scene/scene.h>

#include <optional>
#include <string>
#include <vector>

namespace stratus {

/// An effect, and the largest change that leaving it out makes.
struct LeftOut {
    std::string name;
    ChangeBound change;
};

struct Plan {
    double tolerance = 0;  // the scene's
    SceneEffects effects;  // that remain
    std::vector<LeftOut> left_out;
};

/// The share of a scene's tolerance that what is left out may change; the rest is the tables'.
constexpr double share_left_out = 0.5;

/// Cost     milliseconds; nothing where the scene needs no table.
Plan plan_scene(const Scene& scene);

// ---- for people ---------------------------------------------------------------------------------

/// What one effect does to a scene's picture.
struct EffectShare {
    std::string name;
    bool SceneEffects::*effect = nullptr;
    bool seen = true;      // by the camera; not: nothing below counts
    bool bounded = false;  // `max` is a bound over the scene's contents, else the largest of pixels
    double max = 0;        // relative change
    double mean = 0;       // summed change of a sparse picture's pixels, over their summed light
    std::string where;     // of `max`
    std::string fate;      // "kept", "left out", and why
};

/// A duration or the like, measured several times.
struct Measured {
    double median = 0, spread = 0;  // spread: half of largest minus smallest
};

/// What a scene takes with some of its effects.
struct SceneCost {
    double choose_seconds = 0, solve_seconds = 0, check_seconds = 0;  // of the tables; all threads
    double keep_seconds = 0;  // writing them, and preparing them for lookups
    double bytes = 0;         // of tables in memory
    Measured ray_ns;          // a ray, on one thread
    double rays = 0;          // of the picture

    double table_seconds() const {
        return choose_seconds + solve_seconds + check_seconds + keep_seconds;
    }
};

struct PlanCosts {
    SceneCost all, planned;
    std::vector<SceneCost> without;  // one effect of the report's `shares` each
};

/// What each further order of scattering adds where orders n >= 2 matter most.
struct OrderReport {
    std::vector<double> share;  // [n - 1]: order n's of all
    std::optional<int> enough;  // orders that suffice for the tolerance; none: more than listed
    std::string where;
};

struct PlanReport {
    Plan plan;
    double plan_seconds = 0;
    std::vector<EffectShare> shares;  // of the effects that are on in the scene
    std::optional<OrderReport> orders;
    int width = 0, height = 0;  // of the sparse picture, a ray each
    PlanCosts costs;
};

/// What `render` takes for all scenes of a file, which share tables.
struct RenderCost {
    SceneCost tables;          // nothing of rays
    double light_seconds = 0;  // binding layers; what rings and their planet send one another
    double ray_seconds = 0, ray_spread = 0;

    double seconds() const { return tables.table_seconds() + light_seconds + ray_seconds; }
};

struct FileReport {
    std::vector<PlanReport> scenes;
    RenderCost cost;  // by the plans
};

/// Reports on the scenes of a file. Mean changes, and those of effects that are never left out, are
/// measured on a sparse picture, looked up in tables of tolerance 1e-2 that scenes share.
FileReport report_plans(const std::vector<Scene>& scenes, const BakeOptions& options = {},
                        TableCache* cache = nullptr);

}  // namespace stratus
