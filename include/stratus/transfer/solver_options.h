// Options of the solver.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace stratus {

enum class Scheme {
    harmonic,  // doubling as an arithmetic-harmonic mean (simd/doubling.cpp)
    classic,   // textbook doubling: LU of I - R R (reference/classic.cpp)
};

/// The thin layer that textbook doubling starts from.
enum class ClassicStart {
    single,   // single scattering in closed form: error of the first order in its depth
    diamond,  // of the second order [W76]
};

/// How a forward peak that the nodes do not resolve is truncated (truncation.h).
enum class Truncate {
    nothing,
    delta_m,  // delta-M, with the single-scattering correction
    smooth,   // large shares smoothly, corrected for multiple scattering in the peak;
              // over a lower boundary, in ladders and orders the same as delta_m
};

struct SolverOptions {
    int nodes = 32;        // Gauss nodes in (0, 1), [1, 512]
    double tolerance = 0;  // [1e-12, 1], relative: solve_geometries and solve_fluxes choose the
                           // nodes (solve_to_tolerance.h); 0: as given
    int moments = 0;  // of the phase function, before its peak is cut off; 0: chosen for the nodes
    int modes = 0;    // azimuthal modes solved; 0: until the rest is negligible
    int orders = 0;   // [0, 200]; higher scattering orders are left out; 0: all
    Scheme scheme = Scheme::harmonic;
    ClassicStart start = ClassicStart::diamond;  // classic only
    double start_depth = 0;  // classic only: start at tau / 2^n <= this, [1e-15, 1]; 0: at 1e-3 of
                             // the smallest cosine
    Truncate truncate = Truncate::smooth;
    bool grazing = false;  // narrow peaks are solved as far as nodes hold them at grazing angles
                           // (src/transfer/climb.h): for R and T of one layer over nothing,
                           // all orders, where one cosine or both are up to 0.2
    bool exact_fluxes = true;       // of a narrow peak: mode 0 once more, with 64 nodes or more
    double mode_tolerance = 1e-14;  // with modes = 0: negligible, relative to R and T
};

/// Depths that one run of doubling passes through: first, 2 first, 4 first, ... (`octaves` of
/// them), then infinity.
struct DepthLadder {
    double first = 1;
    int octaves = 1;
    bool to_infinity = false;
    std::vector<bool> asked = {};  // which of these depths, infinity last, are; empty: all

    int count() const { return octaves + (to_infinity ? 1 : 0); }
    bool asks_for(int depth) const {
        return asked.empty() || asked[static_cast<std::size_t>(depth)];
    }
    /// How many of the depths before this one are asked for.
    int place(int depth) const {
        return asked.empty()
                   ? depth
                   : static_cast<int>(std::count(asked.begin(), asked.begin() + depth, true));
    }
};

}  // namespace stratus
