#include "slice_parts.h"

#include <stratus/base/size.h>
#include <stratus/layer/single_scattering.h>

#include "table/layer_blend.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stratus {
namespace {

/// Shares of the tolerance that straight lines and that cubics may use along an axis; half as much
/// with a path law, for the directions near forward, which are judged apart, are few among all.
constexpr double share_of_lines = 0.25, share_of_cubics = 0.15;

// Intervals along an axis: while errors are measured, and of the slice. Cosines that took more straight
// lines than these are interpolated by cubics.
constexpr int probed_along_mu = 32, fewest_along_mu = 16, most_lines = 144, most_cubics = 256,
              fewest_along_azimuth = 4, max_along_azimuth = 512;

/// The coordinate along which fast lookups sample cosines evenly (base/interpolation.h): it falls from 1
/// at grazing to 0 at the normal.
double v_at(double mu) { return std::sqrt(1 - mu) * (1 - std::sqrt(std::sqrt(mu)) / 2); }

/// The inverse of `v_at`.
double mu_at(double v) {
    // v = s g(q) of s = sqrt(1 - q), q = mu^(1/4), nearly s itself: Newton's method doubles the
    // digits of each step, two to begin with.
    double s = v;
    for (int i = 0; i < 5; ++i) {
        const double q = 1 - s * s, p = (1 + q) * (1 + q * q), root = std::sqrt(p);
        const double g = root * (1 - q / 2);
        const double slope = (1 + 2 * q + 3 * q * q) / (2 * root) * (1 - q / 2) - root / 2;
        s -= (s * g - v) / (g - 2 * s * s * slope);
    }
    const double root = 1 - s * s;
    return root * root * root * root;
}

/// Values over three axes, the last contiguous.
struct Sheet {
    int count[3];
    std::vector<float> value;

    Sheet(int a, int b, int c) : count{a, b, c}, value(size(a) * size(b) * size(c)) {}

