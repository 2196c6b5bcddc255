// Looks up a packed table: one value, and a row of pixels whose layers differ.
#include <stratus/runtime.h>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
    const stratus::PackedTable table(argc > 1 ? argv[1] : "table.stratus");

    // Albedo 0.95 and optical depth 1.2, lit at cosine 0.8, seen at cosine 0.5, 60 degrees aside.
    const double azimuth = 1.0471975511965976;
    const stratus::Geometry geometry{0.8, 0.5, azimuth};
    std::printf("R = %.5f, T = %.5f\n", table.reflection(0.95, 1.2, geometry).total(),
                table.transmission(0.95, 1.2, geometry).total());

    const float albedo[] = {0.9f, 0.95f, 1}, depth[] = {0.6f, 1.2f, 2},
                mu_in[] = {0.8f, 0.8f, 0.8f}, mu_out[] = {0.5f, 0.5f, 0.5f},
                around[] = {1.0471976f, 1.0471976f, 1.0471976f};
    float total[3];
    table.reflection({albedo, depth, mu_in, mu_out, around, 3}, total);
    for (const float value : total) std::printf("%.4f\n", static_cast<double>(value));
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
