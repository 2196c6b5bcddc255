#include "least_squares.h"

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stratus {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double between(double low, double high, double share) { return low + share * (high - low); }

std::string interval_text(const Interval& range) {
    return std::string("[")
        .append(joined({short_number(range.low, 6), short_number(range.high, 6)}))
        .append("]");
}

/// Values of one albedo that leave the sum and the mixture within the model's range, the other one
/// being held. `first`: w1 is the free one.
Interval free_albedo(const ParameterRanges& ranges, bool first, double held) {
    const Interval& sum = ranges.albedo;
    const Interval share =
        first ? ranges.mixture : Interval{1 - ranges.mixture.high, 1 - ranges.mixture.low};
    Interval range{std::max(0.0, sum.low - held), sum.high - held};
    if (held == 0) return share.high >= 1 ? range : Interval{1, 0};
    // share = free / (free + held)
    range.low = std::max(range.low, held * share.low / (1 - share.low));
    if (share.high < 1) range.high = std::min(range.high, held * share.high / (1 - share.high));
    return range;
}

/// Whether the observations bring an axis' value themselves.
bool is_known(const Observations& observations, std::size_t axis, const char* name) {
    const auto count = size(std::ranges::count_if(observations, [&](const Observation& observed) {
        return !std::isnan(observed.known[axis]);
    }));
    require(count == 0 || count == observations.size(), fit_caller, name,
            "known of all " + std::to_string(observations.size()) + " observations, or of none",
            count);
    return count > 0;
}

}  // namespace

ParameterSpace::ParameterSpace(const LayerModel& model, const Observations& observations,
                               const FitOptions& options)
    : names_(fit_parameter_names(model)), one_kind_(model.kinds() < 2) {
    const double dilution = 1 - options.density;
    const Interval depth{model.ranges().optical_depth.low * dilution,
                         model.ranges().optical_depth.high * dilution};
    if (options.optical_depth) {
        held_.optical_depth = *options.optical_depth;
        require(model.has_depth(effective_optical_depth(held_.optical_depth, options.density)),
                fit_caller, "optical_depth held",
                "one that the model knows, such as in " + interval_text(depth),
                held_.optical_depth);
    } else {
        held_.optical_depth = depth.low;
        add(fit_optical_depth, depth);
    }
    add_albedos(model, options);
    const FamilyAxes family = model.family();
    if (std::ranges::find(family, PhaseParameter::g, &FamilyAxis::parameter) == family.end())
        add_asymmetry(model, 1, options.g1, options.free_g1);
    add_asymmetry(model, 2, options.g2, options.free_g2);
    add_family(model, observations, options);
}

void ParameterSpace::add(Coordinate of, Interval range) {
    if (!(range.low < range.high)) return;
    Range added{of, range.low, range.high};
    if (added.is_logarithm()) added = {of, std::log2(range.low), std::log2(range.high)};
    ranges_.push_back(added);
}

void ParameterSpace::add_albedos(const LayerModel& model, const FitOptions& options) {
    const ParameterRanges ranges = model.ranges();
    const char* const w1 = one_kind_ ? "w held" : "w1 held";
    require(model.kinds() > 0 || (!options.w1 && !options.w2), fit_caller, "albedos",
            "left out where beams alone are fitted", "one");
    require(model.kinds() != 1 || !options.w2, fit_caller, "w2",
            "left out with particles of one kind", options.w2.value_or(0));
    if (options.w1) require_in("[0, 1]", fit_caller, w1, held_.w1 = *options.w1);
    if (options.w2) require_in("[0, 1]", fit_caller, "w2 held", held_.w2 = *options.w2);
    const bool both_held = options.w1 && (options.w2 || one_kind_);
    if (both_held) {
        require(ranges.albedo.contains(held_.albedo()), fit_caller, one_kind_ ? w1 : "w1 + w2 held",
                "in the model's " + interval_text(ranges.albedo), held_.albedo());
        require(one_kind_ || ranges.mixture.contains(held_.mixture()), fit_caller,
                "w1 / (w1 + w2) held", "in the model's " + interval_text(ranges.mixture),
                held_.mixture());
    } else if (options.w1 || options.w2) {
        const bool first = !options.w1;
        const double held = first ? held_.w2 : held_.w1;
        const Interval range = free_albedo(ranges, first, held);
        require(range.low < range.high, fit_caller, first ? "w2 held" : w1,
                "one that leaves room for the other: w1 + w2 in " + interval_text(ranges.albedo) +
                    ", w1 / (w1 + w2) in " + interval_text(ranges.mixture),
                held);
        add(first ? fit_w1 : fit_w2, range);
    } else {
        mixes_ = true;
        albedo_ = ranges.albedo.low;
        mixture_ = ranges.mixture.low;
        add(sum_of_albedos, ranges.albedo);
        add(share_of_first, ranges.mixture);
    }
}

