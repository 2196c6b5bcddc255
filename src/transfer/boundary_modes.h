// The lower boundary, mode after mode, as an opaque layer: a Lambert surface, a ground with a law of
// its own, or a semi-infinite layer.
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/transfer/truncation.h>

#include "adding.h"
#include "layer_modes.h"

#include <optional>
#include <vector>

namespace stratus {

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

    /// s - R s of mode 0: the weights of the net flux (diffuse_flux_between, adding.h).
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

}  // namespace stratus
