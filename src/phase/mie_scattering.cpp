#include "mie_scattering.h"

#include <stratus/base/constants.h>
#include <stratus/base/gauss_legendre.h>

#include "kernels/sums.h"

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

using Complex = std::complex<double>;

/// Terms after which the series of a sphere has converged: W. J. Wiscombe, Appl. Opt. 19, 1980.
std::size_t term_count(double x) {
    return static_cast<std::size_t>(x + 4.05 * std::cbrt(x) + 2) + 1;
}

/// An order from which downward recurrences may start with any value. Functions of z fall off above
/// n = |z| over a width of |z|^(1/3); fifteen orders beyond |z|, as is often seen, leave resonances
/// of large spheres wrong.
std::size_t start_of_recurrence(double size, std::size_t count) {
    return std::max(count, static_cast<std::size_t>(size)) +
           static_cast<std::size_t>(8 * std::cbrt(size)) + 15;
}

std::size_t padded(std::size_t terms) { return (terms + mie_lanes - 1) / mie_lanes * mie_lanes; }

// ---- Spheres

/// Coefficients of up to mie_lanes spheres, the last in the lanes beyond.
std::vector<CoefficientLanes> sphere_coefficients(const SphereSize* spheres, std::size_t count,
                                                  Complex m) {
    SphereLanes all;
    double largest = 0;
    for (std::size_t k = 0; k < mie_lanes; ++k) {
        const double x = spheres[std::min(k, count - 1)].x;
        all.x[k] = x;
        all.sine[k] = std::sin(x);
        all.cosine[k] = std::cos(x);
        all.terms[k] = static_cast<double>(term_count(x));
        largest = std::max(largest, x);
    }
    SeriesLength length{term_count(largest), 0, 0};
    length.derivative = start_of_recurrence(std::abs(m) * largest, length.count);
    length.ratio = start_of_recurrence(largest, length.count);
    std::vector<double> scratch(3 * (length.count + 1) * mie_lanes);
    std::vector<CoefficientLanes> series(length.count);
    chosen_functions<SphereSums>().coefficients(all, m.real(), m.imag(), length, scratch.data(),
                                                series.data());
    return series;
}

/// Without their common factors.
struct SectionLanes {
    double extinction[mie_lanes] = {}, scattering[mie_lanes] = {}, forward[mie_lanes] = {};

    CrossSections of(std::size_t k, double x) const {
        return {pi * x * x, 2 * pi * extinction[k], 2 * pi * scattering[k], 4 * pi * forward[k]};
    }
};

SectionLanes sum_series(const std::vector<CoefficientLanes>& series) {
    SectionLanes sum;
    const CoefficientLanes none{};
    for (std::size_t i = 0; i < series.size(); ++i) {
        const CoefficientLanes& at = series[i];
        const CoefficientLanes& next = i + 1 < series.size() ? series[i + 1] : none;
        const double n = static_cast<double>(i + 1), both = 2 * n + 1;
        const double own = both / (n * (n + 1)), across = n * (n + 2) / (n + 1);
        for (std::size_t k = 0; k < mie_lanes; ++k) {
            const double a_re = at.a_re[k], a_im = at.a_im[k];
            const double b_re = at.b_re[k], b_im = at.b_im[k];
            sum.extinction[k] += both * (a_re + b_re);
            sum.scattering[k] += both * (a_re * a_re + a_im * a_im + b_re * b_re + b_im * b_im);
            sum.forward[k] += own * (a_re * b_re + a_im * b_im) +
                              across * (a_re * next.a_re[k] + a_im * next.a_im[k] +
                                        b_re * next.b_re[k] + b_im * next.b_im[k]);
        }
    }
    return sum;
}

/// Coefficients of several spheres: a row of the real and one of the imaginary parts of (2n+1) / (n(n+1))
/// (a_n + b_n), and as many with a_n - b_n, times the root of how many spheres there are. See
/// kernels/sums.h.
struct SphereRows {
    std::size_t size, rows;  // terms, a multiple of mie_lanes, and rows that there is place for
    std::size_t count = 0;   // spheres
    std::vector<double> sum, difference;

    SphereRows(std::size_t most_terms, std::size_t most)
        : size(padded(most_terms)), rows(2 * most), sum(rows * size), difference(sum) {}

