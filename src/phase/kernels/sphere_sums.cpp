#include "sums.h"

namespace stratus {
namespace {

#if defined(__AVX512F__)
constexpr std::size_t rows_at_once = 8;  // as many as sums fit into the registers
#elif defined(__AVX__)
constexpr std::size_t rows_at_once = 4;
#else
constexpr std::size_t rows_at_once = 2;
#endif

/// One number for each sphere or angle.
using Lanes = double __attribute__((vector_size(mie_lanes * sizeof(double))));

inline Lanes load(const double* from) {
    Lanes values;
    __builtin_memcpy(&values, from, sizeof values);
    return values;
}

inline void store(Lanes values, double* to) { __builtin_memcpy(to, &values, sizeof values); }

// ---- Coefficients

/// Logarithmic derivatives psi_n'(z) / psi_n(z), z = m x, n = 0 .. count, by downward recurrence;
/// real parts, then imaginary ones. [BH83] 4.89
void fill_derivatives(Lanes inverse_re, Lanes inverse_im, const SeriesLength& length, double* D) {
    Lanes re = {}, im = {};
    for (std::size_t n = length.derivative; n > 0; --n) {
        const double order = static_cast<double>(n);
        const Lanes step_re = order * inverse_re, step_im = order * inverse_im;
        const Lanes sum_re = re + step_re, sum_im = im + step_im;
        const Lanes inverse = 1.0 / (sum_re * sum_re + sum_im * sum_im);
        re = step_re - sum_re * inverse;
        im = step_im + sum_im * inverse;
        if (n - 1 > length.count) continue;
        store(re, D + 2 * mie_lanes * (n - 1));
        store(im, D + 2 * mie_lanes * (n - 1) + mie_lanes);
    }
}

/// psi_n(x) / psi_{n-1}(x), n = 1 .. count, by downward recurrence.
void fill_ratios(Lanes inverse, const SeriesLength& length, double* ratio) {
    Lanes here = {};
    for (std::size_t n = length.ratio; n > 0; --n) {
        here = 1.0 / (static_cast<double>(2 * n + 1) * inverse - here);
        if (n <= length.count) store(here, ratio + mie_lanes * n);
    }
}

/// (e psi_n - psi_{n-1}) / (e xi_n - xi_{n-1}), xi_n = psi_n - i chi_n; 0 where not `inside`.
inline void store_coefficient(Lanes e_re, Lanes e_im, Lanes psi, Lanes psi_before, Lanes chi,
                              Lanes chi_before, Lanes terms, double order, double* re, double* im) {
    const Lanes over_re = e_re * psi - psi_before, over_im = e_im * psi;
    const Lanes under_re = over_re + e_im * chi, under_im = over_im - e_re * chi + chi_before;
    const Lanes inverse = 1.0 / (under_re * under_re + under_im * under_im);
    const Lanes none = {};
    store(order <= terms ? (over_re * under_re + over_im * under_im) * inverse : none, re);
    store(order <= terms ? (over_im * under_re - over_re * under_im) * inverse : none, im);
}

/// [BH83] 4.88
void coefficients(const SphereLanes& spheres, double m_re, double m_im, const SeriesLength& length,
                  double* scratch, CoefficientLanes* all) {
    const Lanes x = load(spheres.x), inverse = 1.0 / x, terms = load(spheres.terms);
    const double norm = m_re * m_re + m_im * m_im;
    const double of_m_re = m_re / norm, of_m_im = -m_im / norm;  // 1 / m
    double *const D = scratch, *const ratio = scratch + 2 * mie_lanes * (length.count + 1);
    fill_derivatives(of_m_re * inverse, of_m_im * inverse, length, D);
    fill_ratios(inverse, length, ratio);
    // Riccati-Bessel functions x j_n(x), upward to n = x, above it, where that would lose them, by
    // their ratios; and chi_n = -x y_n(x).
    Lanes psi_before = load(spheres.cosine), psi = load(spheres.sine);
    Lanes chi_before = -psi, chi = psi_before;
    for (std::size_t n = 1; n <= length.count; ++n) {
        const double order = static_cast<double>(n);
        const Lanes factor = (2 * order - 1) * inverse;
        const Lanes psi_next =
            order > x ? load(ratio + mie_lanes * n) * psi : factor * psi - psi_before;
        const Lanes chi_next = factor * chi - chi_before;
        psi_before = psi;
        chi_before = chi;
        psi = psi_next;
        chi = chi_next;
        const Lanes D_re = load(D + 2 * mie_lanes * n),
                    D_im = load(D + 2 * mie_lanes * n + mie_lanes);
        const Lanes along = order * inverse;
        CoefficientLanes& to = all[n - 1];
        store_coefficient(D_re * of_m_re - D_im * of_m_im + along, D_re * of_m_im + D_im * of_m_re,
                          psi, psi_before, chi, chi_before, terms, order, to.a_re, to.a_im);
        store_coefficient(D_re * m_re - D_im * m_im + along, D_re * m_im + D_im * m_re, psi,
                          psi_before, chi, chi_before, terms, order, to.b_re, to.b_im);
    }
}

// ---- Sums

void add_products(const double* term, std::size_t rows, std::size_t used, std::size_t size,
                  double* matrix) {
    const std::size_t block = rows * mie_lanes;
    for (std::size_t n = 0; n < used; n += rows_at_once) {
        const double* const across = term + n / mie_lanes * block + n % mie_lanes;
        for (std::size_t m = n / mie_lanes * mie_lanes; m < used; m += mie_lanes) {
            const double* const along = term + m / mie_lanes * block;
            Lanes sum[rows_at_once] = {};
            for (std::size_t k = 0; k < block; k += mie_lanes) {
                const Lanes numbers = load(along + k);
                for (std::size_t i = 0; i < rows_at_once; ++i) sum[i] += across[k + i] * numbers;
            }
            for (std::size_t i = 0; i < rows_at_once; ++i) {
                double* const to = matrix + (n + i) * size + m;
                store(load(to) + sum[i], to);
            }
        }
    }
}

void amplitudes(const double* sum, const double* difference, std::size_t first, std::size_t rows,
                std::size_t size, const AngleLanes* angle, double (*value)[mie_lanes]) {
    Lanes part[4] = {};
    for (std::size_t n = 0; n < size; ++n) {
        const std::size_t re = (n / mie_lanes * rows + first) * mie_lanes + n % mie_lanes,
                          im = re + mie_lanes;
        const Lanes plus = load(angle[n].sum), minus = load(angle[n].difference);
        part[0] += sum[re] * plus;
        part[1] += sum[im] * plus;
        part[2] += difference[re] * minus;
        part[3] += difference[im] * minus;
    }
    for (int k = 0; k < 4; ++k) store(part[k], value[k]);
}

void add_form(double (AngleLanes::*part)[mie_lanes], const double* matrix, std::size_t size,
              const AngleLanes* angle, std::size_t groups, double (*value)[mie_lanes]) {
    constexpr std::size_t chunk = 128;  // columns: what the first cache holds of so many rows
    for (std::size_t begin = 0; begin < size; begin += chunk) {
        const std::size_t end = begin + chunk < size ? begin + chunk : size;
        for (std::size_t n = 0; n < end; n += rows_at_once)
            for (std::size_t g = 0; g < groups; ++g) {
                const AngleLanes* const at = angle + g * size;
                Lanes product[rows_at_once] = {};
                for (std::size_t m = n > begin ? n : begin; m < end; ++m) {
                    const Lanes along = load(at[m].*part);
                    for (std::size_t i = 0; i < rows_at_once; ++i)
                        product[i] += matrix[(n + i) * size + m] * along;
                }
                Lanes sum = load(value[g]);
                for (std::size_t i = 0; i < rows_at_once; ++i)
                    sum += product[i] * load(at[n + i].*part);
                store(sum, value[g]);
            }
    }
}

}  // namespace

template <>
const SphereSums& functions_for<SphereSums, InstructionSet::STRATUS_ISA>() noexcept {
    static constexpr SphereSums sphere_sums{coefficients, add_products, amplitudes, add_form};
    return sphere_sums;
}

}  // namespace stratus
