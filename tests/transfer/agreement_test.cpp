// A matrix of layers on which all applicable methods are compared pairwise: each pair agrees within
// the sum of the errors that the two state.
#include <stratus/transfer/reference/solvers.h>
#include <stratus/transfer/stack.h>

#include "indices.h"
#include "row_name.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

namespace stratus {
namespace {

// ---- the layers --------------------------------------------------------------------------------

struct Layer {
    std::string name;
    PhaseFunction phase_function;
    double albedo;
    double optical_depth;
};

bool is_finite(const Layer& of) { return of.optical_depth < infinity; }

std::vector<Layer> list_layers() {
    std::vector<Layer> all;
    for (const auto& [phase, text] :
         {std::pair{"Isotropic", "isotropic"},
          {"Rayleigh", "rayleigh"},
          {"Forward", "henyey_greenstein:g=0.5"},
          {"Saturn", "0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5"},
          {"LambertSphere", "lambert_sphere"}})
        for (const auto& [albedo_name, albedo] :
             {std::pair{"Albedo03", 0.3}, {"Albedo09", 0.9}, {"Albedo1", 1.0}})
            for (const auto& [depth_name, depth] : {std::pair{"Depth01", 0.1},
                                                    {"Depth1", 1.0},
                                                    {"Depth8", 8.0},
                                                    {"Infinite", infinity}})
                all.push_back({std::string(phase) + albedo_name + depth_name,
                               parse_phase_function(text), albedo, depth});
    return all;
}

// ---- compared quantities -----------------------------------------------------------------------

const std::vector<double> compared_cosines{0.1, 0.5, 1};
constexpr int cosine_count = 3;

struct Place {
    int in, out;  // of compared_cosines
    double azimuth;
};

/// Every pair of them once (reciprocity has tests of its own); one azimuth at mu = 1.
const std::vector<Place> places = [] {
    std::vector<Place> all;
    for (int in = 0; in < cosine_count; ++in)
        for (int out = 0; out <= in; ++out)
            for (const double azimuth : {0.0, pi / 3, pi})
                if (azimuth == 0 || compared_cosines[static_cast<std::size_t>(in)] < 1)
                    all.push_back({in, out, azimuth});
    return all;
}();

/// R and T at every geometry, then plane albedos and diffuse transmittances, then both under
/// uniform illumination (the second with the beam).
const std::vector<std::string> quantities = [] {
    std::vector<std::string> all;
    for (const char* what : {"R ", "T "})
        for (const Place& at : places) {
            std::ostringstream name;
            name << what << compared_cosines[static_cast<std::size_t>(at.in)] << ' '
                 << compared_cosines[static_cast<std::size_t>(at.out)] << ' ' << at.azimuth;
            all.push_back(name.str());
        }
    for (const char* what : {"plane albedo ", "diffuse transmittance "})
        for (const double mu : compared_cosines) all.push_back(what + std::to_string(mu));
    all.insert(all.end(), {"spherical albedo", "total transmittance"});
    return all;
}();

struct Stated {
    double value;
    double error;           // infinite: the method does not apply
    double node_error = 0;  // of the quadrature, the same for all methods on the same nodes
};

struct Answer {
    std::string method;
    int nodes;                   // 0: none, or none that affect the error
    std::vector<Stated> stated;  // of all quantities
};

/// Values of a LayerSolution or StackSolution.
template <class Solution>
std::vector<double> values_of(const Solution& solution) {
    std::vector<double> all;
    for (const Side side : both_sides)
        for (const Place& at : places)
            all.push_back(value_at(solution, side, at.in, at.out, at.azimuth).total);
    for (const Eigen::VectorXd& fluxes : {solution.plane_albedo, solution.diffuse_transmittance})
        all.insert(all.end(), fluxes.begin(), fluxes.end());
    all.insert(all.end(), {solution.spherical_albedo, solution.total_transmittance});
    return all;
}

/// `share` and `node_share` of every value, and rounding beside the beam: matrices carry R and T
/// times 2 sqrt(mu mu0), of which 1e-16 is 5e-16 at mu = mu0 = 0.1.
Answer answer(const std::string& method, int nodes, const std::vector<double>& values, double share,
              double node_share) {
    Answer all{method, nodes, {}};
    for (const double value : values)
        all.stated.push_back({value, share * value + 1e-15, node_share * value});
    return all;
}

/// Largest relative change of any value above rounding.
double largest_change(const std::vector<double>& before, const std::vector<double>& after) {
    double largest = 0;
    for (const auto q : indices(after))
        if (after[q] > 1e-12)
            largest = std::max(largest, std::abs(before[q] - after[q]) / after[q]);
    return largest;
}

/// All pairs agree within the sum of their stated errors. The largest share of it used by each pair
/// is recorded (--gtest_output).
void expect_all_agree(const std::vector<Answer>& answers) {
    int comparisons = 0;
    for (const Answer& each : answers)
        for (const auto& [value, error, node_error] : each.stated)
            if (error < infinity && error + node_error > 0.25 * value + 1e-3)
                ADD_FAILURE() << each.method << " states an error that says nothing: " << error
                              << " and " << node_error << " of " << value;
    for (const auto a : indices(answers))
        for (std::size_t b = 0; b < a; ++b) {
            const Answer &A = answers[a], &B = answers[b];
            const bool same_nodes = A.nodes == B.nodes;
            double worst = 0;
            for (const auto q : indices(quantities)) {
                const Stated &x = A.stated[q], &y = B.stated[q];
                double allowed = x.error + y.error;
                if (!same_nodes) allowed += x.node_error + y.node_error;
                if (allowed == infinity) continue;
                EXPECT_NEAR(x.value, y.value, allowed)
                    << A.method << " and " << B.method << " in " << quantities[q];
                worst = std::max(worst, std::abs(x.value - y.value) / allowed);
                ++comparisons;
            }
            testing::Test::RecordProperty(B.method + " | " + A.method, std::to_string(worst));
        }
    testing::Test::RecordProperty("comparisons", comparisons);
}

// ---- the methods -------------------------------------------------------------------------------

/// Nodes for an error of 1e-9: the moments of the Lambert sphere only decay as a power.
int enough_nodes(const PhaseFunction& phase_function) {
    return phase_function.text() == "lambert_sphere" ? 48 : 32;
}

constexpr double left_by_enough = 1e-9;

SolverOptions with_enough(const Layer& of) { return with_nodes(enough_nodes(of.phase_function)); }

/// Few nodes, for methods more expensive than doubling; no truncation, as in the chain.
SolverOptions with_few() { return {.nodes = 8, .modes = 6, .truncate = Truncate::nothing}; }

LayerSolution solve(const Layer& of, const SolverOptions& options) {
    return solve_layer(of.phase_function, of.albedo, of.optical_depth, compared_cosines, options);
}

/// Error of few nodes and modes: 1.5 times the change to 12 nodes and all modes.
double left_by_few(const Layer& of, int orders = 0) {
    SolverOptions few = with_few(), more = with_few();
    few.orders = more.orders = orders;
    more.nodes = 12;
    more.modes = 0;
    return 1.5 * largest_change(values_of(solve(of, few)), values_of(solve(of, more)));
}

Answer harmonic(const Layer& of) {
    return answer("harmonic", enough_nodes(of.phase_function),
                  values_of(solve(of, with_enough(of))), 1e-12, left_by_enough);
}

/// With 1.5 times the nodes, to test the error of the nodes too.
Answer harmonic_finer(const Layer& of) {
    SolverOptions options = with_enough(of);
    options.nodes += options.nodes / 2;
    return answer("harmonic finer", options.nodes, values_of(solve(of, options)), 1e-12,
                  left_by_enough);
}

Answer harmonic_few(const Layer& of) {
    return answer("harmonic few", with_few().nodes, values_of(solve(of, with_few())), 1e-12,
                  left_by_few(of));
}

/// Two parts of 3/8 and 5/8 of the depth; in a semi-infinite layer the first has depth 3/8.
Answer stack(const Layer& of) {
    const double first = is_finite(of) ? 0.375 * of.optical_depth : 0.375;
    const double rest = is_finite(of) ? 0.625 * of.optical_depth : infinity;
    const StackSolution solution =
        solve_stack({{of.phase_function, of.albedo, first}, {of.phase_function, of.albedo, rest}},
                    {}, compared_cosines, with_enough(of));
    return answer("stack", enough_nodes(of.phase_function), values_of(solution), 1e-12,
                  left_by_enough);
}

/// The diamond rule is of second order in its start depth: its error is a third of the change on
/// halving once that depth is below all cosines, and half here, where it exceeds the smallest
/// (4e-9).
Answer classic(const Layer& of) {
    SolverOptions options = with_enough(of);
    options.scheme = Scheme::classic;
    options.start_depth = std::ldexp(1.0, -28);
    const std::vector<double> before = values_of(solve(of, options));
    options.start_depth /= 2;
    const std::vector<double> after = values_of(solve(of, options));
    return answer("classic", options.nodes, after, 1e-12 + largest_change(before, after),
                  left_by_enough);
}

/// Orders for an error below 1e-10 of the sum, 0 where that takes more than 200, or more than 60
/// for an azimuthal series (their cost grows as the square). w^30 = 2e-16 at w = 0.3; w^200 = 7e-10
/// at w = 0.9, of orders that fall off as n^(-3/2) besides; in thin layers light escapes.
int orders_needed(const Layer& of) {
    if (of.albedo < 0.5) return 30;
    if (of.optical_depth <= 0.1) return 20;
    if (of.optical_depth <= 1) return 60;
    return of.albedo < 1 && of.phase_function.is_isotropic() ? 200 : 0;
}

/// Sum of orders 1 to `last`. It lacks the beam, all that is transmitted at albedo 0.
std::vector<double> sum_orders(const Layer& of, SolverOptions options, int last,
                               std::vector<double>* last_order = nullptr) {
    std::vector<double> sum(quantities.size(), 0.0);
    sum.back() = solve_layer(of.phase_function, 0, of.optical_depth, compared_cosines, options)
                     .total_transmittance;
    options.orders = last;
    for (const LayerSolution& order :
         solve_orders(of.phase_function, of.albedo, of.optical_depth, compared_cosines, options)) {
        const std::vector<double> values = values_of(order);
        for (const auto q : indices(sum)) sum[q] += values[q];
        if (last_order) *last_order = values;
    }
    return sum;
}

Answer orders(const Layer& of) {
    std::vector<double> last;
    const std::vector<double> sum = sum_orders(of, with_few(), orders_needed(of), &last);
    for (const auto q : indices(sum))  // no order exceeds 0.9 of the one before
        EXPECT_LE(last[q], 1e-11 * sum[q] + 1e-17) << "too few orders of " << quantities[q];
    return answer("orders", with_few().nodes, sum, 1e-10, left_by_few(of));
}

/// H, or X and Y: 1e-10 (solvers.h).
Answer chandrasekhar(const Layer& of) {
    const IsotropicSolution solution =
        solve_isotropic(of.albedo, of.optical_depth, compared_cosines);
    std::vector<double> values;
    for (const Place& at : places) values.push_back(solution.reflection(at.in, at.out));
    for (const Place& at : places) values.push_back(solution.transmission(at.in, at.out));
    for (int i = 0; i < cosine_count; ++i) values.push_back(solution.plane_albedo(i));
    for (int i = 0; i < cosine_count; ++i) values.push_back(solution.diffuse_transmittance(i));
    values.push_back(solution.spherical_albedo);
    values.push_back(solution.total_transmittance);
    return answer("H, X and Y", 0, values, 1e-10, 0);
}

/// The error that the chain states, plus that of the nodes.
Answer markov(const Layer& of, int highest_order = 0) {
    MarkovOptions options;
    options.nodes = with_few().nodes;
    options.modes = with_few().modes;
    options.sublayers = 32;
    options.orders = highest_order;
    const MarkovSolution chain =
        solve_markov(of.phase_function, of.albedo, of.optical_depth, compared_cosines, options);
    Answer all = answer("Markov", options.nodes, values_of(chain.layer), 1e-12,
                        left_by_few(of, highest_order));
    std::size_t q = 0;
    for (const Side side : both_sides)
        for (const Place& at : places)
            all.stated[q++].error += value_at(chain, side, at.in, at.out, at.azimuth).error;
    while (q < quantities.size()) all.stated[q++].error += chain.flux_error;
    return all;
}

/// 4 standard errors, exceeded by chance once in 16000 values; some 2000 are compared. T below 1e-4
/// is carried by too few photons for a reliable standard error (solvers.h).
Answer photons(const Layer& of, std::uint64_t count, int highest_order = 0) {
    std::vector<Geometry> geometries;
    for (const Place& at : places)
        geometries.push_back({compared_cosines[static_cast<std::size_t>(at.in)],
                              compared_cosines[static_cast<std::size_t>(at.out)], at.azimuth});
    const PhotonSolution solution =
        solve_photons(of.phase_function, of.albedo, of.optical_depth, geometries,
                      {.photons = count, .highest_order = highest_order});
    Answer all{"photons", 0, {}};
    const auto state = [&](double value, double standard_error) {
        all.stated.push_back({value, 4 * standard_error + 1e-14});
    };
    for (const PhotonGeometry& at : solution.geometries)
        state(at.reflection.value.total, at.reflection.standard_error);
    SolverOptions stopped = with_enough(of);
    stopped.orders = highest_order;
    const std::vector<double> expected = values_of(solve(of, stopped));
    for (const PhotonGeometry& at : solution.geometries) {
        const bool few = is_finite(of) && expected[all.stated.size()] < 1e-4;
        state(at.transmission.value.total, few ? infinity : at.transmission.standard_error);
    }
    std::vector<PhotonFluxes> plane;
    for (const double mu : compared_cosines)
        plane.push_back(solution.plane[static_cast<std::size_t>(
            std::ranges::find(solution.mu_in, mu) - solution.mu_in.begin())]);
    for (const PhotonFluxes& of_mu : plane) state(of_mu.albedo.value, of_mu.albedo.standard_error);
    for (const PhotonFluxes& of_mu : plane)
        state(of_mu.transmittance.value, of_mu.transmittance.standard_error);
    state(solution.uniform.albedo.value, solution.uniform.albedo.standard_error);
    state(solution.uniform.transmittance.value + solution.uniform.direct_transmittance,
          solution.uniform.transmittance.standard_error);
    return all;
}

// ---- the matrix --------------------------------------------------------------------------------

class Methods : public testing::TestWithParam<Layer> {};

TEST_P(Methods, AgreeWithinTheirStatedErrors) {
    const Layer& of = GetParam();
    std::vector<Answer> answers{harmonic(of), harmonic_finer(of), harmonic_few(of), stack(of)};
    // In a conservative semi-infinite layer photon paths have no mean length, and rounding in
    // textbook doubling grows as fast as R converges. The chain cannot fill any semi-infinite
    // layer.
    if (is_finite(of) || of.albedo < 1) {
        answers.push_back(classic(of));
        answers.push_back(photons(of, 10'000));
    }
    if (is_finite(of)) answers.push_back(markov(of));
    if (orders_needed(of)) answers.push_back(orders(of));
    if (of.phase_function.is_isotropic()) answers.push_back(chandrasekhar(of));
    expect_all_agree(answers);
}

INSTANTIATE_TEST_SUITE_P(Of, Methods, testing::ValuesIn(list_layers()), row_name);

class StoppedSeries : public testing::TestWithParam<Layer> {};

TEST_P(StoppedSeries, AgreesAfterOrdersTwoAndThree) {
    const Layer& of = GetParam();
    for (const int last : {2, 3}) {
        SCOPED_TRACE(last);
        SolverOptions few = with_few();
        few.orders = last;
        const double few_share = left_by_few(of, last);
        std::vector<Answer> answers{
            answer("orders", enough_nodes(of.phase_function), sum_orders(of, with_enough(of), last),
                   1e-12, left_by_enough),
            answer("orders few", few.nodes, sum_orders(of, few, last), 1e-12, few_share),
            answer("layer few", few.nodes, values_of(solve(of, few)), 1e-12, few_share),
            markov(of, last), photons(of, 30'000, last)};
        expect_all_agree(answers);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Of, StoppedSeries,
    testing::Values(Layer{"IsotropicAlbedo09Depth8", PhaseFunction::isotropic(), 0.9, 8},
                    Layer{"RayleighAlbedo1Depth01", PhaseFunction::rayleigh(), 1, 0.1},
                    Layer{"ForwardAlbedo1Depth1", PhaseFunction::henyey_greenstein(0.5), 1, 1},
                    Layer{"LambertSphereAlbedo03Depth1", PhaseFunction::lambert_sphere(), 0.3, 1}),
    row_name);

}  // namespace
}  // namespace stratus
