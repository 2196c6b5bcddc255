// Random points of a range, solved: some albedos, each at a ladder of depths.
#include <stratus/bake/accuracy.h>
#include <stratus/base/constants.h>

#include "piece_of_work.h"
#include "table_units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <string>

namespace stratus {

namespace {

/// One albedo and phase function at depths an octave apart, which are solved at once.
struct RandomLadder {
    double albedo;
    FamilyPoint member;
    DepthLadder depths;
};

double count_octaves(const AxisView& tau) {
    return tau.count == 0 ? 0 : std::log2(tau.highest / tau.lowest);
}

/// A stack, or one albedo and depth alone.
bool is_one_layer(const PointRange& range) {
    return !range.layers.empty() ||
           (range.albedo.count == 1 && range.optical_depth.size() == 1 && range.family.empty());
}

/// More where layers take long; fewer in families of two axes, whose errors are often large at one corner alone,
/// where a check of few members may have none.
int points_of_many_layers(const PointRange& range) {
    if (range.family.size() > 1) return range.has_path_law ? 12 : 4;
    return range.has_path_law ? 24 : 16;
}

/// More in tables of so few layers that it takes more of them to check than to bake; most of a stack,
/// whose points have 40 cosines.
int points_of_layer(const PointRange& range) {
    if (is_one_layer(range)) return range.layers.empty() ? 100 : 1000;
    if (range.family.size() > 1) return points_of_many_layers(range);
    const int layers = range.albedo.count * range.optical_depth.size() *
                       static_cast<int>(member_count(range.family));
    constexpr int of_usual_check = 2000, most = 40;
    return std::max(points_of_many_layers(range), std::min(most, of_usual_check / layers));
}

/// Depths evenly over octaves, from a share of the first on; of an axis that ends at infinity half as
/// many in each octave beyond.
DepthLadder random_depths(const AxisView& tau, double share, std::mt19937& random) {
    if (tau.count == 0) return {1, 0, true};
    std::uniform_real_distribution<double> uniform(0, 1);
    const double octaves = count_octaves(tau), first = std::min(1.0, octaves) * share;
    constexpr int most_beyond = 10;
    int beyond = 0;
    while (tau.ends_at_infinity && beyond < most_beyond && uniform(random) < 0.5) ++beyond;
    return {tau.lowest * std::exp2(first), 1 + static_cast<int>(octaves - first) + beyond, false};
}

/// At a share of the way along an axis, evenly in its scale.
double random_value(const FamilyAxis& axis, double share) {
    const std::vector<double>& values = axis.axis.values;
    const auto count = static_cast<double>(values.size());
    if (axis.is_discrete) return values[static_cast<std::size_t>(share * count)];
    const double low = values.front(), high = values.back();
    switch (axis.axis.scale) {
        case AxisScale::logarithmic: return low * std::pow(high / low, share);
        case AxisScale::logarithm_of_complement:
            return 1 - (1 - low) * std::pow((1 - high) / (1 - low), share);
        default: return low + share * (high - low);
    }
}

/// Shares of the way along the axes of albedo, of depth and of a family.
using Shares = std::array<double, 2 + max_family_axes>;

/// Returns the shares of ladder `number`. Even those of a few ladders leave no wide gap along an axis:
/// from one ladder to the next they move on by steps that are far from any fraction.
Shares even_shares(unsigned seed, int number) {
    Shares shares{std::sqrt(1.25) - 0.5, std::sqrt(2.0), std::sqrt(3.0), std::sqrt(7.0)};
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (double& share : shares) {
        share = uniform(random) + number * share;
        share -= std::floor(share);
    }
    return shares;
}

/// Albedos, depths and points of a family evenly over the cells of a range.
RandomLadder random_ladder(const PointRange& range, const Shares& shares, std::mt19937& random) {
    const AxisView& w = range.albedo;
    const double s = std::lerp(std::sqrt(1 - w.lowest), std::sqrt(1 - w.highest), shares[0]);
    RandomLadder ladder{w.count == 1 ? w.lowest : std::clamp(1 - s * s, w.lowest, w.highest),
                        {},
                        random_depths(range.optical_depth, shares[1], random)};
    std::vector<double> values;
    for (std::size_t k = 0; k < range.family.size(); ++k)
        values.push_back(random_value(range.family[k], shares[2 + k]));
    ladder.member = FamilyPoint(values);
    return ladder;
}

/// Returns a cosine, drawn evenly over its square root, or over one of `parts` of the way along that.
double random_cosine(double lowest, double highest, std::mt19937& random, int part = 0,
                     int parts = 1) {
    const double first = std::sqrt(lowest), width = (std::sqrt(highest) - first) / parts;
    std::uniform_real_distribution<double> x(0, 1);
    const double root = first + (part + x(random)) * width;
    return std::clamp(root * root, lowest, highest);
}

/// The least cosine of an axis that is judged with the even points.
double least_cosine(const PointRange& range, const AxisView& axis) {
    return range.has_path_law ? std::clamp(least_judged_cosine, axis.lowest, axis.highest)
                              : axis.lowest;
}

struct Azimuths {
    double lowest, highest;

