// A program that knows no more of Stratus than stratus_lookup.h: lookups in a table, of rows of
// numbers from one file into another.
//
//   lookup_program TABLE ROWS OUT                    R and T, single and multiple; BRDF, beam
//   lookup_program TABLE ROWS OUT TAU W (thrice)     a layer: R, T, beam and BSDF of green, a direction
//                                                    drawn, its density twice, its weight in green
#include "stratus_lookup.h"

#include <cstdio>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace {

using stratus_lookup::Layer, stratus_lookup::Table, stratus_lookup::vec3;

struct Row {
    float albedo, optical_depth, mu_in, mu_out, azimuth;
};

void look_up(const Table& table, const Row& at, std::ofstream& out) {
    const auto r = table.reflection(at.albedo, at.optical_depth, at.mu_in, at.mu_out, at.azimuth),
               t = table.transmission(at.albedo, at.optical_depth, at.mu_in, at.mu_out, at.azimuth);
    const vec3 wi{std::sqrt((1 - at.mu_in) * (1 + at.mu_in)), 0, at.mu_in};
    const float sine = std::sqrt((1 - at.mu_out) * (1 + at.mu_out));
    const vec3 wo{-sine * std::cos(at.azimuth), sine * std::sin(at.azimuth), at.mu_out};
    const float found[] = {r.single,
                           r.multiple,
                           t.single,
                           t.multiple,
                           table.bsdf(wi, wo, at.albedo, at.optical_depth),
                           table.direct(at.optical_depth, at.mu_out)};
    out.write(reinterpret_cast<const char*>(found), sizeof found);
}

void look_up(const Layer& layer, const Row& at, std::ofstream& out) {
    const auto r = layer.reflection(at.mu_in, at.mu_out, at.azimuth),
               t = layer.transmission(at.mu_in, at.mu_out, at.azimuth);
    const float sine = std::sqrt((1 - at.mu_in) * (1 + at.mu_in));
    const vec3 wi{sine * std::cos(at.azimuth), sine * std::sin(at.azimuth), at.mu_in};
    const auto drawn = layer.sample(wi, at.mu_out, std::fmod(at.azimuth, 1.0f), at.albedo);
    const float found[] = {r.single.y + r.multiple.y,
                           t.single.y + t.multiple.y,
                           layer.direct(at.mu_out).y,
                           layer.bsdf(wi, drawn.wo).y,
                           drawn.wo.x,
                           drawn.wo.y,
                           drawn.wo.z,
                           drawn.pdf,
                           drawn.pdf > 0 ? layer.pdf(wi, drawn.wo) : 0,
                           drawn.pdf > 0 ? drawn.value.y * std::abs(drawn.wo.z) / drawn.pdf : 0};
    out.write(reinterpret_cast<const char*>(found), sizeof found);
}

}  // namespace

int main(int count, char** words) {
#if defined(__SSE2__)
    _mm_setcsr(_mm_getcsr() | 0x8040);  // subnormal floats are 0, as some renderers have it
#endif
    try {
        const Table table(words[1]);
        std::ifstream rows(words[2], std::ios::binary);
        std::ofstream out(words[3], std::ios::binary);
        const auto each_row = [&](const auto& of) {
            for (Row row; rows.read(reinterpret_cast<char*>(&row), sizeof row);)
                look_up(of, row, out);
        };
        if (count < 10) {
            each_row(table);
            return 0;
        }
        const auto number = [&](int n) { return std::strtof(words[n], nullptr); };
        each_row(
            Layer(table, {number(4), number(5), number(6)}, {number(7), number(8), number(9)}));
        return 0;
    } catch (const std::exception& refusal) {
        std::printf("%s", refusal.what());
        return 1;
    }
}
