#include <stratus/transfer/fourier_sum.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/transfer/stack.h>

#include "options.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <utility>

namespace stratus {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd tabulate_cosines(const std::vector<double>& azimuths, int modes) {
    MatrixXd cosines(static_cast<Eigen::Index>(azimuths.size()), modes);
    for (Eigen::Index k = 0; k < cosines.rows(); ++k)
        for (Eigen::Index m = 0; m < modes; ++m)
            cosines(k, m) = (m ? 2 : 1) * std::cos(static_cast<double>(m) *
                                                   azimuths[static_cast<std::size_t>(k)]);
    return cosines;
}

/// Quantities shared by all solutions at one pair of cosines and a list of azimuths.
struct PairTable {
    std::span<const double> cos_scattering_angle, phase, boundary_phase;
};

/// The Fourier series between mu(in) and each of some mu(out), azimuths x out.
MatrixXd sum_modes(const LayerSolution& layer, Side side, int in, std::span<const int> out,
                   const MatrixXd& cosines) {
    const auto& modes =
        side == Side::reflection ? layer.reflection_modes : layer.transmission_modes;
    const auto count = static_cast<Eigen::Index>(modes.size());
    MatrixXd terms(count, static_cast<Eigen::Index>(out.size()));
    for (Eigen::Index j = 0; j < terms.cols(); ++j)
        for (Eigen::Index m = 0; m < count; ++m)
            terms(m, j) = modes[static_cast<std::size_t>(m)](in, out[static_cast<std::size_t>(j)]);
    return cosines.leftCols(count) * terms;
}

/// Multiple scattering between mu(in) and mu(out) at all azimuths of the table, in two parts; `rest`
/// holds the Fourier series.
struct MultipleParts {
    std::span<double> path, rest;  // path: empty where it is not asked for
};

void split_multiple(const LayerSolution& layer, Side side, int in, int out, const PairTable& table,
                    const PathOrders& path_law, const MultipleParts& parts) {
    const PathWeights weights = layer.path_weights(side, in, out);
    const VectorXd rest = layer.path->rest(weights);
    const std::vector<double> along_path = sum_legendre(
        std::span(rest.data(), static_cast<std::size_t>(rest.size())), table.cos_scattering_angle);
    for (std::size_t k = 0; k < parts.rest.size(); ++k) parts.rest[k] += along_path[k];
    for (std::size_t k = 0; k < parts.path.size(); ++k) {
        const double cosine = table.cos_scattering_angle[k];
        parts.path[k] = path_law(weights, 1 - cosine, 1 + cosine);
    }
}

/// Makes the Fourier series all multiple scattering between mu(in) and mu(out), at all azimuths of
/// the table.
void add_corrections(const LayerSolution& layer, Side side, int in, int out, const PairTable& table,
                     std::span<double> multiple) {
    const PeakCorrection peak = layer.peak_correction(side, in, out);
    for (std::size_t k = 0; k < multiple.size() && peak.single != 0; ++k)
        multiple[k] += peak.single * table.phase[k];
    if (!peak.legendre.empty()) {
        const std::vector<double> scattered_again =
            sum_legendre(peak.legendre, table.cos_scattering_angle);
        for (std::size_t k = 0; k < multiple.size(); ++k) multiple[k] += scattered_again[k];
    }
    if (!layer.lower_boundary.is_present()) return;
    const double correction = layer.boundary_correction(in, out);
    for (std::size_t k = 0; k < multiple.size(); ++k)
        multiple[k] += correction * table.boundary_phase[k];
}

double single_scattering(const LayerSolution& layer, Side side, double phase, int in, int out) {
    const double albedo = layer.order_weights.size() ? layer.order_weights(1) : layer.albedo;
    return (side == Side::reflection ? single_reflection : single_transmission)(
        phase, albedo, layer.optical_depth, layer.mu(in), layer.mu(out));
}

double seen_boundary(const LayerSolution& layer, double phase, int in, int out) {
    return single_reflection_of_boundary(layer.lower_boundary, phase, layer.optical_depth,
                                         layer.mu(in), layer.mu(out));
}

/// Tables hold what the boundary alone reflects where lookups have no closed form for it; for each
/// unit of its phase function.
double tabulated_boundary(const LayerSolution& layer, int in, int out) {
    return layer.lower_boundary.has_closed_form() ? 0 : seen_boundary(layer, 1, in, out);
}

void evaluate_stack(const LayerSolution& solution, Side side, const DirectionGrid& grid,
                    GridValues& values) {
    // R is symmetric in the cosines, of a stack, too.
    const bool symmetric = side == Side::reflection && grid.pairs().in == grid.pairs().out;
    const std::ptrdiff_t azimuths = std::ssize(grid.azimuth());
    for (int i = 0; i < grid.in_count(); ++i)
        for (int j = 0; j < grid.out_count(); ++j) {
            if (symmetric && j < i) {
                for (std::vector<double>* const all : {&values.closed_form, &values.tabulated})
                    if (!all->empty())
                        std::copy_n(all->begin() + static_cast<std::ptrdiff_t>(grid.at(j, i, 0)),
                                    azimuths,
                                    all->begin() + static_cast<std::ptrdiff_t>(grid.at(i, j, 0)));
                continue;
            }
            const int in = grid.pairs().in[static_cast<std::size_t>(i)],
                      out = grid.pairs().out[static_cast<std::size_t>(j)];
            const double ground =
                side == Side::reflection ? tabulated_boundary(solution, in, out) : 0;
            const std::vector<SolvedValue> here = solution.values(side, in, out, grid.azimuth());
            for (std::size_t k = 0; k < here.size(); ++k) {
                const std::size_t at = grid.at(i, j, static_cast<int>(k));
                const double tabulated = ground * grid.boundary_phase()[at];
                if (!values.closed_form.empty())
                    values.closed_form[at] = here[k].single - tabulated;
                values.tabulated[at] = here[k].multiple + tabulated;
            }
        }
}

}  // namespace

