#include "convergence.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

namespace {

// Set by bench/tolerance_bench.cpp: 99 % of errors below 1.5 times their estimate.
constexpr double least_decay = 0.4, most_decay = 0.8, least_share = 1;
constexpr double rounding = 1e-13;

}  // namespace

void Convergence::add(std::vector<double> values) {
    if (values_.size() == most_levels) values_.erase(values_.begin());
    values_.push_back(std::move(values));
}

std::vector<double> Convergence::changes(std::size_t level) const {
    const std::vector<double>&now = values_[level], &before = values_[level - 1];
    std::vector<double> all(now.size());
    for (std::size_t i = 0; i < now.size(); ++i)
        if (now[i] != 0) all[i] = std::abs(now[i] - before[i]) / std::abs(now[i]);
    return all;
}

double Convergence::mean_change(std::size_t level) const {
    double sum = 0;
    std::size_t count = 0;
    for (const double change : changes(level)) {
        sum += std::sqrt(change);
        if (change > 0) ++count;
    }
    return std::pow(sum / static_cast<double>(std::max<std::size_t>(1, count)), 2) + rounding / 100;
}

double Convergence::decay() const {
    const std::size_t last = values_.size() - 1;
    return std::pow(mean_change(last) / mean_change(1), 1 / static_cast<double>(last - 1));
}

std::vector<double> Convergence::errors() const {
    const std::vector<double>& values = values_.back();
    std::vector<double> share(values.size(), least_share);
    for (std::size_t level = 1; level < values_.size(); ++level) {
        const std::vector<double> change = changes(level);
        const double mean = mean_change(level);
        for (std::size_t i = 0; i < change.size(); ++i)
            share[i] = std::max(share[i], change[i] / mean);
    }
    const double q = std::clamp(decay(), least_decay, most_decay);
    const double left = mean_change(values_.size() - 1) * q / (1 - q);
    std::vector<double> errors;
    for (std::size_t i = 0; i < values.size(); ++i)
        errors.push_back((share[i] * left + rounding) * std::abs(values[i]));
    return errors;
}

}  // namespace stratus
