#include "methods.h"

#include <stratus/bake/parallel.h>
#include <stratus/base/argument.h>
#include <stratus/transfer/reference/solvers.h>
#include <stratus/transfer/stack.h>

#include <map>

namespace stratus {
namespace {

/// The distinct cosines of geometries, and where each is in the list.
class Cosines {
  public:
    explicit Cosines(const std::vector<Geometry>& geometries) {
        for (const Geometry& at : geometries)
            for (const double mu : {at.mu_in, at.mu_out})
                if (index_.try_emplace(mu, static_cast<int>(values.size())).second)
                    values.push_back(mu);
    }

    int operator[](double mu) const { return index_.at(mu); }

    std::vector<double> values;

  private:
    std::map<double, int> index_;
};

template <class Vector>
std::vector<double> to_list(const Vector& values) {
    return {values.begin(), values.end()};
}

std::vector<double> beams(double optical_depth, const std::vector<double>& mu) {
    std::vector<double> list;
    for (const double cosine : mu) list.push_back(direct_transmittance(optical_depth, cosine));
    return list;
}

/// Fluxes of a solution. `orders`: the last one that is solved, 0: all.
template <class Solution>
MethodFluxes list_fluxes(const Solution& solution, const std::vector<double>& mu,
                         double optical_depth, double absorptance, int orders = 0) {
    MethodFluxes fluxes;
    fluxes.uniform = {{"spherical_albedo", solution.spherical_albedo},
                      {"total_transmittance", solution.total_transmittance},
                      {orders ? "absorptance_and_higher_orders" : "absorptance", absorptance}};
    if (mu.empty()) return fluxes;
    fluxes.lists = {{"mu_in", mu},
                    {"plane_albedo", to_list(solution.plane_albedo)},
                    {"diffuse_transmittance", to_list(solution.diffuse_transmittance)},
                    {"direct_transmittance", beams(optical_depth, mu)}};
    return fluxes;
}

/// Absorptance of a layer under uniform illumination.
template <class Solution>
double lost_light(const Solution& layer) {
    return 1 - layer.spherical_albedo - layer.total_transmittance;
}

/// Fluxes are made of the first azimuthal mode alone.
template <class Options>
Options flux_only(Options options) {
    options.modes = 1;
    return options;
}

/// Rows of what solve(cosines) finds: row(solution, geometry, in, out), with the places of the cosines.
template <class Solve, class Row>
std::function<std::vector<MethodRow>(const std::vector<Geometry>&)> rows_by(Solve solve, Row row) {
    return [=](const std::vector<Geometry>& geometries) {
        const Cosines cosines(geometries);
        const auto solution = solve(cosines.values);
        std::vector<MethodRow> rows;
        for (const Geometry& at : geometries)
            rows.push_back(row(solution, at, cosines[at.mu_in], cosines[at.mu_out]));
        return rows;
    };
}

/// Columns of errors, and of every order up to the last that is solved.
std::vector<std::string> error_columns(int orders = 0) {
    std::vector<std::string> columns{"reflection_error", "transmission_error"};
    for (const char* side : {"reflection_order_", "transmission_order_"})
        for (int n = 1; n <= orders; ++n) columns.push_back(side + std::to_string(n));
    return columns;
}

// ---- the solver --------------------------------------------------------------------------------

/// Textbook doubling, whose thin layer errs where more nodes do not help.
Method by_classic(const SolveRequest& request) {
    SolverOptions options;
    if (request.nodes) options.nodes = request.nodes;
    options.scheme = Scheme::classic;
    if (request.start == "single") options.start = ClassicStart::single;
    options.start_depth = request.start_depth;
    const auto solve = [=](const std::vector<double>& mu, const SolverOptions& with) {
        return solve_layer(request.phase_function, request.albedo, request.optical_depth, mu, with);
    };
    Method method;
    method.rows = rows_by(
        [=](const std::vector<double>& mu) { return solve(mu, options); },
        [](const LayerSolution& solution, const Geometry& at, int in, int out) -> MethodRow {
            return {{solution.reflection(in, out, at.azimuth),
                     solution.transmission(in, out, at.azimuth)},
                    {}};
        });
    method.fluxes = [=](const std::vector<double>& mu) {
        const LayerSolution solution = solve(mu, flux_only(options));
        return list_fluxes(solution, mu, request.optical_depth,
                           request.albedo == 1 ? 0 : lost_light(solution));
    };
    return method;
}

MethodFluxes solved_fluxes(const Stack& stack, const SolverOptions& options,
                           const std::vector<double>& mu) {
    const SolvedFluxes solved = solve_fluxes(stack.layers, stack.lower_boundary, mu, options);
    const bool is_over = stack.lower_boundary.is_present();
    MethodFluxes fluxes = list_fluxes(solved, mu, stack.optical_depth(),
                                      absorptance(stack, solved, options.orders), options.orders);
    if (is_over) {
        fluxes.uniform.emplace_back("ground_absorptance", solved.spherical_ground_absorptance);
        if (!mu.empty())
            fluxes.lists.emplace_back("plane_ground_absorptance", solved.ground_absorptance);
    }
    fluxes.uniform.emplace_back("error", solved.error);
    fluxes.misses = options.tolerance > 0 && solved.relative_error > options.tolerance;
    if (options.orders == 0) return fluxes;
    SolverOptions with = flux_only(options);
    with.nodes = solved.nodes;
    std::vector<double> albedo, transmittance;
    for (const StackSolution& order : solve_orders(stack.layers, stack.lower_boundary, mu, with)) {
        albedo.push_back(order.spherical_albedo);
        transmittance.push_back(order.total_transmittance);
    }
    fluxes.lists.insert(fluxes.lists.begin(), {{"spherical_albedo_of_order", albedo},
                                               {"diffuse_transmittance_of_order", transmittance}});
    return fluxes;
}

std::vector<MethodRow> solved_rows(const Stack& stack, const SolverOptions& options,
                                   const std::vector<Geometry>& geometries) {
    const SolvedGeometries solved =
        solve_geometries(stack.layers, stack.lower_boundary, geometries, options);
    const auto misses = [&](const SolvedValue& value, double error) {
        return options.tolerance > 0 && relative_error(value.total, error) > options.tolerance;
    };
    std::vector<MethodRow> rows;
    for (const SolvedGeometry& at : solved.at)
        rows.push_back({{at.reflection, at.transmission},
                        {at.reflection_error, at.transmission_error},
                        {misses(at.reflection, at.reflection_error),
                         misses(at.transmission, at.transmission_error)}});
    if (options.orders == 0) return rows;
    SolverOptions with = options;
    with.nodes = solved.nodes;
    const Cosines cosines(geometries);
    const std::vector<StackSolution> orders =
        solve_orders(stack.layers, stack.lower_boundary, cosines.values, with);
    for (std::size_t row = 0; row < rows.size(); ++row) {
        const Geometry& at = geometries[row];
        const int in = cosines[at.mu_in], out = cosines[at.mu_out];
        for (const StackSolution& order : orders)
            rows[row].more.push_back(order.reflection(in, out, at.azimuth).total);
        for (const StackSolution& order : orders)
            rows[row].more.push_back(order.transmission(in, out, at.azimuth).total);
    }
    return rows;
}

// ---- the reference solvers ---------------------------------------------------------------------

Method by_h_function(const SolveRequest& request) {
    require(request.phase_function.is_isotropic(), "solve", "--phase",
            "isotropic for the scheme h-function", request.phase_function.text());
    const auto solve = [=](const std::vector<double>& mu) {
        const std::vector<double> cosines = mu.empty() ? std::vector<double>{1} : mu;
        return request.nodes
                   ? solve_isotropic(request.albedo, request.optical_depth, cosines, request.nodes)
                   : solve_isotropic(request.albedo, request.optical_depth, cosines);
    };
    Method method;
    const auto row = [=](const IsotropicSolution& solution, const Geometry& at, int in,
                         int out) -> MethodRow {
        const auto part = [&](Side side, double all) {
            const double once = single_scattering(side, 1, request.albedo, request.optical_depth,
                                                  at.mu_in, at.mu_out);
            return SolvedValue{all, once, all - once};
        };
        return {{part(Side::reflection, solution.reflection(in, out)),
                 part(Side::transmission, solution.transmission(in, out))},
                {}};
    };
    method.rows = rows_by(solve, row);
    method.fluxes = [=](const std::vector<double>& mu) {
        const IsotropicSolution solution = solve(mu);
        return list_fluxes(solution, mu, request.optical_depth,
                           request.albedo == 1 ? 0 : lost_light(solution));
    };
    return method;
}

/// A Markov chain, and doubling by its nodes and by twice as many: what their number changes, and half as much
/// again for what twice as many still miss.
struct MarkovChain {
    static constexpr double more = 1.5;
    MarkovSolution chain;
    LayerSolution coarse, fine;

