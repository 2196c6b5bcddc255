// The steps of doubling as SIMD code: eight azimuthal modes (or albedos) of a layer, one per lane of
// a Pack; or a single one, of plain doubles, whose rows fill the registers.
//
// doubling.cpp, which includes all files of this folder, is compiled once per instruction set, in a
// namespace of that name, and selected at run time (instruction_set.h). The files use raw memory and
// call no inline functions of other headers, but those below without linkage: the linker could
// otherwise use code built for a newer processor everywhere.
//
// All matrices are over `directions` = `gauss` quadrature nodes followed by extra directions of
// weight zero, and have the form diag(d) + K. Products sum over the Gauss nodes alone; the
// diagonal, which holds the unscattered beam, is never mixed with the diffuse light in K:
//
//     (F G) = diag(d e) + (d L + K e + K[:, :N] L[:N, :]),   N = gauss
//
// Scaling: K_ij = s_i s_j k(mu_i, mu_j) with s_i = sqrt(2 mu_i weight_i), weight 1 in place of 0
// for the extra directions. Reciprocity then is matrix symmetry, and a matrix product is an
// integral over the hemisphere.
#pragma once

#include <stratus/base/instruction_set.h>

namespace stratus {

constexpr int lane_count = 8;

/// One double per lane. Its own alignment depends on the instruction set; in memory it is this.
constexpr int pack_alignment = 64;
using Pack = double __attribute__((vector_size(64)));

/// Lanes of a Number, Pack or double.
template <class Number>
constexpr int lanes_per = static_cast<int>(sizeof(Number) / sizeof(double));
template <class Number>
constexpr bool is_pack = lanes_per<Number> > 1;

namespace {  // never shared with code built for another processor

template <class Number>
[[gnu::always_inline]] inline double extract_lane(const Number& x, int lane) {
    if constexpr (is_pack<Number>)
        return x[lane];
    else
        return x;
}

template <class Number>
[[gnu::always_inline]] inline void set_lane(Number& x, int lane, double value) {
    if constexpr (is_pack<Number>)
        x[lane] = value;
    else
        x = value;
}

}  // namespace

/// A symmetric matrix diag(d) + K for every lane; K row by row, SimdLayer::stride apart. Rows of
/// doubles, and vectors, are padded to a multiple of eight.
template <class Number>
struct SimdMatrix {
    Number* d;
    Number* K;
};

/// A layer during doubling, and its memory.
template <class Number>
struct SimdLayer {
    int gauss, directions, stride;
    int first_extracted;  // R and T are extracted from this direction on: 0, or a multiple of lane_count
    const double* mu;      // directions
    const double* weight;  // directions, 0 for the extra ones
    const double* s;       // directions, sqrt(2 mu weight) (weight 1 for the extra ones)

    alignas(pack_alignment) Number albedo;
    alignas(pack_alignment) Number half_depth;  // h = tau / 2, current
    // 1 in lanes of mode 0, whose absorption is known exactly; 0 elsewhere
    alignas(pack_alignment) Number conserving;
    bool any_conserving;
    bool has_gap;  // Y holds G = Z - Y

    // (P+ - P-)/2 and (P+ + P-)/2, the parts of odd and even l - m, times s_i s_j / (2 mu_i mu_j);
    // no diagonal.
    SimdMatrix<Number> scatter_odd, scatter_even;
    SimdMatrix<Number> Y, Z;  // admittances of the even and odd part of the light, see doubling.cpp
    Number* gap_diagonal;     // of Z - Y, carried from the start to avoid cancellation
    Number* uniform;   // uniform illumination, s; its absorption is known in conserving lanes:
    Number* absorbed;  // a = Y s there, or B s before the thin start

    SimdMatrix<Number> reflection, transmission;  // results of `extract`
    SimdMatrix<Number> spare[2];
    Number* elimination;     // gauss x elimination_stride: [C_NN | U^T], its factor on return
    int elimination_stride;  // > right_side + directions
    int right_side;          // the column where U^T begins, gauss or more
    Number* vector[3];       // directions each
};

/// Directions of a layer in two groups that do not mix (decoupling.h). Each group is a layer of its
/// own, which may share the memory of the whole one up to its thin start.
template <class Number>
struct SimdGroups {
    SimdLayer<Number> grazing, steep;
    const int *grazing_at, *steep_at;  // places in the whole layer; Gauss nodes first, as always
    int row_stride, column_stride;
    Number* columns[8];  // steep x grazing: intermediate results, the last two U and V transposed,
    Number* rows[5];     // grazing x steep: likewise, the last two U and V,
    Number* squares[3];  // grazing x grazing
};

/// Input of the phase kernels: the azimuthal mode of each lane, and chi_l.
template <class Number>
struct PhaseSeries {
    int mode[lanes_per<Number>];
    const double* moments;
    int moment_count;
    bool completed;  // the diagonal is given what the nodes miss of each row
    // 2 x moment_count rows of `directions`: P_l^m normalised, and the same times (2l + 1) chi_l
    Number* legendre;
};

/// Two factors of a product F G, each diag + K, kernels row by row; null: 0. The diagonals
/// are the same in every lane. F is symmetric.
template <class Number>
struct ProductFactors {
    const double *F_diagonal, *G_diagonal;
    const Number *F, *G;
};

/// The steps of the method for one instruction set.
template <class Number>
struct DoublingSteps {
    void (*phase_kernels)(const PhaseSeries<Number>& phase, SimdLayer<Number>& layer);
    void (*thin_layer)(SimdLayer<Number>& layer);
    void (*use_gap)(SimdLayer<Number>& layer);
    void (*double_depth)(SimdLayer<Number>& layer);
    void (*extract)(SimdLayer<Number>& layer);
    /// Fills both groups up to their thin start; false where scattering mixes them too much.
    bool (*decouple)(const SimdLayer<Number>& whole, SimdGroups<Number>& groups);
    /// Y and Z of the whole layer from those of its groups.
    void (*couple)(const SimdGroups<Number>& groups, SimdLayer<Number>& whole);
    /// out += factor times the kernel of F G; sizes as in the layer.
    void (*add_product)(const SimdLayer<Number>& layer, double factor,
                        const ProductFactors<Number>& of, Number* out);
};

}  // namespace stratus
