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

namespace stratus::STRATUS_ISA {

namespace {

/// out = x b + y W (+ T).
template <class Number>
void combine(const SimdLayer<Number>& layer, double x, SimdMatrix<Number> b, double y,
             SimdMatrix<Number> W, const SimdMatrix<Number>* T, SimdMatrix<Number> out) {
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

    combine<Number>(layer, 1.0 / 7 + 1.0 / 11, b, 9, W, nullptr, C);
    parallel_sum(layer, 1.0 / 7, b, C, layer.Z);
    combine(layer, 1.0 / 3, b, 5, W, &layer.Z, C);
    parallel_sum(layer, 1.0 / 3, b, C, layer.Z);
    for (int i = 0; i < n; ++i) {
        layer.Z.d[i] += W.d[i];
        for (long at = i * layer.stride; at < i * layer.stride + n; ++at) layer.Z.K[at] += W.K[at];
    }

    combine<Number>(layer, 1.0 / 9, b, 11, W, nullptr, C);
    parallel_sum(layer, 1.0 / 9, b, C, layer.Y);
    combine(layer, 1.0 / 5, b, 7, W, &layer.Y, C);
    parallel_sum(layer, 1.0 / 5, b, C, layer.Y);
    combine(layer, 1.0, b, 3, W, &layer.Y, C);
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

template void thin_layer(SimdLayer<Pack>&);
template void thin_layer(SimdLayer<double>&);

}  // namespace stratus::STRATUS_ISA