    bool hold(double azimuth) const { return azimuth >= lowest && azimuth <= highest; }
};

Azimuths azimuth_range(const PointRange& range) {
    const AxisView& azimuth = range.azimuth;
    const bool any = azimuth.count == 0 || (azimuth.count == 1 && azimuth.lowest == 0);
    return any ? Azimuths{0, pi} : Azimuths{azimuth.lowest, azimuth.highest};
}

template <class Any>
const Any& pick(const std::vector<Any>& all, std::mt19937& random) {
    return all[random() % all.size()];
}

struct RandomPoint {
    Geometry at;
    PointKind kind;
    std::vector<Side> sides;
};

/// Directions within the cone around straight on, evenly over its angle, that leave on one side;
/// none after a hundred trials. For transmission mu_in is one of `transmitted`.
std::optional<Geometry> random_forward(const PointRange& range, Side side,
                                       const std::vector<double>& transmitted,
                                       std::mt19937& random) {
    const double widest = radians(forward_cone);
    std::uniform_real_distribution<double> angle(0, widest), turn(0, pi);
    // Light comes back within the cone from grazing incidence alone.
    const double lowest = least_cosine(range, range.mu_in),
                 highest = std::min(range.mu_in.highest, std::sin(widest));
    if (side == Side::reflection && lowest > highest) return std::nullopt;
    for (int trial = 0; trial < 100; ++trial) {
        const double mu_in = side == Side::reflection ? random_cosine(lowest, highest, random)
                                                      : pick(transmitted, random);
        const double sine_in = std::sqrt((1 - mu_in) * (1 + mu_in));
        const double theta = angle(random), psi = turn(random);
        const double down = std::cos(theta) * mu_in + std::sin(theta) * std::cos(psi) * sine_in;
        const double along = std::cos(theta) * sine_in - std::sin(theta) * std::cos(psi) * mu_in;
        const double mu_out = side == Side::reflection ? -down : down;
        const double azimuth = std::atan2(std::sin(theta) * std::sin(psi), along);
        if (mu_out >= least_cosine(range, range.mu_out) && mu_out <= range.mu_out.highest &&
            azimuth_range(range).hold(azimuth))
            return Geometry{mu_in, mu_out, azimuth};
    }
    return std::nullopt;
}

/// The points of a ladder's layers. All layers share a few directions: every cosine adds to the time
/// that the ladder takes.
class PointSource {
  public:
    PointSource(const PointRange& range, bool peaked, std::mt19937& random)
        : has_path_law_(range.has_path_law), azimuths_(azimuth_range(range)), random_(random) {
        if (range.reflection) sides_.push_back(Side::reflection);
        if (range.transmission) sides_.push_back(Side::transmission);
        const int times = std::min(4, points_of_layer(range) / points_of_many_layers(range));
        const int few = range.layers.empty() ? 10 : 40;  // pairs differ in azimuth, too
        const int few_grazing = 3 * times;
        for (int n = 0; n < few; ++n) {
            mu_in_.push_back(anywhere(range, range.mu_in, n, few));
            mu_out_.push_back(anywhere(range, range.mu_out, n, few));
        }
        const bool same = range.mu_in.lowest == range.mu_out.lowest &&
                          range.mu_in.highest == range.mu_out.highest;
        if (same && !range.layers.empty()) mu_out_ = mu_in_;
        of_peak_.seed(random());
        if (!peaked) return;
        for (const Side side : sides_) {
            forward_.emplace_back();
            // Each of reflection adds two cosines to be solved, each of transmission one.
            const int few_forward = (side == Side::reflection ? 5 : 10) * times;
            for (int n = 0; n < few_forward; ++n)
                if (const auto at = random_forward(range, side, mu_in_, of_peak_))
                    forward_.back().push_back({*at, PointKind::forward, {side}});
        }
        if (range.mu_in.lowest >= grazing_cosine || range.mu_out.lowest >= grazing_cosine) return;
        for (int n = 0; n < few_grazing; ++n) {
            grazing_in_.push_back(grazing(range.mu_in));
            grazing_out_.push_back(has_path_law_ ? pick(mu_out_, of_peak_) : grazing(range.mu_out));
        }
    }

