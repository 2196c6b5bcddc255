#include <stratus/phase/path_law.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include "kernels/sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace stratus {
namespace {

constexpr int max_count = PathWeights::max_count;

// Samples evenly spaced within each octave of a number, 2^bits to an octave: the leading bits of a
// float are its place among them, with no logarithm. base/lanes.h finds places.

constexpr int mantissa_bits = 23;

std::int32_t to_bits(float x) {
    std::int32_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    return bits;
}

/// The sample at an index; that at 0 is `lowest`, a power of 2.
double octave_sample(float lowest, int bits, int index) {
    const std::int32_t moved = to_bits(lowest) + index * (1 << (mantissa_bits - bits));
    float sample;
    std::memcpy(&sample, &moved, sizeof sample);
    return double{sample};
}

/// Index of the sample at or below x >= lowest.
int octave_index(float lowest, int bits, float x) {
    return (to_bits(x) - to_bits(lowest)) >> (mantissa_bits - bits);
}

struct Inverses {
    double of[max_count + 1];
};

constexpr Inverses inverse = [] {
    Inverses table{};
    for (int n = 1; n <= max_count; ++n) table.of[n] = 1.0 / n;
    return table;
}();

/// How many of `count` orders matter along a path: of the others P(n, s) is below 1e-16 P(2, s).
int orders_along(double s, int count) noexcept {
    const double most = s + 9 * std::sqrt(s) + 14;
    return most < count ? static_cast<int>(most) : count;
}

/// sum_n weight[n] f[n], in lanes side by side: one sum would wait for itself.
double weighted_sum(const double* weight, const float* f, int count) noexcept {
    constexpr int lanes = 8;
    double sum[lanes] = {}, total = 0;
    int n = 0;
    for (; n + lanes <= count; n += lanes)
        for (int k = 0; k < lanes; ++k) sum[k] += weight[n + k] * double{f[n + k]};
    for (; n < count; ++n) total += weight[n] * double{f[n]};
    for (const double lane : sum) total += lane;
    return total;
}

/// log |Gamma(x)|, without std::lgamma's global sign, for which threads would race.
double log_gamma(double x) noexcept {
    int sign;
    return ::lgamma_r(x, &sign);
}

/// Over n: the share of the light that meets n particles or more along a path, P(n, s), that which
/// meets fewer, and dP/ds, the Poisson probability of n - 1.
struct Meetings {
    double more[max_count], fewer[max_count], slope[max_count];

    /// Not-a-number counts as 0, so that it never becomes an index.
    Meetings(int count, double depth) noexcept {
        const double s = std::max(0.0, depth);
        const int last = count - 1;
        if (s > 2 * max_count + 1000) {
            std::fill_n(more, count, 1.0);
            std::fill_n(fewer, count, 0.0);
            std::fill_n(slope, count, 0.0);
            return;
        }
        // Poisson probabilities, from the most probable downwards and upwards.
        double probability[max_count];
        const int peak = std::min(last, static_cast<int>(s));
        probability[peak] =
            peak > 0 ? std::exp(peak * std::log(s) - s - log_gamma(peak + 1.0)) : std::exp(-s);
        const double inverse_s = 1 / s;
        for (int k = peak; k > 0; --k) probability[k - 1] = probability[k] * (k * inverse_s);
        for (int k = peak; k < last; ++k)
            probability[k + 1] = probability[k] * (s * inverse.of[k + 1]);
        fewer[0] = 0;
        for (int n = 1; n <= last; ++n) fewer[n] = fewer[n - 1] + probability[n - 1];
        double beyond = 0;  // the probability of `count` and more
        if (s < last) {
            double term = probability[last] * s / count;
            for (int k = count; term > 1e-17 * beyond && term > 0; term *= s / ++k) beyond += term;
        } else {
            beyond = std::max(0.0, 1 - fewer[last] - probability[last]);
        }
        more[last] = beyond + probability[last];
        for (int n = last; n > 0; --n) more[n - 1] = more[n] + probability[n - 1];
        slope[0] = 0;
        std::copy_n(probability, last, slope + 1);
    }
};

}  // namespace

