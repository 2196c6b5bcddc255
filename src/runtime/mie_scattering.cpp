#include "mie_scattering.h"

#include "gauss_legendre.h"
#include "kernels/sphere_sums.h"

#include <stratus/runtime/constants.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

using Complex = std::complex<double>;

/// Terms after which the series of a sphere has converged: W. J. Wiscombe, Appl. Opt. 19, 1980.
std::size_t terms_of(double x) { return static_cast<std::size_t>(x + 4.05 * std::cbrt(x) + 2) + 1; }

/// An order from which downward recurrences may start with any value. Functions of z fall off above
/// n = |z| over a width of |z|^(1/3); fifteen orders beyond |z|, as is often seen, leave resonances
/// of large spheres wrong.
std::size_t start_of_recurrence(double size, std::size_t count) {
    return std::max(count, static_cast<std::size_t>(size)) +
           static_cast<std::size_t>(8 * std::cbrt(size)) + 15;
}

/// Logarithmic derivatives psi_n'(z) / psi_n(z), n = 0 .. count, by downward recurrence.
/// [BH83] 4.89
std::vector<Complex> logarithmic_derivatives(Complex z, std::size_t count) {
    const std::size_t start = start_of_recurrence(std::abs(z), count);
    std::vector<Complex> D(start + 1);
    const Complex inverse = 1.0 / z;
    for (std::size_t n = start; n > 0; --n) {
        const Complex step = static_cast<double>(n) * inverse;
        D[n - 1] = step - 1.0 / (D[n] + step);
    }
    D.resize(count + 1);
    return D;
}

/// Riccati-Bessel functions x j_n(x), n = 0 .. count: upward to n = x, above it, where that would
/// lose them, by ratios found downward.
std::vector<double> riccati_bessel(double x, std::size_t count) {
    const std::size_t start = start_of_recurrence(x, count);
    std::vector<double> psi(count + 1), ratio(start + 2);  // ratio[n] = psi_n / psi_{n-1}
    for (std::size_t n = start; n > 0 && static_cast<double>(n) > x; --n)
        ratio[n] = 1 / (static_cast<double>(2 * n + 1) / x - ratio[n + 1]);
    double before = std::cos(x);  // psi_{-1}
    psi[0] = std::sin(x);
    for (std::size_t n = 1; n <= count; ++n) {
        psi[n] = static_cast<double>(n) > x
                     ? ratio[n] * psi[n - 1]
                     : static_cast<double>(2 * n - 1) / x * psi[n - 1] - before;
        before = psi[n - 1];
    }
    return psi;
}

// ---- Angles

constexpr std::size_t lanes = spheres_at_once;
constexpr std::size_t chunk = 32;  // angles whose functions are kept

void fill_angle_terms(double c, std::size_t count, AngleTerm* terms) {
    double before = 0, here = 1;  // pi_{n-1}, pi_n
    for (std::size_t n = 1; n <= count; ++n) {
        const double order = static_cast<double>(n);
        const double along = c * here, step = along - before;
        const double tau = order * step - before;
        terms[n - 1] = {here + tau, here - tau};
        before = here;
        here = along + step * (order + 1) / order;
    }
}

void put_sphere(const MieCoefficients& sphere, std::size_t lane, std::vector<SphereTerm>& terms) {
    if (terms.size() < sphere.a.size()) terms.resize(sphere.a.size(), SphereTerm{});
    for (std::size_t i = 0; i < sphere.a.size(); ++i) {
        const double n = static_cast<double>(i + 1);
        const double factor = (2 * n + 1) / (n * (n + 1));
        const Complex sum = factor * (sphere.a[i] + sphere.b[i]);
        const Complex difference = factor * (sphere.a[i] - sphere.b[i]);
        terms[i].sum_re[lane] = sum.real();
        terms[i].sum_im[lane] = sum.imag();
        terms[i].difference_re[lane] = difference.real();
        terms[i].difference_im[lane] = difference.imag();
    }
}

// ---- Sums over spheres

/// The spheres that are summed side by side.
struct LaneSpheres {
    std::vector<SphereTerm> terms;
    double number[lanes] = {};
};

/// Values at the nodes of a quadrature over the cosine.
struct AtNodes {
    GaussLegendre nodes;
    std::vector<double> value;
};

