// R and T of one layer or stack on even axes, as named arrays in the safetensors layout: for
// lookups by straight lines, in any language.
#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>
#include <stratus/base/size.h>
#include <stratus/base/tensor_file.h>
#include <stratus/io/file_bytes.h>

#include "solved_stack.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace stratus {
namespace {

constexpr int slice_cosines = 64, slice_azimuths = 65;
constexpr auto cosines = size(slice_cosines), azimuths = size(slice_azimuths);

/// Samples of one side over (colour, mu_in, mu_out, azimuth), times mu_in + mu_out.
struct Samples {
    std::vector<float> all_orders, multiple;
};

Samples sample(const LitSide& side, const std::vector<SolvedStack>& colours,
               const std::vector<double>& mu, int threads) {
    const std::vector<double> around = even_azimuths(slice_azimuths);
    const std::size_t count = colours.size() * cosines * cosines * azimuths;
    Samples samples{std::vector<float>(count), std::vector<float>(count)};
    parallel_for(static_cast<int>(colours.size()) * slice_cosines, threads, [&](int row) {
        const int in = row % slice_cosines;
        const SolvedStack& colour = colours[size(row / slice_cosines)];
        std::size_t at = size(row) * cosines * azimuths;
        for (int out = 0; out < slice_cosines; ++out) {
            const double sum = mu[size(in)] + mu[size(out)];
            for (const SolvedValue& value : (colour.*side.values)(in, out, around)) {
                samples.all_orders[at] = static_cast<float>(sum * value.total);
                samples.multiple[at++] = static_cast<float>(sum * value.multiple);
            }
        }
    });
    return samples;
}

void set_strings(const Material& material, TensorWriter& file) {
    file.set("format", "stratus-slice");
    file.set("format_version", "1");
    file.set("material", describe(material));
    file.set("axes", "colour, mu_in, mu_out, azimuth; one colour, or red, green and blue");
    file.set("coordinates",
             "even from 0 to 1: asin(sqrt(mu_in)) 2 / pi, asin(sqrt(mu_out)) 2 / pi, azimuth / pi; "
             "azimuth 0 is forward, and light is even in it; straight lines between samples");
    file.set("values",
             "R or T times (mu_in + mu_out); BRDF or BTDF = value / (pi (mu_in + mu_out)), per "
             "steradian, without the cosine");
    file.set("orders",
             "reflection, transmission and reflection_below (lit from below): all orders; the same "
             "with _multiple: orders n >= 2");
    file.set("not_in_it",
             "the beam straight through, exp(-optical_depth / mu); light from below is transmitted "
             "as from above with mu_in and mu_out exchanged");
}

void add_fluxes(const std::vector<SolvedStack>& colours, TensorWriter& file) {
    std::vector<double> albedo, transmittance;
    for (const SolvedStack& colour : colours) {
        const ModeSolution& solution = colour.solution();
        albedo.insert(albedo.end(), solution.plane_albedo.begin(), solution.plane_albedo.end());
        for (const double share : solution.diffuse_transmittance)
            transmittance.push_back(colour.is_transparent() ? share : 0);
    }
    file.add("plane_albedo", {colours.size(), cosines}, albedo);
    file.add("diffuse_transmittance", {colours.size(), cosines}, transmittance);
}

}  // namespace

MaterialFile make_slice(const Material& material, const MaterialOptions& options) {
    MaterialFile file;
    note_beam(material, file.notes);
    const std::vector<double> mu = even_cosines(slice_cosines);
    const std::vector<SolvedStack> colours = solve_colours(material, mu, options);
    TensorWriter tensors;
    set_strings(material, tensors);
    std::vector<double> axis = mu;
    axis[0] = 0;
    tensors.add("mu_in", {cosines}, axis);
    tensors.add("mu_out", {cosines}, axis);
    tensors.add("azimuth", {azimuths}, even_azimuths(slice_azimuths));
    tensors.add("optical_depth", {colours.size()}, beam_depths(material));
    add_fluxes(colours, tensors);
    for (const LitSide& side : lit_sides(material, colours)) {
        const Samples samples = sample(side, colours, mu, options.threads);
        const std::vector<std::size_t> shape{colours.size(), cosines, cosines, azimuths};
        tensors.add(side.name, shape, samples.all_orders);
        tensors.add(std::string(side.name) + "_multiple", shape, samples.multiple);
    }
    file.write = writing(tensors.finish());
    return file;
}

}  // namespace stratus
