// Errors of few nodes with peaked phase functions: R and T against many nodes, within 10 degrees of
// the forward direction and beyond, with delta-M and with the smooth truncation.
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace {

using namespace stratus;

const std::vector<double> cosines{0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 1};

struct Regions {
    std::vector<double> forward, elsewhere;
};

template <class Visit>
void for_each_geometry(Visit visit) {
    for (int i = 0; i < static_cast<int>(cosines.size()); ++i)
        for (int j = i; j < static_cast<int>(cosines.size()); ++j)
            for (int k = 0; k <= 6; ++k) visit(i, j, k * pi / 6);
}

Regions compare(const LayerSolution& found, const LayerSolution& expected) {
    Regions regions;
    for_each_geometry([&](int i, int j, double azimuth) {
        const Geometry at{found.mu(i), found.mu(j), azimuth};
        const auto add = [&](double cosine, double value, double reference) {
            auto& region = cosine > std::cos(pi / 18) ? regions.forward : regions.elsewhere;
            region.push_back(std::abs(value / reference - 1));
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
        SolverOptions options;
        options.nodes = of.exact;
        const LayerSolution expected = solve_layer(phase, 1, of.optical_depth, cosines, options);
        for (const int nodes : {24, 32, 48, 64}) {
            std::printf("| %s | %d |", of.name, nodes);
            options.nodes = nodes;
            for (const Truncate truncate : {Truncate::delta_m, Truncate::smooth}) {
                options.truncate = truncate;
                const Regions regions =
                    compare(solve_layer(phase, 1, of.optical_depth, cosines, options), expected);
                print(regions.elsewhere);
                print(regions.forward);
            }
            std::printf("\n");
        }
    }
}