    int rows() const { return count[0] * count[1]; }
    /// The n-th of all rows.
    float* row(int n) { return &value[size(n) * size(count[2])]; }
    const float* row(int n) const { return &value[size(n) * size(count[2])]; }
    const float* row(int i, int j) const { return row(i * count[1] + j); }
};

/// Places of a slice along an axis, evenly spaced in the coordinate of its lookups, and the values there.
struct EvenPlaces {
    double first, step;
    int intervals;
    std::vector<double> value = {};
};

/// Cosines, from the table's largest to its smallest.
EvenPlaces cosine_places(const AxisView& axis, int intervals) {
    const double first = v_at(axis.highest);
    EvenPlaces places{first, (v_at(axis.lowest) - first) / intervals, intervals};
    for (int i = 0; i <= intervals; ++i) places.value.push_back(mu_at(first + places.step * i));
    return places;
}

/// Azimuths over sin(azimuth / 2), between the ends of the table's.
EvenPlaces azimuth_places(const AxisView& axis, int intervals) {
    const double first = std::sin(axis.lowest / 2), length = std::sin(axis.highest / 2) - first;
    EvenPlaces places{first, length / intervals, intervals};
    for (int k = 0; k <= intervals; ++k)
        places.value.push_back(2 * std::asin(std::min(1.0, first + length * k / intervals)));
    return places;
}

/// Samples of an axis and their weights, for each place of a finer one.
using Stencils = std::vector<Stencil>;

Stencils stencils_at(const EvenPlaces& places, const AxisView& axis,
                     Stencil (AxisView::*stencil)(double) const noexcept = &AxisView::stencil) {
    Stencils all;
    for (const double value : places.value) all.push_back((axis.*stencil)(value));
    return all;
}

/// Fills the cells before and after `count` of a row, each of `numbers` and `step` apart, where `row` is the
/// first: cubics of the outer intervals are those of their neighbours.
void extend(float* row, int count, std::size_t step, std::size_t numbers) {
    const auto beyond = [&](float* to, float* a, float* b, float* c, float* d) {
        for (std::size_t k = 0; k < numbers; ++k) to[k] = 4 * (a[k] + c[k]) - 6 * b[k] - d[k];
    };
    const auto at = [&](int n) { return row + size(n) * step; };
    beyond(at(0), at(1), at(2), at(3), at(4));
    beyond(at(count + 1), at(count), at(count - 1), at(count - 2), at(count - 3));
}

/// Samples at azimuths, and one beyond either end, which is missing.
void extend_azimuth(float* row, const EvenPlaces& around) {
    extend(row, around.intervals + 1, 1, 1);
    if (around.first == 0) row[0] = row[2];  // light is the same on both sides of azimuth 0
}

/// How lookups find places along an axis.
void set_axis(SlicePlaces& slice, int axis, const EvenPlaces& places) {
    const double scale = places.step > 0 ? 1 / places.step : 0;
    slice.scale[axis] = static_cast<float>(scale);
    slice.offset[axis] = static_cast<float>(-places.first * scale);
    slice.last[axis] = static_cast<float>(places.intervals) * (1 - 1e-6f);
}

/// The sum over a blend, as samples are stored: over (mu_in, mu_out, azimuth), to be multiplied by
/// the directional factor.
Sheet summed(const TableView& table, const ChannelOrders& orders) {
    Sheet sum(table.mu_in.count, table.mu_out.count, table.azimuth.count);
    if (!orders.sheet.empty()) {
        sum.value = orders.sheet;
        return sum;
    }
    const LayerBlend& blend = orders.blend;
    const int columns = table.azimuth.count;
    const auto growth = static_cast<float>(blend.growth);
    for (int n = 0; n < blend.count; ++n) {
        const BlendTerm& term = blend.term[n];
        const float* const in = table.mu_in_weight + term.depth * table.mu_in.count;
        const float* const out = table.mu_out_weight + term.depth * table.mu_out.count;
        const float* from = blend.samples + term.first;
        float* to = sum.value.data();
        for (int i = 0; i < table.mu_in.count; ++i)
            for (int j = 0; j < table.mu_out.count; ++j) {
                const float share = growth * term.share * in[i] * out[j];
                for (int k = 0; k < columns; ++k) *to++ += share * *from++;
            }
    }
    return sum;
}

// Weights beyond a short axis are 0 and count as those of its last sample.

/// A row of values, the sum of four others: row(i) is that of sample i, out of `samples`.
template <class Row>
void sum_rows(const Stencil& stencil, int samples, int columns, const Row& row, float* to) {
    const auto at = [&](int s) -> const float* {
        return row(std::min(stencil.first + s, samples - 1));
    };
    const float *const p = at(0), *const q = at(1), *const r = at(2), *const s = at(3);
    const auto [a, b, c, d] = stencil.weight;
    for (int k = 0; k < columns; ++k) to[k] = a * p[k] + b * q[k] + c * r[k] + d * s[k];
}

/// Cubic along one axis: a row of `samples`.
void refine_row(const float* from, int samples, const Stencils& stencils, float* to) {
    const int last = std::min(stencil_size, samples) - 1;
    for (const Stencil& stencil : stencils) {
        const float *const at = from + stencil.first, *const weight = stencil.weight;
        *to++ = weight[0] * at[0] + weight[1] * at[std::min(1, last)] +
                weight[2] * at[std::min(2, last)] + weight[3] * at[last];
    }
}

/// Cubic along the azimuths of a sheet.
Sheet refined_azimuth(const Sheet& sheet, const EvenPlaces& around, const AxisView& azimuths) {
    const Stencils stencils = stencils_at(around, azimuths, &AxisView::mirrored_stencil);
    Sheet finer(sheet.count[0], sheet.count[1], around.intervals + 3);
    for (int n = 0; n < sheet.rows(); ++n) {
        refine_row(sheet.row(n), sheet.count[2], stencils, finer.row(n) + 1);
        extend_azimuth(finer.row(n), around);
    }
    return finer;
}

/// A sheet of every `step`-th azimuth.
Sheet thinned_azimuth(const Sheet& sheet, int step) {
    Sheet thinner(sheet.count[0], sheet.count[1], (sheet.count[2] - 1) / step + 1);
    for (int n = 0; n < sheet.rows(); ++n)
        for (int k = 0; k < thinner.count[2]; ++k) thinner.row(n)[k] = sheet.row(n)[k * step];
    return thinner;
}

/// With the two cosines exchanged.
Sheet transposed(const Sheet& sheet) {
    Sheet other(sheet.count[1], sheet.count[0], sheet.count[2]);
    for (int n = 0; n < sheet.rows(); ++n)
        std::copy_n(sheet.row(n), sheet.count[2],
                    other.row(n % sheet.count[1] * sheet.count[0] + n / sheet.count[1]));
    return other;
}

Sheet refined_in(const Sheet& sheet, const Stencils& stencils) {
    Sheet finer(static_cast<int>(stencils.size()), sheet.count[1], sheet.count[2]);
    for (int i = 0; i < finer.count[0]; ++i)
        sum_rows(
            stencils[size(i)], sheet.count[0], sheet.count[1] * sheet.count[2],
            [&](int k) { return sheet.row(k, 0); }, finer.row(i * sheet.count[1]));
    return finer;
}

/// Errors relative to the totals at the same places, which are spread evenly over the axes.
class RelativeErrors {
  public:
    void reserve(int count) { errors_.reserve(size(count)); }
    void add(double error, double total) { errors_.push_back({std::abs(error), total}); }