    const std::vector<Side>& sides() const { return sides_; }

    /// Evenly drawn points of a layer, then those of the other kinds where something is peaked.
    std::vector<RandomPoint> draw(int count) {
        std::vector<RandomPoint> points;
        std::uniform_real_distribution<double> azimuth(azimuths_.lowest, azimuths_.highest);
        for (int n = 0; n < count; ++n)
            points.push_back({{pick(mu_in_, random_), pick(mu_out_, random_), azimuth(random_)},
                              PointKind::even,
                              sides_});
        for (int n = 0; n < (has_path_law_ ? count + 3 : 2 * count + 2) / 4; ++n, ++drawn_forward_)
            for (const std::vector<RandomPoint>& of_side : forward_)
                if (!of_side.empty()) points.push_back(of_side[drawn_forward_ % of_side.size()]);
        if (!grazing_in_.empty())
            for (int n = 0; n < (count + 3) / 4; ++n)
                points.push_back(
                    {{pick(grazing_in_, of_peak_), pick(grazing_out_, of_peak_), azimuth(of_peak_)},
                     PointKind::grazing,
                     sides_});
        return points;
    }

  private:
    double anywhere(const PointRange& range, const AxisView& axis, int part, int parts) {
        return random_cosine(least_cosine(range, axis), axis.highest, random_, part, parts);
    }
    double grazing(const AxisView& axis) {
        return random_cosine(axis.lowest, std::min(axis.highest, grazing_cosine), of_peak_);
    }

    bool has_path_law_;
    Azimuths azimuths_;
    std::mt19937& random_;
    std::mt19937 of_peak_;  // apart: even points are those of any phase function
    std::vector<Side> sides_;
    std::vector<double> mu_in_, mu_out_, grazing_in_, grazing_out_;
    std::vector<std::vector<RandomPoint>> forward_;  // of each side, taken in turn
    std::size_t drawn_forward_ = 0;
};

/// The place of a cosine in a list without repetition, where it is added unless it is there.
int find_or_add(std::vector<double>& cosines, double mu) {
    const auto found = std::ranges::find(cosines, mu);
    const auto place = static_cast<int>(found - cosines.begin());
    if (found == cosines.end()) cosines.push_back(mu);
    return place;
}

/// Points of the first layers of a random ladder.
class LadderPoints {
  public:
    LadderPoints(const PhaseFunction& phase_function, const PointRange& range, bool peaked,
                 int most, unsigned seed, int number)
        : phase_function_(phase_function), range_(range), mu_(floor_cosines()) {
        std::mt19937 random(seed * 1000003u + static_cast<unsigned>(number));
        ladder_ = random_ladder(range, even_shares(seed, number), random);
        PointSource source(range, peaked, random);
        sides_ = source.sides();
        const int layers = ladder_.depths.count();
        while (points_ < most && int_size(layers_) < layers) {
            const int of_layer = std::min(points_of_layer(range), most - points_);
            layers_.push_back(source.draw(of_layer));
            points_ += of_layer;
            count_ += sides_.size();
            for (const RandomPoint& point : layers_.back()) {
                count_ += point.sides.size();
                places_.push_back(
                    {find_or_add(mu_, point.at.mu_in), find_or_add(mu_, point.at.mu_out)});
            }
        }
        if (!ladder_.depths.to_infinity) ladder_.depths.octaves = int_size(layers_);
    }

    /// Evenly drawn ones, at most `most`.
    int points() const { return points_; }

    std::size_t value_count() const { return count_; }