    double node_error(Side side, int in, int out, double azimuth) const {
        return more * std::abs(coarse.values(side, in, out, {azimuth})[0].total -
                               fine.values(side, in, out, {azimuth})[0].total);
    }
    double node_error() const {
        return more * std::max({std::abs(coarse.spherical_albedo - fine.spherical_albedo),
                                std::abs(coarse.total_transmittance - fine.total_transmittance),
                                (coarse.plane_albedo - fine.plane_albedo).cwiseAbs().maxCoeff(),
                                (coarse.diffuse_transmittance - fine.diffuse_transmittance)
                                    .cwiseAbs()
                                    .maxCoeff()});
    }
};

Method by_markov(const SolveRequest& request) {
    MarkovOptions options;
    if (request.nodes) options.nodes = request.nodes;
    if (request.sublayers) options.sublayers = request.sublayers;
    options.orders = request.orders;
    const auto solve = [=](const std::vector<double>& asked, const MarkovOptions& with) {
        // Without cosines solutions would be along their own nodes, which differ.
        const std::vector<double> mu = asked.empty() ? std::vector<double>{1} : asked;
        const auto doubled = [&](int nodes) {
            SolverOptions doubling;
            doubling.nodes = nodes;
            doubling.modes = with.modes;
            doubling.orders = with.orders;
            doubling.truncate = Truncate::nothing;
            return solve_layer(request.phase_function, request.albedo, request.optical_depth, mu,
                               doubling);
        };
        return MarkovChain{
            solve_markov(request.phase_function, request.albedo, request.optical_depth, mu, with),
            doubled(with.nodes), doubled(std::min(512, 2 * with.nodes))};
    };
    Method method;
    method.more_columns = error_columns(request.orders);
    const auto row = [=](const MarkovChain& solved, const Geometry& at, int in, int out) {
        const MarkovValue R = solved.chain.reflection(in, out, at.azimuth);
        const MarkovValue T = solved.chain.transmission(in, out, at.azimuth);
        MethodRow row{{R.value, T.value},
                      {R.error + solved.node_error(Side::reflection, in, out, at.azimuth),
                       T.error + solved.node_error(Side::transmission, in, out, at.azimuth)}};
        for (const Side side : both_sides)
            for (int n = 1; n <= request.orders; ++n)
                row.more.push_back(solved.chain.of_order(side, n, in, out, at.azimuth));
        return row;
    };
    method.rows = rows_by([=](const std::vector<double>& mu) { return solve(mu, options); }, row);
    method.fluxes = [=](const std::vector<double>& mu) {
        const MarkovChain solved = solve(mu, flux_only(options));
        const LayerSolution& layer = solved.chain.layer;
        MethodFluxes fluxes =
            list_fluxes(layer, mu, request.optical_depth, lost_light(layer), request.orders);
        fluxes.uniform.emplace_back("error", solved.chain.flux_error + solved.node_error());
        return fluxes;
    };
    return method;
}

Method by_photons(const SolveRequest& request) {
    PhotonOptions options;
    if (request.photons) options.photons = request.photons;
    options.seed = request.seed;
    options.highest_order = request.orders;
    options.backward_collisions = request.backward_collisions;
    options.parallel_for = [threads = request.threads](int count,
                                                       const std::function<void(int)>& body) {
        parallel_for(count, threads, body);
    };
    const auto solve = [=](const std::vector<Geometry>& geometries) {
        return solve_photons(request.phase_function, request.albedo, request.optical_depth,
                             geometries, options);
    };
    Method method;
    method.more_columns = error_columns();
    method.max_cosines = std::numeric_limits<std::size_t>::max();
    method.rows = [=](const std::vector<Geometry>& geometries) {
        std::vector<MethodRow> rows;
        for (const PhotonGeometry& at : solve(geometries).geometries)
            rows.push_back({{at.reflection.value, at.transmission.value},
                            {at.reflection.standard_error, at.transmission.standard_error}});
        return rows;
    };
    method.fluxes = [=](const std::vector<double>& mu) {
        std::vector<Geometry> vertical;
        for (const double cosine : mu) vertical.push_back({cosine, 1, 0});
        const PhotonSolution solution = solve(vertical);
        const PhotonFluxes& all = solution.uniform;
        MethodFluxes fluxes;
        fluxes.uniform = {
            {"spherical_albedo", all.albedo.value},
            {"total_transmittance", all.transmittance.value + all.direct_transmittance},
            {"absorptance", all.absorptance.value},
            {"spherical_albedo_error", all.albedo.standard_error},
            {"total_transmittance_error", all.transmittance.standard_error},
            {"absorptance_error", all.absorptance.standard_error}};
        if (mu.empty()) return fluxes;
        const auto column = [&](Estimate PhotonFluxes::*flux, double Estimate::*number) {
            std::vector<double> values;
            for (const PhotonFluxes& at : solution.plane) values.push_back(at.*flux.*number);
            return values;
        };
        fluxes.lists = {
            {"mu_in", solution.mu_in},
            {"plane_albedo", column(&PhotonFluxes::albedo, &Estimate::value)},
            {"diffuse_transmittance", column(&PhotonFluxes::transmittance, &Estimate::value)},
            {"direct_transmittance", beams(request.optical_depth, solution.mu_in)},
            {"plane_albedo_error", column(&PhotonFluxes::albedo, &Estimate::standard_error)},
            {"diffuse_transmittance_error",
             column(&PhotonFluxes::transmittance, &Estimate::standard_error)}};
        return fluxes;
    };
    return method;
}

}  // namespace

Method make_method(const SolveRequest& request) {
    if (request.scheme == "h-function") return by_h_function(request);
    if (request.scheme == "markov") return by_markov(request);
    if (request.scheme == "photons") return by_photons(request);
    if (request.scheme == "classic") return by_classic(request);
    return make_method(Stack{{{request.phase_function, request.albedo, request.optical_depth}}, {}},
                       request);
}

SolverOptions make_options(const SolveRequest& request) {
    SolverOptions options;
    if (request.nodes)
        options.nodes = request.nodes;
    else
        options.tolerance = request.tolerance;
    return options;
}

Method make_method(const Stack& stack, const SolveRequest& request) {
    SolverOptions options = make_options(request);
    options.orders = request.orders;
    Method method;
    // With orders, these are solved at all cosines that are given at once.
    if (request.orders == 0) method.max_cosines = std::numeric_limits<std::size_t>::max();
    method.more_columns = error_columns(request.orders);
    method.rows = [=](const std::vector<Geometry>& geometries) {
        return solved_rows(stack, options, geometries);
    };
    method.fluxes = [=](const std::vector<double>& mu) {
        return solved_fluxes(stack, options, mu);
    };
    return method;
}

}  // namespace stratus
