// Stacks: homogeneous layers on top of one another, seen from outside.
//
// Light scattered once by a stack is that of each layer, attenuated by the layers on the way in and
// out: a closed sum. Lit from above; the layers in reverse order are the stack lit from below.
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/phase/phase_function.h>

#include <vector>

namespace stratus {

/// A homogeneous layer of a stack.
struct StackLayer {
    PhaseFunction phase_function;
    double albedo;         // [0, 1]
    double optical_depth;  // [0, inf), of the lowest layer [0, inf]
};

/// The layers of a stack, top first.
using StackLayers = std::vector<StackLayer>;

/// Checks albedos and optical depths.
///
/// Errors   std::invalid_argument naming `caller`, the layer, the allowed range and the value met;
///          for no layer at all; for infinite depth above another layer, or `over_boundary`.
void check_layers(const StackLayers& layers, bool over_boundary, const char* caller);

/// The optical depth of all layers together.
double total_depth(const StackLayers& layers) noexcept;

/// The homogeneous layer that scatters as much in all, by the same phase function on the whole:
/// total depth, mean albedo by depth, mean phase function by what is scattered. Thin stacks look
/// like it. Of infinite depth that of the lowest layer.
StackLayer mean_layer(const StackLayers& layers);

/// The optical depths of the layers above and below a layer of a stack.
struct Surroundings {
    double above = 0, below = 0;
};

/// Single scattering of a layer, seen from outside the stack.
double single_scattering_through(Side side, const Surroundings& around, double phase_value,
                                 double albedo, double optical_depth, double mu_in,
                                 double mu_out) noexcept;

/// R or diffuse T of order 1 of all layers, without what they lie on. T is 0 at infinite depth, and
/// not symmetric in the two cosines.
double stack_single_scattering(Side side, const StackLayers& layers,
                               const Geometry& geometry) noexcept;

}  // namespace stratus
