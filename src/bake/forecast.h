#pragma once

#include <stratus/bake/forecast.h>

#include "resolve.h"

namespace stratus {

/// The forecast of a resolved recipe; with ranks, which would wait for it, without times.
Forecast forecast_of(const Resolution& resolution, const BakeOptions& options);

}  // namespace stratus
