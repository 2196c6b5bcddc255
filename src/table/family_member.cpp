#include <stratus/table/family_member.h>

#include <stratus/base/argument.h>
#include <stratus/base/size.h>

#include "layer_blend.h"

#include <algorithm>
#include <cstddef>
#include <variant>

namespace stratus {
namespace {

/// MemberShares of the members around a point in what lies over (member, layer, ...): over (member around
/// the point, layer).
struct MemberShares {
    std::size_t layers;
    std::vector<double> share;
};

MemberShares same_shares(const FamilyStencil& around) {
    return {1, {around.weight, around.weight + around.count}};
}

/// The sum over the members around a point.
template <class Number>
std::vector<Number> joined_members(const std::vector<Number>& numbers, std::size_t members,
                                   const FamilyStencil& around, const MemberShares& shares) {
    const std::size_t count = numbers.size() / members, row = count / shares.layers;
    std::vector<Number> sum;
    sum.reserve(count);
    for (std::size_t n = 0; n < count; ++n) {
        double all = 0;
        const double* const share = shares.share.data() + n / row;
        for (std::size_t m = 0; m < size(around.count); ++m)
            all += share[m * shares.layers] *
                   static_cast<double>(numbers[size(around.member[m]) * count + n]);
        sum.push_back(static_cast<Number>(all));
    }
    return sum;
}

/// MemberShares in transmitted light, over (albedo, optical_depth): the members' falls with depth as at
/// the chosen point, as in lookups (layer_blend.cpp).
MemberShares shares_of_fall(const Table& table, const FamilyStencil& around,
                            const std::vector<double>& exponents) {
    const std::vector<double>& depths = table.optical_depth.values;
    MemberShares shares{exponents.size() * depths.size(), {}};
    for (std::size_t m = 0; m < size(around.count); ++m)
        for (std::size_t a = 0; a < exponents.size(); ++a)
            for (const double depth : depths)
                shares.share.push_back(
                    double{around.weight[m]} *
                    fall_from_member(
                        depth,
                        table.diffusion_exponent[size(around.member[m]) * exponents.size() + a],
                        exponents[a], table.extrapolation_length));
    return shares;
}

double length_at(const Table& table, const TableView& view) {
    return joined_members(table.extrapolation_lengths, table.member_count(), view.members,
                          same_shares(view.members))[0];
}

std::optional<double> parameter_value(const PhaseFunction::Term& term, PhaseParameter parameter) {
    if (const auto* const lobe = std::get_if<HenyeyGreenstein>(&term))
        return parameter == PhaseParameter::g ? std::optional(lobe->g) : std::nullopt;
    const auto* const mie = std::get_if<Mie>(&term);
    if (mie == nullptr) return {};
    if (parameter != PhaseParameter::wavelength && !mie->droplets.has_effective_parameters())
        return {};
    switch (parameter) {
        case PhaseParameter::radius: return mie->droplets.effective_radius;
        case PhaseParameter::wavelength: return mie->droplets.wavelength;
        case PhaseParameter::variance: return mie->droplets.effective_variance;
        default: return {};
    }
}

}  // namespace

Table table_at(const Table& table, const FamilyPoint& point) {
    const TableView view = table.view().at(point);
    if (!table.has_family()) return table;
    for (std::size_t k = 0; k < table.family.size(); ++k)
        require(holds(table.family[k], point[k]), "table_at", table.family[k].name(),
                allowed_text(table.family[k]), point[k]);
    const FamilyStencil& around = view.members;
    const MemberShares same = same_shares(around);
    std::vector<double> exponents =
        joined_members(table.diffusion_exponent, table.member_count(), around, same);
    for (double& exponent : exponents) exponent = std::max(0.0, exponent);
    const MemberShares transmitted = shares_of_fall(table, around, exponents);

    Table one = table;
    one.family.clear();
    one.phase_function = view.chosen_phase_function();
    one.second_phase_function = {};
    one.path_law = view.own_path_law;
    one.extrapolation_length = length_at(table, view);
    for_each_of_members(
        [&](auto& numbers, const auto& of_all) {
            const void* const which = &of_all;
            const bool falls =
                which == &table.transmission_multiple || which == &table.diffuse_transmittance;
            numbers =
                joined_members(of_all, table.member_count(), around, falls ? transmitted : same);
        },
        one, table);
    one.diffusion_exponent = exponents;
    prepare(one);
    return one;
}

std::optional<double> find_parameter(const PhaseFunction& phase_function,
                                     PhaseParameter parameter) {
    std::optional<double> found;
    for (const auto& [weight, term] : phase_function.terms()) {
        const std::optional<double> value = parameter_value(term, parameter);
        if (!value) continue;
        if (found) return {};
        found = value;
    }
    return found;
}

}  // namespace stratus