DirectionGrid::DirectionGrid(const PhaseFunction& phase_function, const LowerBoundary& boundary,
                             std::vector<double> mu, std::vector<double> azimuth, int max_modes,
                             std::shared_ptr<const PathOrders> path_law, CosinePairs pairs)
    : mu_(std::move(mu)),
      pairs_(std::move(pairs)),
      azimuth_(std::move(azimuth)),
      cosines_(tabulate_cosines(azimuth_, max_modes)),
      path_law_(std::move(path_law)) {
    if (pairs_.in.empty() && pairs_.out.empty()) {
        pairs_.in.resize(mu_.size());
        std::iota(pairs_.in.begin(), pairs_.in.end(), 0);
        pairs_.out = pairs_.in;
    }
    for (int in = 0; in < in_count(); ++in)
        for (int out = 0; out < out_count(); ++out)
            for (const double phi : azimuth_) {
                const Geometry geometry{mu_in(in), mu_out(out), phi};
                reflected_.push_back(cos_scattering_angle_reflected(geometry));
                transmitted_.push_back(cos_scattering_angle_transmitted(geometry));
                reflected_phase_.push_back(phase_function(reflected_.back()));
                transmitted_phase_.push_back(phase_function(transmitted_.back()));
                boundary_phase_.push_back(boundary_phase_value(boundary, geometry));
            }
}

