#include "cosine_series.h"

#include <stratus/base/constants.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace stratus {
namespace {

constexpr int fewest_intervals = 32, most_intervals = 8192;

/// A function at azimuths j pi / intervals, and its series as far as it was worked out.
class Series {
  public:
    explicit Series(std::vector<double> values) : values_(std::move(values)), rest_(values_) {}

    /// Adds the next term.
    void extend(const std::vector<double>& cosine) {
        const std::size_t intervals = values_.size() - 1, k = terms_.size();
        const auto cosine_at = [&](std::size_t j) { return cosine[k * j % (2 * intervals)]; };
        double sum = (values_.front() + values_.back() * cosine_at(intervals)) / 2;
        for (std::size_t j = 1; j < intervals; ++j) sum += values_[j] * cosine_at(j);
        const double term = sum * (k == 0 ? 1 : 2) / static_cast<double>(intervals);
        for (std::size_t j = 0; j <= intervals; ++j) rest_[j] -= term * cosine_at(j);
        terms_.push_back(term);
    }

    bool is_within(double tolerance) const {
        const double floor = 1e-3 * std::abs(terms_[0]);
        for (std::size_t j = 0; j < values_.size(); ++j)
            if (std::abs(rest_[j]) > tolerance * std::max(values_[j], floor)) return false;
        return true;
    }

    const std::vector<double>& terms() const { return terms_; }

  private:
    std::vector<double> values_, rest_, terms_;
};

/// All series within the tolerance, of as many terms as half the intervals at most; empty where
/// more are needed.
std::vector<std::vector<double>> try_series(const AzimuthValues& values, int intervals,
                                            double tolerance) {
    std::vector<double> azimuths, cosine;
    for (int j = 0; j <= intervals; ++j) azimuths.push_back(j * pi / intervals);
    for (int j = 0; j < 2 * intervals; ++j) cosine.push_back(std::cos(j * pi / intervals));
    std::vector<Series> all;
    for (std::vector<double>& of : values(azimuths)) all.emplace_back(std::move(of));
    for (int count = 1; count <= intervals / 2; ++count) {
        bool within = true;
        for (Series& series : all) {
            series.extend(cosine);
            within = within && series.is_within(tolerance);
        }
        if (!within) continue;
        std::vector<std::vector<double>> terms;
        for (const Series& series : all) terms.push_back(series.terms());
        return terms;
    }
    return {};
}

}  // namespace

std::vector<std::vector<double>> cosine_series(const AzimuthValues& values, double tolerance) {
    for (int intervals = fewest_intervals; intervals <= most_intervals; intervals *= 2) {
        std::vector<std::vector<double>> found = try_series(values, intervals, tolerance);
        if (found.empty()) continue;
        const bool dark = std::all_of(found.begin(), found.end(),
                                      [](const auto& terms) { return !(terms[0] > 0); });
        return dark ? std::vector<std::vector<double>>() : found;
    }
    throw std::runtime_error(
        "export: the phase function is too narrow for cosine series of 4096 terms");
}

}  // namespace stratus
