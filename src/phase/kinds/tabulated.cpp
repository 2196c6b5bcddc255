#include <stratus/phase/tabulated.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/gauss_legendre.h>
#include <stratus/base/number_text.h>

#include "phase_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <iterator>
#include <utility>

namespace stratus {
namespace {

void check_rows(const std::vector<double>& angle_deg, const std::vector<double>& value,
                const RowName& row_name) {
    const char* const caller = Tabulated::kind.name;
    require(angle_deg.size() == value.size(), caller, "value", "as many numbers as phase_angle_deg",
            value.size());
    require(value.size() >= 3, caller, "phase table", "at least 3 rows", value.size());
    bool dark = true;
    for (std::size_t i = 0; i < value.size(); ++i) {
        const std::string angle_here = "phase_angle_deg" + row_name(i);
        require(std::isfinite(value[i]) && value[i] >= 0, caller, "value" + row_name(i),
                "finite and at least 0", value[i]);
        require(i == 0 || angle_deg[i] > angle_deg[i - 1], caller, angle_here,
                "above the one before it", angle_deg[i]);
        require_in("[0, 180]", caller, angle_here, angle_deg[i]);
        dark = dark && value[i] == 0;
    }
    require(!dark, caller, "value", "above 0 somewhere", 0);
}

/// Slopes of Fritsch and Carlson (1980): parabolic, then held within the circle of radius 3 that
/// keeps every interval monotone; 0 at both ends, about which phi is even.
std::vector<double> monotone_slopes(const std::vector<double>& angle_deg,
                                    const std::vector<double>& value) {
    const std::size_t count = value.size();
    std::vector<double> width(count - 1), secant(count - 1), slope(count);
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
    const double width_deg = table.knot_angle_deg[i + 1] - table.knot_angle_deg[i];
    const double width = radians(width_deg);
    const double t = (angle_deg - table.knot_angle_deg[i]) / width_deg;
    const double u = 1 - t;
    return u * u * ((1 + 2 * t) * table.knot_value[i] + t * width * table.slope[i]) +
           t * t * ((1 + 2 * u) * table.knot_value[i + 1] - u * width * table.slope[i + 1]);
}

/// A number for each node of a panel.
using PanelNodes = std::array<double, 2 * std::size(gauss_8_node)>;

/// Adds (1/2) sum_k weight_k P_l(c_k), l = 0 .. sums.size() - 1, to the sums.
void add_legendre(const PanelNodes& weight, const PanelNodes& c, std::vector<double>& sums) {
    PanelNodes before{}, here;
    here.fill(1);
    for (std::size_t l = 0; l < sums.size(); ++l) {
        const double order = static_cast<double>(l), up = (2 * order + 1) / (order + 1),
                     down = order / (order + 1);
        double sum = 0;
        for (std::size_t k = 0; k < c.size(); ++k) {
            sum += weight[k] * here[k];
            const double next = up * c[k] * here[k] - down * before[k];
            before[k] = here[k];
            here[k] = next;
        }
        sums[l] += sum / 2;
    }
}

/// Moments before normalisation: half the integral of value P_l(-cos a) sin a da.
std::vector<double> raw_moments(const Tabulated& table, std::size_t count) {
    std::vector<double> sums(count);
    for (std::size_t i = 0; i + 1 < table.knot_value.size(); ++i) {
        const double begin = table.knot_angle_deg[i];
        const double width = table.knot_angle_deg[i + 1] - begin;
        // The phase of P_l is (l + 1/2) times the angle; eight nodes for two radians of it leave
        // an error below rounding.
        const int panels =
            static_cast<int>(std::ceil((static_cast<double>(count) + 1) * radians(width) / 2));
        const double half = width / panels / 2;
        for (int panel = 0; panel < panels; ++panel) {
            const double middle = begin + (2 * panel + 1) * half;
            PanelNodes weight, c;
            for (std::size_t k = 0; k < c.size(); ++k) {
                const double side = k % 2 == 0 ? -1 : 1,
                             angle_deg = middle + side * half * gauss_8_node[k / 2],
                             angle = radians(angle_deg);
                weight[k] = radians(half) * gauss_8_weight[k / 2] * std::sin(angle) *
                            hermite(table, i, angle_deg);
                c[k] = -std::cos(angle);
            }
            add_legendre(weight, c, sums);
        }
    }
    return sums;
}

/// c1 HG(g1) + c2 HG(g2).
struct DoubleLobe {
    double g[2] = {0, 0}, c[2] = {0, 0};
    double miss = infinity;  // sum of squares of relative errors

