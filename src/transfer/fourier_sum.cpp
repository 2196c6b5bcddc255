#include <stratus/transfer/fourier_sum.h>

#include <stratus/base/argument.h>
#include <stratus/transfer/stack.h>


#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <string>
#include <utility>

namespace stratus {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd tabulate_cosines(const std::vector<double>& azimuths, int modes) {
    MatrixXd cosines(std::ssize(azimuths), modes);
    for (Index k = 0; k < cosines.rows(); ++k)
        for (Index m = 0; m < modes; ++m)
            cosines(k, m) = (m ? 2 : 1) * std::cos(static_cast<double>(m) * azimuths[size(k)]);
    return cosines;
}

/// Quantities shared by all solutions at one pair of cosines and a list of azimuths.
struct PairTable {
    std::span<const double> cos_scattering_angle, phase, boundary_phase;
};

/// The Fourier series between mu(in) and each of some mu(out), azimuths x out.
MatrixXd sum_modes(const LayerSolution& layer, Side side, int in, std::span<const int> out,
                   const MatrixXd& cosines) {
    const std::vector<AzimuthalMode>& modes = layer.modes[side];
    MatrixXd terms(std::ssize(modes), std::ssize(out));
    for (Index j = 0; j < terms.cols(); ++j)
        for (Index m = 0; m < terms.rows(); ++m) terms(m, j) = modes[size(m)](in, out[size(j)]);
    return cosines.leftCols(terms.rows()) * terms;
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
    return stratus::single_scattering(side, phase, albedo, layer.optical_depth, layer.mu(in),
                                      layer.mu(out));
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

/// Copies what is the same both ways between two cosines to the other way.
void mirror(const DirectionGrid& grid, int i, int j, GridValues& values) {
    for (std::vector<double>* const all : {&values.closed_form, &values.tabulated})
        if (!all->empty())
            std::copy_n(all->data() + grid.at(i, j, 0), grid.azimuth().size(),
                        all->data() + grid.at(j, i, 0));
}

void evaluate_stack(const LayerSolution& solution, Side side, const DirectionGrid& grid,
                    GridValues& values) {
    // R is symmetric in the cosines, of a stack, too.
    const bool symmetric = side == Side::reflection && grid.pairs().in == grid.pairs().out;
    for (int i = 0; i < grid.in_count(); ++i)
        for (int j = symmetric ? i : 0; j < grid.out_count(); ++j) {
            const int in = grid.pairs().in[size(i)], out = grid.pairs().out[size(j)];
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
            if (symmetric) mirror(grid, i, j, values);
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
                for (const Side side : both_sides) {
                    cos_scattering_angle_[side].push_back(
                        stratus::cos_scattering_angle(side, geometry));
                    phase_[side].push_back(phase_function(cos_scattering_angle_[side].back()));
                }
                boundary_phase_.push_back(boundary_phase_value(boundary, geometry));
            }
}

namespace {

/// Evaluates as `evaluate` does; `closed_form` is empty unless asked for.
GridValues evaluate_parts(const LayerSolution& solution, Side side, const DirectionGrid& grid,
                          bool asks_closed_form) {
    const auto n = std::ssize(grid.mu());
    require(solution.mu.size() == n, "evaluate", "cosines of the solution", std::to_string(n),
            solution.mu.size());
    const auto modes = std::ssize(solution.modes.reflection);
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
        const int in = grid.pairs().in[size(i)], first_out = symmetric ? i : 0;
        const std::span<const int> outs = std::span(grid.pairs().out).subspan(size(first_out));
        const MatrixXd series = sum_modes(solution, side, in, outs, grid.cosines());
        std::vector<PathWeights> along_path;
        for (std::size_t j = 0; j < outs.size() && path_law != nullptr; ++j)
            along_path.push_back(solution.path_weights(side, in, outs[j]));
        const MatrixXd rest = path_law != nullptr ? solution.path->rest(along_path) : MatrixXd();
        for (int j = first_out; j < grid.out_count(); ++j) {
            const int out = grid.pairs().out[size(j)];
            const std::size_t first = grid.at(i, j, 0);
            const auto part = [&](auto& all) { return std::span(all).subspan(first, azimuths); };
            const std::span<double> tabulated = part(values.tabulated);
            const PairTable table{part(grid.cos_scattering_angle(side)), part(grid.phase(side)),
                                  part(grid.boundary_phase())};
            std::ranges::copy(series.col(j - first_out), tabulated.begin());
            if (path_law == nullptr) {
                add_corrections(solution, side, in, out, table, tabulated);
            } else {
                const std::vector<double> along =
                    sum_legendre({rest.col(j - first_out).data(), size(rest.rows())},
                                 table.cos_scattering_angle);
                for (std::size_t k = 0; k < azimuths; ++k) {
                    tabulated[k] += along[k];
                    const double cosine = table.cos_scattering_angle[k];
                    if (asks_closed_form)
                        values.closed_form[first + k] =
                            (*path_law)(along_path[size(j - first_out)], 1 - cosine, 1 + cosine);
                }
            }
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
            if (symmetric) mirror(grid, i, j, values);
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

/// One pair of cosines among positions of a grid, and what solutions share there.
struct SketchedPair {
    int in, out;
    std::size_t first;  // of its positions
    std::vector<Index> places;
    std::vector<double> azimuth, cosine, phase, boundary;  // cosine: of the scattering angle

    SketchedPair(const DirectionGrid& grid, Side side, const std::vector<std::size_t>& positions,
                 std::size_t begin)
        : first(begin) {
        const std::size_t azimuths = grid.azimuth().size(), outs = grid.pairs().out.size(),
                          pair = positions[begin] / azimuths;
        in = grid.pairs().in[pair / outs];
        out = grid.pairs().out[pair % outs];
        for (std::size_t n = begin; n < positions.size() && positions[n] / azimuths == pair; ++n) {
            const std::size_t at = positions[n];
            places.push_back(static_cast<Index>(at % azimuths));
            azimuth.push_back(grid.azimuth()[at % azimuths]);
            cosine.push_back(grid.cos_scattering_angle(side)[at]);
            phase.push_back(grid.phase(side)[at]);
            boundary.push_back(grid.boundary_phase()[at]);
        }
    }
    std::size_t size() const { return places.size(); }
};

GridPositions::GridPositions(const DirectionGrid& grid, Side side,
                             const std::vector<std::size_t>& positions)
    : grid_(grid), side_(side), count_(positions.size()) {
    for (std::size_t first = 0; first < positions.size(); first += pairs_.back().size())
        pairs_.emplace_back(grid, side, positions, first);
}

GridPositions::~GridPositions() = default;

void GridPositions::add_mode(ModeSolution& solution, int number, const AzimuthalMode& mode) const {
    std::vector<double>& series = solution.series[side_];
    series.resize(count_);
    const auto cosines = grid_.cosines().col(number);
    for (const SketchedPair& pair : pairs_) {
        const double value = mode(pair.in, pair.out);
        for (std::size_t k = 0; k < pair.size(); ++k)
            series[pair.first + k] += cosines(pair.places[k]) * value;
    }
}

namespace {

/// Sets what a solution leaves to tables at a pair, but for the rest of a path law.
void evaluate_pair(const LayerSolution& solution, Side side, const DirectionGrid& grid,
                   const SketchedPair& pair, std::span<double> values) {
    if (solution.stack) {
        std::ranges::transform(solution.values(side, pair.in, pair.out, pair.azimuth),
                               values.begin(), &SolvedValue::multiple);
    } else {
        std::copy_n(solution.series[side].begin() + static_cast<std::ptrdiff_t>(pair.first),
                    values.size(), values.begin());
        if (grid.path_law() == nullptr)
            add_corrections(solution, side, pair.in, pair.out,
                            {pair.cosine, pair.phase, pair.boundary}, values);
    }
    const double ground =
        side == Side::reflection ? tabulated_boundary(solution, pair.in, pair.out) : 0;
    for (std::size_t k = 0; k < values.size() && ground != 0; ++k)
        values[k] += ground * pair.boundary[k];
}

/// The rest of a path law, of many solutions at once.
class RestOfPaths {
  public:
    explicit RestOfPaths(const std::vector<const LayerSolution*>& solutions) : any_(*solutions[0]) {
        for (std::size_t n = 0; n < solutions.size(); ++n) {
            Depth& depth = depths_[solutions[n]->optical_depth];
            depth.solutions.push_back(n);
            depth.orders.push_back(solutions[n]->path_orders());
        }
    }

    /// Sums along the paths of one depth once; `rest`: the sums over l at the pair.
    void add(Side side, const SketchedPair& pair, const MatrixXd& rest,
             std::vector<std::vector<double>>& values) const {
        for (const auto& [optical_depth, depth] : depths_) {
            const PathWeights along = path_weights(side, int_size(depth.orders[0]), optical_depth,
                                                   any_.mu(pair.in), any_.mu(pair.out));
            const Index orders = std::max(0, along.count - 2);
            const MatrixXd terms =
                Eigen::Map<const VectorXd>(along.of_order + 2, orders).asDiagonal() *
                rest.topRows(orders);
            for (std::size_t n = 0; n < depth.solutions.size(); ++n)
                for (std::size_t k = 0; k < pair.size(); ++k)
                    values[depth.solutions[n]][pair.first + k] +=
                        depth.orders[n].segment(2, orders).dot(terms.col(static_cast<Index>(k)));
        }
    }

  private:
    struct Depth {
        std::vector<std::size_t> solutions;
        std::vector<VectorXd> orders;  // the weights of each solution's orders
    };

    const LayerSolution& any_;
    std::map<double, Depth> depths_;  // by optical depth
};

}  // namespace

std::vector<std::vector<double>> GridPositions::evaluate_tabulated(
    const std::vector<const LayerSolution*>& solutions) const {
    std::vector<std::vector<double>> values(solutions.size(), std::vector<double>(count_));
    if (solutions.empty() ||
        (side_ == Side::transmission && solutions[0]->lower_boundary.is_present()))
        return values;
    for (std::size_t n = 0; n < solutions.size(); ++n)
        for (const SketchedPair& pair : pairs_)
            evaluate_pair(*solutions[n], side_, grid_, pair,
                          std::span(values[n]).subspan(pair.first, pair.size()));
    if (grid_.path_law() == nullptr || solutions[0]->stack) return values;
    std::call_once(has_rest_, [&] {
        for (const SketchedPair& pair : pairs_)
            rest_.push_back(solutions[0]->path->rest_of_orders(pair.cosine));
    });
    const RestOfPaths rest(solutions);
    for (std::size_t p = 0; p < pairs_.size(); ++p) rest.add(side_, pairs_[p], rest_[p], values);
    return values;
}

std::vector<SolvedValue> LayerSolution::values(Side side, int in, int out,
                                               const std::vector<double>& azimuths) const {
    if (stack) return stack->values(side, in, out, azimuths);
    if (side == Side::transmission && lower_boundary.is_present())
        return std::vector<SolvedValue>(azimuths.size());
    std::vector<double> cosines, phase, boundary_phase;
    for (const double azimuth : azimuths) {
        const Geometry geometry{mu(in), mu(out), azimuth};
        cosines.push_back(cos_scattering_angle(side, geometry));
        phase.push_back(phase_function(cosines.back()));
        boundary_phase.push_back(boundary_phase_value(lower_boundary, geometry));
    }
    const MatrixXd series_cosines = tabulate_cosines(azimuths, int_size(modes.reflection));
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

}  // namespace stratus
