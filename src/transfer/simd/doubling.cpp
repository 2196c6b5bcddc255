// A layer from its thin start to R and T: the start, then doubling, then the list of all steps.
//
// The start: a layer of optical depth up to the smallest cosine, to rounding.
//
// With A = diag(1/mu) - t + r and B = diag(1/mu) - t - r (one azimuthal mode, per unit of depth)
// and h = tau / 2,
//
//     Y = tanh(h sqrt(BA)) sqrt(BA)^-1 B      Z = [tanh(h sqrt(AB)) sqrt(AB)^-1 A]^-1
//
// Lambert's continued fraction tanh(z)/z = 1/(1 + z^2/(3 + z^2/(5 + ...))) becomes, with b = h B
// and W = (h A)^-1, a chain of parallel sums of symmetric matrices,
//
//     P : Q = (P^-1 + Q^-1)^-1 = P - P (P + Q)^-1 P
//     Y = b : (3 W + (b/5 : (7 W + (b/9 : 11 W))))
//     Z = W + (b/3 : (5 W + (b/7 : (9 W + b/11))))
//
// Six levels leave a relative error below 2e-13 in the row of the smallest cosine at z_0 = 1/2, and
// (z/z_0)^12 times that elsewhere.
#include "congruence.h"
#include "decoupling.h"
#include "phase_kernels.h"

