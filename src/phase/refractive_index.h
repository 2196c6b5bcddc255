// Rows of indices of refraction n + i k, and what lies between them.
#pragma once

#include <stratus/phase/phase_function.h>

#include <complex>
#include <cstddef>

namespace stratus {

struct IndexRow {
    double wavelength, n, k;  // wavelength in vacuum, um
};

struct IndexRows {
    const IndexRow* first;
    std::size_t count;
};

/// The rows of liquid water.
IndexRows water_rows();

/// Interpolates n and ln k by monotone cubics in the logarithm of the wavelength, and passes through
/// every row. Beside a row with k = 0, k itself is interpolated, linearly.
///
/// Range  two rows or more, ascending; a wavelength within them.
std::complex<double> interpolated_index(IndexRows rows, double wavelength);

/// Interpolates likewise in a file with the columns wavelength_um, n and k.
///
/// Errors  std::invalid_argument naming the file and its line, what is allowed and what was met; for
///         fewer than two rows, and for a wavelength beyond them.
std::complex<double> index_of_file(const PhaseColumns& columns, double wavelength);

}  // namespace stratus
