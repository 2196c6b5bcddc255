// Grazing and steep directions, decoupled.
//
// Extinction along a direction takes a depth of its cosine: grazing directions need a start below
// 1e-6, of which the others, and most of the doublings, have no use. Per unit of depth light obeys
// p' = -A q, q' = -B p (p, q even and odd about the mid-plane), and any M may change the basis:
//
//     A~ = M^-1 A M^-T        B~ = M^T B M        Y = M^-T Y~ M^-1        Z = M^-T Z~ M^-1
//
// Scattering mixes directions of unlike extinction little. Hence M near I leaves no element of A~
// and B~ between grazing directions (S) and steep ones (L), and each group is doubled by itself,
// from a thin start of its own:
//
//     M = [I  V] [I  0]        M^-1 = [ I  0] [I -V]
//         [0  I] [U' I]               [-U' I] [0  I]            U, V: S x L, U' the transpose
//
// With D = diag(1/mu), A = D - P and B = D - Q, both vanish where, element by element,
//
//     u d_S + v d_L = (-P + V P_L + X U)_SL                   a = (-P + V P_L - V D)_SL
//     v d_S + u d_L = ( Q + U Q_L + F Q + (Q_S - H) V)_SL     b = (-Q + D V - Q_S V)_SL
//     X = P_S - V P_LS + a V'        F = U V'        H = U b'
//
// which iteration solves: each round gains the factor that a photon has to scatter from grazing
// directions to grazing ones. Then
//
//     P~_S = X        P~_L = P_L + U' a        Q~_S = Q_S - H        Q~_L = Q_L + V' Q - b' V
#pragma once

#include "congruence.h"

namespace stratus::STRATUS_ISA {

namespace {

template <class Number>
struct View {
    Number* at;
    long stride;
    int rows, columns;

    [[gnu::always_inline]] Number& operator()(int i, int j) const { return at[i * stride + j]; }
};

/// out += sign F^T G, summed over `depth` rows of F and G.
template <class Number, class FirstColumn = decltype(whole_rows)>
void add_product(int depth, double sign, View<Number> F, View<Number> G, View<Number> out,
                 FirstColumn first_column = {}) {
    for_each_product<Number>(out.rows, out.columns, first_column, depth, F.at, F.stride, G.at,
                             G.stride, [=](Register<Number> in, int i, int j, Word sum) {
                                 in(out.at, i * out.stride + j) += sign * sum;
                             });
}

template <class Number, class Value>
[[gnu::always_inline]] inline void fill(View<Number> out, Value value) {
    for (int i = 0; i < out.rows; ++i)
        for (int j = 0; j < out.columns; ++j) out(i, j) = value(i, j);
}

template <class Number>
void transpose(View<Number> from, View<Number> to) {
    fill(to, [&](int i, int j) { return from(j, i); });
}

/// Operands of all steps, named as above. A name ending in t is transposed: steep x grazing.
template <class Number>
struct Blocks {
    const SimdGroups<Number>& of;
    int S = of.grazing.gauss, L = of.steep.gauss;              // Gauss nodes of each group,
    int nS = of.grazing.directions, nL = of.steep.directions;  // and directions
    View<Number> U = rows(of.rows[3]), V = rows(of.rows[4]), Ut = columns(of.columns[6]),
                 Vt = columns(of.columns[7]), P_S = square(of.grazing, of.grazing.scatter_odd.K),
                 Q_S = square(of.grazing, of.grazing.scatter_even.K),
                 P_L = square(of.steep, of.steep.scatter_odd.K),
                 Q_L = square(of.steep, of.steep.scatter_even.K);
    View<Number> Pt = columns(of.columns[0]), Qt = columns(of.columns[1]),
                 at = columns(of.columns[2]), bt = columns(of.columns[3]), Q = rows(of.rows[0]),
                 X = square(of.grazing, of.squares[0]), Ft = square(of.grazing, of.squares[1]),
                 Ht = square(of.grazing, of.squares[2]);