    void add(const std::vector<CoefficientLanes>& series, std::size_t k, double number) {
        const std::size_t first = 2 * count++;
        const double root = std::sqrt(number);
        for (std::size_t i = 0; i < series.size(); ++i) {
            const CoefficientLanes& at = series[i];
            const double n = static_cast<double>(i + 1);
            const double factor = root * (2 * n + 1) / (n * (n + 1));
            const std::size_t re = (i / mie_lanes * rows + first) * mie_lanes + i % mie_lanes;
            sum[re] = factor * (at.a_re[k] + at.b_re[k]);
            sum[re + mie_lanes] = factor * (at.a_im[k] + at.b_im[k]);
            difference[re] = factor * (at.a_re[k] - at.b_re[k]);
            difference[re + mie_lanes] = factor * (at.a_im[k] - at.b_im[k]);
        }
    }

    void clear() {
        count = 0;
        sum.assign(sum.size(), 0.0);
        difference = sum;
    }
};

// ---- Angles

/// `count` terms at mie_lanes cosines.
void fill_angle_terms(const double* cosine, std::size_t count, AngleLanes* terms) {
    double before[mie_lanes] = {}, here[mie_lanes];  // pi_{n-1}, pi_n
    std::fill(here, here + mie_lanes, 1.0);
    for (std::size_t i = 0; i < count; ++i) {
        const double n = static_cast<double>(i + 1), growth = (n + 1) / n;
        for (std::size_t k = 0; k < mie_lanes; ++k) {
            const double along = cosine[k] * here[k], step = along - before[k];
            const double tau = n * step - before[k];
            terms[i].sum[k] = here[k] + tau;
            terms[i].difference[k] = here[k] - tau;
            before[k] = here[k];
            here[k] = along + step * growth;
        }
    }
}

/// Values at the nodes of a quadrature over the cosine.
struct AtNodes {
    GaussLegendre nodes;
    std::vector<double> value;
};

/// Calls `add(angle terms, groups, values)` for groups of mie_lanes nodes.
template <class Add>
void at_all_nodes(AtNodes& nodes, std::size_t terms, const Add& add) {
    constexpr std::size_t most_groups = 8, most = most_groups * mie_lanes;
    std::vector<AngleLanes> angle(most_groups * terms);
    const std::size_t count = nodes.value.size();
    for (std::size_t first = 0; first < count; first += most) {
        const std::size_t some = std::min(most, count - first), groups = padded(some) / mie_lanes;
        double cosine[most] = {}, value[most_groups][mie_lanes] = {};
        std::copy_n(&nodes.nodes.x[first], some, cosine);
        for (std::size_t g = 0; g < groups; ++g)
            fill_angle_terms(cosine + g * mie_lanes, terms, &angle[g * terms]);
        add(angle.data(), groups, value);
        for (std::size_t j = 0; j < some; ++j)
            nodes.value[first + j] += value[j / mie_lanes][j % mie_lanes];
    }
}

// ---- Intensities |S1|^2 + |S2|^2 = (|S1 + S2|^2 + |S1 - S2|^2) / 2 of many spheres, without the
// factor, in one of two ways

/// From the amplitudes of each sphere.
void add_intensities(const SphereRows& spheres, AtNodes& nodes) {
    at_all_nodes(nodes, spheres.size,
                 [&](const AngleLanes* angle, std::size_t groups, double(*value)[mie_lanes]) {
                     for (std::size_t g = 0; g < groups; ++g)
                         for (std::size_t i = 0; i < spheres.count; ++i) {
                             double S[4][mie_lanes];
                             chosen_functions<SphereSums>().amplitudes(
                                 spheres.sum.data(), spheres.difference.data(), 2 * i, spheres.rows,
                                 spheres.size, angle + g * spheres.size, S);
                             for (const auto& part : S)
                                 for (std::size_t k = 0; k < mie_lanes; ++k)
                                     value[g][k] += part[k] * part[k];
                         }
                 });
}

/// From sums over spheres of products of two terms, which all angles share: for many spheres.
class ProductSums {
  public:
    explicit ProductSums(std::size_t size) : size_(size), sum_(size * size), difference_(sum_) {}

    void add(const SphereRows& spheres, std::size_t most_terms) {
        const auto add_products = chosen_functions<SphereSums>().add_products;
        const std::size_t used = padded(most_terms);
        add_products(spheres.sum.data(), spheres.rows, used, size_, sum_.data());
        add_products(spheres.difference.data(), spheres.rows, used, size_, difference_.data());
    }

