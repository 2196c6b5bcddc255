#include <stratus/fit/layer_model.h>

#include <stratus/runtime/constants.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace stratus {
namespace {

constexpr ParameterRanges all_layers{{1e-4, 64}, {0, 1}, {0, 1}, {-0.95, 0.95}};

double cos_scattering_angle(const Observation& observed) {
    return observed.light == Light::transmitted
               ? cos_scattering_angle_transmitted(observed.geometry)
               : cos_scattering_angle_reflected(observed.geometry);
}

class TableModel : public LayerModel {
  public:
    explicit TableModel(const TableView& table) : table_(table) {
        require(!table.has_family() || is_mixture(*table.family), "fit", "table",
                "of one phase function, or mixtures of two", "of a family");
    }

    int kinds() const override { return table_.has_family() ? 2 : 1; }

    ParameterRanges ranges() const override {
        const auto of = [](const AxisView& axis) { return Interval{axis.lowest, axis.highest}; };
        const Interval infinite{infinity, infinity};
        return {table_.optical_depth.count > 0 ? of(table_.optical_depth) : infinite,
                of(table_.albedo),
                table_.has_family() ? of((*table_.family)[0].axis.view()) : Interval{1, 1},
                {0, 0}};
    }

    bool has_depth(double depth) const override {
        const AxisView& axis = table_.optical_depth;
        if (depth == infinity) return axis.count == 0 || axis.ends_at_infinity;
        return axis.count > 0 && depth >= 0 && depth <= axis.highest;
    }

    bool has(Light light) const override {
        if (light == Light::beam) return !table_.has_lower_boundary();
        return light == Light::reflected ? table_.has_reflection() : table_.has_transmission();
    }

    bool has_lower_boundary() const override { return table_.has_lower_boundary(); }

    std::optional<double> asymmetry(int) const override { return {}; }

    std::vector<Scattered> scattered(const LayerParameters& layer,
                                     const std::vector<Observation>& observations) const override {
        const TableView mixed = table_.at_mixture(layer.mixture());
        std::vector<Scattered> values;
        for (const Observation& observed : observations) {
            const auto look_up = observed.light == Light::transmitted ? transmission : reflection;
            values.push_back(
                observed.light == Light::beam
                    ? Scattered{}
                    : look_up(mixed, layer.albedo(), layer.optical_depth, observed.geometry));
        }
        return values;
    }

  private:
    TableView table_;
};

/// Phase functions of one or two kinds of particles, whose asymmetries may vary.
class ParticleModel : public LayerModel {
  public:
    ParticleModel(const PhaseFunction& first, const std::optional<PhaseFunction>& second)
        : first_(first), second_(second) {}

    int kinds() const override { return second_ ? 2 : 1; }

    ParameterRanges ranges() const override {
        ParameterRanges ranges = all_layers;
        if (!second_) ranges.mixture = {1, 1};
        return ranges;
    }

    bool has_depth(double depth) const override { return depth >= 0; }
    bool has(Light) const override { return true; }

    std::optional<double> asymmetry(int kind) const override {
        if (kind == 2 && !second_) return {};
        const PhaseFunction& phase_function = kind == 1 ? first_ : *second_;
        if (phase_function.terms().size() != 1) return {};
        const auto* lobe = std::get_if<HenyeyGreenstein>(&phase_function.terms().front().second);
        return lobe ? std::optional(lobe->g) : std::nullopt;
    }

  protected:
    PhaseFunction phase_function(int kind, double g) const {
        const std::optional<double> own = asymmetry(kind);
        if (own && *own != g) return PhaseFunction::henyey_greenstein(g);
        return kind == 1 ? first_ : *second_;
    }

    const PhaseFunction first_;
    const std::optional<PhaseFunction> second_;
};

class SingleScatteringModel : public ParticleModel {
  public:
    using ParticleModel::ParticleModel;

    std::vector<Scattered> scattered(const LayerParameters& layer,
                                     const std::vector<Observation>& observations) const override {
        const PhaseFunction first = phase_function(1, layer.g1);
        const PhaseFunction second = second_ ? phase_function(2, layer.g2) : first;
        std::vector<Scattered> values;
        for (const Observation& observed : observations) {
            const double cosine = cos_scattering_angle(observed);
            const double w_phase = layer.w1 * first(cosine) + layer.w2 * second(cosine);
            const auto once =
                observed.light == Light::transmitted ? single_transmission : single_reflection;
            values.push_back({once(w_phase, 1, layer.optical_depth, observed.geometry.mu_in,
                                   observed.geometry.mu_out),
                              0});
        }
        return values;
    }
};

class SolverModel : public ParticleModel {
  public:
    SolverModel(const PhaseFunction& first, const std::optional<PhaseFunction>& second,
                const SolverOptions& options)
        : ParticleModel(first, second), options_(options) {
        options_.exact_fluxes = false;  // which no observation is made of
    }

