// The lower boundary of a layer: none, a Lambert surface, a ground with a law of its own, or a
// semi-infinite layer with a phase function of its own.
//
// Light that reaches it through a layer of optical depth tau, is scattered there once and leaves
// again has the closed form exp(-tau/mu0) exp(-tau/mu) times the boundary's R of order 1.
#pragma once

#include <stratus/layer/ground_law.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/phase/phase_function.h>

#include <memory>

namespace stratus {

struct LowerBoundary {
    enum class Kind {
        none,     // transmitted light is lost
        surface,  // Lambert: R = albedo at every geometry
        layer,    // semi-infinite
        ground,   // R by its law
    };
    Kind kind = Kind::none;
    // The surface's, the ground's spherical albedo, or the layer's single-scattering albedo; [0, 1].
    double albedo = 0;
    PhaseFunction phase_function;          // of the layer
    std::shared_ptr<const GroundLaw> law;  // of the ground

    static LowerBoundary surface(double albedo);
    static LowerBoundary layer(PhaseFunction phase_function, double albedo);
    static LowerBoundary ground(std::shared_ptr<const GroundLaw> law);

    bool is_present() const noexcept { return kind != Kind::none; }
    bool is_surface() const noexcept { return kind == Kind::surface; }
    bool is_layer() const noexcept { return kind == Kind::layer; }
    bool is_ground() const noexcept { return kind == Kind::ground; }
    /// True where lookups of tables add what the boundary alone scatters once; what a ground
    /// reflects is tabulated.
    bool has_closed_form() const noexcept { return is_present() && !is_ground(); }
};

/// Light scattered once at the boundary, seen through the layer. 0 without one.
///
/// Range    optical_depth [0, inf], that of the layer above.
double single_reflection_of_boundary(const LowerBoundary& boundary, double optical_depth,
                                     const Geometry& geometry) noexcept;

/// Takes a value of the boundary's phase function; pass 1 for a surface, which has none, and R for
/// a ground.
double single_reflection_of_boundary(const LowerBoundary& boundary, double phase_value,
                                     double optical_depth, double mu_in, double mu_out) noexcept;

/// The phase function's value, 1 of a surface, R of a ground.
double boundary_phase_value(const LowerBoundary& boundary, const Geometry& geometry) noexcept;

}  // namespace stratus
