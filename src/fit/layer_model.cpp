#include <stratus/fit/fit.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <set>
#include <span>

namespace stratus {
namespace {

constexpr ParameterRanges all_layers{{1e-4, 64}, {0, 1}, {0, 1}, {-0.95, 0.95}};

/// Where light that is no beam leaves the layer.
Side side(const Observation& observed) {
    return observed.light == Light::transmitted ? Side::transmission : Side::reflection;
}

/// Whether it takes long to see a table at another point of its family.
bool is_slow(const TableView& table) {
    if (!table.has_family()) return false;
    return table.path_law != nullptr ||
           std::ranges::any_of(*table.family, [](const FamilyAxis& axis) {
               return axis.parameter != PhaseParameter::mixture &&
                      axis.parameter != PhaseParameter::g;
           });
}

/// Finer than phase functions vary: those of droplets by the root of their variance, some 0.3.
FamilyAxis fine_axis(const FamilyAxis& axis) {
    constexpr double step = 0.05;  // of the logarithm, or of g or a mixture itself
    if (axis.is_discrete) return axis;
    const double low = axis.axis.values.front(), high = axis.axis.values.back();
    const bool is_logarithm = axis.axis.scale == AxisScale::logarithmic;
    const double extent = is_logarithm ? std::log(high / low) : high - low;
    const int count = std::max(stencil_size, 1 + static_cast<int>(std::ceil(extent / step)));
    return {axis.parameter, make_axis(axis.axis.scale, low, high, count)};
}

Interval of(const AxisView& axis) { return {axis.lowest, axis.highest}; }

struct WeightedView {
    double weight;
    TableView view;
};

/// A table at points of its family. Where that takes long, it is seen at a grid of points around,
/// which are kept for the lookups that follow, and these are joined by cubics.
class FamilyViews {
  public:
    explicit FamilyViews(const TableView& table) : table_(table) {
        if (is_slow(table))
            for (const FamilyAxis& axis : *table.family) grid_.push_back(fine_axis(axis));
    }

    std::vector<WeightedView> at(const FamilyPoint& point) const {
        if (grid_.empty()) return {{1, table_.at(point)}};
        const FamilyStencil stencil = family_stencil(grid_, point);
        std::vector<WeightedView> views;
        for (int n = 0; n < stencil.count; ++n)
            if (stencil.weight[n] != 0)
                views.push_back({stencil.weight[n], kept(stencil.member[n])});
        return views;
    }

  private:
    TableView kept(int member) const {
        {
            const std::lock_guard lock(mutex_);
            if (const auto found = kept_.find(member); found != kept_.end()) return found->second;
        }
        const TableView view = table_.at(member_at(grid_, size(member)));
        const std::lock_guard lock(mutex_);
        if (kept_.size() >= most_kept) kept_.clear();
        return kept_.emplace(member, view).first->second;
    }

    static constexpr std::size_t most_kept = 256;  // of the largest droplets a megabyte each

    const TableView table_;
    FamilyAxes grid_;
    mutable std::mutex mutex_;
    mutable std::map<int, TableView> kept_;
};

class TableModel : public LayerModel {
  public:
    explicit TableModel(const TableView& table)
        : table_(table), family_(table.has_family() ? *table.family : FamilyAxes{}), views_(table) {
        require(table.highest_order == 0, "fit", "table", "of all orders of scattering",
                "orders up to " + std::to_string(table.highest_order));
        for (const FamilyAxis& axis : family_)
            require(axis.parameter != PhaseParameter::mixture || !axis.is_discrete, "fit", "table",
                    "of a range of mixtures, or none", "of some mixtures");
    }

    int kinds() const override { return mixes_two(family_) ? 2 : 1; }

    FamilyAxes family() const override { return family_; }

    ParameterRanges ranges() const override {
        const Interval infinite{infinity, infinity};
        Interval mixture{1, 1};
        for (const FamilyAxis& axis : family_)
            if (axis.parameter == PhaseParameter::mixture) mixture = of(axis.axis.view());
        return {table_.optical_depth.count > 0 ? of(table_.optical_depth) : infinite,
                of(table_.albedo),
                mixture,
                {0, 0}};
    }

    bool has_depth(double depth) const override {
        const AxisView& axis = table_.optical_depth;
        if (depth == infinity) return axis.count == 0 || axis.ends_at_infinity;
        return axis.count > 0 && depth >= 0 && depth <= axis.highest &&
               (!is_thinner(depth) || table_.knows_thinner_layers());
    }

    bool has(Light light) const override {
        if (light == Light::beam) return !table_.has_lower_boundary();
        return light == Light::reflected ? table_.has_reflection() : table_.has_transmission();
    }