    /// Returns what 99.9 % of the errors stay below, relative to totals of at least `floor`.
    double quantile(double floor) const {
        constexpr int bins = 256, bins_an_octave = 8;  // downwards from `highest`
        constexpr double highest = 16, rare = 1e-3;
        std::size_t count[bins] = {};
        for (const Error& at : errors_) {
            const double ratio = at.error / std::max(at.total, floor);
            if (!(ratio > 0)) continue;
            const double down = bins_an_octave * std::log2(highest / ratio);
            ++count[static_cast<int>(std::clamp(down, 0.0, bins - 1.0))];
        }
        const double exceptions = rare * static_cast<double>(errors_.size());
        int bin = 0;
        for (std::size_t above = count[0];
             static_cast<double>(above) <= exceptions && bin + 1 < bins; above += count[bin])
            ++bin;
        return highest * std::exp2(-static_cast<double>(bin) / bins_an_octave);
    }

  private:
    struct Error {
        double error, total;
    };
    std::vector<Error> errors_;
};

/// Errors along one cosine of straight lines and of cubics, between as many samples as are probed.
struct CosineErrors {
    double lines = 0, cubics = 0;

    void join(const CosineErrors& other) {
        lines = std::max(lines, other.lines);
        cubics = std::max(cubics, other.cubics);
    }
};

/// The error of a cubic between samples `step` apart: 3/128 of the fourth difference.
double cubic_error(const float* at, std::ptrdiff_t step) {
    return (6 * double{*at} - 4 * (double{at[-step]} + double{at[step]}) + double{at[-2 * step]} +
            double{at[2 * step]}) *
           3 / 128;
}

/// Orders n >= 2 of one channel while they are refined.
class Refinement {
  public:
    Refinement(const TableView& table, const ChannelOrders& orders, int channel,
               const SingleScattering& single)
        : table_(table),
          blend_(orders.blend),
          channel_(channel),
          single_(single),
          sheet_(summed(table, orders)) {
        if (!blend_.fades) return;
        for (int n = 0; n < sheet_.rows(); ++n) {
            const auto factor = static_cast<float>(
                directional_factor(table_, blend_, table_.mu_in.value(n / sheet_.count[1]),
                                   table_.mu_out.value(n % sheet_.count[1])));
            for (int k = 0; k < sheet_.count[2]; ++k) sheet_.row(n)[k] *= factor;
        }
    }

    /// Errors between the probed samples along mu_in and mu_out, relative to R or T.
    std::array<CosineErrors, 2> errors() {
        MeasuredErrors of_in, of_out;
        const AxisView &in = table_.mu_in, &out = table_.mu_out;
        double largest = add_errors_along_mu(sheet_, in, out, of_in);
        if (!table_.is_symmetric())
            largest = std::max(largest, add_errors_along_mu(transposed(sheet_), out, in, of_out));
        floor_ = darkest_share * largest;
        const CosineErrors along_in = of_in.quantiles(floor_);
        return {along_in, table_.is_symmetric() ? along_in : of_out.quantiles(floor_)};
    }

    /// Errors between `probed` + 1 samples along azimuth, once those along cosines are known.
    double azimuth_error(int probed) const {
        if (sheet_.count[2] < 2) return 0;
        RelativeErrors errors;
        const EvenPlaces places = azimuth_places(table_.azimuth, probed);
        const Stencils stencils = stencils_at(places, table_.azimuth, &AxisView::mirrored_stencil);
        constexpr int cosine_step = 3;
        std::vector<float> samples(size(probed + 1));
        float* const row = samples.data();
        for (int i = 0; i < sheet_.count[0]; i += cosine_step) {
            const int last = table_.is_symmetric() ? i : sheet_.count[1] - 1;
            for (int j = 0; j <= last; j += cosine_step) {
                const double in = table_.mu_in.value(i), out = table_.mu_out.value(j);
                if (std::min(in, out) < least_cosine()) continue;
                const double factor = divided_by(in) * divided_by(out);
                refine_row(sheet_.row(i, j), sheet_.count[2], stencils, row);
                for (int k = 2; k + 1 < probed; ++k) {
                    const double total =
                        double{row[k]} * factor + single_(channel_, in, out, places.value[size(k)]);
                    errors.add(cubic_error(row + k, 1) * factor, total);
                }
            }
        }
        return errors.quantile(floor_);
    }