void ParameterSpace::add_asymmetry(const LayerModel& model, int kind,
                                   const std::optional<double>& held, bool is_free) {
    double& value = kind == 1 ? held_.g1 : held_.g2;
    const std::string name = kind == 2 ? "g2" : one_kind_ ? "g" : "g1";
    const std::optional<double> own = model.asymmetry(kind);
    value = own.value_or(0);
    if (!held && !is_free) return;
    require(own.has_value(), fit_caller, name,
            "left out unless it is that of a Henyey-Greenstein phase function, or a table's family "
            "varies it",
            held ? short_number(*held, 6) : "free");
    const Interval range = model.ranges().g;
    if (is_free) {
        require(!held, fit_caller, name, "either held or free", "both");
        value = std::clamp(value, range.low, range.high);
        add(kind == 1 ? fit_g1 : fit_g2, range);
        return;
    }
    require(range.contains(*held), fit_caller, name + " held", "in " + interval_text(range), *held);
    value = *held;
}

void ParameterSpace::add_family(const LayerModel& model, const Observations& observations,
                                const FitOptions& options) {
    const FamilyAxes family = model.family();
    for (const FitParameter parameter : {fit_radius, fit_wavelength, fit_variance}) {
        const auto& held = options.*held_fields[parameter];
        const bool is_varied = std::ranges::any_of(family, [&](const FamilyAxis& axis) {
            return to_fit_parameter(axis.parameter) == parameter;
        });
        require(!held || is_varied, fit_caller, names_[parameter],
                "left out unless a table's family varies it", held.value_or(0));
    }
    for (std::size_t k = 0; k < family.size(); ++k) {
        const FamilyAxis& axis = family[k];
        const auto parameter = to_fit_parameter(axis.parameter);
        if (!parameter) continue;
        const std::string name = names_[*parameter];
        const auto& held = options.*held_fields[*parameter];
        const Interval range{axis.axis.values.front(), axis.axis.values.back()};
        double& value = held_.*layer_fields[*parameter];
        value = between(range.low, range.high, 0.5);
        if (is_known(observations, k, axis.name())) {
            require(!held, fit_caller, name, "either held or known of the observations", "both");
        } else if (held) {
            require(holds(axis, *held), fit_caller, name + " held", allowed_text(axis), *held);
            value = *held;
        } else {
            require(!axis.is_discrete, fit_caller, name,
                    "held or known of the observations: " + allowed_text(axis), "neither");
            add(*parameter, range);
        }
    }
}

int ParameterSpace::place(Coordinate wanted) const {
    const auto found = std::ranges::find(ranges_, wanted, &Range::of);
    return found == ranges_.end() ? -1 : static_cast<int>(found - ranges_.begin());
}

double ParameterSpace::Range::extent() const {
    return (is_logarithm() ? std::numbers::ln2 : 1) * (high - low);
}

double ParameterSpace::extent(Coordinate coordinate) const {
    const int at = place(coordinate);
    return at < 0 ? 0 : ranges_[stratus::size(at)].extent();
}

bool ParameterSpace::is_logarithm(Coordinate coordinate) const {
    const int at = place(coordinate);
    return at >= 0 && ranges_[stratus::size(at)].is_logarithm();
}

double ParameterSpace::value(int of, double at) const {
    const Range& range = ranges_[stratus::size(of)];
    const double value = between(range.low, range.high, at);
    return range.is_logarithm() ? std::exp2(value) : value;
}

std::string ParameterSpace::name(int of) const {
    switch (coordinate(of)) {
        case sum_of_albedos: return one_kind_ ? "w" : "w1 + w2";
        case share_of_first: return "w1 / (w1 + w2)";
        default: return names_[coordinate(of)];
    }
}

LayerParameters ParameterSpace::layer(const Point& at) const {
    LayerParameters layer = held_;
    double albedo = albedo_, mixture = mixture_;
    for (int p = 0; p < size(); ++p) {
        const double value = this->value(p, at[p]);
        switch (coordinate(p)) {
            case sum_of_albedos: albedo = value; break;
            case share_of_first: mixture = value; break;
            default: layer.*layer_fields[coordinate(p)] = value;
        }
    }
    if (mixes_) {
        layer.w1 = albedo * mixture;
        layer.w2 = albedo * (1 - mixture);
    }
    return layer;
}

