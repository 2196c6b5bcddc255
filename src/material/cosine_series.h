// Even functions of azimuth as cosine series, as short as a relative error allows.
#pragma once

#include <functional>
#include <vector>

namespace stratus {

/// Values of several functions at azimuths: over (function, azimuth).
using AzimuthValues =
    std::function<std::vector<std::vector<double>>(const std::vector<double>& azimuths)>;

/// f = sum_k a_k cos(k azimuth) of each function, all equally long: within `tolerance` of every
/// value, or of a thousandth of the mean where that is more. Empty where no mean is above 0.
///
/// Errors   std::runtime_error where 4,096 terms do not suffice.
std::vector<std::vector<double>> cosine_series(const AzimuthValues& values, double tolerance);

}  // namespace stratus
