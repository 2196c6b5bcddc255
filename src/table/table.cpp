#include <stratus/table/table.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/layer/diffusion.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/table/metadata.h>

#include "layer_blend.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace stratus {
namespace {

constexpr const char* caller = "prepare";

/// Below this a sample is too near the end of float's range to be scaled back up.
constexpr double min_scale = 1e-35;

bool spans_all_azimuths(const AxisView& azimuth) {
    if (azimuth.lowest > 0) return false;
    return azimuth.count == 1 || pi - azimuth.highest <= 1e-9;
}

void check_axis_field(const Table& table, const AxisField& field) {
    const Axis& axis = table.*field.axis;
    const auto [usual, other] = field.scales;
    require(axis.scale == usual || axis.scale == other, caller,
            std::string("scale of axis ") + field.name, allowed_scales(field),
            axis_scale_name(axis.scale));
    check_axis(axis, field.name);
    const NumberRange range = field.range;
    for (const double value : axis.values)
        require(range.holds(value), caller, field.name, "within " + range.text, value);
}

void check_azimuths(const Axis& azimuth) {
    const auto count = static_cast<int>(azimuth.values.size());
    require(count == 1 || count >= stencil_size || spans_all_azimuths(azimuth.view()), caller,
            "samples of azimuth", "1, or 4 at least, where they do not span 0 to pi", count);
}

/// How many numbers lie over the first axes; std::invalid_argument for more than memory could hold.
std::size_t checked_count(const Table& table, std::size_t rank) {
    std::size_t product = 1;
    for (const std::size_t extent : extents(table, rank)) {
        require(extent == 0 || product <= std::numeric_limits<std::size_t>::max() / 16 / extent,
                caller, "product of the axes' lengths", "addressable", product);
        product *= extent;
    }
    return product;
}

template <class Number>
void check_dataset(const std::vector<Number>& samples, const char* name, std::size_t extent) {
    require(samples.size() == extent, caller, std::string("length of ") + name,
            std::to_string(extent), samples.size());
    int any_bad = 0;  // no early exit, so that the loop is vectorised
    for (const Number sample : samples) any_bad |= std::isfinite(sample) ? 0 : 1;
    if (any_bad == 0) return;
    const auto bad =
        std::find_if(samples.begin(), samples.end(), [](Number n) { return !std::isfinite(n); });
    require(false, caller,
            std::string(name) + " (sample " + std::to_string(bad - samples.begin()) + ")", "finite",
            *bad);
}

/// Checks fluxes, or the samples, as far as the table has them.
void check_fields(const Table& table, bool are_fluxes) {
    for (const SampleField& field : sample_fields)
        if (field.is_flux() == are_fluxes && !(table.*field.samples).empty())
            check_dataset(table.*field.samples, field.name, checked_count(table, field.rank));
}

void check_samples(const Table& table) {
    require(!table.reflection_multiple.empty() || !table.transmission_multiple.empty(), caller,
            "table", "given reflection_multiple or transmission_multiple", "neither");
    check_fields(table, false);
}

void check_numbers(const Table& table) {
    for (const double exponent : table.diffusion_exponent)
        require_in("[0, 1000]", caller, "diffusion_exponent", exponent);
    require_in("(0, inf)", caller, "extrapolation_length", table.extrapolation_length);
    require_in("[0, inf)", caller, "tolerance", table.tolerance);
    require_in("[0, inf)", caller, "measured_error", table.measured_error);
    require(table.highest_order >= 0, caller, "highest_order", "at least 0", table.highest_order);
    constexpr int most_orders = 1 << 20;  // one more is still a number
    require(table.highest_order <= most_orders, caller, "highest_order", "at most 1048576",
            table.highest_order);
}

void check_stack(const Table& table) {
    require_in("[0, 1]", caller, "spherical_albedo_below", table.spherical_albedo_below);
    if (!table.is_stack()) return;
    check_layers(table.layers, table.lower_boundary.is_present(), caller);
    require(!table.has_family() && !table.path_law && table.highest_order == 0, caller,
            "table of a stack", "without family, path law and highest order", "one of them");
    const StackLayer mean = mean_layer(table.layers);
    for (const auto& [axis, name, value] :
         {std::tuple(&table.optical_depth, "optical_depth", mean.optical_depth),
          std::tuple(&table.albedo, "albedo", mean.albedo)})
        require(axis->values.size() == 1 &&
                    (axis->values[0] == value || std::abs(axis->values[0] - value) <= 1e-9 * value),
                caller, name, "the mean of the stack's layers alone, " + shortest_text(value),
                axis->values.empty() ? 0 : axis->values[0]);
}

void check_boundary(const Table& table) {
    require_in("[0, 1]", caller, "albedo of the lower boundary", table.lower_boundary.albedo);
    require(!table.lower_boundary.is_present() || table.transmission_multiple.empty(), caller,
            "transmission_multiple", "absent over a lower boundary", "given");
}

/// 1 / scale, or 0 where a sample is too near the end of float's range to be scaled back up.
float inverse_scale(double scale) { return scale < min_scale ? 0 : static_cast<float>(1 / scale); }

void check_lengths(const Table& table) {
    if (!table.has_family()) return;
    const std::vector<double>& lengths = table.extrapolation_lengths;
    require(lengths.size() == table.member_count(), caller, "extrapolation_lengths",
            "as many as members, " + std::to_string(table.member_count()), lengths.size());
    for (const double length : lengths)
        require_in("(0, inf)", caller, "extrapolation_lengths", length);
}

void work_out_weights(Table& table) {
    table.reflection_weight.clear();
    table.transmission_weight.clear();
    const std::size_t albedos = table.albedo.values.size();
    for (std::size_t a = 0; a < table.member_count() * albedos; ++a)
        for (const double depth : table.optical_depth.values) {
            const double sampled = table.albedo.values[a % albedos];
            const double albedo = sampled > tiny_albedo && !table.is_stack() ? sampled : 1;
            const double exponent = table.diffusion_exponent[a];
            const double length = table.extrapolation_lengths[a / albedos];
            table.reflection_weight.push_back(
                table.lower_boundary.is_present()
                    ? 1
                    : inverse_scale(albedo * reflection_scale(depth, exponent, length)));
            table.transmission_weight.push_back(
                inverse_scale(albedo * transmission_scale(depth, exponent, length)));
        }
    auto over_cosines = [&](const Axis& cosines, std::vector<float>& weights) {
        weights.clear();
        for (const double depth : table.optical_depth.values)
            for (const double mu : cosines.values)
                weights.push_back(table.lower_boundary.is_present()
                                      ? 1
                                      : static_cast<float>(1 / intercepted_share(depth, mu)));
    };
    over_cosines(table.mu_in, table.mu_in_weight);
    over_cosines(table.mu_out, table.mu_out_weight);
}

}  // namespace