    std::vector<Scattered> scattered(const LayerParameters& layer,
                                     const std::vector<Observation>& observations) const override {
        std::set<double> cosines;
        for (const Observation& observed : observations)
            if (observed.light != Light::beam)
                cosines.insert({observed.geometry.mu_in, observed.geometry.mu_out});
        std::vector<Scattered> values(observations.size());
        if (cosines.empty()) return values;

        const std::vector<double> mu(cosines.begin(), cosines.end());
        const auto at = [&](double cosine) {
            return static_cast<int>(std::ranges::lower_bound(mu, cosine) - mu.begin());
        };
        const PhaseFunction first = phase_function(1, layer.g1);
        const LayerSolution solution = solve_layer(
            second_ ? PhaseFunction::mixture(layer.mixture(), first, phase_function(2, layer.g2))
                    : first,
            layer.albedo(), layer.optical_depth, mu, options_);
        for (std::size_t i = 0; i < observations.size(); ++i) {
            const auto& [geometry, light, brightness, sigma] = observations[i];
            if (light == Light::beam) continue;
            const int in = at(geometry.mu_in), out = at(geometry.mu_out);
            const SolvedValue value = light == Light::transmitted
                                          ? solution.transmission(in, out, geometry.azimuth)
                                          : solution.reflection(in, out, geometry.azimuth);
            values[i] = {value.single, value.multiple};
        }
        return values;
    }

    ParameterRanges ranges() const override {
        ParameterRanges ranges = ParticleModel::ranges();
        ranges.g = {-0.9, 0.9};  // peaks that few nodes hold
        return ranges;
    }

    int scanned_depths() const override { return 10; }

  private:
    SolverOptions options_;
};

class BeamModel : public LayerModel {
  public:
    int kinds() const override { return 0; }
    ParameterRanges ranges() const override {
        ParameterRanges ranges = all_layers;
        ranges.albedo = {0, 0};
        ranges.mixture = {1, 1};
        return ranges;
    }
    bool has_depth(double depth) const override { return depth >= 0; }
    bool has(Light light) const override { return light == Light::beam; }
    std::optional<double> asymmetry(int) const override { return {}; }
    std::vector<Scattered> scattered(const LayerParameters&,
                                     const std::vector<Observation>& observations) const override {
        return std::vector<Scattered>(observations.size());
    }
};

}  // namespace

std::vector<double> LayerModel::brightness(const LayerParameters& layer,
                                           const std::vector<Observation>& observations,
                                           double density, const Opposition& opposition) const {
    LayerParameters met = layer;
    met.optical_depth = effective_optical_depth(layer.optical_depth, density);
    const std::vector<Scattered> values = scattered(met, observations);
    const Opposition seen = seen_opposition(opposition, density);
    std::vector<double> brightness;
    for (std::size_t i = 0; i < observations.size(); ++i) {
        const Observation& observed = observations[i];
        const double mu_in = observed.geometry.mu_in, mu_out = observed.geometry.mu_out;
        double factor = 1;
        if (observed.light == Light::reflected && seen.law != Opposition::Law::none)
            factor = opposition_factor(seen, cos_scattering_angle(observed), met.optical_depth,
                                       mu_in, mu_out);
        brightness.push_back(observed.light == Light::beam
                                 ? direct_transmittance(met.optical_depth, mu_out)
                                 : mu_in * (factor * values[i].single + values[i].multiple));
    }
    return brightness;
}

std::unique_ptr<LayerModel> table_model(const TableView& table) {
    return std::make_unique<TableModel>(table);
}

std::unique_ptr<LayerModel> single_scattering_model(const PhaseFunction& first,
                                                    const std::optional<PhaseFunction>& second) {
    return std::make_unique<SingleScatteringModel>(first, second);
}

std::unique_ptr<LayerModel> solver_model(const PhaseFunction& first,
                                         const std::optional<PhaseFunction>& second,
                                         const SolverOptions& options) {
    return std::make_unique<SolverModel>(first, second, options);
}

std::unique_ptr<LayerModel> beam_model() { return std::make_unique<BeamModel>(); }

}  // namespace stratus
