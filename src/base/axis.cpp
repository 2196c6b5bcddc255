#include <stratus/base/axis.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace stratus {
namespace {

/// All that an axis asks of its scale.
struct ScaleLaw {
    const char* name;    // in files
    const char* domain;  // for messages
    bool (*holds)(double value);
    double (*coordinate)(double value);
    double (*value)(double coordinate);
};

/// One for each AxisScale, in order; values are finite.
constexpr ScaleLaw scale_laws[] = {
    {"linear", "finite", [](double) { return true; }, [](double x) { return x; },
     [](double c) { return c; }},
    {"arcsine_of_fourth_root", "in [0, 1]", [](double mu) { return mu >= 0 && mu <= 1; },
     [](double mu) { return std::asin(std::sqrt(std::sqrt(mu))); },
     [](double c) { return std::pow(std::sin(c), 4); }},
    {"logarithmic", "in (0, inf)", [](double x) { return x > 0; },
     [](double x) { return std::log2(x); }, [](double c) { return std::exp2(c); }},
    {"square_root_of_complement", "finite and at most 1", [](double w) { return w <= 1; },
     [](double w) { return -std::sqrt(1 - w); }, [](double c) { return 1 - c * c; }},
    {"square_root", "in [0, inf)", [](double x) { return x >= 0; },
     [](double x) { return std::sqrt(x); }, [](double c) { return c * c; }},
    {"fourth_root_of_complement", "finite and at most 1", [](double w) { return w <= 1; },
     [](double w) { return -std::sqrt(std::sqrt(1 - w)); },
     [](double c) { return 1 - c * c * (c * c); }},
    {"logarithm_of_complement", "finite and below 1", [](double g) { return g < 1; },
     [](double g) { return -std::log2(1 - g); }, [](double c) { return 1 - std::exp2(-c); }},
};

const ScaleLaw& law(AxisScale scale) noexcept { return scale_laws[static_cast<int>(scale)]; }

void require_in_domain(AxisScale scale, const char* caller, const char* name, double value) {
    require(std::isfinite(value) && law(scale).holds(value), caller, name, law(scale).domain,
            value);
}

/// `value`, or the nearer end of [low, high]; not-a-number gives `low`, so that it never becomes an
/// index.
double clamped(double value, double low, double high) noexcept {
    if (!(value > low)) return low;
    return value < high ? value : high;
}

/// Lagrange weights at `t` of the samples at 0 .. count - 1, count from 1 to 4; the rest are 0.
void lagrange(int count, double t, double (&weight)[stencil_size]) noexcept {
    std::fill(weight, weight + stencil_size, 0.0);
    switch (count) {
        case 1: weight[0] = 1; break;
        case 2:
            weight[0] = 1 - t;
            weight[1] = t;
            break;
        case 3:
            weight[0] = (t - 1) * (t - 2) / 2;
            weight[1] = -t * (t - 2);
            weight[2] = t * (t - 1) / 2;
            break;
        default:
            weight[0] = -(t - 1) * (t - 2) * (t - 3) / 6;
            weight[1] = t * (t - 2) * (t - 3) / 2;
            weight[2] = -t * (t - 1) * (t - 3) / 2;
            weight[3] = t * (t - 1) * (t - 2) / 6;
    }
}

/// About which light is even in azimuth: 0 and pi.
bool is_mirror(double azimuth) noexcept { return azimuth == 0 || pi - azimuth <= 1e-9; }

/// Up to four samples around a value, out of those from `lowest` to `highest`: where these lie past an
/// end of the axis, which is a mirror then, they are the images of samples inside.
Stencil stencil_within(const AxisView& axis, double value, int lowest, int highest) noexcept {
    if (axis.count < 2) return {0, {1, 0, 0, 0}};
    const double position = axis.index(value);
    const int last = axis.count - 1, used = std::min(stencil_size, highest - lowest + 1);
    const int before = std::min(static_cast<int>(position), last - 1);  // another sample follows
    const int window = std::clamp(before - 1, lowest, highest - used + 1);
    double weight[stencil_size];
    lagrange(used, position - window, weight);
    Stencil stencil{std::clamp(window, 0, std::max(0, axis.count - stencil_size)), {}};
    for (int i = 0; i < used; ++i) {
        const int sample = std::abs(window + i);
        const int inside = sample > last ? 2 * last - sample : sample;
        stencil.weight[inside - stencil.first] += static_cast<float>(weight[i]);
    }
    return stencil;
}

}  // namespace

