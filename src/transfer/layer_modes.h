// Azimuthal modes of truncated layers, one after another, solved on demand: of a layer, of the lower
// boundary, and of the layers of a stack.
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/truncation.h>

#include "layer.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace stratus {

/// Along all directions.
struct Beam {
    Eigen::VectorXd unscattered;  // in the truncated problem: exp(-tau*/mu)
    Eigen::VectorXd truncated;    // its truncated (diffuse) part: exp(-tau*/mu) - exp(-tau/mu)
};

/// The requested layer, after truncation.
struct LayerTask {
    std::vector<double> moments;
    double albedo;
    double co_albedo;
    double optical_depth;  // [0, inf]
};

/// A homogeneous layer; doubles eight modes at a time.
class LayerModes {
  public:
    LayerModes(const Directions& directions, LayerTask task);

    /// Higher modes are empty: nothing is scattered into them.
    int count() const { return count_; }

    /// R, T and beam of a mode below count(); opaque at infinite depth. Valid until the next call.
    const LayerMode& layer(int mode);
    /// Phase kernels of a mode below count().
    const PhaseKernels& kernels(int mode);

  private:
    void solve_pack(int first);

    const Directions& directions_;
    const LayerTask task_;
    const DepthTarget target_;
    const int count_;
    int first_ = -1;  // mode of the current pack
    std::vector<LayerMode> layers_;
    std::vector<PhaseKernels> kernels_;
};

/// The lower boundary as an opaque layer: a Lambert surface, a ground with a law of its own, or a
/// semi-infinite layer.
class BoundaryModes {
  public:
    /// `truncation` is that of the layer's phase function; unused for a surface.
    BoundaryModes(const LowerBoundary& boundary, const Truncation& truncation,
                  const Directions& directions);

    /// Higher modes reflect nothing; 0 without a boundary, 1 for a surface; of a ground's, which have
    /// no end, as many as the nodes resolve.
    int count() const;

    /// R of one mode, an opaque layer.
    LayerMode layer(int mode);

    /// Light scattered once, unscaled, between all directions.
    Eigen::MatrixXd once(int mode);

    /// s - R s of mode 0: the weights of the net flux (diffuse_flux_between, layer.h).
    Eigen::VectorXd entering();

  private:
    /// R of a ground in one mode; computes some at a time.
    const Eigen::MatrixXd& ground(int mode);

    const LowerBoundary& boundary_;
    const Truncation& truncation_;
    const Directions& directions_;
    std::optional<LayerModes> modes_;      // of a layer
    std::vector<Eigen::MatrixXd> ground_;  // of a ground: modes from first_ on
    int first_ = 0;
};

/// The layers of a stack.
class StackModes {
  public:
    /// Truncates `layers` as `truncations` say. Directions must outlive this.
    StackModes(const StackLayers& layers, const std::vector<Truncation>& truncations,
               const Directions& directions);

    std::size_t size() const { return layers_.size(); }
    /// Returns the optical depths after truncation.
    const std::vector<double>& depths() const { return depths_; }
    /// Returns how many modes any layer scatters into.
    int count() const;

    /// Returns a layer in a mode; where nothing is scattered into the mode, the beam alone.
    LayerMode layer(std::size_t k, int mode);
    /// Returns those of each layer; null where one scatters nothing into the mode. Valid until another
    /// mode is asked for.
    std::vector<const PhaseKernels*> kernels(int mode);

    /// Returns the beam below the first `end` layers.
    Beam beam(std::size_t end) const;

  private:
    const Directions& directions_;
    std::vector<double> depths_;
    std::vector<double> left_out_;  // the optical depth that truncation takes out of each layer
    std::vector<LayerModes> layers_;
};

}  // namespace stratus
