// Plans: which effects of a scene are left out because they change less than its tolerance, and,
// for people, what each effect changes and costs.
//
// Three effects are worth leaving out to save time: the orders n >= 2, which need a table, their azimuth,
// and shells, whose rays are slow and see all directions. What the scene cannot see (the far side of its
// layer) is not in its recipe either way. Orders are left out on an estimate over all that the scene
// contains, never on a sample of pixels; shells where the pixels that they change most hardly change. No
// effect is left out that the scene names.
#pragma once

#include <stratus/io/image.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/scene/layer_tables.h>
#include <stratus/scene/scene.h>

#include <memory>

namespace stratus {

// How much the orders n >= 2 matter in a scene: estimates over all that it contains and sees, by the
// solver itself, in milliseconds and without a table.
//
// Along a ray the light of a layer is R = R_1 + R_m, of a ground A t t' / (1 - A s), of a
// background B t. What leaving out the orders n >= 2 changes is at most the largest of the relative
// changes of these, so each is looked at alone. The share R_m / R grows with albedo and optical
// depth: the layer is solved with the largest albedo that occurs, at octaves up to the largest depth,
// on a grid over all directions that are seen. An estimate is a margin times the largest change
// found there. It is no bound: `bench/plan_bench.cpp` keeps the record of how often, and by how much,
// pictures change by more (docs/scenes.md).

/// A pixel's change is relative to at least this share of the brightest.
constexpr double min_reference = 0.01;

/// The largest relative change that leaving an effect out makes: of light along a ray, or of a pixel.
struct ChangeEstimate {
    double found = 0;   // the largest at the geometries that were solved
    double change = 0;  // with a margin for all others
    std::string where;  // the matter and geometry of what was found
};

/// Makes `all` the larger change.
void join(ChangeEstimate& all, const ChangeEstimate& one);

struct OrderEstimates {
    ChangeEstimate multiple;  // orders n >= 2, and what they carry through the layer
    ChangeEstimate azimuth;   // replaced by their mean over azimuth
};

/// Ends as soon as both effects are found to change more than `enough`, which what is found then
/// says. The change is taken to be 1 of both effects of a shell, and of azimuth where few nodes do
/// not resolve the phase function.
OrderEstimates estimate_orders(const Scene& scene, double enough);

/// The largest change of a pixel, relative to its own light or to `min_reference` of the brightest one's,
/// without the effect of a shell, which the scene has. Ends as soon as more than `enough` is found.
ChangeEstimate estimate_shell(const Scene& scene, double enough);

/// Directions of scattering, and how much they count.
struct WeightedGeometry {
    Geometry geometry;
    double weight;
};

/// Shares of the orders in the light of one side of a layer, summed over directions: [n - 1] is that of
/// order n.
///
/// Range    orders [1, 200]; at least one direction.
std::vector<double> order_shares(const PhaseFunction& phase_function, double albedo,
                                 double optical_depth, Side side,
                                 const std::vector<WeightedGeometry>& directions, int orders);

/// The fewest orders that leave out no more than `tolerance`; beyond those listed as if they went on
/// in the geometric series that the rest of all light leaves.
int orders_for(const std::vector<double>& shares, double tolerance);

/// An effect, and the largest change that leaving it out makes.
struct LeftOut {
    std::string name;
    ChangeEstimate change;
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

/// The plan of the first of a film's frames, that leaves out what the plans of all frames do, so that no
/// light jumps from one to the next.
///
/// Cost     that of one plan where it leaves out nothing, else of one for each frame.
Plan plan_frames(const std::vector<const Scene*>& frames);

/// Switches off what a plan leaves out.
void leave_out(const Plan& plan, Scene& scene);

/// Plans each panel of a film over its frames, and switches off in these what the plan leaves out; a plan
/// for each panel.
std::vector<Plan> follow_plans(Film& film);

// ---- for people ---------------------------------------------------------------------------------

/// The change that one effect makes in a scene's picture, and what it adds to the cost of tables.
struct EffectShare {
    std::string name;
    EffectFlag effect = nullptr;
    bool seen = true;  // by the camera; not: nothing below counts
    bool estimated =
        false;        // `max` is an estimate over the scene's contents, else the largest of pixels
    double max = 0;   // relative change
    double mean = 0;  // summed change of a sparse picture's pixels, over their summed light
    std::string where;  // of `max`
    std::string fate;   // "kept", "left out", and why
    double table_seconds = 0, table_bytes = 0;
    std::vector<float> changes{};  // of each pixel of the sparse picture, row by row
};

/// The cost of tables: seconds of one processor, and bytes in memory.
struct TableCost {
    double choose_seconds = 0, solve_seconds = 0, check_seconds = 0, pack_seconds = 0;
    double bytes = 0;

    double seconds() const { return choose_seconds + solve_seconds + check_seconds + pack_seconds; }
    void add(double share, const TableCost& more) {
        for (const auto part :
             {&TableCost::choose_seconds, &TableCost::solve_seconds, &TableCost::check_seconds,
              &TableCost::pack_seconds, &TableCost::bytes})
            this->*part += share * (more.*part);
    }
};

/// Shares of the orders of scattering in the light that is seen of one side of the layer.
struct OrderReport {
    Side side;
    std::vector<double> share;  // [n - 1]: order n's of all
    int enough;                 // orders that suffice for the tolerance, beyond those about
    std::string where;
};

struct PlanReport {
    Plan plan;
    std::vector<EffectShare> shares;  // of the effects that are on in the scene
    std::vector<OrderReport> orders;  // a side each
    Image picture;                    // sparse, a ray each, under a point sun
};

/// The cost of the next `render` for all scenes of a file, which share tables: seconds of one
/// processor; of a film, of its first frame, but for the tables, which serve all.
struct RenderCost {
    TableCost tables;          // those that are kept already cost nothing
    double light_seconds = 0;  // binding layers; what rings and their planet send one another
    double ray_seconds = 0;

    double seconds() const { return tables.seconds() + light_seconds + ray_seconds; }
};

struct FileReport {
    std::vector<PlanReport> scenes;
    RenderCost cost;  // by the plans
    /// The part of `cost.tables` that was chosen here and is kept in the cache for the render.
    double kept_seconds = 0;
};

/// Pixels of sparse pictures: enough to tell how much effects change.
constexpr double few_pixels = 400;

/// A table of few nodes and samples, which misses some 3 % of the light: for what effects change.
SharedLayerTable small_table(const Recipe& recipe);

/// Reports on the scenes of a file, or of the first frame of a film, whose tables serve the scenes of
/// its `later` frames, too. Mean changes, and those of effects that are never left out, are
/// measured on a sparse picture, looked up in small tables that scenes share. The choices that a
/// render's tables need are made, and kept in the cache.
///
/// Cost     these choices, and beside them about a tenth of the render.
FileReport report_plans(const Scenes& scenes, const BakeOptions& options = {},
                        TableCache* cache = nullptr, double pixels = few_pixels,
                        const Scenes& later = {});

}  // namespace stratus
