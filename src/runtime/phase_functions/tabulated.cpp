#include <stratus/runtime/phase_functions/tabulated.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/number_text.h>

#include "../gauss_legendre.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {
namespace {

void check_rows(const std::vector<double>& angle_deg, const std::vector<double>& value,
                const Tabulated::RowName& row_name) {
    const char* const caller = Tabulated::kind.name;
    require(angle_deg.size() == value.size(), caller, "value", "as many numbers as phase_angle_deg",
            value.size());
    require(value.size() >= 3, caller, "phase table", "at least 3 rows", value.size());
    bool dark = true;
    for (std::size_t i = 0; i < value.size(); ++i) {
        const std::string angle_here = "phase_angle_deg" + row_name(i);
        require(std::isfinite(value[i]) && value[i] >= 0, caller, "value" + row_name(i),
                "finite and at least 0", value[i]);
        require(i == 0 ? angle_deg[i] == 0 : angle_deg[i] > angle_deg[i - 1], caller, angle_here,
                i == 0 ? "0 (angles must cover 0 to 180)" : "above the one before it",
                angle_deg[i]);
        require(angle_deg[i] <= 180, caller, angle_here, "in [0, 180]", angle_deg[i]);
        dark = dark && value[i] == 0;
    }
    require(angle_deg.back() == 180, caller, "phase_angle_deg" + row_name(value.size() - 1),
            "180 (angles must cover 0 to 180)", angle_deg.back());
    require(!dark, caller, "value", "above 0 somewhere", 0);
}

/// Slopes of Fritsch and Carlson (1980): parabolic, then held within the circle of radius 3 that
/// keeps every interval monotone; 0 at both ends, about which phi is even.
std::vector<double> monotone_slopes(const std::vector<double>& angle_deg,
                                    const std::vector<double>& value) {
    const std::size_t count = value.size();
    std::vector<double> width(count - 1), secant(count - 1), slope(count, 0.0);
    for (std::size_t i = 0; i + 1 < count; ++i) {
        width[i] = radians(angle_deg[i + 1] - angle_deg[i]);
        secant[i] = (value[i + 1] - value[i]) / width[i];
    }
    for (std::size_t i = 1; i + 1 < count; ++i) {
        const bool turns = (secant[i - 1] > 0) != (secant[i] > 0);
        if (turns || secant[i - 1] == 0 || secant[i] == 0) continue;
        slope[i] =
            (width[i] * secant[i - 1] + width[i - 1] * secant[i]) / (width[i - 1] + width[i]);
    }
    for (std::size_t i = 0; i + 1 < count; ++i) {
        if (secant[i] == 0) continue;
        const double radius = std::hypot(slope[i] / secant[i], slope[i + 1] / secant[i]);
        if (radius <= 3) continue;
        slope[i] *= 3 / radius;
        slope[i + 1] *= 3 / radius;
    }
    return slope;
}

/// The monotone cubic of a table in the interval that starts at knot i, not yet normalised.
double hermite(const Tabulated& table, std::size_t i, double angle_deg) noexcept {
    const double width_deg = table.phase_angle_deg[i + 1] - table.phase_angle_deg[i];
    const double width = radians(width_deg);
    const double t = (angle_deg - table.phase_angle_deg[i]) / width_deg;
    const double u = 1 - t;
    return u * u * ((1 + 2 * t) * table.value[i] + t * width * table.slope[i]) +
           t * t * ((1 + 2 * u) * table.value[i + 1] - u * width * table.slope[i + 1]);
}

/// Adds (1/2) weight P_l(c), l = 0 .. sums.size() - 1, to the sums.
void add_legendre(double weight, double c, std::vector<double>& sums) {
    double before = 0, here = 1;
    for (std::size_t l = 0; l < sums.size(); ++l) {
        sums[l] += weight / 2 * here;
        const double order = static_cast<double>(l);
        const double next = ((2 * order + 1) * c * here - order * before) / (order + 1);
        before = here;
        here = next;
    }
}

/// Moments before normalisation: half the integral of value P_l(-cos a) sin a da.
std::vector<double> raw_moments(const Tabulated& table, std::size_t count) {
    std::vector<double> sums(count, 0.0);
    for (std::size_t i = 0; i + 1 < table.value.size(); ++i) {
        const double begin = table.phase_angle_deg[i];
        const double width = table.phase_angle_deg[i + 1] - begin;
        // The phase of P_l is (l + 1/2) times the angle; eight nodes for two radians of it leave
        // an error below rounding.
        const int panels =
            static_cast<int>(std::ceil((static_cast<double>(count) + 1) * radians(width) / 2));
        const double half = width / panels / 2;
        for (int panel = 0; panel < panels; ++panel) {
            const double middle = begin + (2 * panel + 1) * half;
            for (int k = 0; k < 4; ++k)
                for (const double side : {-1.0, 1.0}) {
                    const double angle_deg = middle + side * half * gauss_8_node[k];
                    const double angle = radians(angle_deg);
                    const double weight = radians(half) * gauss_8_weight[k] * std::sin(angle);
                    add_legendre(weight * hermite(table, i, angle_deg), -std::cos(angle), sums);
                }
        }
    }
    return sums;
}

}  // namespace

Tabulated::Tabulated(std::vector<double> angles, std::vector<double> values,
                     const RowName& row_name)
    : phase_angle_deg(std::move(angles)), value(std::move(values)) {
    check_rows(phase_angle_deg, value, row_name);
    slope = monotone_slopes(phase_angle_deg, value);
    const double mean = raw_moments(*this, 1)[0];
    normalisation = 1 / mean;
    require(std::isnormal(mean) && std::isnormal(normalisation), kind.name,
            "spherical mean of the values", "a number whose inverse is one too", mean);
}

Tabulated::Tabulated(std::vector<double> angles, std::vector<double> values)
    : Tabulated(std::move(angles), std::move(values),
                [](std::size_t row) { return " (row " + std::to_string(row + 1) + ")"; }) {}

Tabulated Tabulated::read(PhaseText& text) {
    std::vector<double> angle_deg, value;
    do {
        angle_deg.push_back(text.number("tabulated: the angle of a point"));
        value.push_back(text.number("tabulated: the value of a point"));
    } while (text.accept('/'));
    return {std::move(angle_deg), std::move(value)};
}

std::string Tabulated::parameter_text() const {
    std::string points;
    for (std::size_t i = 0; i < value.size(); ++i)
        points +=
            (i == 0 ? "" : "/") + shortest_text(phase_angle_deg[i]) + ' ' + shortest_text(value[i]);
    return points;
}

double Tabulated::operator()(double c) const noexcept {
    const double sine = std::sqrt(std::max(0.0, (1 - c) * (1 + c)));
    const double angle_deg = degrees(std::atan2(sine, -c));
    const auto above =
        std::upper_bound(phase_angle_deg.begin() + 1, phase_angle_deg.end() - 1, angle_deg);
    const std::size_t interval = static_cast<std::size_t>(above - phase_angle_deg.begin()) - 1;
    return normalisation * hermite(*this, interval, angle_deg);
}

std::vector<double> Tabulated::moments(std::size_t count) const {
    std::vector<double> chi = raw_moments(*this, count);
    for (double& moment : chi) moment *= normalisation;
    chi[0] = 1;
    return chi;
}

}  // namespace stratus
