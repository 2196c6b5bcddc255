#include "layer_blend.h"

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/layer/diffusion.h>
#include <stratus/layer/single_scattering.h>

#include "lookup_arguments.h"

#include <algorithm>
#include <cstddef>
#include <sstream>

namespace stratus {

namespace {

/// The layer at which the multiply scattered part is asked for.
struct LayerQuery {
    Stencil albedo_stencil;
    double albedo;  // clamped to the axis; 1 where samples are not divided by anything
    double optical_depth;
    int member;
    double extrapolation_length;
    double diffusion_exponent;
};

double interpolate_exponent(const TableView& table, int member, const Stencil& albedo) noexcept {
    const double* const exponent =
        table.diffusion_exponent + member * table.albedo.count + albedo.first;
    double sum = 0;
    for (int l = 0; l < used_samples(table.albedo); ++l)
        sum += double{albedo.weight[l]} * exponent[l];
    return std::max(0.0, sum);
}

LayerQuery make_query(const TableView& table, double albedo, double optical_depth, int member,
                      BeyondDeepest beyond) noexcept {
    const Stencil stencil = table.albedo.stencil(albedo);
    LayerQuery query{stencil,
                     std::clamp(albedo, table.albedo.lowest, table.albedo.highest),
                     depth_in(table, optical_depth, beyond),
                     member,
                     table.extrapolation_lengths[member],
                     interpolate_exponent(table, member, stencil)};
    if (table.has_lower_boundary() || table.is_stack()) query.albedo = 1;
    return query;
}

/// Adds up the terms of one side of a table.
class BlendBuilder {
  public:
    BlendBuilder(const TableView& table, const float* samples, const float* weight,
                 LayerBlend& blend) noexcept
        : table_(table),
          weight_(weight),
          depths_(table.optical_depth.size()),
          term_size_(std::ptrdiff_t{table.mu_in.count} * table.mu_out.count * table.azimuth.count),
          blend_(blend) {
        blend_.samples = samples;
    }

    /// The terms that add(query) adds for each of some members, by its weight.
    template <class Add>
    void add_members(const FamilyStencil& members, double albedo, double optical_depth,
                     BeyondDeepest beyond, const Add& add) noexcept {
        for (int m = 0; m < members.count; ++m) {
            share_of_member_ = double{members.weight[m]};
            add(make_query(table_, albedo, optical_depth, members.member[m], beyond));
        }
        blend_.optical_depth = depth_in(table_, optical_depth, beyond);
        const AxisView& depths = table_.optical_depth;
        if (depths.count == 0 || !(blend_.optical_depth < depths.lowest)) return;
        if (!table_.has_lower_boundary())
            blend_.growth = thin_growth(blend_.optical_depth) / thin_growth(depths.lowest);
        else
            blend_.fades = table_.lower_boundary->kind == LowerBoundary::Kind::surface;
    }

    /// The samples of one depth around an albedo. One too deep to be scaled back up hands its share
    /// to the neighbour of higher albedo, which decays more slowly; false comes back when there is
    /// none to take it.
    bool add_depth(const LayerQuery& query, int depth, double share) noexcept {
        double handed_on = 0;
        for (int l = 0; l < used_samples(table_.albedo); ++l) {
            const double part = share * double{query.albedo_stencil.weight[l]} + handed_on;
            handed_on = add(query, query.albedo_stencil.first + l, depth, part) ? 0 : part;
        }
        return handed_on == 0;
    }

    /// Cubic along optical depth within the finite samples. A depth without a usable sample hands
    /// its share to the one above it.
    void add_depths(const LayerQuery& query, double scale) noexcept {
        const Stencil depth = table_.optical_depth.stencil(query.optical_depth);
        double handed_on = 0;
        for (int t = used_samples(table_.optical_depth) - 1; t >= 0; --t) {
            const double share = scale * double{depth.weight[t]} + handed_on;
            handed_on = add_depth(query, depth.first + t, share) ? 0 : share;
        }
    }

    /// Between the deepest finite sample and the one at infinity the distance from the limit dies
    /// away by the law of diffusion; the scale of the sample at infinity is 1. Albedos whose
    /// deficit is spent hand their share of it on, as above.
    void add_between_last_and_infinity(const LayerQuery& query) noexcept {
        const double length = query.extrapolation_length, highest = table_.optical_depth.highest;
        const bool over_boundary = table_.has_lower_boundary();
        const double deficit =
            reflection_deficit(query.optical_depth, query.diffusion_exponent, length);
        const int last = table_.optical_depth.count - 1;
        double handed_on = 0;
        for (int l = 0; l < used_samples(table_.albedo); ++l) {
            const int albedo = query.albedo_stencil.first + l;
            const double exponent =
                table_.diffusion_exponent[query.member * table_.albedo.count + albedo];
            const double deepest = last < 0 ? 0 : reflection_deficit(highest, exponent, length);
            const double weight = double{query.albedo_stencil.weight[l]};
            const bool spent = deepest < min_deficit;
            const double share = spent ? 0 : (weight + handed_on) * deficit / deepest;
            handed_on = spent ? weight + handed_on : 0;
            add(query, albedo, last + 1, query.albedo * (weight - share));
            if (!spent)
                add(query, albedo, last,
                    query.albedo * share *
                        (over_boundary ? 1 : reflection_scale(highest, exponent, length)));
        }
    }

