// Errors of few nodes with peaked phase functions: R and T against many nodes. Of forward peaks within
// 10 degrees of the forward direction and beyond, with delta-M and with the smooth truncation; of
// backward peaks between steep directions.
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace {

using namespace stratus;

const std::vector<double> cosines{0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 1};

LayerSolution solution(const PhaseFunction& phase, double optical_depth, int nodes,
                       Truncate truncate = Truncate::smooth) {
    SolverOptions options;
    options.nodes = nodes;
    options.truncate = truncate;
    return solve_layer(phase, 1, optical_depth, cosines, options);
}

struct Regions {
    std::vector<double> forward, elsewhere;
};

double relative_error(double value, double reference) { return std::abs(value / reference - 1); }

/// Visits pairs of the cosines `from` on, and azimuths in so many steps.
template <class Visit>
void for_each_geometry(int from, int steps, Visit visit) {
    for (int i = from; i < std::ssize(cosines); ++i)
        for (int j = i; j < std::ssize(cosines); ++j)
            for (int k = 0; k <= steps; ++k) visit(i, j, k * pi / steps);
}

Regions compare(const LayerSolution& found, const LayerSolution& expected) {
    Regions regions;
    for_each_geometry(0, 6, [&](int i, int j, double azimuth) {
        const Geometry at{found.mu(i), found.mu(j), azimuth};
        const auto add = [&](double cosine, double value, double reference) {
            auto& region = cosine > std::cos(pi / 18) ? regions.forward : regions.elsewhere;
            region.push_back(relative_error(value, reference));
        };
        add(cos_scattering_angle_reflected(at), found.reflection(i, j, azimuth).total,
            expected.reflection(i, j, azimuth).total);
        add(cos_scattering_angle_transmitted(at), found.transmission(i, j, azimuth).total,
            expected.transmission(i, j, azimuth).total);
    });
    std::sort(regions.forward.begin(), regions.forward.end());
    std::sort(regions.elsewhere.begin(), regions.elsewhere.end());
    return regions;
}

/// R and T between the cosines `from` on, at 19 azimuths; each list is sorted.
void compare_backward(const LayerSolution& found, const LayerSolution& expected, int from,
                      std::vector<double>& R, std::vector<double>& T) {
    for_each_geometry(from, 18, [&](int i, int j, double azimuth) {
        R.push_back(relative_error(found.reflection(i, j, azimuth).total,
                                   expected.reflection(i, j, azimuth).total));
        T.push_back(relative_error(found.transmission(i, j, azimuth).total,
                                   expected.transmission(i, j, azimuth).total));
    });
    std::ranges::sort(R);
    std::ranges::sort(T);
}

/// Henyey-Greenstein from g = -0.95 to -0.999, against `exact` nodes, which truncate nothing where they
/// hold the series.
void print_backward_peaks() {
    const int nodes[] = {48, 72, 108, 164};
    const struct {
        const char* phase;
        int exact;
        Truncate truncate;
    } cases[] = {{"henyey_greenstein:g=-0.95", 160, Truncate::nothing},
                 {"henyey_greenstein:g=-0.98", 320, Truncate::nothing},
                 {"henyey_greenstein:g=-0.99", 240, Truncate::smooth},
                 {"henyey_greenstein:g=-0.999", 240, Truncate::smooth}};
    std::printf(
        "\nBackward peaks, w = 1, depth 2, cosines from 0.3 on: relative error of 99 %% of R (of "
        "T).\n\n| phase function | 48 nodes | 72 | 108 | 164 |\n| --- | --- | --- | --- | --- "
        "|\n");
    for (const auto& of : cases) {
        const PhaseFunction phase = parse_phase_function(of.phase);
        const LayerSolution expected = solution(phase, 2, of.exact, of.truncate);
        std::printf("| %s |", of.phase);
        for (const int count : nodes) {
            std::vector<double> R, T;
            compare_backward(solution(phase, 2, count), expected, 2, R, T);
            const std::size_t at = R.size() * 99 / 100;
            std::printf(" %.0e (%.0e) |", R[at], T[at]);
        }
        std::printf("\n");
    }
}

void print(const std::vector<double>& errors) {
    std::printf(" %.0e / %.0e |", errors[errors.size() / 2], errors.back());
}

}  // namespace

int main() {
    const struct {
        const char *phase, *name;
        double optical_depth;
        int exact;
    } cases[] = {{"henyey_greenstein:g=0.9", "HG 0.9, depth 2", 2, 112},
                 {"henyey_greenstein:g=0.95", "HG 0.95, depth 8", 8, 144},
                 {"henyey_greenstein:g=0.99", "HG 0.99, depth 2", 2, 160},
                 {"0.4*henyey_greenstein:g=0.98 + 0.55*henyey_greenstein:g=0.75 + "
                  "0.05*henyey_greenstein:g=-0.4",
                  "three HG 0.98, 0.75, -0.4, depth 4", 4, 144}};
    std::printf(
        "Relative errors of R and T at w = 1, median / worst.\n\n"
        "| phase function | nodes | delta-M, beyond 10 deg | within | Stratus, beyond 10 "
        "deg | within |\n| --- | --- | --- | --- | --- | --- |\n");
    for (const auto& of : cases) {
        const PhaseFunction phase = parse_phase_function(of.phase);
        const LayerSolution expected = solution(phase, of.optical_depth, of.exact);
        for (const int nodes : {24, 32, 48, 64}) {
            std::printf("| %s | %d |", of.name, nodes);
            for (const Truncate truncate : {Truncate::delta_m, Truncate::smooth}) {
                const Regions regions =
                    compare(solution(phase, of.optical_depth, nodes, truncate), expected);
                print(regions.elsewhere);
                print(regions.forward);
            }
            std::printf("\n");
        }
    }
    print_backward_peaks();
}