    /// Once all spheres have been added.
    void add_intensities(AtNodes& nodes) {
        for (std::vector<double>* const matrix : {&sum_, &difference_})
            for (std::size_t n = 0; n < size_; ++n) {
                double* const row = matrix->data() + n * size_;
                std::fill(row, row + n, 0.0);
                for (std::size_t m = n + 1; m < size_; ++m) row[m] *= 2;
            }
        at_all_nodes(nodes, size_,
                     [&](const AngleLanes* angle, std::size_t groups, double(*value)[mie_lanes]) {
                         const auto add_form = chosen_functions<SphereSums>().add_form;
                         add_form(&AngleLanes::sum, sum_.data(), size_, angle, groups, value);
                         add_form(&AngleLanes::difference, difference_.data(), size_, angle, groups,
                                  value);
                     });
    }

  private:
    std::size_t size_;
    std::vector<double> sum_, difference_;  // of terms n and m >= n
};

/// The Legendre moments, divided by the first, of values at Gauss nodes.
std::vector<double> moments_at(const AtNodes& nodes, std::size_t count) {
    const std::size_t nodes_count = nodes.value.size();
    std::vector<double> chi(count), before(nodes_count), here(nodes_count);
    for (std::size_t j = 0; j < nodes_count; ++j) here[j] = nodes.nodes.weight[j] * nodes.value[j];
    for (std::size_t l = 0; l < count; ++l) {
        const double order = static_cast<double>(l), share = order / (order + 1);
        double sum = 0;
        for (std::size_t j = 0; j < nodes_count; ++j) {
            sum += here[j];
            const double along = nodes.nodes.x[j] * here[j];
            const double next = along + share * (along - before[j]);
            before[j] = here[j];
            here[j] = next;
        }
        chi[l] = sum;
    }
    const double mean = chi[0];
    for (double& moment : chi) moment /= mean;
    return chi;
}

}  // namespace

MieAmplitudes mie_amplitudes(double x, Complex m, double cos_theta) {
    const SphereSize sphere{x, 1};
    const std::vector<CoefficientLanes> series = sphere_coefficients(&sphere, 1, m);
    SphereRows row(series.size(), 1);
    row.add(series, 0, sphere.number);
    std::vector<AngleLanes> angle(row.size);
    const double cosine[mie_lanes] = {cos_theta};
    fill_angle_terms(cosine, angle.size(), angle.data());
    double S[4][mie_lanes];
    chosen_functions<SphereSums>().amplitudes(row.sum.data(), row.difference.data(), 0, row.rows,
                                              row.size, angle.data(), S);
    const Complex sum(S[0][0], S[1][0]), difference(S[2][0], S[3][0]);
    return {(sum + difference) / 2.0, (sum - difference) / 2.0};
}

CrossSections cross_sections(double x, Complex m) {
    const SphereSize sphere{x, 1};
    return sum_series(sphere_coefficients(&sphere, 1, m)).of(0, x);
}

SphereScattering sphere_scattering(const std::vector<SphereSize>& spheres, Complex m) {
    SphereScattering whole;
    std::size_t most_terms = 0;
    for (const SphereSize& sphere : spheres)
        most_terms = std::max(most_terms, term_count(sphere.x));
    // The intensity is a polynomial of degree 2 most_terms in the cosine: so many nodes are exact.
    const std::size_t count = 2 * most_terms + 1;
    AtNodes nodes{GaussLegendre(count), std::vector<double>(count)};
    constexpr std::size_t batch = 4 * mie_lanes;  // spheres whose rows are kept
    SphereRows rows(most_terms, batch);
    const bool many = spheres.size() > most_terms / 3;  // which way is faster
    ProductSums products(many ? rows.size : 0);
    std::size_t terms = 0;  // of the longest series in the batch
    for (std::size_t first = 0; first < spheres.size(); first += mie_lanes) {
        const std::size_t some = std::min(mie_lanes, spheres.size() - first);
        const std::vector<CoefficientLanes> series = sphere_coefficients(&spheres[first], some, m);
        const SectionLanes sections = sum_series(series);
        terms = std::max(terms, series.size());
        for (std::size_t k = 0; k < some; ++k) {
            const SphereSize& sphere = spheres[first + k];
            const CrossSections one = sections.of(k, sphere.x);
            whole.total.area += sphere.number * one.area;
            whole.total.extinction += sphere.number * one.extinction;
            whole.total.scattering += sphere.number * one.scattering;
            whole.total.forward += sphere.number * one.forward;
            rows.add(series, k, sphere.number);
        }
        if (rows.count < batch && first + some < spheres.size()) continue;
        if (many)
            products.add(rows, terms);
        else
            add_intensities(rows, nodes);
        rows.clear();
        terms = 0;
    }
    if (many) products.add_intensities(nodes);
    whole.moments = moments_at(nodes, count);
    return whole;
}

}  // namespace stratus