PathWeights path_weights(Side side, int count, double optical_depth, double mu_in,
                         double mu_out) noexcept {
    PathWeights weights;
    const double in = optical_depth / mu_in, out = optical_depth / mu_out;
    count = orders_along(side == Side::reflection ? in + out : std::max(in, out), count);
    weights.count = count;
    if (side == Side::reflection) {
        const Meetings meetings(count, in + out);
        for (int n = 0; n < count; ++n)
            weights.of_order[n] = meetings.more[n] / (4 * (mu_in + mu_out));
    } else if (std::isinf(optical_depth)) {
        std::fill_n(weights.of_order, count, 0.0);
    } else if (std::abs(in - out) > 0.5) {
        const Meetings more(count, std::max(in, out)), less(count, std::min(in, out));
        const double factor = optical_depth / (4 * mu_in * mu_out) / std::abs(in - out);
        for (int n = 0; n < count; ++n)  // the form without cancellation
            weights.of_order[n] = factor * (less.more[n] > 0.5 ? less.fewer[n] - more.fewer[n]
                                                               : more.more[n] - less.more[n]);
    } else {  // the mean slope in between, by seven Gauss points
        constexpr double node[] = {0, 0.4058451513773972, 0.7415311855993945, 0.9491079123427585};
        constexpr double share[] = {0.4179591836734694, 0.3818300505051189, 0.2797053914892767,
                                    0.1294849661688697};
        const double factor = optical_depth / (4 * mu_in * mu_out) / 2;
        const double middle = (in + out) / 2, half = std::abs(in - out) / 2;
        std::fill_n(weights.of_order, count, 0.0);
        for (int k = -3; k <= 3; ++k) {
            const Meetings at(count, middle + (k < 0 ? -half : half) * node[std::abs(k)]);
            for (int n = 0; n < count; ++n)
                weights.of_order[n] += factor * share[std::abs(k)] * at.slope[n];
        }
    }
    weights.of_order[0] = 0;
    for (int n = 1; n < count; ++n) weights.of_order[n] *= inverse.of[n];
    return weights;
}

std::vector<double> significant_moments(const PhaseFunction& phase_function, int most) {
    for (int count = 256;; count = std::min(2 * count, most)) {
        std::vector<double> moments = phase_function.moments(count);
        const auto shows = [&](double least) {
            return std::abs(moments.back()) * 2 * static_cast<double>(moments.size()) >= least;
        };
        const bool suffices = count >= most_table_moments && !shows(1e-3);
        if (count == most && !suffices) return {};
        while (!moments.empty() && !shows(1e-9)) moments.pop_back();
        if (suffices || static_cast<int>(moments.size()) < count) return moments;
    }
}

bool has_narrow_peak(const PhaseFunction& phase_function) {
    constexpr int resolved = 32;        // moments that a few nodes hold
    constexpr double least_peak = 0.2;  // phase value
    const std::vector<double> first = phase_function.moments(resolved + 2);
    return first[resolved] * (2 * resolved + 1) >= least_peak && first[resolved + 1] > 0;
}

PathLaw::PathLaw(std::vector<double> moments) : chi_(std::move(moments)) {
    require(!chi_.empty(), "path law", "moments", "at least one", "none");
    // Terms of order n fall like the largest of chi_l^n that is not smooth, l = 3 and more.
    for (std::size_t l = 3; l < chi_.size(); ++l) largest_ = std::max(largest_, std::abs(chi_[l]));
    constexpr double negligible = 1e-9;
    while (order_count_ < max_count &&
           2 * smooth_moments * std::pow(largest_, order_count_) > negligible * order_count_)
        ++order_count_;

    constexpr double never_matters = 1e-18;
    std::vector<double> power = chi_, smooth;  // chi_l^n and r_l^n
    for (std::size_t l = 0; l < chi_.size(); ++l) smooth.push_back(smooth_moment(l));
    std::size_t count = chi_.size();
    for (int n = 2; n < order_count_; ++n) {
        for (std::size_t l = 0; l < count; ++l) {
            power[l] *= chi_[l];
            smooth[l] *= smooth_moment(l);
        }
        while (count > 1 && std::abs(power[count - 1]) < never_matters) --count;
        std::vector<double>& coefficient = coefficients_.emplace_back(count);
        for (std::size_t l = 0; l < count; ++l)
            coefficient[l] = (2 * static_cast<double>(l) + 1) * (power[l] - smooth[l]);
    }
}

