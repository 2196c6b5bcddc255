// Looks up one value of a table of one sample: single scattering by the closed form plus 0.25.
#include <stratus/table/lookup.h>

#include <cstdio>

int main() {
    stratus::Table table;
    table.phase_function = stratus::parse_phase_function("henyey_greenstein:g=0.5");
    table.albedo.values = {0.9};
    table.optical_depth.values = {2};
    table.mu_in.values = {0.5};
    table.mu_out.values = {0.5};
    table.azimuth.values = {0};
    table.reflection_multiple = {0.25f};
    table.diffusion_exponent = {0.4};
    stratus::prepare(table);

    const stratus::Geometry geometry{0.5, 0.5, 0};
    const stratus::Scattered r = stratus::reflection(table.view(), 0.9, 2, geometry);
    std::printf("R = %.6f + %.6f\n", r.single, r.multiple);
}
