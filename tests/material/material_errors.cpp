// Prints size, time and errors of every format: the figures of docs/exports.md.
#include "fourier_reader.h"
#include "material_check.h"

#include <chrono>
#include <cstdio>

namespace {

using namespace stratus;
using namespace stratus::test;

void print(const char* name, Errors errors) {
    std::printf("    %-28s median %.3f %%, 99 %% %.3f %%, worst %.3f %%\n", name,
                100 * errors.quantile(0.5), 100 * errors.quantile(0.99), 100 * errors.quantile(1));
}

void report_fourier(const std::string& name, const Stack& stack) {
    const auto start = std::chrono::steady_clock::now();
    const std::string bytes = written({{stack}, ""}, MaterialFormat::fourier);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const FourierReader table(bytes);
    std::printf("fourier, %s: %zu bytes, %.1f s, longest series %d\n", name.c_str(), bytes.size(),
                seconds, table.longest);
    Errors R, below, T;
    for (const Expected& at : random_geometries(stack, 500, 0.01)) {
        const auto& [mu_in, mu_out, azimuth] = at.geometry;
        R.add(table(mu_out, -mu_in, azimuth)[0] * pi, at.reflection);
        below.add(table(-mu_out, mu_in, azimuth)[0] * pi, at.reflection_below);
        T.add(table(-mu_out, -mu_in, azimuth)[0] * pi, at.transmission);
    }
    print("reflection", R);
    print("reflection from below", below);
    print("transmission", T);
    double defect = 0;
    for (int k = 1; k <= 50; ++k) {
        const double mu = k / 50.0;
        const double sum = table.albedo(mu) + std::exp(-stack.layers[0].optical_depth / mu);
        defect = std::max(defect, std::abs(sum - 1));
    }
    std::printf("    furnace %.2g\n", defect);
}

}  // namespace

int main() {
    for (const char* phase : {"isotropic", "henyey_greenstein:g=0.5", "henyey_greenstein:g=0.75",
                              "henyey_greenstein:g=0.85"})
        for (const double depth : {0.1, 1.0, 8.0, 100.0})
            report_fourier(std::string(phase) + ", depth " + std::to_string(depth),
                           layer(phase, 1, depth));
}