    void check_directions(const char* caller, const Observation& observed) const override {
        if (observed.light == Light::beam || table_.has_all_directions()) return;
        const auto& [mu_in, mu_out, azimuth] = observed.geometry;
        const auto check = [&](const char* name, const Interval& known, const char* unit,
                               double value) {
            constexpr double rounding = 1e-7;
            require(value >= known.low - rounding && value <= known.high + rounding, caller, name,
                    "in [" + short_number(known.low, 6) + ", " + short_number(known.high, 6) + "]" +
                        unit + " of the table",
                    value);
        };
        check("mu_in", of(table_.mu_in), "", mu_in);
        check("mu_out", of(table_.mu_out), "", mu_out);
        const Interval around = of(table_.azimuth);
        if (table_.azimuth.count > 1 || around.low > 0)  // nothing depends on that of 0 alone
            check("azimuth", {degrees(around.low), degrees(around.high)}, " degrees",
                  degrees(std::abs(std::remainder(azimuth, 2 * pi))));
    }

    bool has_lower_boundary() const override { return table_.has_lower_boundary(); }

    std::vector<Scattered> scattered(const LayerParameters& layer,
                                     const Observations& observations) const override {
        std::vector<Scattered> values;
        std::vector<WeightedView> views;
        FamilyPoint seen;
        for (const Observation& observed : observations) {
            values.emplace_back();
            if (observed.light == Light::beam) continue;
            const FamilyPoint point = family_point(layer, observed);
            if (views.empty() || !(point == seen)) views = views_.at(seen = point);
            for (const auto& [weight, view] : views) {
                const Scattered found = scattering(view, side(observed), layer.albedo(),
                                                   layer.optical_depth, observed.geometry);
                values.back().single += weight * found.single;
                values.back().multiple += weight * found.multiple;
            }
        }
        return values;
    }

    /// Estimates the error of layers thinner than the samples, which lookups extrapolate; 0 for all others.
    double error(const LayerParameters& layer, const Observations& observations) const override {
        double largest = 0;
        if (!is_thinner(layer.optical_depth)) return largest;
        for (const Observation& observed : observations) {
            if (observed.light == Light::beam) continue;
            const double w = layer.albedo(), tau = layer.optical_depth;
            const Geometry& at = observed.geometry;
            const Side on = side(observed);
            double error = 0;
            for (const auto& [weight, view] : views_.at(family_point(layer, observed)))
                error += weight * thin_layer_error(view, on, w, tau, at) *
                         scattering(view, on, w, tau, at).total();
            largest = std::max(largest, at.mu_in * std::abs(error) / observed.sigma);
        }
        return largest;
    }

    const char* error_name() const override {
        return "the error of extrapolating the table to so thin a layer";
    }

    int scanned_depths() const override {
        return is_slow(table_) ? 10 : LayerModel::scanned_depths();
    }

  private:
    /// Whether a layer is thinner than the table's first sample, by more than rounding.
    bool is_thinner(double depth) const {
        constexpr double rounding = 1e-7;
        return depth < table_.optical_depth.lowest * (1 - rounding);
    }

    /// Values known of an observation, and the layer's own values of all others.
    FamilyPoint family_point(const LayerParameters& layer, const Observation& observed) const {
        std::vector<double> values;
        for (const FamilyAxis& axis : family_) {
            const auto parameter = to_fit_parameter(axis.parameter);
            const double known = observed.known[values.size()];
            values.push_back(!parameter          ? layer.mixture()
                             : std::isnan(known) ? layer.*layer_fields[*parameter]
                                                 : known);
        }
        return FamilyPoint(values);
    }

    const TableView table_;
    const FamilyAxes family_;
    const FamilyViews views_;
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
                                     const Observations& observations) const override {
        const PhaseFunction first = phase_function(1, layer.g1);
        const PhaseFunction second = second_ ? phase_function(2, layer.g2) : first;
        std::vector<Scattered> values;
        for (const Observation& observed : observations) {
            const double cosine = cos_scattering_angle(side(observed), observed.geometry);
            const double w_phase = layer.w1 * first(cosine) + layer.w2 * second(cosine);
            values.push_back({single_scattering(side(observed), w_phase, 1, layer.optical_depth,
                                                observed.geometry.mu_in, observed.geometry.mu_out),
                              0});
        }
        return values;
    }
};

class SolverModel : public ParticleModel {
  public:
    SolverModel(const PhaseFunction& first, const std::optional<PhaseFunction>& second, int nodes)
        : ParticleModel(first, second) {
        options_.nodes = nodes;
        options_.exact_fluxes = false;  // which no observation is made of
    }

    std::vector<Scattered> scattered(const LayerParameters& layer,
                                     const Observations& observations) const override {
        const PhaseFunction phase = mixed_phase_function(layer);
        std::vector<Scattered> values(observations.size());
        for (std::size_t first = 0; first < observations.size();) {
            std::set<double> cosines;
            std::size_t end = first;
            // Cosines cost as much as nodes: as many at once as there are nodes cost least.
            for (; end < observations.size() && int_size(cosines) <= options_.nodes; ++end)
                if (observations[end].light != Light::beam)
                    cosines.insert(
                        {observations[end].geometry.mu_in, observations[end].geometry.mu_out});
            if (!cosines.empty())
                solve(layer, phase, cosines, std::span(observations).subspan(first, end - first),
                      &values[first]);
            first = end;
        }
        return values;
    }

