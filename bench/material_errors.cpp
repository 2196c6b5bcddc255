// Prints size, time and errors of every format: the figures of docs/exports.md.
#include "atlas_reader.h"
#include "fourier_reader.h"
#include "material_check.h"
#include "mqdiffuse_reader.h"
#include "slice_reader.h"
#include "tensor_reader.h"

#include <chrono>
#include <cstdio>
#include <string>

namespace {

using namespace stratus;
using namespace stratus::test;

constexpr double away_from_horizon = 0.15;

void print(const char* name, Errors errors) {
    std::printf("    %-22s median %.3f %%, 99 %% %.3f %%, worst %.2f %%\n", name,
                100 * errors.quantile(0.5), 100 * errors.quantile(0.99), 100 * errors.quantile(1));
}

/// A file in a folder of its own, its size and the time it took.
struct Made {
    TemporaryFolder folder;
    std::filesystem::path path, json;

    Made(const char* format_name, const Stack& stack, MaterialFormat format, const char* name) {
        const auto start = std::chrono::steady_clock::now();
        path = folder / name;
        json = std::filesystem::path(path).replace_extension(".json");
        write_material(make_material({{stack}, ""}, format), path);
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        std::printf("  %s: %.2f MB, %.1f s\n", format_name,
                    static_cast<double>(std::filesystem::file_size(path)) / 1e6, seconds);
    }
};

void report_fourier(const Stack& stack, const std::vector<Expected>& all) {
    const Made made("fourier", stack, MaterialFormat::fourier, "m.bsdf");
    const FourierReader table(content(made.path));
    Errors R, T;
    for (const Expected& at : all) {
        const auto& [mu_in, mu_out, azimuth] = at.geometry;
        R.add(table(mu_out, -mu_in, azimuth)[0] * pi, at.reflection);
        if (at.transmission > 0) T.add(table(-mu_out, -mu_in, azimuth)[0] * pi, at.transmission);
    }
    print("reflection", R);
    print("transmission", T);
}

void report_atlas(const Stack& stack, const std::vector<Expected>& all) {
    const Made made("exr-atlas", stack, MaterialFormat::exr_atlas, "m.exr");
    const AtlasReader atlas(made.path, content(made.json));
    Errors R, T;
    for (const Expected& at : all) {
        const auto& [mu_in, mu_out, azimuth] = at.geometry;
        R.add(atlas(0, mu_in, mu_out, azimuth)[0] * pi, at.reflection);
        if (at.transmission > 0) T.add(atlas(1, mu_in, mu_out, azimuth)[0] * pi, at.transmission);
    }
    print("reflection", R);
    print("transmission", T);
}

void report_slice(const Stack& stack, const std::vector<Expected>& all) {
    const Made made("slice", stack, MaterialFormat::slice, "m.safetensors");
    const SliceReader file(content(made.path));
    const SliceReader::Side reflection = file.side("reflection"),
                            rest = file.side("reflection_multiple"),
                            transmission = file.side("transmission"),
                            rest_of_T = file.side("transmission_multiple");
    Errors R, T, R_with_single, T_with_single;
    for (const Expected& at : all) {
        const auto& [mu_in, mu_out, azimuth] = at.geometry;
        R.add(reflection(mu_in, mu_out, azimuth), at.reflection);
        T.add(transmission(mu_in, mu_out, azimuth), at.transmission);
        R_with_single.add(rest(mu_in, mu_out, azimuth) +
                              stack_single_scattering(Side::reflection, stack.layers, at.geometry),
                          at.reflection);
        T_with_single.add(
            rest_of_T(mu_in, mu_out, azimuth) +
                stack_single_scattering(Side::transmission, stack.layers, at.geometry),
            at.transmission);
    }
    print("reflection", R);
    print("transmission", T);
    print("R, single added", R_with_single);
    print("T, single added", T_with_single);
}

template <class Reader>
void report_reflection(const Reader& f, const std::vector<Expected>& all) {
    Errors near_horizon, away;
    for (const Expected& at : all) {
        const auto& [mu_in, mu_out, azimuth] = at.geometry;
        const double found = f(mu_out, mu_in, pi - azimuth) * pi;
        const bool is_away = std::min(mu_in, mu_out) >= away_from_horizon;
        (is_away ? away : near_horizon).add(found, at.reflection);
    }
    print("cosines from 0.15", away);
    print("cosines below 0.15", near_horizon);
}

void report(const std::string& phase, double depth) {
    std::printf("%s, albedo 1, depth %g\n", phase.c_str(), depth);
    const Stack stack = layer(phase, 1, depth);
    const std::vector<Expected> all = random_geometries(stack, 500, 0.01);
    report_fourier(stack, all);
    report_atlas(stack, all);
    report_slice(stack, all);
    {
        const Made made("tensor", stack, MaterialFormat::tensor, "m.bsdf");
        report_reflection(TensorReader(content(made.path)), all);
    }
    const Made made("netcdf", stack, MaterialFormat::netcdf, "m.nc");
    const MqdiffuseReader grid(made.path);
    report_reflection([&](double o, double i, double phi) { return grid(o, phi, i); }, all);
}

}  // namespace

int main() {
    for (const char* phase : {"isotropic", "henyey_greenstein:g=0.5", "henyey_greenstein:g=0.85"})
        for (const double depth : {0.1, 1.0, 8.0}) report(phase, depth);
}
