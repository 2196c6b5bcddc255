// Which samples of a table speak for one mixture, optical depth and albedo, and by how much each:
// cubic along these axes, the laws of diffusion between the deepest sample and infinity, the way
// around samples that float cannot hold.
#pragma once

#include <stratus/runtime/table.h>

#include <cstddef>

namespace stratus {

/// Where less than this of the law of diffusion is left at the deepest sample, that sample is the
/// limit itself.
constexpr double min_deficit = 1e-5;

/// One (mixture, albedo, optical_depth) of a side: where its directions start among the side's
/// samples, its share of the answer, its depth.
struct Layer {
    std::ptrdiff_t first;
    float share;
    int depth;
};

/// The layers that a lookup adds up, each over (mu_in, mu_out, azimuth) times the table's weights
/// of its depth along both directions: no more than 4 mixtures by 4 albedos by 4 depths.
struct Layers {
    const float* samples;  // of the side
    Layer layer[window * window * window];
    int count = 0;
    double optical_depth = 0;  // clamped to the table
    bool fades = false;        // see `directional_factor`
};

/// Needs a table that has this side.
Layers reflection_layers(const TableView& table, double albedo, double optical_depth) noexcept;
Layers transmission_layers(const TableView& table, double albedo, double optical_depth) noexcept;

/// What the sum over the layers is to be multiplied by along both directions: what the samples were
/// divided by.
double directional_factor(const TableView& table, const Layers& layers, double mu_in,
                          double mu_out) noexcept;

}  // namespace stratus
