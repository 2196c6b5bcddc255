#pragma once

#include <stratus/bake/forecast.h>

#include "resolve.h"

namespace stratus {

/// The size of a table.
struct TableSize {
    double layers, samples_a_side, bytes;
};

TableSize size_of(const Recipe& resolved);

/// The forecast of a resolved recipe; with ranks, which would wait for it, without times.
Forecast forecast_of(const Resolution& resolution, const BakeOptions& options);

}  // namespace stratus
