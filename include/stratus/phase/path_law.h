// The path law: multiple scattering near forward, in closed form.
//
// Light that is scattered n times by small angles, and turned once by any of the n, keeps to a path
// of the slant depth s of single scattering. Whichever the turn, its Legendre moments are those of
// the phase function to the power of n:
//
//     R_n = w^n P(n, tau/mu + tau/mu0) / n / (4 (mu + mu0))          f_n(Theta)
//     T_n = w^n [P(n, tau/mu0) - P(n, tau/mu)] / n / (4 (mu - mu0))  f_n(Theta)
//     f_n = sum_l (2l+1) chi_l^n P_l(cos Theta)
//
// with P(n, s) the regularised incomplete gamma function: the share of the light that meets n
// particles or more in s. n = 1 is single scattering, exact; orders n >= 2 are right for what is
// scattered by narrow angles alone. What the smooth part of a phase function scatters, with the
// moments r_l = b(l) chi_l, is therefore left out,
//
//     f_n = sum_l (2l+1) (chi_l^n - r_l^n) P_l(cos Theta),   n >= 2,
//
// b falling from 1 at l = 2 to 0 at l = 16. What remains of orders n >= 2 is smooth: tables hold
// that (table.h), and every lookup adds the path law. For phase functions of few moments there is
// none.
#pragma once

#include <stratus/base/direction.h>
#include <stratus/phase/phase_function.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace stratus {

/// Factors of f_n, n = 0 .. count - 1; 0 for n = 0. Orders from `count` on add nothing.
struct PathWeights {
    static constexpr int max_count = 1025;
    int count = 0;
    double of_order[max_count];
};

/// P(n, tau/mu + tau/mu0) / n / (4 (mu + mu0)) for R, [P(n, tau/mu0) - P(n, tau/mu)] / n /
/// (4 (mu - mu0)) for T: all but the albedo.
///
/// Range    count [2, PathWeights::max_count], optical_depth [0, inf], cosines (0, 1]. Along short
///          paths fewer orders are given: those left out add less than 1e-16 of order 2.
/// Accuracy 1e-8 of the value, 1e-12 where mu and mu0 differ by little or much.
PathWeights path_weights(Side side, int count, double optical_depth, double mu_in,
                         double mu_out) noexcept;

/// Moments that the path law of a table has at most: Henyey-Greenstein needs them at g = 0.998.
constexpr int most_table_moments = 8192;

/// Moments of a phase function until they are negligible; none where `most` do not suffice.
std::vector<double> significant_moments(const PhaseFunction& phase_function,
                                        int most = most_table_moments);

/// True where moments beyond 32 show, and are those of a forward peak: (2l+1) chi_l is 0.2 or more
/// at l = 32 (Henyey-Greenstein: g from 0.84 on).
bool has_narrow_peak(const PhaseFunction& phase_function);

/// At smaller cosines the path bends away from the surface: the law still is what lookups add, but
/// what it leaves is not smooth. Tables and slices answer for their accuracy from here on.
constexpr double least_path_cosine = 0.15;

/// The law of one phase function, from its moments: exact.
class PathLaw {
  public:
    /// b(l) falls from 1 at the first to 0 at the second: r_l = 0 from there on.
    static constexpr int first_smoothed = 2, smooth_moments = 16;

    /// Range    chi_0 .. , as far as they matter.
    explicit PathLaw(std::vector<double> moments);

    const std::vector<double>& moments() const noexcept { return chi_; }

    /// r_l = b(l) chi_l.
    double smooth_moment(std::size_t l) const noexcept;

    /// Orders below this matter, at albedo 1 and any depth.
    int order_count() const noexcept { return order_count_; }

    /// The largest of chi_l, l >= 3, those that are not smooth.
    double largest_moment() const noexcept { return largest_; }

    /// Legendre coefficients of f_n, n >= 2, as far as they matter; the factor 2l + 1 included.
    const std::vector<double>& legendre(int n) const {
        return coefficients_[static_cast<std::size_t>(n - 2)];
    }