    double error(const LayerParameters& layer, const Observations& observations) const override {
        double largest = 0;
        const SolvedGeometries solved = solved_at(layer, observations, options_);
        for (std::size_t i = 0; i < observations.size(); ++i) {
            const Observation& observed = observations[i];
            if (observed.light == Light::beam) continue;
            const double error = observed.light == Light::transmitted
                                     ? solved.at[i].transmission_error
                                     : solved.at[i].reflection_error;
            largest = std::max(largest, observed.geometry.mu_in * error / observed.sigma);
        }
        return largest;
    }

    std::unique_ptr<LayerModel> refined(const LayerParameters& layer,
                                        const Observations& observations,
                                        double tolerance) const override {
        double relative = 1;
        for (const Observation& observed : observations)
            if (observed.light != Light::beam && observed.brightness > observed.sigma)
                relative = std::min(relative, observed.sigma / observed.brightness);
        SolverOptions options = options_;
        options.tolerance = std::max(tolerance * relative, 1e-9);
        const int nodes =
            std::min(solved_at(layer, observations, options).nodes, most_fitted_nodes);
        if (nodes <= options_.nodes) return nullptr;
        return std::make_unique<SolverModel>(first_, second_, nodes);
    }

    ParameterRanges ranges() const override {
        ParameterRanges ranges = ParticleModel::ranges();
        ranges.g = {-0.9, 0.9};  // peaks that few nodes hold
        return ranges;
    }

    int scanned_depths() const override { return 10; }

  private:
    static constexpr int most_fitted_nodes = 164;  // a fit solves some hundred layers

    /// Solves a layer for the values of observations, all along these cosines; leaves those of occultations.
    void solve(const LayerParameters& layer, const PhaseFunction& phase,
               const std::set<double>& cosines, std::span<const Observation> observations,
               Scattered* values) const {
        const std::vector<double> mu(cosines.begin(), cosines.end());
        const auto at = [&](double cosine) {
            return static_cast<int>(std::ranges::lower_bound(mu, cosine) - mu.begin());
        };
        const LayerSolution solution =
            solve_layer(phase, layer.albedo(), layer.optical_depth, mu, options_);
        for (std::size_t i = 0; i < observations.size(); ++i) {
            const Observation& observed = observations[i];
            if (observed.light == Light::beam) continue;
            const auto& [mu_in, mu_out, azimuth] = observed.geometry;
            const SolvedValue value =
                solution.values(side(observed), at(mu_in), at(mu_out), {azimuth})[0];
            values[i] = {value.single, value.multiple};
        }
    }

    PhaseFunction mixed_phase_function(const LayerParameters& layer) const {
        const PhaseFunction first = phase_function(1, layer.g1);
        if (!second_) return first;
        return PhaseFunction::mixture(layer.mixture(), first, phase_function(2, layer.g2));
    }

    SolvedGeometries solved_at(const LayerParameters& layer, const Observations& observations,
                               const SolverOptions& options) const {
        std::vector<Geometry> geometries;
        for (const Observation& observed : observations)
            geometries.push_back(observed.light == Light::beam ? Geometry{1, 1, 0}
                                                               : observed.geometry);
        return solve_geometries(
            {{mixed_phase_function(layer), layer.albedo(), layer.optical_depth}}, {}, geometries,
            options);
    }

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
    bool has(Light light) const override { return light == Light::beam; }
    std::vector<Scattered> scattered(const LayerParameters&,
                                     const Observations& observations) const override {
        return std::vector<Scattered>(observations.size());
    }
};

}  // namespace

std::optional<FitParameter> to_fit_parameter(PhaseParameter parameter) noexcept {
    switch (parameter) {
        case PhaseParameter::mixture: return {};
        case PhaseParameter::g: return fit_g1;
        case PhaseParameter::radius: return fit_radius;
        case PhaseParameter::wavelength: return fit_wavelength;
        case PhaseParameter::variance: return fit_variance;
    }
    return {};
}

std::vector<double> LayerModel::brightness(const LayerParameters& layer,
                                           const Observations& observations, double density,
                                           const Opposition& opposition) const {
    LayerParameters met = layer;
    met.optical_depth = effective_optical_depth(layer.optical_depth, density);
    const std::vector<Scattered> values = scattered(met, observations);
    const Opposition seen = seen_opposition(opposition, density);
    std::vector<double> brightness;
    for (std::size_t i = 0; i < observations.size(); ++i) {
        const Observation& observed = observations[i];
        const double mu_in = observed.geometry.mu_in, mu_out = observed.geometry.mu_out;
        double factor = 1;
        if (observed.light == Light::reflected && seen.is_present())
            factor =
                opposition_factor(seen, cos_scattering_angle(side(observed), observed.geometry),
                                  met.optical_depth, mu_in, mu_out);
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
                                         const std::optional<PhaseFunction>& second, int nodes) {
    return std::make_unique<SolverModel>(first, second, nodes);
}

std::unique_ptr<LayerModel> beam_model() { return std::make_unique<BeamModel>(); }

}  // namespace stratus