    View<Number> rows(Number* K) const { return {K, of.row_stride, nS, nL}; }
    View<Number> columns(Number* K) const { return {K, of.column_stride, nL, nS}; }
    View<Number> square(const SimdLayer<Number>& group, Number* K) const {
        return {K, group.stride, group.directions, group.directions};
    }
};

/// The blocks of w times a kernel of the whole layer; `between` is transposed.
template <class Number>
void take_blocks(const SimdLayer<Number>& whole, const SimdGroups<Number>& groups, const Number* K,
                 View<Number> of_grazing, View<Number> of_steep, View<Number> between) {
    const auto from = [&](const int* rows, const int* columns) {
        return [=, &whole](int i, int j) {
            return whole.albedo * K[rows[i] * static_cast<long>(whole.stride) + columns[j]];
        };
    };
    fill(of_grazing, from(groups.grazing_at, groups.grazing_at));
    fill(of_steep, from(groups.steep_at, groups.steep_at));
    fill(between, from(groups.steep_at, groups.grazing_at));
}

/// a, b, X, F and H from U and V.
template <class Number>
void combine(const Blocks<Number>& m) {
    const double *mu_S = m.of.grazing.mu, *mu_L = m.of.steep.mu;
    fill(m.at, [&](int j, int i) { return -m.Pt(j, i) - m.Vt(j, i) * (1 / mu_L[j]); });
    add_product(m.L, 1, m.P_L, m.Vt, m.at);
    fill(m.bt, [&](int j, int i) { return m.Vt(j, i) * (1 / mu_S[i]) - m.Qt(j, i); });
    add_product(m.S, -1, m.V, m.Q_S, m.bt);
    fill(m.X, m.P_S);
    add_product(m.L, -1, m.Vt, m.Pt, m.X);
    add_product(m.L, 1, m.at, m.Vt, m.X);
    fill(m.Ft, [](int, int) { return Number{}; });
    add_product(m.L, 1, m.Vt, m.Ut, m.Ft);
    fill(m.Ht, [](int, int) { return Number{}; });
    add_product(m.L, 1, m.bt, m.Ut, m.Ht);
}

/// The next U and V. Returns the squared change, relative to single scattering.
template <class Number>
Number iterate(const SimdLayer<Number>& whole, const Blocks<Number>& m) {
    const SimdLayer<Number>&grazing = m.of.grazing, &steep = m.of.steep;
    const double *mu_S = grazing.mu, *mu_L = steep.mu;
    const View<Number> odd = m.columns(m.of.columns[4]), even = m.columns(m.of.columns[5]);
    combine(m);
    fill(odd, [&](int j, int i) { return m.at(j, i) + m.Vt(j, i) * (1 / mu_L[j]); });
    add_product(m.S, 1, m.U, m.X, odd);
    // Q + (Q_S - H) V = D V - b - H V
    fill(even, [&](int j, int i) { return m.Vt(j, i) * (1 / mu_S[i]) - m.bt(j, i); });
    add_product(m.S, -1, m.V, m.Ht, even);
    add_product(m.L, 1, m.Q_L, m.Ut, even);
    add_product(m.S, 1, m.Q, m.Ft, even);

    Number change{};
    for (int j = 0; j < m.nL; ++j)
        for (int i = 0; i < m.nS; ++i) {
            const double d_S = 1 / mu_S[i], d_L = 1 / mu_L[j];
            const double share = 1 / ((d_S - d_L) * (d_S + d_L));
            const Number u = (d_S * odd(j, i) - d_L * even(j, i)) * share;
            const Number v = (d_S * even(j, i) - d_L * odd(j, i)) * share;
            const double unit = 2 / (grazing.s[i] * steep.s[j] * d_L);
            const Number du = unit * (u - m.Ut(j, i)), dv = unit * (v - m.Vt(j, i));
            change += du * du + dv * dv;
            m.Ut(j, i) = u;
            m.Vt(j, i) = v;
        }
    transpose(m.Ut, m.U);
    transpose(m.Vt, m.V);
    return change / (whole.albedo * whole.albedo + 1e-300);
}

/// Uniform illumination and its absorption B s in the new basis: M^-1 s and M^T B s.
template <class Number>
void change_basis(const SimdLayer<Number>& whole, SimdGroups<Number>& groups,
                  const Blocks<Number>& m) {
    SimdLayer<Number>&S = groups.grazing, &L = groups.steep;
    for (int i = 0; i < m.nS; ++i) S.absorbed[i] = whole.absorbed[groups.grazing_at[i]];
    for (int j = 0; j < m.nL; ++j) {
        Number& sum = L.absorbed[j] = whole.absorbed[groups.steep_at[j]];
        for (int i = 0; i < m.S; ++i) sum += m.Vt(j, i) * S.absorbed[i];
    }
    for (int i = 0; i < m.nS; ++i)
        for (int j = 0; j < m.L; ++j) S.absorbed[i] += m.U(i, j) * L.absorbed[j];
    // In grazing directions only what is absorbed is left of uniform illumination: B~ s~, solved
    // for s~, keeps its relative accuracy.
    const int columns = m.S + 1;
    const long stride = S.elimination_stride;
    for (int i = 0; i < m.S; ++i) {
        Number* row = S.elimination + i * stride;
        for (int k = 0; k < m.S; ++k) row[k] = -S.scatter_even.K[i * S.stride + k];
        row[i] += 1 / S.mu[i];
        row[m.S] = S.absorbed[i];
    }
    eliminate(m.S, columns, S.elimination, stride);
    for (int i = 0; i < m.S; ++i) S.uniform[i] = S.elimination[i * stride + m.S];
    back_substitute(m.S, S.elimination, stride, S.uniform);
    for (int i = m.S; i < m.nS; ++i) {
        Number& sum = S.uniform[i] = S.absorbed[i];
        for (int k = 0; k < m.S; ++k) sum += S.scatter_even.K[i * S.stride + k] * S.uniform[k];
        sum *= S.mu[i];
    }
    for (int j = 0; j < m.nL; ++j) {
        Number& sum = L.uniform[j] = whole.uniform[groups.steep_at[j]];
        for (int i = 0; i < m.S; ++i) sum -= m.Ut(j, i) * S.uniform[i];
    }
}

}  // namespace

template <class Number>
bool decouple(const SimdLayer<Number>& whole, SimdGroups<Number>& groups) {
    const Blocks<Number> m{groups};
    take_blocks(whole, groups, whole.scatter_odd.K, m.P_S, m.P_L, m.Pt);
    take_blocks(whole, groups, whole.scatter_even.K, m.Q_S, m.Q_L, m.Qt);
    transpose(m.Qt, m.Q);
    const auto zero = [](int, int) { return Number{}; };
    fill(m.U, zero);
    fill(m.V, zero);
    fill(m.Ut, zero);
    fill(m.Vt, zero);

    constexpr int max_rounds = 24;
    constexpr double converged = 1e-28, slow = 0.1;  // squares: 1e-14, and a gain of 3 a round
    double last = 0;
    for (int round = 0;; ++round) {
        const Number change = iterate(whole, m);
        double most = 0;
        for (int lane = 0; lane < lanes_per<Number>; ++lane)
            if (!(extract_lane(change, lane) <= most)) most = extract_lane(change, lane);
        const bool is_next_small = most * most <= converged * last;  // at this round's gain
        if (most <= converged || is_next_small) break;
        if (round == max_rounds || (round > 2 && !(most < slow * last))) return false;
        last = most;
    }

    combine(m);
    const View<Number> a = m.rows(groups.rows[1]), b = m.rows(groups.rows[2]);
    transpose(m.at, a);
    transpose(m.bt, b);
    add_product(m.S, 1, m.U, a, m.P_L);
    add_product(m.S, 1, m.V, m.Q, m.Q_L);
    add_product(m.S, -1, b, m.V, m.Q_L);
    fill(m.P_S, m.X);
    for (int i = 0; i < m.nS; ++i)
        for (int k = 0; k < m.nS; ++k) m.Q_S(i, k) -= m.Ht(k, i);
    if (whole.any_conserving) change_basis(whole, groups, m);
    return true;
}

namespace {

/// `to` = M^-T F~ M^-1 in the places of the whole layer.
template <class Number>
void couple_matrix(const Blocks<Number>& m, SimdMatrix<Number> of_grazing,
                   SimdMatrix<Number> of_steep, const SimdLayer<Number>& whole,
                   SimdMatrix<Number> to) {
    const SimdGroups<Number>& groups = m.of;
    const View<Number> F_S = m.square(groups.grazing, of_grazing.K),
                       F_L = m.square(groups.steep, of_steep.K);
    const View<Number> Et = m.columns(groups.columns[0]), Gt = m.columns(groups.columns[1]);
    const View<Number> E = m.rows(groups.rows[0]), G = m.rows(groups.rows[1]), E_S = m.X;
    // E = -U F_L,  E_S = F_S - E U',  G = E - E_S V
    fill(Et, [&](int j, int i) { return -of_steep.d[j] * m.Ut(j, i); });
    add_product(m.L, -1, F_L, m.Ut, Et);
    fill(E_S, F_S);
    add_product(m.L, -1, Et, m.Ut, E_S);
    fill(Gt, [&](int j, int i) { return Et(j, i) - m.Vt(j, i) * of_grazing.d[i]; });
    add_product(m.S, -1, m.V, E_S, Gt);
    transpose(Et, E);
    transpose(Gt, G);

    const auto place = [&](const int* rows, int i, const int* columns, int j) -> Number& {
        return to.K[rows[i] * static_cast<long>(whole.stride) + columns[j]];
    };
    const int *S = groups.grazing_at, *L = groups.steep_at;
    for (int i = 0; i < m.nS; ++i) {
        to.d[S[i]] = of_grazing.d[i];
        for (int k = 0; k < m.nS; ++k) place(S, i, S, k) = E_S(i, k);
        for (int j = 0; j < m.nL; ++j) place(S, i, L, j) = place(L, j, S, i) = G(i, j);
    }
    for (int j = 0; j < m.nL; ++j) to.d[L[j]] = of_steep.d[j];
    const View<Number> change{whole.spare[0].K, whole.stride, m.nL, m.nL};  // V' E + G' V
    fill(change, [](int, int) { return Number{}; });
    add_product(m.S, 1, m.V, E, change, from_diagonal);
    add_product(m.S, 1, G, m.V, change, from_diagonal);
    for (int i = 0; i < m.nL; ++i)
        for (int j = i; j < m.nL; ++j)
            place(L, i, L, j) = place(L, j, L, i) = F_L(i, j) - change(i, j);
}

}  // namespace

template <class Number>
void couple(const SimdGroups<Number>& groups, SimdLayer<Number>& whole) {
    const Blocks<Number> m{groups};
    const SimdLayer<Number>&S = groups.grazing, &L = groups.steep;
    couple_matrix(m, S.Y, L.Y, whole, whole.Y);
    couple_matrix(m, S.Z, L.Z, whole, whole.Z);
    whole.has_gap = L.has_gap;
    whole.half_depth = L.half_depth;
    if (!whole.any_conserving) return;
    // The absorbed light M^-T a~.
    Number* a_S = whole.vector[0];
    absorb_uniform(S, a_S);
    for (int i = 0; i < m.nS; ++i) {
        for (int j = 0; j < m.L; ++j) a_S[i] -= m.U(i, j) * L.absorbed[j];
        whole.absorbed[groups.grazing_at[i]] = a_S[i];
    }
    for (int j = 0; j < m.nL; ++j) {
        Number& sum = whole.absorbed[groups.steep_at[j]] = L.absorbed[j];
        for (int i = 0; i < m.S; ++i) sum -= m.Vt(j, i) * a_S[i];
    }
    restore_absorption(whole);
}

}  // namespace stratus::STRATUS_ISA
