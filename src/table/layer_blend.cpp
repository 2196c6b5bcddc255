#include "layer_blend.h"

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/layer/diffusion.h>
#include <stratus/layer/single_scattering.h>

#include <algorithm>
#include <cstddef>

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

LayerQuery make_query(const TableView& table, double albedo, double optical_depth,
                      int member) noexcept {
    const Stencil stencil = table.albedo.stencil(albedo);
    LayerQuery query{stencil,
                     std::clamp(albedo, table.albedo.lowest, table.albedo.highest),
                     optical_depth,
                     member,
                     table.extrapolation_lengths[member],
                     interpolate_exponent(table, member, stencil)};
    if (table.has_lower_boundary() || table.is_stack()) query.albedo = 1;
    return query;
}

/// Adds the terms of one member to the blend of a side.
struct BlendBuilder {
    const TableView& table;
    const float* weights;  // of the side's layers
    const LayerQuery& query;
    double share_of_member;
    LayerBlend& blend;

    /// The samples of one depth around an albedo. One too deep to be scaled back up hands its share
    /// to the neighbour of higher albedo, which decays more slowly; false comes back when there is
    /// none to take it.
    bool add_depth(int depth, double share) noexcept {
        double handed_on = 0;
        for (int l = 0; l < used_samples(table.albedo); ++l) {
            const double part = share * double{query.albedo_stencil.weight[l]} + handed_on;
            handed_on = add(query.albedo_stencil.first + l, depth, part) ? 0 : part;
        }
        return handed_on == 0;
    }

    /// Cubic along optical depth within the finite samples. A depth without a usable sample hands
    /// its share to the one above it.
    void add_depths(double optical_depth, double scale) noexcept {
        const Stencil depth = table.optical_depth.stencil(optical_depth);
        double handed_on = 0;
        for (int t = used_samples(table.optical_depth) - 1; t >= 0; --t) {
            const double share = scale * double{depth.weight[t]} + handed_on;
            handed_on = add_depth(depth.first + t, share) ? 0 : share;
        }
    }

    /// A layer thinner than all samples, but for what `growth` of the blend counts.
    void add_thin(double scale, bool with_order_1) noexcept {
        const ThinLayers thin = thin_layers(table.optical_depth);
        const ThinLayers::Weights weights = with_order_1 ? thin.all_orders(query.optical_depth)
                                                         : thin.higher_orders(query.optical_depth);
        add_depths(thin.thinnest, scale * weights.of_thinnest);
        add_depths(thin.deeper, scale * weights.of_deeper);
    }

    /// Between the deepest finite sample and the one at infinity the distance from the limit dies
    /// away by the law of diffusion; the scale of the sample at infinity is 1. Albedos whose
    /// deficit is spent hand their share of it on, as above.
    void add_between_last_and_infinity() noexcept {
        const double length = query.extrapolation_length, highest = table.optical_depth.highest;
        const bool over_boundary = table.has_lower_boundary();
        const double deficit =
            reflection_deficit(query.optical_depth, query.diffusion_exponent, length);
        const int last = table.optical_depth.count - 1;
        double handed_on = 0;
        for (int l = 0; l < used_samples(table.albedo); ++l) {
            const int albedo = query.albedo_stencil.first + l;
            const double exponent =
                table.diffusion_exponent[query.member * table.albedo.count + albedo];
            const double deepest = last < 0 ? 0 : reflection_deficit(highest, exponent, length);
            const double weight = double{query.albedo_stencil.weight[l]};
            const bool spent = deepest < min_deficit;
            const double share = spent ? 0 : (weight + handed_on) * deficit / deepest;
            handed_on = spent ? weight + handed_on : 0;
            add(albedo, last + 1, query.albedo * (weight - share));
            if (!spent)
                add(albedo, last,
                    query.albedo * share *
                        (over_boundary ? 1 : reflection_scale(highest, exponent, length)));
        }
    }

