// Forecasts of what the next render of some scenes takes.
#pragma once

#include <stratus/scene/layer_light.h>
#include <stratus/scene/plan.h>

#include <cstddef>
#include <optional>
#include <vector>

namespace stratus {

class RenderForecast {
  public:
    /// Chooses what the recipes of scenes, as they are planned, leave open, for the render to find, and
    /// times pieces of their bakes.
    RenderForecast(const Scenes& planned, const BakeOptions& options, TableCache* cache);

    /// Adds what tables take more for each effect of a scene: of one after the other.
    void add_table_costs(const Scene& scene, std::vector<EffectShare>& shares);

    /// Adds what light and rays of a planned scene take, from a few whole rows: neighbouring rays, as in
    /// the picture, are faster than scattered ones. Returns that light, which lives as long as this.
    const LayerLight& add_rays(const Scene& scene, const LayerTables* tables);

    const RenderCost& cost() const { return cost_; }

  private:
    /// A table that some scenes share.
    struct SharedTable {
        SharedRecipe shared;
        Recipe resolved;
        TableCost cost;
    };
    /// Light of a layer for timing rays.
    struct TimedLight {
        Scene scene;  // that the light refers to
        const LayerTables* tables;
        std::optional<LayerLight> light{};
        double seconds = 0;  // that a render takes to prepare it
    };

    /// Times a piece of the table, unless one that takes times alike was timed before.
    SharedTable choose(const SharedRecipe& shared, const BakeOptions& options,
                       TableCache* cache) const;
    /// Cost of a table whose times are in proportion to another's, which were timed.
    static TableCost scaled_cost(const SharedTable& timed, const Recipe& resolved);
    static TableCost cost_like(const SharedTable& table, const Recipe& recipe);
    TableCost cost_like(const Scene& scene) const;
    const TimedLight& prepare(const Scene& scene, const LayerTables* tables);

    RenderCost cost_;
    std::vector<SharedTable> tables_;
    std::vector<std::unique_ptr<TimedLight>> lights_;
    std::size_t first_channel_ = 0;  // of the next scene
};

}  // namespace stratus