MatrixXd ParameterSpace::derivatives(const Point& at) const {
    MatrixXd derivatives = MatrixXd::Zero(fit_parameters, size());
    const LayerParameters layer = this->layer(at);
    for (int p = 0; p < size(); ++p) {
        const double extent = ranges_[stratus::size(p)].extent();
        switch (coordinate(p)) {
            case sum_of_albedos: {
                const int mixture = place(share_of_first);
                const double share = mixture < 0 ? mixture_ : value(mixture, at[mixture]);
                derivatives(fit_w1, p) = share * extent;
                derivatives(fit_w2, p) = (1 - share) * extent;
                break;
            }
            case share_of_first:
                derivatives(fit_w1, p) = layer.albedo() * extent;
                derivatives(fit_w2, p) = -layer.albedo() * extent;
                break;
            default: derivatives(index(coordinate(p)), p) = extent;
        }
    }
    return derivatives;
}

ParameterSpace::Point ParameterSpace::start() const {
    Point at = Point::Constant(size(), 0.5);
    for (int p = 0; p < size(); ++p) {
        const auto& [of, low, high] = ranges_[stratus::size(p)];
        if (of == fit_g1 || of == fit_g2) at[p] = (held_.*layer_fields[of] - low) / (high - low);
    }
    return at;
}

namespace {

using Point = Problem::Point;

/// The step that the damped normal equations ask for; none along coordinates that must not move.
Point damped_step(const MatrixXd& curvature, const Point& slope, const Point& at, double damping,
                  std::optional<int> held) {
    constexpr double min_curvature = 1e-9;
    MatrixXd damped = curvature;
    Point right_side = -slope;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += 1e-12 * curvature.trace() + min_curvature;
    for (int p = 0; p < at.size(); ++p) {
        const bool outward = (at[p] <= 0 && slope[p] > 0) || (at[p] >= 1 && slope[p] < 0);
        if (!outward && held != p) continue;
        damped.row(p).setZero();
        damped.col(p).setZero();
        damped(p, p) = 1;
        right_side[p] = 0;
    }
    return damped.ldlt().solve(right_side);
}

/// `start` with every combination of starts of the parameters of phase functions that are free.
std::vector<Point> starting_points(const ParameterSpace& space) {
    std::vector<Point> points{space.start()};
    for (const FitParameter parameter : of_phase_functions) {
        const int place = space.place(parameter);
        if (place < 0) continue;
        const std::vector<Point> before = points;
        for (const double at : {0.2, 0.8})
            for (Point point : before) {
                point[place] = at;
                points.push_back(point);
            }
    }
    return points;
}

/// The minima of one scan of coordinate `held`, each fit starting from the one before; where a phase function
/// is free, from `start`: one fit in which its particles have vanished would lose it for all that follow.
void scan(const Problem& problem, const Point& start, int held, int count,
          std::vector<Minimum>& minima) {
    constexpr double rough_tolerance = 1e-3;
    const bool afresh = std::ranges::any_of(of_phase_functions, [&](FitParameter parameter) {
        return problem.space.place(parameter) >= 0;
    });
    std::vector<Minimum> profile;
    for (int n = 0; n < count; ++n) {
        Point at = afresh || n == 0 ? start : profile.back().at;
        at[held] = n / (count - 1.0);
        profile.push_back(descend(problem, at, held, rough_tolerance));
    }
    const auto chi_square = [&](std::size_t n) {
        return n < profile.size() ? profile[n].chi_square : infinity;
    };
    const auto is_minimum = [&](std::size_t n) {
        return chi_square(n) <= std::min(chi_square(n - 1), chi_square(n + 1));
    };
    // With few observations another valley, less than two steps from a minimum, may hide beside it.
    const bool are_few = int_size(problem.observations) <= problem.space.size() + 2;
    for (std::size_t n = 0; n < profile.size(); ++n)
        if (is_minimum(n) || (are_few && (is_minimum(n - 1) || is_minimum(n + 1))))
            minima.push_back(profile[n]);
}

/// Without those that lie next to a better one.
std::vector<Minimum> distinct(const std::vector<Minimum>& sorted) {
    constexpr double next_to = 0.01;
    std::vector<Minimum> kept;
    for (const Minimum& minimum : sorted) {
        const auto is_near = [&](const Minimum& other) {
            return (minimum.at - other.at).isZero(0) ||
                   (minimum.at - other.at).cwiseAbs().maxCoeff() < next_to;
        };
        if (std::ranges::none_of(kept, is_near)) kept.push_back(minimum);
    }
    return kept;
}

}  // namespace