std::size_t Table::layer_count() const noexcept {
    return member_count() * albedo.values.size() * optical_depth.values.size();
}

std::size_t Table::sample_count() const noexcept {
    return layer_count() * mu_in.values.size() * mu_out.values.size() * azimuth.values.size();
}

bool Table::varies_parameters() const noexcept { return has_family() && !is_mixture(family); }

bool TableView::has_all_directions() const noexcept {
    constexpr double grazing = 0.01;
    return has_same_cosines() && mu_in.lowest <= grazing && mu_in.highest == 1 &&
           spans_all_azimuths(azimuth);
}

TableView TableView::at(const FamilyPoint& point) const {
    const std::size_t axes = has_family() ? family->size() : 0;
    require(point.size() == axes, "at", "values of parameters",
            std::to_string(axes) + ", one for each axis of the family", point.size());
    TableView view = *this;
    if (!has_family()) return view;
    view.chosen = point;
    for (std::size_t k = 0; k < axes; ++k) {
        const FamilyAxis& axis = (*family)[k];
        require(!axis.is_discrete || holds(axis, point[k]), "at", axis.name(), allowed_text(axis),
                point[k]);
        if (axis.parameter != PhaseParameter::mixture) continue;
        require_in("[0, 1]", "at", axis.name(), point[k]);
        view.chosen_mixture = point[k];
    }
    view.members = family_stencil(*family, point);
    view.own_phase_function =
        std::make_shared<const PhaseFunction>(with_parameters(*phase_function, *family, point));
    view.phase_function = view.own_phase_function.get();
    if (path_law == nullptr) return view;
    view.own_path_law = PathOrders::of_any(*view.phase_function);
    view.path_law = view.own_path_law.get();
    return view;
}