    /// The sum of weights times them.
    std::vector<double> legendre(const PathWeights& weights) const;

  private:
    std::vector<double> chi_;
    std::vector<std::vector<double>> coefficients_;  // over n
    double largest_ = 0;
    int order_count_ = 2;
};

/// f_n tabulated over angle: for any layer, one lookup at a time.
///
/// Angles are evenly spaced within each octave of x + offset, x the smaller of 1 - cos Theta and
/// 1 + cos Theta: those of the forward half first, then those of the backward half.
class PathOrders {
  public:
    static constexpr int angle_bits = 5;  // 2^5 angles to an octave

    explicit PathOrders(const PathLaw& law);

    /// One that was tabulated before; `samples` over (half and angle, order).
    ///
    /// Errors   std::invalid_argument for numbers that belong to none.
    PathOrders(float offset, double deepest, int order_count, std::vector<float> samples);

    /// Null for a phase function without a narrow peak, or with one too narrow for 8192 moments.
    static std::shared_ptr<const PathOrders> of(const PhaseFunction& phase_function);
    /// Same, without the narrow-peak test.
    static std::shared_ptr<const PathOrders> of_any(const PhaseFunction& phase_function);

    /// The sum of weights times f_n, n >= 2, at 1 - cos Theta and 1 + cos Theta, each accurate
    /// where it is small. Linear between angles: to 4e-4 of its value.
    double operator()(const PathWeights& weights, double forward, double backward) const noexcept;

    /// R (T) of the path law at one geometry; `highest_order` 0: all orders.
    double operator()(Side side, double albedo, double optical_depth, const Geometry& geometry,
                      int highest_order) const noexcept;

    int order_count() const noexcept { return order_count_; }
    /// Slant depth beyond which no order of the law gains any more, at albedo 1.
    double deepest() const noexcept { return deepest_; }
    float offset() const noexcept { return offset_; }
    int angle_count() const noexcept { return angles_; }  // of either half
    /// (x + offset) f_n at an angle of either half, n from 2.
    const float* of_angle(int angle) const noexcept {
        return samples_.data() + static_cast<std::ptrdiff_t>(angle) * (order_count_ - 2);
    }

  private:
    int order_count_, angles_;
    double deepest_;
    float offset_;
    std::vector<float> samples_;
};

/// The samples of the path law that a bound lookup reads; trivially copyable.
struct PathSheetView {
    const float* sample = nullptr;  // null: no path law
    float offset = 1;               // as in PathOrders
    std::int32_t first_angle = 0;   // place of the first angle of a half, and angles of a half
    int angles = 0;
    float last_depth = 2;  // 2 + s of the last sample, less rounding
    int channel = 0;       // samples from one channel to the next
};

/// The path law of layers of one albedo or several, for all depths: H and dH/ds over slant depth and
/// angle, H(s, Theta) = sum_n w^n P(n, s) / n f_n(Theta), in single precision. H is held less its limit
/// for s to infinity, which it comes near to in deep layers, whose T is its slope.
///
/// Depths are evenly spaced within each octave of 2 + s, 2^4 to an octave, up to where H has
/// reached its limit. Joined by cubics in depth, by straight lines in angle.
class PathSheet {
  public:
    static constexpr int depth_bits = 4;
    static constexpr float depth_offset = 2;  // a power of 2

    PathSheet() = default;

    /// `highest_order` 0: all orders. Order n is multiplied by w^(n - divided).
    PathSheet(const PathOrders& law, const double* albedo, int channels, int highest_order,
              int divided = 0);

    PathSheetView view() const noexcept;
    std::size_t sample_count() const noexcept { return samples_.size(); }

    /// The view of samples that lie elsewhere.
    static PathSheetView make_view(const float* samples, float offset, int angles,
                                   int depths) noexcept;

  private:
    float offset_ = 1;
    int angles_ = 0, depths_ = 0;
    // (x + offset) {H less its limit, dH/ds} over (channel, depth, angle)
    std::vector<float> samples_;
};

}  // namespace stratus