VectorXd Problem::residuals(const Point& at) const {
    const std::vector<double> brightness =
        model.brightness(space.layer(at), observations, options.density, options.opposition);
    VectorXd residuals(index(observations.size()));
    for (Eigen::Index i = 0; i < residuals.size(); ++i) {
        const Observation& observed = observations[size(i)];
        residuals[i] = (brightness[size(i)] - observed.brightness) / observed.sigma;
    }
    return residuals;
}

MatrixXd Problem::derivatives(const Point& at, std::optional<int> held) const {
    constexpr double step = 1e-3;
    MatrixXd derivatives = MatrixXd::Zero(index(observations.size()), at.size());
    for (int p = 0; p < at.size(); ++p) {
        if (held == p) continue;
        Point upper = at, lower = at;
        upper[p] = std::min(1.0, at[p] + step);
        lower[p] = std::max(0.0, at[p] - step);
        derivatives.col(p) = (residuals(upper) - residuals(lower)) / (upper[p] - lower[p]);
    }
    return derivatives;
}

Minimum descend(const Problem& problem, Point at, std::optional<int> held, double tolerance) {
    constexpr double min_damping = 1e-9, max_damping = 1e9;
    VectorXd residuals = problem.residuals(at);
    double chi_square = residuals.squaredNorm(), damping = 1e-3;
    bool ended = at.size() == 0;
    for (int step = 0; step < most_steps && !ended; ++step) {
        const MatrixXd derivatives = problem.derivatives(at, held);
        const MatrixXd curvature = derivatives.transpose() * derivatives;
        const Point slope = derivatives.transpose() * residuals;
        bool improved = false, converged = true;
        for (; !improved && damping < max_damping; damping *= improved ? 0.1 : 10) {
            const Point next =
                (at + damped_step(curvature, slope, at, damping, held)).cwiseMax(0).cwiseMin(1);
            const VectorXd next_residuals = problem.residuals(next);
            if (!(next_residuals.squaredNorm() < chi_square)) continue;
            improved = true;
            converged = chi_square - next_residuals.squaredNorm() < tolerance * (1 + chi_square) &&
                        (next - at).cwiseAbs().maxCoeff() < std::sqrt(tolerance);
            at = next;
            residuals = next_residuals;
            chi_square = next_residuals.squaredNorm();
        }
        ended = !improved || converged;
        damping = std::max(damping, min_damping);
    }
    return {at, chi_square, ended};
}

std::vector<Minimum> scan_minima(const Problem& problem) {
    constexpr int scanned_sizes = 33;  // glories and bows move with the size and make many valleys
    std::vector<Minimum> minima;
    const ParameterSpace& space = problem.space;
    for (const FitParameter size : {fit_radius, fit_wavelength})
        if (const int place = space.place(size); place >= 0)
            scan(problem, space.start(), place, scanned_sizes, minima);
    const int depth = space.place(fit_optical_depth);
    for (const Point& start : starting_points(space)) {
        if (depth < 0)
            minima.push_back(descend(problem, start));
        else
            scan(problem, start, depth, problem.model.scanned_depths(), minima);
    }
    std::ranges::sort(minima, {}, &Minimum::chi_square);
    return distinct(minima);
}

// Q(a + 1, x) = Q(a, x) + x^a e^-x / Gamma(a + 1), from Q(1/2, x) = erfc(sqrt x) or Q(1, x) = e^-x.
double chi_square_probability(double chi_square, int degrees_of_freedom) noexcept {
    const double x = chi_square / 2;
    if (x == 0) return 1;
    if (std::isinf(x)) return 0;
    const bool odd = degrees_of_freedom % 2 == 1;
    double a = odd ? 0.5 : 1;
    double probability = odd ? std::erfc(std::sqrt(x)) : std::exp(-x);
    const double log_gamma = odd ? std::log(std::numbers::pi) / 2 - std::numbers::ln2 : 0;
    double log_term = a * std::log(x) - x - log_gamma;  // x^a e^-x / Gamma(a + 1)
    for (; a < degrees_of_freedom / 2.0; a += 1) {
        probability += std::exp(log_term);
        log_term += std::log(x / (a + 1));
    }
    return std::fmin(probability, 1);
}

}  // namespace stratus
