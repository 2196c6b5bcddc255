#include "render_forecast.h"

#include <stratus/bake/forecast.h>
#include <stratus/bake/parallel.h>
#include <stratus/scene/render.h>

#include <algorithm>
#include <numeric>
#include <span>

namespace stratus {
namespace {

constexpr double timed_rays = 2000;
constexpr int min_timed_rows = 3, min_counted_rows = 24;

double ray_count(const Scene& scene) {
    return static_cast<double>(scene.width) * scene.height *
           std::max(static_cast<double>(scene.samples) * scene.samples,
                    static_cast<double>(sun_directions(scene).size()));
}

/// Packing solves all layers once and those that it is founded on once more, which makes up most of a
/// small table; finding functions takes about as long per byte of samples whatever these are.
double packing_solves(double layers) {
    constexpr double founding_layers = 1000;  // with those that they share a run of doubling with
    return 1.1 + std::min(1.0, founding_layers / layers);
}
constexpr double packing_seconds_per_byte = 5.5e-9;

/// Whether a piece of one recipe's table tells the times of another: of colours as a rule.
bool take_alike(const Recipe& one, const Recipe& other) {
    return one.discretisation.nodes == other.discretisation.nodes &&
           one.layers.size() == other.layers.size() && one.family.size() == other.family.size() &&
           one.reflection == other.reflection && one.transmission == other.transmission;
}

/// Whether a scene's light serves another: lights of uniform layers take long to bind.
bool serves(const Scene& known, const Scene& scene) {
    return uniform_matter(known) && uniform_matter(scene) && known.effects == scene.effects &&
           known.background.pattern == scene.background.pattern &&
           known.background.is_black() == scene.background.is_black() &&
           are_alike(known.layer, scene.layer);
}

}  // namespace

RenderForecast::RenderForecast(const Scenes& planned, const BakeOptions& options,
                               TableCache* cache) {
    for (const SharedRecipe& shared : shared_recipes(channel_scenes(planned))) {
        tables_.push_back(choose(shared, options, cache));
        cost_.tables.add(1, tables_.back().cost);
    }
}

RenderForecast::SharedTable RenderForecast::choose(const SharedRecipe& shared,
                                                   const BakeOptions& options,
                                                   TableCache* cache) const {
    SharedTable table{shared, shared.recipe, {}};
    if (cache && cache->find(shared.recipe)) return table;
    BakeOptions choosing = options;
    const std::unique_ptr<Checkpoint> kept = cache ? cache->open_choices(shared.recipe) : nullptr;
    if (kept) {
        choosing.log.find = std::bind_front(&Checkpoint::find, kept.get());
        choosing.log.keep = [&](const std::string& piece, std::span<const char> result) {
            if (!kept->find(piece)) kept->keep(piece, result);
        };
    }
    const double started = processor_seconds();
    const Resolution resolution = resolve_as_first(shared.recipe, choosing);
    table.resolved = resolution.recipe;
    TableCost& cost = table.cost;
    const double chosen = processor_seconds() - started;
    const auto timed = std::ranges::find_if(tables_, [&](const SharedTable& known) {
        return known.cost.bytes > 0 && known.shared.path == shared.path &&
               take_alike(known.resolved, table.resolved);
    });
    if (timed != tables_.end()) cost = scaled_cost(*timed, table.resolved);
    cost.choose_seconds = chosen;
    if (timed != tables_.end()) return table;
    const Forecast ahead = forecast(resolution, table_options(choosing));
    const auto& units = ahead.unit_seconds;
    cost.solve_seconds = packing_solves(table_size(table.resolved).layers) *
                         std::accumulate(units.begin(), units.end(), 0.0);
    cost.pack_seconds = packing_seconds_per_byte * ahead.bytes;
    cost.check_seconds = ahead.check_seconds * thread_count(options.threads);
    cost.bytes = ahead.bytes;
    return table;
}

TableCost RenderForecast::scaled_cost(const SharedTable& timed, const Recipe& resolved) {
    const auto work = [](const Recipe& recipe) {
        return table_size(recipe).layers * recipe.discretisation.modes;
    };
    TableCost cost;
    cost.add(work(resolved) / work(timed.resolved), timed.cost);
    cost.bytes = table_size(resolved).bytes;
    return cost;
}

/// Cost of a recipe that is sampled like a table's, by its layers, modes and bytes.
TableCost RenderForecast::cost_like(const SharedTable& table, const Recipe& recipe) {
    if (table.cost.bytes == 0) return {};  // the table is kept already
    Recipe resolved = recipe;
    Discretisation& d = resolved.discretisation = table.resolved.discretisation;
    if (recipe.discretisation.modes == 1) d.modes = d.azimuth_samples = 1;
    return scaled_cost(table, resolved);
}

/// Cost of the next scene's tables that are sampled like those for all.
TableCost RenderForecast::cost_like(const Scene& scene) const {
    TableCost sum;
    const Scenes channels = channel_scenes(scene);
    for (std::size_t c = 0; c < channels.size(); ++c)
        for (const SharedTable& table : tables_)
            if (std::ranges::count(table.shared.scenes, first_channel_ + c) > 0)
                for (const auto& [path, recipe] : needed_recipes(channels[c]))
                    if (path == table.shared.path) sum.add(1, cost_like(table, recipe));
    return sum;
}

void RenderForecast::add_table_costs(const Scene& scene, std::vector<EffectShare>& shares) {
    const TableCost all = cost_like(scene);
    for (EffectShare& share : shares) {
        if (!share.seen) continue;
        const TableCost less = cost_like(with_effects(scene, without(scene.effects, share.effect)));
        share.table_seconds = std::max(0.0, all.seconds() - less.seconds());
        share.table_bytes = std::max(0.0, all.bytes - less.bytes);
    }
    first_channel_ += channel_scenes(scene).size();
}

const RenderForecast::TimedLight& RenderForecast::prepare(const Scene& scene,
                                                          const LayerTables* tables) {
    for (const auto& known : lights_)
        if (known->tables == tables && serves(known->scene, scene)) return *known;
    TimedLight& fresh =
        *lights_.emplace_back(std::make_unique<TimedLight>(TimedLight{scene, tables}));
    const double started = processor_seconds();
    fresh.light.emplace(fresh.scene, tables, 1,
                        uniform_matter(scene) ? LightDetail::fine : LightDetail::sketch);
    const bool shines = seen_light(scene).shine;
    fresh.seconds = (shines ? fine_over_sketch : 1) * (processor_seconds() - started);
    return fresh;
}

const LayerLight& RenderForecast::add_rays(const Scene& scene, const LayerTables* tables) {
    const TimedLight& timed = prepare(scene, tables);
    cost_.light_seconds += timed.seconds;
    RenderOptions few;
    few.threads = 1;
    const int rows = std::clamp(static_cast<int>(timed_rays * scene.height / ray_count(scene)),
                                std::min(min_timed_rows, scene.height), scene.height);
    few.row_step = std::max(1, scene.height / rows);
    const double started = processor_seconds();
    render(scene, *timed.light, few);
    const double seconds = processor_seconds() - started;
    const int counted_step = std::max(1, scene.height / min_counted_rows);
    cost_.ray_seconds += seconds * counted_step * sample_count(scene, counted_step) /
                         sample_count(scene, few.row_step);
    return *timed.light;
}

}  // namespace stratus