    /// All samples, `stride` apart: row i over mu_in holds all mu_out by azimuth; for straight lines
    /// those up to i + 1 where the table is symmetric, for cubics with room for those beyond the ends.
    void write(const EvenPlaces& in, const EvenPlaces& out, const EvenPlaces& around, bool cubic,
               int stride, float* to) const {
        const Stencils rows = stencils_at(in, table_.mu_in),
                       columns = stencils_at(out, table_.mu_out);
        const bool azimuthal = sheet_.count[2] > 1;
        const int azimuths = azimuthal ? around.intervals + 3 : 1;
        const Sheet finer = azimuthal ? refined_azimuth(sheet_, around, table_.azimuth) : sheet_;
        Sheet row(1, finer.count[1], azimuths), cell(1, 1, azimuths);
        const std::size_t cell_size = size(azimuths) * size(stride),
                          row_size = size(out.intervals + 3) * cell_size;
        float* const first = to;
        for (int i = 0; i <= in.intervals; ++i) {
            if (cubic) to = first + size(i + 1) * row_size + cell_size;
            sum_rows(
                rows[size(i)], finer.count[0], finer.count[1] * azimuths,
                [&](int k) { return finer.row(k, 0); }, row.row(0));
            // One column beyond the last of a symmetric row is never read.
            const int last = table_.is_symmetric() && !cubic ? i + 1 : out.intervals;
            for (int j = 0; j <= last; ++j) {
                float* const sums = stride == 1 ? to : cell.row(0);
                sum_rows(
                    columns[size(std::min(j, out.intervals))], finer.count[1], azimuths,
                    [&](int k) { return row.row(k); }, sums);
                if (stride > 1)
                    for (int k = 0; k < azimuths; ++k) to[k * stride] = sums[k];
                to += cell_size;
            }
        }
    }

  private:
    struct MeasuredErrors {
        RelativeErrors lines, cubics;

        CosineErrors quantiles(double floor) const {
            return {lines.quantile(floor), cubics.quantile(floor)};
        }
    };

    /// Adds the errors of a sheet whose first axis is `along`; returns the largest total away from the
    /// horizon.
    double add_errors_along_mu(const Sheet& sheet, const AxisView& along, const AxisView& across,
                               MeasuredErrors& errors) const {
        const EvenPlaces places = cosine_places(along, probed_along_mu);
        const int azimuth_step = std::max(1, (sheet.count[2] - 1) / 4);  // a few are enough
        const Sheet finer =
            refined_in(thinned_azimuth(sheet, azimuth_step), stencils_at(places, along));
        const int columns = finer.count[2];
        errors.lines.reserve(probed_along_mu * sheet.count[1] * columns);
        errors.cubics.reserve(probed_along_mu * sheet.count[1] * columns);
        std::vector<double> others, shares, azimuths;
        for (int j = 0; j < sheet.count[1]; ++j) {
            others.push_back(across.value(j));
            shares.push_back(divided_by(others.back()));
        }
        for (int k = 0; k < columns; ++k)
            azimuths.push_back(table_.azimuth.value(k * azimuth_step));
        double largest = 0;
        for (int i = 1; i < probed_along_mu; ++i) {
            const double mu = places.value[size(i)], share = divided_by(mu);
            for (int j = 0; j < sheet.count[1]; ++j) {
                const double other = others[size(j)], factor = share * shares[size(j)];
                if (std::min(mu, other) < least_cosine()) continue;
                for (int k = 0; k < columns; ++k) {
                    const auto at = [&](int row) { return double{finer.row(row, j)[k]}; };
                    const double total =
                        at(i) * factor + single_(channel_, mu, other, azimuths[size(k)]);
                    errors.lines.add((at(i - 1) - 2 * at(i) + at(i + 1)) / 8 * factor, total);
                    if (i > 1 && i + 1 < probed_along_mu)
                        errors.cubics.add(
                            cubic_error(finer.row(i, j) + k, sheet.count[1] * columns) * factor,
                            total);
                    if (mu >= 0.1 && other >= 0.1) largest = std::max(largest, total);
                }
            }
        }
        return largest;
    }

