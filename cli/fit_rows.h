// Rows of observations: what light each is of, and what a fit makes of it, as text and as a figure.
#pragma once

#include <stratus/fit/layer_model.h>
#include <stratus/picture/residual_plot.h>

#include "query.h"

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace stratus {

std::size_t column_index(const CsvTable& table, const std::string& column);

/// Returns the light that a row observes, and the word for it in the column side.
Light observed_light(const RowDirection& direction);
const char* light_word(Light light);

bool all_are_beams(const Query& rows);

/// Writes the rows with columns model and residual; `model` has a value for each row.
void write_rows(std::ostream& out, const Query& query, const std::vector<double>& model);

/// Returns a figure of the rows, over the wavelength if that is a column, else over the phase angle, or over
/// the emission angle if that takes more values.
ResidualPlot plot_of_rows(const Query& query, const std::vector<double>& model);

}  // namespace stratus