  private:
    /// False when the sample is too small to be scaled back up.
    bool add(const LayerQuery& query, int albedo, int depth, double share_in_member) noexcept {
        const std::ptrdiff_t at =
            (std::ptrdiff_t{query.member} * table_.albedo.count + albedo) * depths_ + depth;
        if (weight_[at] == 0) return false;
        const double share = share_of_member_ * share_in_member;
        if (share != 0)
            blend_.term[blend_.count++] = {at * term_size_,
                                           static_cast<float>(share * double{weight_[at]}), depth};
        return true;
    }

    const TableView& table_;
    const float* weight_;
    int depths_;
    std::ptrdiff_t term_size_;
    double share_of_member_ = 1;
    LayerBlend& blend_;
};

}  // namespace

double depth_in(const TableView& table, double optical_depth, BeyondDeepest beyond) noexcept {
    const bool is_clamped =
        !table.optical_depth.ends_at_infinity && beyond == BeyondDeepest::is_clamped;
    return is_clamped ? std::min(optical_depth, table.optical_depth.highest) : optical_depth;
}

double fall_from_member(double optical_depth, double exponent, double chosen_exponent,
                        double extrapolation_length) noexcept {
    const auto fall = [&](double k) {
        return transmission_scale(optical_depth, k, extrapolation_length);
    };
    const double sampled = fall(exponent);
    return sampled > 0 ? fall(chosen_exponent) / sampled : 0;
}

FamilyStencil transmitted_members(const TableView& table, FamilyStencil members, double albedo,
                                  double optical_depth) noexcept {
    if (!table.has_family()) return members;
    const Stencil stencil = table.albedo.stencil(albedo);
    double exponent[FamilyStencil::max_count], chosen = 0;
    for (int m = 0; m < members.count; ++m) {
        exponent[m] = interpolate_exponent(table, members.member[m], stencil);
        chosen += double{members.weight[m]} * exponent[m];
    }
    for (int m = 0; m < members.count; ++m)
        members.weight[m] *= static_cast<float>(fall_from_member(
            optical_depth, exponent[m], std::max(0.0, chosen), table.extrapolation_length));
    return members;
}

LayerBlend layer_blend(const TableView& table, Side side, double albedo, double optical_depth,
                       BeyondDeepest beyond) noexcept {
    const AxisView& depth = table.optical_depth;
    const bool is_lit = side == Side::reflection;
    LayerBlend blend;
    BlendBuilder terms(table, is_lit ? table.reflection_multiple : table.transmission_multiple,
                       is_lit ? table.reflection_weight : table.transmission_weight, blend);
    const auto add_reflection = [&](const LayerQuery& query) {
        if (depth.ends_at_infinity && (depth.count == 0 || query.optical_depth > depth.highest))
            terms.add_between_last_and_infinity(query);
        else if (table.has_lower_boundary())
            terms.add_depths(query, 1);
        else
            terms.add_depths(query, query.albedo * reflection_scale(query.optical_depth,
                                                                    query.diffusion_exponent,
                                                                    query.extrapolation_length));
    };
    const auto add_transmission = [&](const LayerQuery& query) {
        if (depth.count == 0) return;  // a semi-infinite layer transmits nothing
        const double scale =
            query.albedo * transmission_scale(query.optical_depth, query.diffusion_exponent,
                                              query.extrapolation_length);
        if (query.optical_depth > depth.highest)
            terms.add_depth(query, depth.count - 1, scale);
        else
            terms.add_depths(query, scale);
    };
    if (is_lit)
        terms.add_members(table.members, albedo, optical_depth, beyond, add_reflection);
    else
        terms.add_members(transmitted_members(table, table.members, albedo,
                                              depth_in(table, optical_depth, beyond)),
                          albedo, optical_depth, beyond, add_transmission);
    return blend;
}

double deficit_of_deepest(const TableView& table, double albedo) noexcept {
    const LayerQuery query =
        make_query(table, albedo, 0, table.members.member[0], BeyondDeepest::is_clamped);
    return reflection_deficit(table.optical_depth.highest, query.diffusion_exponent,
                              query.extrapolation_length);
}

double directional_factor(const TableView& table, const LayerBlend& blend, double mu_in,
                          double mu_out) noexcept {
    const double in = std::clamp(mu_in, table.mu_in.lowest, table.mu_in.highest);
    const double out = std::clamp(mu_out, table.mu_out.lowest, table.mu_out.highest);
    if (!table.has_lower_boundary())
        return blend.growth * intercepted_share(blend.optical_depth, in) *
               intercepted_share(blend.optical_depth, out);
    if (!blend.fades) return 1;
    // A surface alone scatters once; a thin layer adds in proportion to what it extinguishes.
    const auto extinguished = [&](double depth) {
        return intercepted_share(depth, in) + intercepted_share(depth, out);
    };
    return extinguished(blend.optical_depth) / extinguished(table.optical_depth.lowest);
}

std::vector<double> diffuse_transmittance(const TableView& table, double albedo,
                                          double optical_depth) {
    if (table.diffuse_transmittance == nullptr) return {};
    albedo = in_range("albedo", 0.0, 1.0, albedo);
    optical_depth = in_range("optical_depth", 0.0, infinity, optical_depth);
    const int cosines = table.mu_in.count;
    if (is_unknown(albedo, optical_depth))
        return std::vector<double>(static_cast<std::size_t>(cosines), double{not_a_number});
    std::vector<double> sum(static_cast<std::size_t>(cosines));
    const double clamped_albedo = std::clamp(albedo, table.albedo.lowest, table.albedo.highest);
    if (clamped_albedo == 0) return sum;
    const LayerBlend blend = layer_blend(table, Side::transmission, albedo, optical_depth,
                                         BeyondDeepest::follows_diffusion);
    const std::ptrdiff_t term_size =
        std::ptrdiff_t{cosines} * table.mu_out.count * table.azimuth.count;
    for (int n = 0; n < blend.count; ++n) {
        const BlendTerm& term = blend.term[n];
        const std::ptrdiff_t layer = term.first / term_size;
        // A blend is of samples divided by the albedo, which order 1 does not allow at albedo 0.
        const auto sampled_albedo = table.albedo.value(
            static_cast<int>(layer / table.optical_depth.size() % table.albedo.count));
        const double share = double{term.share} * sampled_albedo / clamped_albedo;
        for (int i = 0; i < cosines; ++i)
            sum[static_cast<std::size_t>(i)] +=
                share * double{table.mu_in_weight[term.depth * cosines + i]} *
                double{table.diffuse_transmittance[layer * cosines + i]};
    }
    for (int i = 0; i < cosines; ++i)
        sum[static_cast<std::size_t>(i)] *=
            intercepted_share(blend.optical_depth, table.mu_in.value(i));
    return sum;
}

namespace {

std::string range_text(double min, double max) {
    std::ostringstream text;
    text << "in [" << min << ", " << max << "] of the table";
    return text.str();
}

/// True over a boundary whose light in the samples stays as the layer vanishes.
bool keeps_light(const TableView& table) {
    return table.has_lower_boundary() && table.lower_boundary->kind != LowerBoundary::Kind::surface;
}

/// Layers deeper than the deepest sample of a table without one at infinity.
bool is_depth_known_by_diffusion(const TableView& table, Side side, double albedo,
                                 double optical_depth) {
    if (side == Side::transmission && optical_depth == infinity) return true;
    return deficit_of_deepest(table, albedo) <= kept_tolerance(table);
}

}  // namespace

bool holds(const AxisView& axis, double value) {
    constexpr double rounding = 1e-7;
    return value >= axis.lowest * (1 - rounding) && value <= axis.highest * (1 + rounding);
}

bool is_scattered_once(const TableView& table, double albedo, double optical_depth) {
    return !table.is_stack() && (albedo == 0 || optical_depth == 0) && !keeps_light(table);
}

bool is_depth_known(const TableView& table, Side side, double albedo, double optical_depth) {
    const AxisView& depth = table.optical_depth;
    if (depth.count == 0) return optical_depth == infinity;
    if (holds(depth, optical_depth) || table.is_stack()) return holds(depth, optical_depth);
    if (optical_depth < depth.lowest) return !keeps_light(table);
    return depth.ends_at_infinity ||
           is_depth_known_by_diffusion(table, side, albedo, optical_depth);
}

std::string allowed_albedo(const TableView& table) {
    if (table.is_stack()) return shortest_text(table.albedo.lowest) + ", that of the stack";
    const bool is_black_known = !keeps_light(table);
    const AxisView& albedo = table.albedo;
    return (is_black_known && albedo.lowest > 0 ? "0 or " : "") +
           range_text(albedo.lowest, albedo.highest);
}

std::string allowed_depth(const TableView& table) {
    const AxisView& depth = table.optical_depth;
    if (depth.count == 0) return "inf, all that the table holds";
    if (table.is_stack()) return shortest_text(depth.lowest) + ", that of the stack";
    const bool is_thin_known = !keeps_light(table);
    return range_text(is_thin_known ? 0 : depth.lowest, depth.highest) +
           (depth.ends_at_infinity ? " or inf" : "");
}

}  // namespace stratus