namespace stratus::STRATUS_ISA {

namespace {

/// out = x b + y W (+ T); `out` may be one of them.
template <class Number>
void combine(const SimdLayer<Number>& layer, double x, SimdMatrix<Number> b, double y,
             SimdMatrix<Number> W, SimdMatrix<Number> out, const SimdMatrix<Number>* T = nullptr) {
    const int n = layer.directions;
    for (int i = 0; i < n; ++i) {
        out.d[i] = x * b.d[i] + y * W.d[i];
        if (T) out.d[i] += T->d[i];
        for (long at = i * layer.stride; at < i * layer.stride + n; ++at) {
            out.K[at] = x * b.K[at] + y * W.K[at];
            if (T) out.K[at] += T->K[at];
        }
    }
}

/// out = p b : Q, given C = p b + Q. A vector `along` becomes p b C^-1 along.
template <class Number>
void parallel_sum(const SimdLayer<Number>& layer, double p, SimdMatrix<Number> b,
                  SimdMatrix<Number> C, SimdMatrix<Number> out, Number* along = nullptr) {
    const Scaled<Number> of{p, b};
    eliminate_for(layer, of, C, along);
    congruence_kernel(layer, of, C, out.K, [&](Register<Number> in, int i, int j, Word value) {
        return p * in(b.K, i * layer.stride + j) - value;
    });
    for (int i = 0; i < layer.directions; ++i)
        out.d[i] = p * b.d[i] * (C.d[i] - p * b.d[i]) / C.d[i];
}

}  // namespace

template <class Number>
void thin_layer(SimdLayer<Number>& layer) {
    const int n = layer.directions;
    const Number h = layer.half_depth;
    const SimdMatrix<Number> b = layer.reflection, W = layer.transmission, C = layer.spare[0];

    for (int i = 0; i < n; ++i) {
        C.d[i] = b.d[i] = h / layer.mu[i];
        for (long at = i * layer.stride; at < i * layer.stride + n; ++at) {
            C.K[at] = -h * layer.albedo * layer.scatter_odd.K[at];  // h A
            b.K[at] = -h * layer.albedo * layer.scatter_even.K[at];
        }
    }
    invert(layer, C, W);

    combine(layer, 1.0 / 7 + 1.0 / 11, b, 9, W, C);
    parallel_sum(layer, 1.0 / 7, b, C, layer.Z);
    combine(layer, 1.0 / 3, b, 5, W, C, &layer.Z);
    parallel_sum(layer, 1.0 / 3, b, C, layer.Z);
    combine(layer, 1.0, layer.Z, 1, W, layer.Z);

    combine(layer, 1.0 / 9, b, 11, W, C);
    parallel_sum(layer, 1.0 / 9, b, C, layer.Y);
    combine(layer, 1.0 / 5, b, 7, W, C, &layer.Y);
    parallel_sum(layer, 1.0 / 5, b, C, layer.Y);
    combine(layer, 1.0, b, 3, W, C, &layer.Y);
    // Light absorbed: b s is known exactly, and Y s = b s - b C^-1 b s.
    Number* u = layer.vector[1];
    for (int i = 0; i < n; ++i) u[i] = layer.absorbed[i] *= h;
    parallel_sum(layer, 1.0, b, C, layer.Y, u);
    for (int i = 0; i < n; ++i) {
        layer.absorbed[i] -= u[i];
        layer.gap_diagonal[i] = layer.Z.d[i] - layer.Y.d[i];
    }
    layer.has_gap = false;
}

// Doubling as an arithmetic-harmonic mean, and the extraction of R and T.
//
// Light in a layer is the sum of a part symmetric and a part antisymmetric about the mid-plane. Two
// symmetric positive matrices, Y and Z, describe the two parts (T with the beam on its diagonal):
//
//     R + T = (I + Y)^-1 (I - Y)        R - T = (I + Z)^-1 (I - Z)
//
// Adding two equal layers, tanh 2x and coth 2x, is one step of the arithmetic-harmonic mean:
//
//     Z' = (Z + Y)/2        Y' = 2 (Z^-1 + Y^-1)^-1 = 2 Y - Y Z'^-1 Y
//
// In thick layers Y and Z converge; there the gap G = Z - Y is carried in place of Y, and T keeps
// its relative accuracy at any depth:
//
//     Z' = Z - G/2          G' = (1/4) G Z'^-1 G          T = (I + Y)^-1 G (I + Z)^-1
//
// Mode 0 conserves energy: the light absorbed under uniform illumination, a = Y s, is known exactly
// at the start and doubles as a' = Z Z'^-1 a; the matrices are corrected to it after every step.

template <class Number>
void use_gap(SimdLayer<Number>& layer) {
    combine(layer, 1.0, layer.Z, -1, layer.Y, layer.Y);
    for (int i = 0; i < layer.directions; ++i) layer.Y.d[i] = layer.gap_diagonal[i];
    layer.has_gap = true;
}

template <class Number>
void double_depth(SimdLayer<Number>& layer) {
    const int n = layer.directions;
    SimdMatrix<Number>&Y = layer.Y, &Z = layer.Z;
    combine(layer, layer.has_gap ? 1 : 0.5, Z, layer.has_gap ? -0.5 : 0.5, Y, Z);
    Number* Yu = layer.vector[1];  // Y Z'^-1 a
    for (int i = 0; i < n; ++i) Yu[i] = layer.absorbed[i];
    const Scaled<Number> of{1.0, Y};
    eliminate_for(layer, of, Z, layer.any_conserving ? Yu : nullptr);
    if (layer.any_conserving)  // a' = Z Z'^-1 a with the old Z = 2 Z' - Y, or Z' + G/2
        for (int i = 0; i < n; ++i)
            layer.absorbed[i] =
                layer.has_gap ? layer.absorbed[i] + 0.5 * Yu[i] : 2.0 * layer.absorbed[i] - Yu[i];
    if (layer.has_gap)
        congruence_kernel(layer, of, Z, Y.K,
                          [](Register<Number>, int, int, Word value) { return 0.25 * value; });
    else
        congruence_kernel(layer, of, Z, Y.K, [&](Register<Number> in, int i, int j, Word value) {
            return 2.0 * in(Y.K, i * layer.stride + j) - value;
        });
    for (int i = 0; i < n; ++i) {
        // Squaring doubles the relative error of the gap: carry it once the difference would lose
        // more.
        Number& gap = layer.gap_diagonal[i];
        const Number squared = 0.25 * gap * gap / Z.d[i];
        if (layer.has_gap) {
            Y.d[i] = gap = squared;
        } else {
            Y.d[i] *= 2.0 - Y.d[i] / Z.d[i];
            gap = Y.d[i] < 0.25 * Z.d[i] ? Z.d[i] - Y.d[i] : squared;
        }
    }
    layer.half_depth *= 2.0;
    if (layer.any_conserving) restore_absorption(layer);
}

template <class Number>
void extract(SimdLayer<Number>& layer) {
    const int N = layer.gauss, n = layer.directions, from = layer.first_extracted;
    const long stride = layer.stride;
    const SimdMatrix<Number>&Y = layer.Y, &Z = layer.Z;
    const SimdMatrix<Number> E = layer.reflection,
                             O = layer.transmission;  // (I + Y)^-1 and (I + Z)^-1
    const SimdMatrix<Number> C = layer.spare[0];

    for (int i = 0; i < n; ++i) C.d[i] = 1.0 + Z.d[i];
    invert(layer, {C.d, Z.K}, O, from);
    if (!layer.has_gap) {
        for (int i = 0; i < n; ++i) C.d[i] = 1.0 + Y.d[i];
        invert(layer, {C.d, Y.K}, E, from);
        for (int i = from; i < n; ++i)
            for (long at = i * stride + from; at < i * stride + n; ++at) {
                const Number even = E.K[at], odd = O.K[at];
                E.K[at] = even + odd;
                O.K[at] = even - odd;
            }
        return;
    }

    if (from > 0) invert_gauss_rows(layer, O, from);
    const SimdMatrix<Number>& G = Y;
    for (int i = 0; i < n; ++i) {
        C.d[i] = 1.0 + Z.d[i] - G.d[i];
        for (long at = i * stride; at < i * stride + n; ++at) C.K[at] = Z.K[at] - G.K[at];
    }
    invert(layer, C, E, from);
    if (from > 0) invert_gauss_rows(layer, E, from);
    // T = O F with F = G E, so that both products run over rows.
    const SimdMatrix<Number> F = layer.spare[0], T = layer.spare[1];
    const auto first = [&](Register<Number> in, int i, int column, Word sum) {
        const int j = from + column;
        const long at = i * stride + j;
        in(F.K, at) = sum + in.same(G.d, i) * in(E.K, at) + in(G.K, at) * in(E.d, j);
    };
    for_each_product<Number>(n, n - from, whole_rows, N, G.K, stride, E.K + from, stride, first);
    const auto second = [&](Register<Number> in, int row, int column, Word sum) {
        const int i = from + row, j = from + column;
        const long at = i * stride + j;
        sum += in(E.d, j) * in(G.d, j) * in(O.K, at) + in.same(O.d, i) * in(F.K, at);
        store_upper(in, T.K, stride, i, j, sum);
    };
    for_each_product<Number>(n - from, n - from, from_diagonal, N, O.K + from, stride, F.K + from,
                             stride, second);
    mirror(from, n, T.K, stride);
    for (int i = from; i < n; ++i)
        for (long at = i * stride + from; at < i * stride + n; ++at) E.K[at] += O.K[at];
    layer.spare[1] = layer.transmission;
    layer.transmission = T;
}

/// One term of a product of series (ordered_ladder.h).
template <class Number>
void add_product(const SimdLayer<Number>& layer, double factor, const ProductFactors<Number>& of,
                 Number* out) {
    const int n = layer.directions;
    const long stride = layer.stride;
    if (of.F && of.G)
        for_each_product(n, n, whole_rows, layer.gauss, of.F, stride, of.G, stride,
                         [=](Register<Number> in, int i, int j, Word sum) {
                             in(out, i * stride + j) += factor * sum;
                         });
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const long at = i * stride + j;
            if (of.F_diagonal && of.G) out[at] += factor * (of.F_diagonal[i] * of.G[at]);
            if (of.F && of.G_diagonal) out[at] += factor * (of.F[at] * of.G_diagonal[j]);
        }
}

}  // namespace stratus::STRATUS_ISA

namespace stratus {
namespace {

template <class Number>
constexpr DoublingSteps<Number> all_steps{
    STRATUS_ISA::phase_kernels<Number>, STRATUS_ISA::thin_layer<Number>,
    STRATUS_ISA::use_gap<Number>,       STRATUS_ISA::double_depth<Number>,
    STRATUS_ISA::extract<Number>,       STRATUS_ISA::decouple<Number>,
    STRATUS_ISA::couple<Number>,        STRATUS_ISA::add_product<Number>};

}  // namespace

template <>
const DoublingSteps<Pack>&
functions_for<DoublingSteps<Pack>, InstructionSet::STRATUS_ISA>() noexcept {
    return all_steps<Pack>;
}

template <>
const DoublingSteps<double>&
functions_for<DoublingSteps<double>, InstructionSet::STRATUS_ISA>() noexcept {
    return all_steps<double>;
}

}  // namespace stratus