const char* axis_scale_name(AxisScale scale) noexcept { return law(scale).name; }

std::optional<AxisScale> axis_scale_named(const std::string& name) noexcept {
    const auto found = std::find_if(std::begin(scale_laws), std::end(scale_laws),
                                    [&](const ScaleLaw& known) { return known.name == name; });
    if (found == std::end(scale_laws)) return {};
    return static_cast<AxisScale>(found - std::begin(scale_laws));
}

double AxisView::value(int sample) const noexcept {
    if (sample == 0) return lowest;
    return sample == count - 1 ? highest : law(scale).value(first + sample / inverse_step);
}

double AxisView::index(double value) const noexcept {
    if (count < 2) return 0;
    const double coordinate = law(scale).coordinate(clamped(value, lowest, highest));
    return clamped((coordinate - first) * inverse_step, 0, count - 1);
}

Stencil AxisView::stencil(double value) const noexcept {
    return stencil_within(*this, value, 0, count - 1);
}

Stencil AxisView::mirrored_stencil(double value) const noexcept {
    const int last = count - 1;
    return stencil_within(*this, value, is_mirror(lowest) ? -last : 0,
                          is_mirror(highest) ? 2 * last : last);
}

AxisView Axis::view() const noexcept {
    AxisView view{};
    view.scale = scale;
    view.ends_at_infinity = !values.empty() && values.back() == infinity;
    view.count = static_cast<int>(values.size()) - (view.ends_at_infinity ? 1 : 0);
    if (view.count == 0) return view;
    view.lowest = values.front();
    view.highest = values[size(view.count - 1)];
    view.first = law(scale).coordinate(view.lowest);
    if (view.count > 1)
        view.inverse_step = (view.count - 1) / (law(scale).coordinate(view.highest) - view.first);
    return view;
}

Axis make_axis(AxisScale scale, double lowest, double highest, int count, bool and_infinity) {
    require(!and_infinity || scale == AxisScale::logarithmic, "make_axis", "scale",
            "logarithmic for an axis that ends at infinity", axis_scale_name(scale));
    require(count >= (and_infinity ? 0 : 1), "make_axis", "count",
            and_infinity ? "at least 0" : "at least 1", count);
    Axis axis{scale, {}};
    axis.values.reserve(size(count) + 1);
    if (count > 0) {
        require_in_domain(scale, "make_axis", "lowest", lowest);
        require_in_domain(scale, "make_axis", "highest", highest);
        require(count == 1 ? lowest == highest : lowest < highest, "make_axis", "highest",
                (count == 1 ? "equal to lowest = " : "above lowest = ") + std::to_string(lowest),
                highest);
    }
    const double first = law(scale).coordinate(lowest);
    const double last = law(scale).coordinate(highest);
    for (int i = 0; i < count; ++i) {
        const double coordinate = first + (last - first) * i / (count - 1);
        axis.values.push_back(i == 0           ? lowest
                              : i == count - 1 ? highest
                                               : law(scale).value(coordinate));
    }
    if (and_infinity) axis.values.push_back(infinity);
    return axis;
}

void check_axis(const Axis& axis, const char* name) {
    const AxisView view = axis.view();
    require(view.size() > 0, "check_axis", name, "an axis of at least one sample", "none");
    require(!view.ends_at_infinity || axis.scale == AxisScale::logarithmic, "check_axis", name,
            "finite unless logarithmic", infinity);
    double before = -infinity;
    for (int i = 0; i < view.count; ++i) {
        const double value = axis.values[size(i)];
        require_in_domain(axis.scale, "check_axis", name, value);
        require(value > before, "check_axis", name, "ascending", value);
        before = value;
    }
    constexpr double of_a_step = 1e-9;
    constexpr double last_bits = 4 * std::numeric_limits<double>::epsilon();
    for (int i = 1; i + 1 < view.count; ++i) {
        const double value = axis.values[size(i)];
        const double uniform = law(axis.scale).value(view.first + i / view.inverse_step);
        const double off = law(axis.scale).coordinate(value) - view.first - i / view.inverse_step;
        require(std::abs(off) * view.inverse_step <= of_a_step ||
                    std::abs(value - uniform) <= last_bits * std::abs(value),
                "check_axis", name,
                std::string("uniform in the coordinate of scale ") + axis_scale_name(axis.scale),
                value);
    }
}

}  // namespace stratus
