#include <stratus/table/member_and_ground.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/table/lookup.h>
#include <stratus/table/metadata.h>
#include <stratus/table/packed_table.h>

#include "layer_blend.h"
#include "phase/kinds/phase_text.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <variant>

namespace stratus {
namespace {

/// MemberShares of the members around a point in what lies over (member, layer, ...): over (member around
/// the point, layer).
struct MemberShares {
    std::size_t layers;
    std::vector<double> share;
};

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
    const MemberShares same{1, {around.weight, around.weight + around.count}};
    std::vector<double> exponents =
        joined_members(table.diffusion_exponent, table.member_count(), around, same);
    for (double& exponent : exponents) exponent = std::max(0.0, exponent);
    const MemberShares transmitted = shares_of_fall(table, around, exponents);

    Table one = table;
    one.family.clear();
    one.phase_function = view.chosen_phase_function();
    one.second_phase_function = {};
    one.path_law = view.own_path_law;
    one.extrapolation_length =
        joined_members(table.extrapolation_lengths, table.member_count(), around, same)[0];
    for (const SampleField& field : sample_fields) {
        const bool falls = field.samples == &Table::transmission_multiple ||
                           field.samples == &Table::diffuse_transmittance;
        one.*field.samples = joined_members(table.*field.samples, table.member_count(), around,
                                            falls ? transmitted : same);
    }
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

namespace {

constexpr const char* ground_caller = "ground";
constexpr std::string_view table_form = "table:";

class TableGround final : public GroundLaw {
  public:
    TableGround(std::string text, const std::string& path,
                const std::map<std::string, double>& given)
        : text_(std::move(text)), packed_(path), view_(packed_.view()) {
        require(!view_.has_family() && view_.has_reflection() && view_.has_all_directions(),
                ground_caller, "table", "one without a family, of reflection in all directions",
                text_);
        require(view_.highest_order == 0, ground_caller, "table", "of all orders of scattering",
                text_);
        optical_depth_ = chosen(given, "optical_depth", view_.optical_depth);
        albedo_ = chosen(given, "albedo", view_.albedo);
        require_in("[0, inf]", ground_caller, "optical_depth", optical_depth_);
        once_ = is_scattered_once(view_, albedo_, optical_depth_);
        if (once_) return;
        const AxisView& depths = view_.optical_depth;
        require(
            depths.count == 0 || optical_depth_ > depths.lowest || holds(depths, optical_depth_),
            ground_caller, "optical_depth",
            "0 or at least " + short_number(depths.lowest, 6) +
                ", the table's first, for thinner layers are extrapolated",
            optical_depth_);
        require(is_depth_known(view_, Side::reflection, albedo_, optical_depth_), ground_caller,
                "optical_depth", allowed_depth(view_), optical_depth_);
        require(holds(view_.albedo, albedo_), ground_caller, "albedo", allowed_albedo(view_),
                albedo_);
    }

    double operator()(const Geometry& at) const noexcept override {
        const auto one_way = [&](const Geometry& way) {
            const Scattered light = reflection(view_, albedo_, optical_depth_, way);
            return once_ ? light.single : light.total();
        };
        return view_.is_symmetric()
                   ? one_way(at)
                   : (one_way(at) + one_way({at.mu_out, at.mu_in, at.azimuth})) / 2;
    }

    std::string text() const override { return text_; }

  private:
    static double chosen(const std::map<std::string, double>& given, const char* name,
                         const AxisView& axis) {
        if (given.count(name) > 0) return given.at(name);
        if (axis.count == 0) return infinity;  // of optical depth alone
        require(axis.count == 1, ground_caller, name, "given, for the table holds several", "none");
        return axis.lowest;
    }

    std::string text_;
    PackedTable packed_;
    TableView view_;
    double optical_depth_ = 0, albedo_ = 0;
    bool once_ = false;  // scattered once alone: the samples do not count
};

std::shared_ptr<const GroundLaw> read_table_ground(const std::string& text,
                                                   const std::string& directory) {
    PhaseText rest{text, table_form.size(), {}, ground_caller};
    rest.parameter("table", {"file"});
    const std::size_t comma = std::min(text.find(',', rest.at), text.size());
    const std::string file = text.substr(rest.at, comma - rest.at);
    rest.at = comma;
    std::map<std::string, double> given;
    if (rest.accept(',')) given = rest.numbers("table", {"optical_depth", "albedo"});
    const bool is_relative = !directory.empty() && file.rfind('/', 0) != 0;
    return std::make_shared<TableGround>(text, is_relative ? directory + '/' + file : file, given);
}

}  // namespace

LowerBoundary read_ground(const std::string& text, const std::string& directory) {
    double albedo = 0;
    if (!text.empty() && read_number(text, albedo) == text.size()) {
        require_in("[0, 1]", ground_caller, "albedo", albedo);
        return LowerBoundary::surface(albedo);
    }
    const bool is_table = text.rfind(table_form, 0) == 0;
    require(is_table || text.find(':') != std::string::npos, ground_caller, "kind",
            "an albedo, ocean:wind=..., rpv:rho0=...,k=...,theta=... or table:file=...", text);
    return LowerBoundary::ground(is_table ? read_table_ground(text, directory)
                                          : read_ground_law(text));
}

std::string ground_help() {
    return ground_law_help() +
           "\ntable:file=T.stratus,optical_depth=4,albedo=0.9   a layer of a packed table";
}

}  // namespace stratus