    /// Returns a floor for each side of each layer, then the totals, point by point.
    std::vector<double> values(const SolverOptions& solver) const {
        const PhaseFunction member = phase_function_at(
            phase_function_, range_.second_phase_function, range_.family, ladder_.member);
        const auto solutions = solve_material(range_.layers, member, {ladder_.albedo},
                                              ladder_.depths, mu_, solver, range_.lower_boundary);
        std::vector<double> solved;
        const Places* at = places_.data();
        for (std::size_t k = 0; k < layers_.size(); ++k) {
            const LayerSolution& solution = solutions[0][k];
            for (const Side side : sides_) solved.push_back(error_floor(solution, side));
            for (const RandomPoint& point : layers_[k]) {
                const double phi = point.at.azimuth;
                for (const Side side : point.sides)
                    solved.push_back(
                        solution.values(side, at->mu_in, at->mu_out, {phi}).front().total);
                ++at;
            }
        }
        return solved;
    }

    std::vector<ErrorSample> error_samples(const std::vector<double>& solved) const {
        std::vector<ErrorSample> samples;
        const double* next = solved.data();
        for (std::size_t k = 0; k < layers_.size(); ++k) {
            const double depth = ladder_.depths.to_infinity
                                     ? infinity
                                     : std::ldexp(ladder_.depths.first, static_cast<int>(k));
            const PerSide<double> floors{next[0], next[sides_.size() - 1]};
            next += sides_.size();
            for (const RandomPoint& point : layers_[k])
                for (const Side side : point.sides) {
                    const double cosine = cos_scattering_angle(side, point.at);
                    samples.push_back({side, ladder_.albedo, depth, point.at,
                                       std::acos(std::clamp(cosine, -1.0, 1.0)), *next++, 0, 0,
                                       floors[side], ladder_.member, point.kind});
                }
        }
        return samples;
    }

  private:
    struct Places {
        int mu_in, mu_out;  // in mu_
    };

    const PhaseFunction& phase_function_;
    const PointRange& range_;
    RandomLadder ladder_;
    std::vector<Side> sides_;
    std::vector<std::vector<RandomPoint>> layers_;
    std::vector<Places> places_;
    std::vector<double> mu_;
    int points_ = 0;
    std::size_t count_ = 0;  // of values
};

}  // namespace

bool has_peak(const PhaseFunction& phase_function, const PointRange& range) {
    std::vector<PhaseFunction> corners;  // the phase function itself without a family
    for (const FamilyPoint& corner : family_corners(range.family))
        corners.push_back(
            phase_function_at(phase_function, range.second_phase_function, range.family, corner));
    return std::ranges::any_of(corners, [&](const PhaseFunction& corner) {
        return std::ranges::any_of(list_phase_functions(range.layers, corner, range.lower_boundary),
                                   is_peaked);
    });
}

int points_of_ladder(const PointRange& range) {
    return points_of_layer(range) * (1 + static_cast<int>(count_octaves(range.optical_depth)));
}

std::vector<ErrorSample> solve_random_points(const PhaseFunction& phase_function,
                                             const PointRange& range, const SolverOptions& solver,
                                             const VerifyOptions& options) {
    // At grazing angles the mirrored sun is such a peak.
    const bool peaked =
        range.all_kinds && (range.lower_boundary.law != nullptr || has_peak(phase_function, range));
    std::vector<LadderPoints> ladders;
    for (int left = options.samples; left > 0;) {
        const int number = int_size(ladders);
        ladders.emplace_back(phase_function, range, peaked, left, options.seed, number);
        left -= ladders.back().points();
    }
    std::vector<std::vector<ErrorSample>> of_ladder(ladders.size());
    const auto name = [](int piece) { return "ladder " + std::to_string(piece); };
    const auto solve = [&](int piece) { return as_chars(ladders[size(piece)].values(solver)); };
    const auto take = [&](int piece, std::span<const char> solved) {
        const auto k = size(piece);
        of_ladder[k] = ladders[k].error_samples(
            numbers_in<double>(solved, name(piece), ladders[k].value_count()));
    };
    solve_pieces({int_size(ladders), name, solve, take, options.progress}, options.log,
                 options.threads);
    std::vector<ErrorSample> samples;
    for (const auto& some : of_ladder) samples.insert(samples.end(), some.begin(), some.end());
    return samples;
}

}  // namespace stratus