    double operator()(double angle_deg) const noexcept {
        return c[0] * lobe(g[0], angle_deg) + c[1] * lobe(g[1], angle_deg);
    }

    static double lobe(double g, double angle_deg) noexcept {
        const double sine = std::cos(radians(angle_deg) / 2);  // of Theta / 2
        return (1 - g * g) / std::pow((1 - g) * (1 - g) + 4 * g * sine * sine, 1.5);
    }
};

/// Rows that a tail is fitted to.
struct Rows {
    std::vector<double> angle_deg, value;
};

/// The amplitudes >= 0 that fit best at given g.
DoubleLobe with_amplitudes(double g1, double g2, const Rows& rows) {
    double aa = 0, ab = 0, bb = 0, a = 0, b = 0;
    for (std::size_t i = 0; i < rows.value.size(); ++i) {
        const double first = DoubleLobe::lobe(g1, rows.angle_deg[i]) / rows.value[i];
        const double second = DoubleLobe::lobe(g2, rows.angle_deg[i]) / rows.value[i];
        aa += first * first;
        ab += first * second;
        bb += second * second;
        a += first;
        b += second;
    }
    const double determinant = aa * bb - ab * ab;
    DoubleLobe best;
    for (int which = 0; which < 3; ++which) {  // both, or either alone
        DoubleLobe lobe{{g1, g2}, {which == 1 ? a / aa : 0, which == 2 ? b / bb : 0}, 0};
        if (which == 0) {
            if (determinant <= 1e-12 * aa * bb) continue;
            lobe.c[0] = (a * bb - b * ab) / determinant;
            lobe.c[1] = (b * aa - a * ab) / determinant;
            if (lobe.c[0] < 0 || lobe.c[1] < 0) continue;
        }
        for (std::size_t i = 0; i < rows.value.size(); ++i) {
            const double miss = lobe(rows.angle_deg[i]) / rows.value[i] - 1;
            lobe.miss += miss * miss;
        }
        if (lobe.miss < best.miss) best = lobe;
    }
    return best;
}

constexpr double max_g = 0.99;

/// By search over g1 and g2: a grid, then steps to better neighbours, halved where there is none.
DoubleLobe fitted(const Rows& rows) {
    DoubleLobe best;
    const auto consider = [&](double g1, double g2) {
        const DoubleLobe here = with_amplitudes(g1, g2, rows);
        if (here.miss < best.miss) best = here;
    };
    for (int i = 0; i <= 18; ++i)
        for (int j = 0; j <= 18; ++j) consider(max_g * i / 18, -max_g * j / 18);
    double step = max_g / 18;
    for (int tries = 0; tries < 2000 && step > 1e-9; ++tries) {
        const DoubleLobe before = best;
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                consider(std::clamp(before.g[0] + i * step, 0.0, max_g),
                         std::clamp(before.g[1] + j * step, -max_g, 0.0));
        if (!(best.miss < before.miss)) step /= 2;
    }
    return best;
}

/// Samples of a tail from `end` degrees to a row: where they lie, in shares of the way from it.
constexpr int tail_samples = 96;
double tail_share(int sample) {  // dense towards the end, where peaks are
    return sample == 0 ? 0 : std::exp2(-10.0 * (tail_samples - sample) / tail_samples);
}

}  // namespace

Tabulated::Tabulated(std::vector<double> angles, std::vector<double> values, const Options& asked,
                     const RowName& row_name)
    : phase_angle_deg(std::move(angles)), value(std::move(values)), options(asked) {
    check_rows(phase_angle_deg, value, row_name);
    knot_angle_deg = phase_angle_deg;
    knot_value = value;
    if (options.tail == Tail::hg && !continuation().empty()) {
        continue_by_fit(row_name);
    } else {
        if (knot_angle_deg.front() > 0) {
            knot_angle_deg.insert(knot_angle_deg.begin(), 0);
            knot_value.insert(knot_value.begin(), value.front());
        }
        if (knot_angle_deg.back() < 180) {
            knot_angle_deg.push_back(180);
            knot_value.push_back(value.back());
        }
    }
    slope = monotone_slopes(knot_angle_deg, knot_value);
    const double mean = raw_moments(*this, 1)[0];
    normalisation = 1 / mean;
    require(std::isnormal(mean) && std::isnormal(normalisation), kind.name,
            "spherical mean of the values", "a number whose inverse is one too", mean);
    if (!options.geometric_albedo) return;
    const double given = *options.geometric_albedo, most = knot_value.front() * normalisation / 4;
    require(given >= 0 && given <= most * (1 + 1e-9), kind.name, "geometric_albedo",
            "in [0, " + short_number(most, 6) + "], where the single-scattering albedo is 1",
            given);
    albedo = most > 0 ? std::min(1.0, given / most) : 0;  // but for rounding
}

void Tabulated::continue_by_fit(const RowName& row_name) {
    constexpr double reach_deg = 40;
    const double first = phase_angle_deg.front(), last = phase_angle_deg.back();
    Rows rows;
    for (std::size_t i = 0; i < value.size(); ++i) {
        const double angle = phase_angle_deg[i];
        const bool is_outer =
            (first > 0 && angle <= first + reach_deg) || (last < 180 && angle >= last - reach_deg);
        if (!is_outer) continue;
        require(value[i] > 0, kind.name, "value" + row_name(i), "above 0 for tail=hg", value[i]);
        rows.angle_deg.push_back(angle);
        rows.value.push_back(value[i]);
    }
    require(rows.value.size() >= 4, kind.name, "phase table",
            "at least 4 rows within 40 degrees of the ends that tail=hg continues",
            rows.value.size());
    const DoubleLobe lobe = fitted(rows);
    fitted_g_[0] = lobe.c[0] > 0 ? lobe.g[0] : 0;
    fitted_g_[1] = lobe.c[1] > 0 ? lobe.g[1] : 0;
    knot_angle_deg.clear();
    knot_value.clear();
    const auto add = [&](double angle, double brightness) {
        knot_angle_deg.push_back(angle);
        knot_value.push_back(brightness);
    };
    for (int i = 0; first > 0 && i < tail_samples; ++i) {
        const double angle = first * tail_share(i);
        add(angle, value.front() * (lobe(angle) / lobe(first)));
    }
    for (std::size_t i = 0; i < value.size(); ++i) add(phase_angle_deg[i], value[i]);
    for (int i = tail_samples - 1; last < 180 && i >= 0; --i) {
        const double angle = 180 - (180 - last) * tail_share(i);
        add(angle, value.back() * (lobe(angle) / lobe(last)));
    }
}

std::string Tabulated::continuation() const {
    std::string ends;
    if (phase_angle_deg.front() > 0) ends = "below " + shortest_text(phase_angle_deg.front());
    if (phase_angle_deg.back() < 180)
        ends += (ends.empty() ? "" : " and ") + ("beyond " + shortest_text(phase_angle_deg.back()));
    if (ends.empty()) return "";
    return "values " + ends + " degrees of phase angle are continued by " +
           (options.tail == Tail::constant
                ? std::string("that of the outer row")
                : "a double Henyey-Greenstein function fitted to the outer rows, g = " +
                      short_number(fitted_g_[0], 3) + " and " + short_number(fitted_g_[1], 3));
}

const std::vector<std::string>& Tabulated::option_names() {
    static const std::vector<std::string> names{"tail", "geometric_albedo"};
    return names;
}

Tabulated::Options Tabulated::read_options(PhaseText& text) {
    Options options;
    while (text.accept(',')) {
        if (text.parameter(kind.name, option_names()) == "geometric_albedo") {
            options.geometric_albedo = text.number("tabulated: geometric_albedo");
            continue;
        }
        const std::string tail = text.name();
        if (tail != "hg" && tail != "constant")
            text.refuse("tabulated: tail must be hg or constant, got '" + tail + "'");
        options.tail = tail == "hg" ? Tail::hg : Tail::constant;
    }
    return options;
}

Tabulated Tabulated::read(PhaseText& text, const std::string&) {
    std::vector<double> angle_deg, value;
    do {
        angle_deg.push_back(text.number("tabulated: the angle of a point"));
        value.push_back(text.number("tabulated: the value of a point"));
    } while (text.accept('/'));
    const Options options = read_options(text);
    return {std::move(angle_deg), std::move(value), options};
}

std::string Tabulated::parameter_text() const {
    std::string points;
    for (std::size_t i = 0; i < value.size(); ++i)
        points += (i == 0 ? "points=" : "/") + shortest_text(phase_angle_deg[i]) + ' ' +
                  shortest_text(value[i]);
    if (options.tail == Tail::hg) points += ",tail=hg";
    if (options.geometric_albedo)
        points += ",geometric_albedo=" + shortest_text(*options.geometric_albedo);
    return points;
}

double Tabulated::operator()(double c) const noexcept {
    const double sine = std::sqrt(std::max(0.0, (1 - c) * (1 + c)));
    const double angle_deg = degrees(std::atan2(sine, -c));
    const auto above =
        std::upper_bound(knot_angle_deg.begin() + 1, knot_angle_deg.end() - 1, angle_deg);
    const std::size_t interval = static_cast<std::size_t>(above - knot_angle_deg.begin()) - 1;
    return normalisation * hermite(*this, interval, angle_deg);
}

std::vector<double> Tabulated::moments(std::size_t count) const {
    std::vector<double> chi = raw_moments(*this, count);
    for (double& moment : chi) moment *= normalisation;
    chi[0] = 1;
    return chi;
}

namespace {

constexpr std::size_t max_moments = std::size_t{1} << 16;  // of drops of some millimetres

/// The series sum_l (2 l + 1) chi_l P_l(cos x) as sum_k c_k cos(k x).
///
/// Source   P_l(cos x) = sum_m h_m h_{l-m} cos((l - 2 m) x), h_m = (1/2)_m / m!: the generating
///          function 1 / |1 - t exp(i x)|, factor by factor.
/// Cost     n^2 / 4 steps.
std::vector<double> cosine_coefficients(const std::vector<double>& chi) {
    const std::size_t n = chi.size();
    std::vector<double> h(n, 1.0), scaled(n), cosines(n);
    for (std::size_t m = 1; m < n; ++m) h[m] = h[m - 1] * (1 - 0.5 / static_cast<double>(m));
    for (std::size_t l = 0; l < n; ++l) scaled[l] = (2 * static_cast<double>(l) + 1) * chi[l];
    for (std::size_t m = 0; 2 * m < n; ++m) {
        cosines[0] += h[m] * h[m] * scaled[2 * m];
        const double twice = 2 * h[m];  // m and l - m give the same cosine
        for (std::size_t k = 1; 2 * m + k < n; ++k)
            cosines[k] += twice * h[m + k] * scaled[2 * m + k];
    }
    return cosines;
}

/// Least and largest value of sum_k c_k cos(k x) at eight or more angles to an oscillation, by one
/// Fourier transform.
std::pair<double, double> range_of_cosines(const std::vector<double>& cosines) {
    std::size_t size = 16;
    while (size < 16 * cosines.size()) size *= 2;
    std::vector<std::complex<double>> values(size), roots(size / 2);
    for (std::size_t k = 0; k < size / 2; ++k)
        roots[k] = std::polar(1.0, 2 * pi * static_cast<double>(k) / static_cast<double>(size));
    std::copy(cosines.begin(), cosines.end(), values.begin());
    // Halving from the front: the values come out of order, which neither end of a range minds.
    for (std::size_t half = size / 2, step = 1; half > 0; half /= 2, step *= 2)
        for (std::size_t begin = 0; begin < size; begin += 2 * half)
            for (std::size_t k = 0; k < half; ++k) {
                auto &here = values[begin + k], &there = values[begin + k + half];
                const std::complex<double> sum = here + there, rest = here - there;
                const std::complex<double> root = roots[k * step];
                here = sum;
                there = {rest.real() * root.real() - rest.imag() * root.imag(),
                         rest.real() * root.imag() + rest.imag() * root.real()};
            }
    const auto [least, largest] = std::minmax_element(
        values.begin(), values.end(),
        [](const auto& one, const auto& other) { return one.real() < other.real(); });
    return {least->real(), largest->real()};
}

}  // namespace

Moments::Moments(std::vector<double> given, const RowName& row_name) : chi(std::move(given)) {
    require(!chi.empty(), kind.name, "chi", "at least one moment", 0);
    require(chi.size() <= max_moments, kind.name, "chi",
            "at most " + std::to_string(max_moments) + " moments", chi.size());
    require(std::abs(chi[0] - 1) <= 1e-6, kind.name, "chi_0" + row_name(0), "1 (to 1e-6)", chi[0]);
    for (std::size_t l = 0; l < chi.size(); ++l) {
        constexpr double rounding = 1e-6;
        const double weight = 2 * static_cast<double>(l) + 1;
        const bool may_be_weighted = std::abs(chi[l]) <= weight * (1 + rounding);
        require(std::abs(chi[l]) <= 1 + rounding, kind.name,
                "chi_" + std::to_string(l) + row_name(l),
                may_be_weighted ? "in [-1, 1], which (2 l + 1) chi_l divided by 2 l + 1 would be"
                                : "in [-1, 1]",
                chi[l]);
    }
    const double mean = chi[0];
    for (double& moment : chi) moment = std::clamp(moment / mean, -1.0, 1.0);
    const auto [smallest, largest] = range_of_cosines(cosine_coefficients(chi));
    require(smallest >= -1e-3 * largest, kind.name, "sum of (2 l + 1) chi_l P_l",
            "no lower than -1e-3 of its largest value", smallest);
}

Moments Moments::read(PhaseText& text, const std::string&) {
    std::vector<double> chi = {text.number("moments: chi")};
    while (!text.at_end() && !text.next_is('+')) chi.push_back(text.number("moments: chi"));
    return Moments(std::move(chi));
}

std::string Moments::parameter_text() const {
    std::string list;
    for (const double moment : chi) list += (list.empty() ? "chi=" : " ") + shortest_text(moment);
    return list;
}

double Moments::operator()(double c) const noexcept {
    double next = 0, after_next = 0;  // Clenshaw, (l + 1) P_{l+1} = (2 l + 1) c P_l - l P_{l-1}
    for (std::size_t l = chi.size(); l-- > 0;) {
        const double order = static_cast<double>(l);
        const double here = (2 * order + 1) * (chi[l] + c / (order + 1) * next) -
                            (order + 1) / (order + 2) * after_next;
        after_next = next;
        next = here;
    }
    return next;
}

std::vector<double> Moments::moments(std::size_t count) const {
    return continued_moments(chi, count);
}

bool Moments::is_isotropic() const noexcept {
    return std::all_of(chi.begin() + 1, chi.end(), [](double moment) { return moment == 0; });
}

}  // namespace stratus