namespace {

/// Evaluates as `evaluate` does; `closed_form` is empty unless asked for.
GridValues evaluate_parts(const LayerSolution& solution, Side side, const DirectionGrid& grid,
                          bool asks_closed_form) {
    const auto n = static_cast<Eigen::Index>(grid.mu().size());
    require(solution.mu.size() == n, "evaluate", "cosines of the solution", std::to_string(n),
            solution.mu.size());
    const auto modes = static_cast<Eigen::Index>(solution.reflection_modes.size());
    require(modes <= grid.cosines().cols(), "evaluate", "modes of the solution",
            "at most " + std::to_string(grid.cosines().cols()), modes);
    GridValues values{std::vector<double>(asks_closed_form ? grid.size() : 0),
                      std::vector<double>(grid.size())};
    if (side == Side::transmission && solution.lower_boundary.is_present()) return values;
    const PathOrders* const path_law = grid.path_law();
    require(path_law == nullptr || solution.path != nullptr, "evaluate", "path law",
            "that of a solution whose peak is narrow", "another");
    if (solution.stack) {
        evaluate_stack(solution, side, grid, values);
        return values;
    }
    const std::size_t azimuths = grid.azimuth().size();
    const bool symmetric = grid.pairs().are_symmetric();
    for (int i = 0; i < grid.in_count(); ++i) {
        const int in = grid.pairs().in[static_cast<std::size_t>(i)], first_out = symmetric ? i : 0;
        const MatrixXd series =
            sum_modes(solution, side, in,
                      std::span(grid.pairs().out).subspan(static_cast<std::size_t>(first_out)),
                      grid.cosines());
        for (int j = first_out; j < grid.out_count(); ++j) {
            const int out = grid.pairs().out[static_cast<std::size_t>(j)];
            const std::size_t first = grid.at(i, j, 0);
            const auto part = [&](auto& all) {
                return all.empty() ? std::span(all) : std::span(all).subspan(first, azimuths);
            };
            std::ranges::copy(series.col(j - first_out), part(values.tabulated).begin());
            const PairTable table{part(grid.cos_scattering_angle(side)), part(grid.phase(side)),
                                  part(grid.boundary_phase())};
            if (path_law != nullptr)
                split_multiple(solution, side, in, out, table, *path_law,
                               {part(values.closed_form), part(values.tabulated)});
            else
                add_corrections(solution, side, in, out, table, part(values.tabulated));
            const double ground = tabulated_boundary(solution, in, out);
            for (std::size_t at = first; at < first + azimuths && ground != 0; ++at)
                values.tabulated[at] += ground * grid.boundary_phase()[at];
            if (asks_closed_form) {
                const double once = single_scattering(solution, side, 1, in, out);
                const double boundary = seen_boundary(solution, 1, in, out) - ground;
                for (std::size_t at = first; at < first + azimuths; ++at)
                    values.closed_form[at] +=
                        once * grid.phase(side)[at] + boundary * grid.boundary_phase()[at];
            }
            if (!symmetric) continue;
            for (std::vector<double>* all : {&values.closed_form, &values.tabulated})
                if (!all->empty())
                    std::copy_n(all->data() + first, azimuths, all->data() + grid.at(j, i, 0));
        }
    }
    return values;
}

}  // namespace

GridValues evaluate(const LayerSolution& solution, Side side, const DirectionGrid& grid) {
    return evaluate_parts(solution, side, grid, true);
}

std::vector<double> evaluate_tabulated(const LayerSolution& solution, Side side,
                                       const DirectionGrid& grid) {
    return evaluate_parts(solution, side, grid, false).tabulated;
}

namespace {

/// Evaluates what a solution leaves to tables, pair by pair of cosines, at some azimuths of a grid.
class PairSamples {
  public:
    PairSamples(const LayerSolution& solution, Side side, const DirectionGrid& grid)
        : solution_(solution), side_(side), grid_(grid) {}