/// Adds the intensity |S1|^2 + |S2|^2 of all spheres to the values at the nodes.
void add_intensities(const std::vector<LaneSpheres>& spheres, std::size_t most_terms,
                     AtNodes& nodes) {
    const std::size_t count = nodes.value.size();
    std::vector<AngleTerm> angle(chunk * most_terms);
    SphereAmplitudes S[chunk];
    for (std::size_t first = 0; first < count; first += chunk) {
        const std::size_t angles = std::min(chunk, count - first);
        for (std::size_t j = 0; j < angles; ++j)
            fill_angle_terms(nodes.nodes.x[first + j], most_terms, &angle[j * most_terms]);
        for (const LaneSpheres& group : spheres) {
            sphere_sums().amplitudes(group.terms.data(), group.terms.size(), angle.data(),
                                     most_terms, angles, S);
            for (std::size_t j = 0; j < angles; ++j)
                for (std::size_t k = 0; k < lanes; ++k)
                    nodes.value[first + j] +=
                        group.number[k] / 2 *
                        (S[j].sum_re[k] * S[j].sum_re[k] + S[j].sum_im[k] * S[j].sum_im[k] +
                         S[j].difference_re[k] * S[j].difference_re[k] +
                         S[j].difference_im[k] * S[j].difference_im[k]);
        }
    }
}

/// The Legendre moments, divided by the first, of values at Gauss nodes.
std::vector<double> moments_at(const AtNodes& nodes, std::size_t count) {
    const std::size_t nodes_count = nodes.value.size();
    std::vector<double> chi(count), before(nodes_count, 0.0), here(nodes_count);
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

MieCoefficients mie_coefficients(double x, Complex m) {
    const std::size_t count = terms_of(x);
    const std::vector<Complex> D = logarithmic_derivatives(m * x, count);
    const std::vector<double> psi = riccati_bessel(x, count);
    MieCoefficients sphere{std::vector<Complex>(count), std::vector<Complex>(count)};
    double chi_before = -std::sin(x), chi = std::cos(x);  // chi_{n-1}, chi_n; -x y_n(x)
    for (std::size_t n = 1; n <= count; ++n) {
        const double order = static_cast<double>(n);
        const double chi_next = (2 * order - 1) / x * chi - chi_before;
        chi_before = chi;
        chi = chi_next;
        const Complex xi(psi[n], -chi), xi_before(psi[n - 1], -chi_before);
        const Complex electric = D[n] / m + order / x, magnetic = m * D[n] + order / x;
        sphere.a[n - 1] = (electric * psi[n] - psi[n - 1]) / (electric * xi - xi_before);
        sphere.b[n - 1] = (magnetic * psi[n] - psi[n - 1]) / (magnetic * xi - xi_before);
    }
    return sphere;
}

MieAmplitudes mie_amplitudes(const MieCoefficients& sphere, double cos_theta) {
    std::vector<SphereTerm> terms;
    put_sphere(sphere, 0, terms);
    std::vector<AngleTerm> angle(terms.size());
    fill_angle_terms(cos_theta, terms.size(), angle.data());
    SphereAmplitudes S;
    sphere_sums().amplitudes(terms.data(), terms.size(), angle.data(), 0, 1, &S);
    const Complex sum(S.sum_re[0], S.sum_im[0]);
    const Complex difference(S.difference_re[0], S.difference_im[0]);
    return {(sum + difference) / 2.0, (sum - difference) / 2.0};
}

CrossSections cross_sections(double x, const MieCoefficients& sphere) {
    const auto &a = sphere.a, &b = sphere.b;
    double extinction = 0, scattering = 0, forward = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double n = static_cast<double>(i + 1);
        extinction += (2 * n + 1) * (a[i] + b[i]).real();
        scattering += (2 * n + 1) * (std::norm(a[i]) + std::norm(b[i]));
        forward += (2 * n + 1) / (n * (n + 1)) * (a[i] * std::conj(b[i])).real();
        if (i + 1 < a.size())
            forward += n * (n + 2) / (n + 1) *
                       (a[i] * std::conj(a[i + 1]) + b[i] * std::conj(b[i + 1])).real();
    }
    return {pi * x * x, 2 * pi * extinction, 2 * pi * scattering, 4 * pi * forward};
}

SphereScattering scattering_of(const std::vector<SphereSize>& spheres, Complex m) {
    SphereScattering whole;
    std::vector<LaneSpheres> groups((spheres.size() + lanes - 1) / lanes);
    std::size_t most_terms = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const MieCoefficients sphere = mie_coefficients(spheres[i].x, m);
        put_sphere(sphere, i % lanes, groups[i / lanes].terms);
        groups[i / lanes].number[i % lanes] = spheres[i].number;
        const CrossSections one = cross_sections(spheres[i].x, sphere);
        whole.total.area += spheres[i].number * one.area;
        whole.total.extinction += spheres[i].number * one.extinction;
        whole.total.scattering += spheres[i].number * one.scattering;
        whole.total.forward += spheres[i].number * one.forward;
        most_terms = std::max(most_terms, sphere.a.size());
    }
    // The intensity is a polynomial of degree 2 most_terms in the cosine: so many nodes are exact.
    const std::size_t count = 2 * most_terms + 1;
    AtNodes nodes{GaussLegendre(count), std::vector<double>(count, 0.0)};
    add_intensities(groups, most_terms, nodes);
    whole.moments = moments_at(nodes, count);
    return whole;
}

}  // namespace stratus