    /// False when the sample is too small to be scaled back up.
    bool add(int albedo, int depth, double share_in_member) noexcept {
        const std::ptrdiff_t at = (std::ptrdiff_t{query.member} * table.albedo.count + albedo) *
                                      table.optical_depth.size() +
                                  depth;
        if (weights[at] == 0) return false;
        const double share = share_of_member * share_in_member;
        if (share != 0)
            blend.term[blend.count++] = {at * samples_per_layer(table),
                                         static_cast<float>(share * double{weights[at]}), depth};
        return true;
    }
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

ThinLayers thin_layers(const AxisView& depths) noexcept {
    const double deeper = std::min(2 * depths.lowest, depths.value(std::min(3, depths.count) - 1));
    return {depths.lowest, deeper, thin_growth_of_samples(depths.lowest),
            thin_growth_of_samples(deeper)};
}

LayerBlend layer_blend(const TableView& table, Side side, double albedo, double optical_depth,
                       BeyondDeepest beyond, bool with_order_1) noexcept {
    const AxisView& depths = table.optical_depth;
    const bool is_lit = side == Side::reflection;
    LayerBlend blend;
    blend.samples = is_lit ? table.reflection_multiple : table.transmission_multiple;
    blend.optical_depth = depth_in(table, optical_depth, beyond);
    const double depth = blend.optical_depth;
    const bool is_thin = depths.count > 0 && depth < depths.lowest;
    const FamilyStencil members =
        is_lit ? table.members : transmitted_members(table, table.members, albedo, depth);
    for (int m = 0; m < members.count; ++m) {
        const LayerQuery query = make_query(table, albedo, depth, members.member[m]);
        const double scale =
            table.has_lower_boundary()
                ? 1
                : query.albedo * diffusion_scale(side, depth, query.diffusion_exponent,
                                                 query.extrapolation_length);
        BlendBuilder terms{table, is_lit ? table.reflection_weight : table.transmission_weight,
                           query, double{members.weight[m]}, blend};
        if (is_lit && depths.ends_at_infinity && (depths.count == 0 || depth > depths.highest)) {
            terms.add_between_last_and_infinity();
        } else if (depths.count == 0) {
            continue;  // a semi-infinite layer transmits nothing
        } else if (is_thin && !table.has_lower_boundary()) {
            terms.add_thin(scale, with_order_1);
        } else if (!is_lit && depth > depths.highest) {
            terms.add_depth(depths.count - 1, scale);
        } else {
            terms.add_depths(depth, scale);
        }
    }
    if (!is_thin) return blend;
    if (!table.has_lower_boundary())
        blend.growth = thin_growth_of_samples(depth) / thin_growth_of_samples(depths.lowest);
    else
        blend.fades = table.lower_boundary->is_surface();
    return blend;
}

double directional_factor(const TableView& table, const LayerBlend& blend, double mu_in,
                          double mu_out) noexcept {
    const double in = std::clamp(mu_in, table.mu_in.lowest, table.mu_in.highest);
    const double out = std::clamp(mu_out, table.mu_out.lowest, table.mu_out.highest);
    if (!table.has_lower_boundary())
        return blend.growth * intercepted_share(blend.optical_depth, in) *
               intercepted_share(blend.optical_depth, out);
    if (!blend.fades) return 1;
    return share_of_thinnest(blend.optical_depth, table.optical_depth.lowest, in, out);
}

double thin_law(const TableView& table, Side side, double albedo, double optical_depth,
                const Geometry& geometry) noexcept {
    const LayerQuery layer = make_query(table, albedo, optical_depth, table.members.member[0]);
    return thin_growth(optical_depth) * intercepted_share(optical_depth, geometry.mu_in) *
           intercepted_share(optical_depth, geometry.mu_out) *
           diffusion_scale(side, optical_depth, layer.diffusion_exponent,
                           layer.extrapolation_length);
}

double share_of_thinnest(double optical_depth, double thinnest, double mu_in,
                         double mu_out) noexcept {
    const auto extinguished = [&](double depth) {
        return intercepted_share(depth, mu_in) + intercepted_share(depth, mu_out);
    };
    return extinguished(optical_depth) / extinguished(thinnest);
}

namespace {

std::string range_text(double min, double max) {
    return "in [" + short_number(min, 6) + ", " + short_number(max, 6) + "] of the table";
}

/// Whether transmission falls off alike in all directions from the `deepest` layer on, or is negligible at
/// `optical_depth`.
bool is_transmission_known(const LayerQuery& deepest, double optical_depth, double tolerance) {
    constexpr double negligible = 1e-8;
    const double k = deepest.diffusion_exponent, length = deepest.extrapolation_length;
    return transmission_shape_error(deepest.optical_depth, deepest.albedo, k, length) <=
               tolerance ||
           transmission_scale(optical_depth, k, length) <= negligible;
}

}  // namespace

bool holds(const AxisView& axis, double value) {
    constexpr double rounding = 1e-7;
    return value >= axis.lowest * (1 - rounding) && value <= axis.highest * (1 + rounding);
}

bool is_scattered_once(const TableView& table, double albedo, double optical_depth) {
    return !table.is_stack() && (albedo == 0 || optical_depth == 0) && !table.keeps_light();
}

bool is_depth_known(const TableView& table, Side side, double albedo, double optical_depth) {
    const AxisView& depth = table.optical_depth;
    if (depth.count == 0) return optical_depth == infinity;
    if (holds(depth, optical_depth) || table.is_stack()) return holds(depth, optical_depth);
    if (optical_depth < depth.lowest) return table.knows_thinner_layers();
    if (depth.ends_at_infinity) return true;
    if (side == Side::transmission && optical_depth == infinity) return true;
    const FamilyStencil& members = table.members;
    for (int m = 0; m < members.count; ++m) {
        if (members.weight[m] == 0) continue;
        const LayerQuery deepest = make_query(table, albedo, depth.highest, members.member[m]);
        if (reflection_deficit(depth.highest, deepest.diffusion_exponent,
                               deepest.extrapolation_length) > kept_tolerance(table) ||
            (side == Side::transmission &&
             !is_transmission_known(deepest, optical_depth, kept_tolerance(table))))
            return false;
    }
    return true;
}

std::string allowed_albedo(const TableView& table) {
    if (table.is_stack()) return shortest_text(table.albedo.lowest) + ", that of the stack";
    const bool is_black_known = !table.keeps_light();
    const AxisView& albedo = table.albedo;
    return (is_black_known && albedo.lowest > 0 ? "0 or " : "") +
           range_text(albedo.lowest, albedo.highest);
}

std::string allowed_depth(const TableView& table) {
    const AxisView& depth = table.optical_depth;
    if (depth.count == 0) return "inf, all that the table holds";
    if (table.is_stack()) return shortest_text(depth.lowest) + ", that of the stack";
    return range_text(table.knows_thinner_layers() ? 0 : depth.lowest, depth.highest) +
           (depth.ends_at_infinity ? " or inf" : ", or deep enough for the law of diffusion");
}

}  // namespace stratus