    /// `positions`: in the grid, of one pair. Writes as many values.
    void write(std::span<const std::size_t> positions, double* values) {
        const std::size_t azimuths = grid_.azimuth().size(), pair = positions[0] / azimuths,
                          outs = grid_.pairs().out.size();
        const int in = grid_.pairs().in[pair / outs], out = grid_.pairs().out[pair % outs];
        const double ground =
            side_ == Side::reflection ? tabulated_boundary(solution_, in, out) : 0;
        if (solution_.stack) {
            std::vector<double> some;
            for (const std::size_t at : positions) some.push_back(grid_.azimuth()[at % azimuths]);
            for (const SolvedValue& value : solution_.values(side_, in, out, some))
                *values++ = value.multiple;
            if (ground != 0)
                for (std::size_t n = positions.size(); n-- > 0;)
                    *--values += ground * grid_.boundary_phase()[positions[n]];
            return;
        }
        const auto& modes =
            side_ == Side::reflection ? solution_.reflection_modes : solution_.transmission_modes;
        terms_.resize(static_cast<Eigen::Index>(modes.size()));
        for (Eigen::Index m = 0; m < terms_.size(); ++m)
            terms_(m) = modes[static_cast<std::size_t>(m)](in, out);
        cosines_.clear();
        phase_.clear();
        boundary_.clear();
        const std::span<double> all(values, positions.size());
        for (std::size_t n = 0; n < positions.size(); ++n) {
            const std::size_t at = positions[n];
            const auto azimuth = static_cast<Eigen::Index>(at % azimuths);
            all[n] = grid_.cosines().row(azimuth).head(terms_.size()).dot(terms_);
            cosines_.push_back(grid_.cos_scattering_angle(side_)[at]);
            phase_.push_back(grid_.phase(side_)[at]);
            boundary_.push_back(grid_.boundary_phase()[at]);
        }
        const PairTable table{cosines_, phase_, boundary_};
        if (grid_.path_law() != nullptr)
            split_multiple(solution_, side_, in, out, table, *grid_.path_law(), {{}, all});
        else
            add_corrections(solution_, side_, in, out, table, all);
        for (std::size_t n = 0; n < all.size() && ground != 0; ++n) all[n] += ground * boundary_[n];
    }

  private:
    const LayerSolution& solution_;
    Side side_;
    const DirectionGrid& grid_;
    VectorXd terms_;
    std::vector<double> cosines_, phase_, boundary_;
};

}  // namespace

std::vector<double> evaluate_tabulated(const LayerSolution& solution, Side side,
                                       const DirectionGrid& grid,
                                       const std::vector<std::size_t>& positions) {
    std::vector<double> values(positions.size());
    if (side == Side::transmission && solution.lower_boundary.is_present()) return values;
    PairSamples samples(solution, side, grid);
    const std::size_t azimuths = grid.azimuth().size();
    for (std::size_t first = 0, end = 0; first < positions.size(); first = end) {
        while (end < positions.size() && positions[end] / azimuths == positions[first] / azimuths)
            ++end;
        samples.write(std::span(positions).subspan(first, end - first), &values[first]);
    }
    return values;
}

std::vector<SolvedValue> LayerSolution::values(Side side, int in, int out,
                                               const std::vector<double>& azimuths) const {
    if (stack) return stack->values(side, in, out, azimuths);
    if (side == Side::transmission && lower_boundary.is_present())
        return std::vector<SolvedValue>(azimuths.size(), {0, 0, 0});
    std::vector<double> cosines, phase, boundary_phase;
    for (const double azimuth : azimuths) {
        const Geometry geometry{mu(in), mu(out), azimuth};
        cosines.push_back(side == Side::reflection ? cos_scattering_angle_reflected(geometry)
                                                   : cos_scattering_angle_transmitted(geometry));
        phase.push_back(phase_function(cosines.back()));
        boundary_phase.push_back(boundary_phase_value(lower_boundary, geometry));
    }
    const MatrixXd series_cosines =
        tabulate_cosines(azimuths, static_cast<int>(reflection_modes.size()));
    const VectorXd series = sum_modes(*this, side, in, {&out, 1}, series_cosines);
    std::vector<double> multiple(series.begin(), series.end());
    add_corrections(*this, side, in, out, {cosines, phase, boundary_phase}, multiple);
    std::vector<SolvedValue> all;
    for (std::size_t k = 0; k < azimuths.size(); ++k) {
        const double single = single_scattering(*this, side, phase[k], in, out) +
                              seen_boundary(*this, boundary_phase[k], in, out);
        all.push_back({single + multiple[k], single, multiple[k]});
    }
    return all;
}

SolvedValue LayerSolution::reflection(int in, int out, double azimuth) const {
    return values(Side::reflection, in, out, {azimuth})[0];
}

SolvedValue LayerSolution::transmission(int in, int out, double azimuth) const {
    return values(Side::transmission, in, out, {azimuth})[0];
}

}  // namespace stratus