PhaseFunction TableView::chosen_phase_function() const {
    if (!has_family()) return *phase_function;
    for (std::size_t k = 0; k < family->size(); ++k)
        require(!std::isnan(chosen[k]), "at", (*family)[k].name(), "chosen for this table",
                chosen[k]);
    if (second_phase_function == nullptr) return *phase_function;
    return PhaseFunction::mixture(chosen_mixture, *phase_function, *second_phase_function);
}

TableView Table::view() const noexcept {
    TableView view;
    view.phase_function = &phase_function;
    view.phase_curve = &phase_curve;
    if (has_family()) {
        view.family = &family;
        view.members = family_stencil(family, {});
    }
    if (mixes_two(family)) view.second_phase_function = &second_phase_function;
    if (is_stack()) view.layers = &layers;
    view.lower_boundary = &lower_boundary;
    view.albedo = albedo.view();
    view.optical_depth = optical_depth.view();
    view.mu_in = mu_in.view();
    view.mu_out = mu_out.view();
    view.azimuth = azimuth.view();
    if (!reflection_multiple.empty()) view.reflection_multiple = reflection_multiple.data();
    if (!transmission_multiple.empty()) view.transmission_multiple = transmission_multiple.data();
    view.reflection_weight = reflection_weight.data();
    view.transmission_weight = transmission_weight.data();
    view.mu_in_weight = mu_in_weight.data();
    view.mu_out_weight = mu_out_weight.data();
    view.diffusion_exponent = diffusion_exponent.data();
    if (!diffuse_transmittance.empty()) view.diffuse_transmittance = diffuse_transmittance.data();
    view.extrapolation_length = extrapolation_length;
    view.extrapolation_lengths = extrapolation_lengths.data();
    view.tolerance = tolerance;
    view.path_law = path_law.get();
    view.highest_order = highest_order;
    return view;
}

namespace {

void check_header(const Table& table) {
    check_family(table.phase_function, table.family, caller);
    check_lengths(table);
    for (const AxisField& field : axis_fields) check_axis_field(table, field);
    check_azimuths(table.azimuth);
    check_fields(table, true);
    check_dataset(table.diffusion_exponent, diffusion_exponent_name, checked_count(table, 1));
    check_numbers(table);
    check_boundary(table);
    check_stack(table);
}

}  // namespace

void check(const Table& table) {
    check_header(table);
    check_samples(table);
}

void prepare_header(Table& table) {
    check_header(table);
    if (!table.has_family()) table.extrapolation_lengths = {table.extrapolation_length};
    work_out_weights(table);
}

void prepare(Table& table) {
    prepare_header(table);
    check_samples(table);
    table.phase_curve = PhaseCurve(table.phase_function);
}

bool is_mixture(const FamilyAxes& family) noexcept {
    return family.size() == 1 && family[0].parameter == PhaseParameter::mixture &&
           !family[0].is_discrete;
}

PhaseFunction phase_function_of_member(const Table& table, std::size_t member) {
    if (!table.has_family()) return table.phase_function;
    return table.view().at(member_at(table.family, member)).chosen_phase_function();
}

}  // namespace stratus