    double least_cosine() const { return table_.path_law != nullptr ? least_path_cosine : 0; }

    /// Returns the factor of samples along one of the directions.
    double divided_by(double mu) const {
        return table_.has_lower_boundary() ? 1 : intercepted_share(blend_.optical_depth, mu);
    }

    const TableView& table_;
    const LayerBlend& blend_;
    int channel_;
    const SingleScattering& single_;
    Sheet sheet_;
    double floor_ = 0;  // of the totals that errors are relative to
};

}  // namespace

RefinedSamples refine(const TableView& table, const std::vector<ChannelOrders>& channels,
                      const SingleScattering& single) {
    std::vector<Refinement> refinements;
    std::array<CosineErrors, 2> error;  // along mu_in and mu_out
    for (const ChannelOrders& orders : channels) {
        refinements.emplace_back(table, orders, static_cast<int>(refinements.size()), single);
        const std::array<CosineErrors, 2> more = refinements.back().errors();
        for (std::size_t a = 0; a < error.size(); ++a) error[a].join(more[a]);
    }
    const double tolerance = (table.path_law != nullptr ? 0.5 : 1) * kept_tolerance(table);
    const int stride = static_cast<int>(channels.size());
    // Straight lines miss by the square of an interval, cubics by its fourth power.
    const auto lines = [&](const CosineErrors& along) {
        return probed_along_mu * std::sqrt(along.lines / (share_of_lines * tolerance));
    };
    const auto cubics = [&](int probed, double off) {
        return probed * std::sqrt(std::sqrt(off / (share_of_cubics * tolerance)));
    };
    const auto intervals = [&](double count, int fewest, int most) {
        return static_cast<int>(std::clamp<double>(std::ceil(count), fewest, most));
    };
    RefinedSamples refined{};
    refined.cubic = std::max(lines(error[0]), lines(error[1])) > most_lines;
    const auto along_mu = [&](const AxisView& axis, const CosineErrors& along) {
        if (axis.count < 2) return refined.cubic ? 3 : 1;
        return refined.cubic
                   ? intervals(cubics(probed_along_mu, along.cubics), fewest_along_mu, most_cubics)
                   : intervals(lines(along), fewest_along_mu, most_lines);
    };
    const EvenPlaces in = cosine_places(table.mu_in, along_mu(table.mu_in, error[0]));
    const EvenPlaces out = cosine_places(table.mu_out, along_mu(table.mu_out, error[1]));
    // Intervals too coarse to tell are halved: a rainbow may lie between two samples.
    double along_azimuth = 0;
    for (int probed = 32; probed <= max_along_azimuth; probed *= 2) {
        double off = 0;
        for (const Refinement& channel : refinements)
            off = std::max(off, channel.azimuth_error(probed));
        along_azimuth = cubics(probed, off);
        if (along_azimuth <= probed) break;
    }
    const EvenPlaces around = azimuth_places(
        table.azimuth, intervals(along_azimuth, fewest_along_azimuth, max_along_azimuth));
    refined.symmetric = table.is_symmetric();
    refined.columns = out.intervals + (refined.cubic ? 3 : 1);
    refined.azimuths = table.azimuth.count < 2 ? 1 : around.intervals + 3;
    // Rows 0 to `intervals`, the last one column short where they are symmetric, or one more at either end.
    const std::size_t rows = size(in.intervals + (refined.cubic ? 3 : 1));
    const std::size_t cells =
        refined.symmetric && !refined.cubic ? rows * (rows + 3) / 2 : rows * size(refined.columns);
    refined.sample.resize(cells * size(refined.azimuths) * size(stride) + 1);
    float* const first = refined.sample.data();
    for (std::size_t c = 0; c < refinements.size(); ++c)
        refinements[c].write(in, out, around, refined.cubic, stride, first + c);
    if (refined.cubic) {
        const std::size_t cell_size = size(refined.azimuths * stride),
                          row_size = size(refined.columns) * cell_size;
        for (int i = 1; i <= in.intervals + 1; ++i)
            extend(first + size(i) * row_size, out.intervals + 1, cell_size, cell_size);
        extend(first, in.intervals + 1, row_size, row_size);
    }
    set_axis(refined.places, 0, in);
    set_axis(refined.places, 1, out);
    set_axis(refined.places, 2, around);
    return refined;
}

}  // namespace stratus