PathOrders::PathOrders(const PathLaw& law)
    : order_count_(law.order_count()), deepest_(std::min(4000.0, 14 / (1 - law.largest_moment()))) {
    // The width of the peak of order 2 is about that of the last moment that matters to it.
    const std::vector<double>& chi = law.moments();
    std::size_t last = 0;
    for (std::size_t l = 0; l < chi.size(); ++l)
        if (std::abs(chi[l]) > 0.03) last = l;
    offset_ = static_cast<float>(
        std::exp2(std::floor(std::log2(0.1 / std::pow(static_cast<double>(last + 1), 2)))));
    angles_ = octave_index(offset_, angle_bits, 1 + offset_) + 2;

    const auto orders = size(order_count_ - 2), stride = size(angles_);
    std::vector<double> sums[2];  // of even and of odd moments, the latter odd in x, too
    for (std::vector<double>& sum : sums) sum.resize(orders * stride);
    std::vector<double> x(stride), before(stride), here(stride, 1.0);  // P_l-1 and P_l
    for (std::size_t k = 0; k < stride; ++k)
        x[k] = 1 - (octave_sample(offset_, angle_bits, static_cast<int>(k)) - double{offset_});
    for (std::size_t l = 0; l < chi.size(); ++l) {
        for (std::size_t n = 0; n < orders; ++n) {
            const std::vector<double>& coefficients = law.legendre(static_cast<int>(n) + 2);
            if (l >= coefficients.size()) break;  // those of higher orders are fewer still
            const double c = coefficients[l];
            double* const row = &sums[l % 2][n * stride];
            for (std::size_t k = 0; k < stride; ++k) row[k] += c * here[k];
        }
        const double order = static_cast<double>(l);
        for (std::size_t k = 0; k < stride; ++k) {
            const double next =
                ((2 * order + 1) * x[k] * here[k] - order * before[k]) / (order + 1);
            before[k] = std::exchange(here[k], next);
        }
    }
    for (const double sign : {1.0, -1.0})  // forward, and backward
        for (std::size_t k = 0; k < stride; ++k)
            for (std::size_t n = 0; n < orders; ++n)
                samples_.push_back(
                    static_cast<float>((sums[0][n * stride + k] + sign * sums[1][n * stride + k]) *
                                       octave_sample(offset_, angle_bits, static_cast<int>(k))));
}

PathOrders::PathOrders(float offset, double deepest, int order_count, std::vector<float> samples)
    : order_count_(order_count), deepest_(deepest), offset_(offset), samples_(std::move(samples)) {
    int exponent;
    require(offset >= 1e-12f && offset <= 1 && std::frexp(offset, &exponent) == 0.5f, "path law",
            "offset", "a power of two in [1e-12, 1]", offset);
    require(deepest >= 1 && deepest <= 4000, "path law", "deepest", "in [1, 4000]", deepest);
    require(order_count > 2 && order_count <= max_count, "path law", "orders",
            "in [3, " + std::to_string(max_count) + "]", order_count);
    angles_ = octave_index(offset_, angle_bits, 1 + offset_) + 2;
    const auto angles = 2 * size(angles_);
    require(samples_.size() == angles * size(order_count - 2), "path law", "samples",
            "those of " + std::to_string(angles) + " angles", samples_.size());
}

std::shared_ptr<const PathOrders> PathOrders::of(const PhaseFunction& phase_function) {
    if (!has_narrow_peak(phase_function)) return {};
    std::vector<double> moments = significant_moments(phase_function);
    if (moments.empty()) return {};
    return std::make_shared<const PathOrders>(PathLaw(std::move(moments)));
}

std::shared_ptr<const PathOrders> PathOrders::of_any(const PhaseFunction& phase_function) {
    return std::make_shared<const PathOrders>(PathLaw(significant_moments(phase_function)));
}

double PathLaw::smooth_moment(std::size_t l) const noexcept {
    constexpr double first = first_smoothed, last = smooth_moments;
    const double u = std::clamp((static_cast<double>(l) - first) / (last - first), 0.0, 1.0);
    return l < chi_.size() ? chi_[l] * (1 - u * u * (3 - 2 * u)) : 0;
}

std::vector<double> PathLaw::legendre(const PathWeights& weights) const {
    const int orders = std::min(weights.count, order_count_);
    std::vector<double> sum(orders > 2 ? legendre(2).size() : 0);  // the most of any order
    for (int n = 2; n < orders; ++n) {
        const double weight = weights.of_order[n];
        const std::vector<double>& coefficients = legendre(n);
        for (std::size_t l = 0; l < coefficients.size(); ++l) sum[l] += weight * coefficients[l];
    }
    return sum;
}

double PathOrders::operator()(const PathWeights& weights, double forward,
                              double backward) const noexcept {
    const float x = static_cast<float>(std::min(forward, backward)) + offset_;
    const int at = std::clamp(octave_index(offset_, angle_bits, x), 0, angles_ - 2);
    const double low = octave_sample(offset_, angle_bits, at);
    const double high = octave_sample(offset_, angle_bits, at + 1);
    const double share = (double{x} - low) / (high - low);
    const float* const here = of_angle(at + (forward <= backward ? 0 : angles_));
    const float* const next = here + order_count_ - 2;
    const double* const weight = weights.of_order + 2;
    const int orders = std::max(0, std::min(weights.count, order_count_) - 2);
    const double low_sum = weighted_sum(weight, here, orders);
    return (low_sum + share * (weighted_sum(weight, next, orders) - low_sum)) / double{x};
}

