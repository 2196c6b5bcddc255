// Indices of refraction of water and ice from the ultraviolet to the middle infrared, and of what
// users bring in files.
#include "mie_scattering.h"

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace stratus {
namespace {

constexpr IndexRow water[] = {
#include "water_rows.inc"
};
constexpr IndexRow ice[] = {
#include "ice_rows.inc"
};

void require_wavelength(double wavelength, double first, double last, const std::string& where) {
    require(wavelength >= first && wavelength <= last, "mie", "wavelength",
            "in [" + shortest_text(first) + ", " + shortest_text(last) + "] um" + where,
            wavelength);
}

/// The row that ends the interval of a wavelength.
const IndexRow* row_above(const IndexRow* begin, const IndexRow* end, double wavelength) {
    return std::lower_bound(begin + 1, end - 1, wavelength,
                            [](const IndexRow& row, double here) { return row.wavelength < here; });
}

/// The share of the way from one row to the next, in the logarithm of the wavelength.
double share_of_way(const IndexRow& from, const IndexRow& to, double wavelength) {
    return std::log(wavelength / from.wavelength) / std::log(to.wavelength / from.wavelength);
}

/// Between rows of ice n and the logarithm of k are linear in the logarithm of the wavelength.
std::complex<double> index_of_ice(double wavelength) {
    require_wavelength(wavelength, ice[0].wavelength, 4, " in ice");
    const IndexRow* const above = row_above(std::begin(ice), std::end(ice), wavelength);
    const IndexRow &a = above[-1], &b = *above;
    const double t = share_of_way(a, b, wavelength);
    return {a.n + t * (b.n - a.n), a.k * std::pow(b.k / a.k, t)};
}

/// The rows about an interval: `at[1]` and `at[2]` are its ends, the others the rows next to these,
/// or none.
struct NeighbourRows {
    const IndexRow* at[4];
};

/// The slope of a monotone cubic where two intervals meet: the weighted harmonic mean of their
/// secants, 0 where these differ in sign. F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5,
/// 300 (1984).
double monotone_slope(double width_before, double secant_before, double width_after,
                      double secant_after) {
    if (secant_before * secant_after <= 0) return 0;
    const double weight_before = width_before + 2 * width_after;
    const double weight_after = 2 * width_before + width_after;
    return (weight_before + weight_after) /
           (weight_before / secant_before + weight_after / secant_after);
}

/// Interpolates `row_value` of the rows by a monotone cubic in the logarithm of the wavelength, which
/// must lie between the middle two. At the ends of the table the slope is that of the secant.
template <class ValueOf>
double interpolated(const NeighbourRows& rows, double wavelength, const ValueOf& row_value) {
    const auto width = [&](int i) {
        return std::log(rows.at[i + 1]->wavelength / rows.at[i]->wavelength);
    };
    const auto secant = [&](int i) {
        return (row_value(*rows.at[i + 1]) - row_value(*rows.at[i])) / width(i);
    };
    const double within = secant(1), h = width(1);
    const double slope_a =
        rows.at[0] == nullptr ? within : monotone_slope(width(0), secant(0), width(1), within);
    const double slope_b =
        rows.at[3] == nullptr ? within : monotone_slope(width(1), within, width(2), secant(2));
    const double t = std::log(wavelength / rows.at[1]->wavelength) / h;
    const double a = row_value(*rows.at[1]), b = row_value(*rows.at[2]);
    return a + t * t * (3 - 2 * t) * (b - a) + t * (1 - t) * h * ((1 - t) * slope_a - t * slope_b);
}

}  // namespace

IndexRows water_rows() { return {water, std::size(water)}; }

std::complex<double> interpolated_index(IndexRows rows, double wavelength) {
    const IndexRow* const end = rows.first + rows.count;
    const IndexRow* const above = row_above(rows.first, end, wavelength);
    for (const IndexRow* row : {above - 1, above})
        if (row->wavelength == wavelength) return {row->n, row->k};
    NeighbourRows about{{above - 1 == rows.first ? nullptr : above - 2, above - 1, above,
                         above + 1 == end ? nullptr : above + 1}};
    const double n = interpolated(about, wavelength, [](const IndexRow& row) { return row.n; });
    if (above[-1].k == 0 || above->k == 0) {
        const double t = share_of_way(above[-1], *above, wavelength);
        return {n, (1 - t) * above[-1].k + t * above->k};
    }
    for (const IndexRow*& row : about.at)  // the logarithm ends where there is none
        if (row != nullptr && row->k == 0) row = nullptr;
    return {n, std::exp(interpolated(about, wavelength,
                                     [](const IndexRow& row) { return std::log(row.k); }))};
}

std::complex<double> index_of_file(const PhaseColumns& columns, double wavelength) {
    std::vector<IndexRow> rows;
    for (std::size_t i = 0; i < columns.values[0].size(); ++i) {
        rows.push_back({columns.values[0][i], columns.values[1][i], columns.values[2][i]});
        const IndexRow& row = rows.back();
        const std::string here = columns.row_name(i);
        require(row.wavelength > 0 && std::isfinite(row.wavelength), "mie", "wavelength_um" + here,
                "above 0 and finite", row.wavelength);
        require(i == 0 || row.wavelength > rows[i - 1].wavelength, "mie", "wavelength_um" + here,
                "above the one before it", row.wavelength);
        require_in("(0, 10]", "mie", "n" + here, row.n);
        require_in("[0, 10]", "mie", "k" + here, row.k);
    }
    require(rows.size() >= 2, "mie", "index file " + columns.name, "of at least 2 rows",
            rows.size());
    require_wavelength(wavelength, rows.front().wavelength, rows.back().wavelength,
                       ", the rows of " + columns.name);
    return interpolated_index({rows.data(), rows.size()}, wavelength);
}

std::complex<double> index_of_refraction(const Droplets& droplets) {
    const double wavelength = droplets.wavelength;
    switch (droplets.material) {
        case Droplets::Material::water:
            require_wavelength(wavelength, std::begin(water)->wavelength,
                               std::prev(std::end(water))->wavelength, " in water");
            return interpolated_index(water_rows(), wavelength);
        case Droplets::Material::ice: return index_of_ice(wavelength);
        case Droplets::Material::other: break;
    }
    return droplets.index;
}

}  // namespace stratus