double PathOrders::operator()(Side side, double albedo, double optical_depth,
                              const Geometry& geometry, int highest_order) const noexcept {
    const int count = highest_order > 0 ? std::min(order_count_, highest_order + 1) : order_count_;
    PathWeights weights = path_weights(side, count, optical_depth, geometry.mu_in, geometry.mu_out);
    double power = albedo;
    for (int n = 1; n < weights.count; ++n, power *= albedo) weights.of_order[n] *= power;
    const double cosine = cos_scattering_angle(side, geometry);
    return (*this)(weights, 1 - cosine, 1 + cosine);
}

PathSheet::PathSheet(const PathOrders& law, const double* albedo, int channels, int highest_order,
                     int divided)
    : offset_(law.offset()), angles_(law.angle_count()) {
    const int count =
        highest_order > 0 ? std::min(law.order_count(), highest_order + 1) : law.order_count();
    const int octaves =
        static_cast<int>(std::ceil(std::log2(1 + law.deepest() / double{depth_offset})));
    depths_ = (octaves << depth_bits) + 1;
    const auto orders = size(std::max(0, count - 2)), held_rows = size(channels * depths_),
               rows = held_rows + size(channels),  // and the limits of H
        columns = 4 * size(angles_);
    samples_.resize(held_rows * columns);
    if (orders == 0) return;
    samples_.resize(rows * columns);
    // Over (channel, depth, order): what f_n is multiplied by for H, from `deep` on less its limit, and
    // for dH/ds.
    constexpr double deep = 8;
    const auto depth = [](int d) {
        return octave_sample(depth_offset, depth_bits, d) - double{depth_offset};
    };
    std::vector<float> weight(rows * orders * 2);
    std::vector<int> used(rows);
    for (int d = 0; d <= depths_; ++d) {
        const bool is_limit = d == depths_, is_deep = !is_limit && depth(d) >= deep;
        const Meetings at(count, is_limit ? infinity : depth(d));
        for (int c = 0; c < channels; ++c) {
            const auto row = is_limit ? held_rows + size(c) : size(c * depths_ + d);
            float* to = &weight[row * orders * 2];
            double power = std::pow(albedo[c], 1 - divided);
            for (int n = 2; n < count; ++n) {
                power *= albedo[c];
                const double share = is_deep ? -at.fewer[n] : at.more[n];
                const auto value = static_cast<float>(power / n * share);
                const auto rise = static_cast<float>(power / n * at.slope[n]);
                if (!is_deep && value < 1e-12f && rise < 1e-12f) break;
                *to++ = value;
                *to++ = rise;
                ++used[row];
            }
        }
    }
    std::vector<float> twice(orders * columns);  // f_n over (order, angle), for H and dH/ds
    for (std::size_t n = 0; n < orders; ++n)
        for (std::size_t angle = 0; 2 * angle < columns; ++angle)
            twice[n * columns + 2 * angle] = twice[n * columns + 2 * angle + 1] =
                law.of_angle(static_cast<int>(angle))[n];
    chosen_functions<PathSums>().sums({twice.data(), columns, orders}, weight.data(), used.data(),
                                      rows, samples_.data());
    for (std::size_t row = 0; row < held_rows; ++row) {
        const auto depths = size(depths_);
        if (depth(static_cast<int>(row % depths)) >= deep) continue;
        const float* const limit = &samples_[(held_rows + row / depths) * columns];
        for (std::size_t k = 0; k < columns; k += 2) samples_[row * columns + k] -= limit[k];
    }
    samples_.resize(held_rows * columns);
}

PathSheetView PathSheet::view() const noexcept {
    if (samples_.empty()) return {};
    return make_view(samples_.data(), offset_, angles_, depths_);
}

PathSheetView PathSheet::make_view(const float* samples, float offset, int angles,
                                   int depths) noexcept {
    PathSheetView view;
    view.sample = samples;
    view.offset = offset;
    view.first_angle = to_bits(offset) >> (mantissa_bits - PathOrders::angle_bits);
    view.angles = angles;
    view.last_depth =
        static_cast<float>(octave_sample(depth_offset, depth_bits, depths - 1)) * (1 - 1e-6f);
    view.channel = 4 * angles * depths;
    return view;
}

}  // namespace stratus
