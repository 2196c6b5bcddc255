#include <stratus/bake/bake.h>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/parallel.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/instruction_set.h>
#include <stratus/runtime/number_text.h>

#include "axes.h"
#include "piece_of_work.h"
#include "resolve.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>

namespace stratus {

namespace {

/// Share of the tolerance that every single choice may use up at the first attempt, and what it
/// shrinks by at each further one: the errors of the choices add up, though seldom at the same
/// point.
constexpr double first_strictness = 0.5;
constexpr double stricter = 0.6;
constexpr int max_attempts = 3;

/// The bake's own check must be met with this much to spare, so that other random points meet the
/// tolerance too.
constexpr double margin = 0.8;

constexpr unsigned check_seed =
    20260;  // the bake's own check and `verify` look at different points
constexpr int check_samples = 2000;

const std::map<std::string, std::string>& conventions() {
    static const std::map<std::string, std::string> sentences{
        {"convention_reflection",
         "reflection = pi I / (mu_in F0), F0 the irradiance on a plane facing the beam; a white "
         "Lambert surface has 1; BRDF = reflection / pi"},
        {"convention_transmission",
         "transmission is the diffuse part in the same normalisation; the beam that passes "
         "straight is exp(-optical_depth / mu_in), kept apart"},
        {"convention_multiple",
         "reflection_multiple and transmission_multiple hold orders n >= 2 of the Neumann series, "
         "to highest_order if that is not 0; single scattering is added in closed form"},
        {"convention_azimuth",
         "azimuth is the angle between the two directions of propagation, 0 = forward side, "
         "radians"},
        {"convention_phase_function",
         "the phase function has spherical mean 1; g is the mean cosine of the scattering angle, "
         "positive for forward scattering"},
        {"convention_fluxes",
         "plane_albedo and diffuse_transmittance are fluxes of all orders over the incident flux, "
         "spherical_albedo is for uniform illumination"},
    };
    return sentences;
}

/// A sample without the last bits that the tolerance does not need: files then compress well, and a
/// thousandth of the tolerance is all that it costs.
class Rounding {
  public:
    explicit Rounding(double tolerance) {
        constexpr int mantissa_bits = 23;
        const int needed = static_cast<int>(std::ceil(-std::log2(tolerance / 500)));
        drop_ = std::max(0, mantissa_bits - needed);
    }

    float operator()(double sample) const {
        if (drop_ == 0) return static_cast<float>(sample);
        auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(sample));
        bits = (bits + (1u << (drop_ - 1))) & ~((1u << drop_) - 1);
        return std::bit_cast<float>(bits);
    }

  private:
    int drop_ = 0;
};

/// Solves every sample of a resolved recipe.
class TableSolver {
  public:
    TableSolver(const Recipe& recipe, const BakeOptions& options)
        : recipe_(recipe), options_(options), rounded_(recipe.tolerance) {
        const Discretisation& d = recipe.discretisation;
        table_.phase_function = recipe.phase_function;
        table_.lower_boundary = recipe.lower_boundary;
        table_.albedo = albedo_axis(recipe.albedo, d.albedo_samples);
        table_.optical_depth = optical_depth_axis(recipe.optical_depth,
                                                  std::max(1, d.optical_depth_samples_per_octave),
                                                  d.deepest_optical_depth);
        table_.mu_in = table_.mu_out = mu_axis(d.mu_samples);
        table_.azimuth = azimuth_axis(d.azimuth_samples);
        table_.extrapolation_length =
            extrapolation_length(recipe.phase_function, recipe.lower_boundary);
        const std::size_t rows = table_.albedo.values.size() * table_.optical_depth.values.size();
        const std::size_t mus = table_.mu_in.values.size();
        block_ = mus * mus * table_.azimuth.values.size();
        if (recipe.reflection) table_.reflection_multiple.resize(rows * block_);
        if (recipe.transmission) table_.transmission_multiple.resize(rows * block_);
        table_.plane_albedo.resize(rows * mus);
        table_.spherical_albedo.resize(rows);
        if (recipe.transmission) table_.diffuse_transmittance.resize(rows * mus);
        solver_.nodes = d.nodes;
        solver_.modes = d.modes;
        solver_.scheme = d.scheme;
        solver_.orders = recipe.orders;
        table_.highest_order = recipe.orders;
        table_.diffusion_exponent = decay_exponents(recipe, table_.albedo.values);
        tabulate_geometry();
    }

    Table solve() {
        // One run of doubling serves all octaves: as many runs as samples an octave, each for some
        // albedos at a time.
        const AxisView tau = table_.optical_depth.view();
        const int runs =
            tau.count == 0
                ? 1
                : std::min(std::max(1, recipe_.discretisation.optical_depth_samples_per_octave),
                           tau.count);
        constexpr int albedos_at_once = 8;
        const int chunks = (table_.albedo.view().count + albedos_at_once - 1) / albedos_at_once;
        parallel_for(
            runs * chunks, options_.threads,
            [&](int unit) {
                stop_if_asked(options_.log);
                solve_unit(unit % runs, runs, (unit / runs) * albedos_at_once, albedos_at_once);
            },
            [&](int done) {
                if (options_.progress)
                    options_.progress(static_cast<double>(done) / (runs * chunks), "baking");
            });
        return std::move(table_);
    }

  private:
    /// cos(m phi_k) with the factor 2 of m > 0, and the phase function on both sides at every
    /// sample direction.
    void tabulate_geometry() {
        const auto azimuths = static_cast<Eigen::Index>(table_.azimuth.values.size());
        cosines_.resize(recipe_.discretisation.modes, azimuths);
        for (Eigen::Index m = 0; m < cosines_.rows(); ++m)
            for (Eigen::Index k = 0; k < azimuths; ++k)
                cosines_(m, k) =
                    (m ? 2 : 1) * std::cos(static_cast<double>(m) *
                                           table_.azimuth.values[static_cast<std::size_t>(k)]);
        for (double in : table_.mu_in.values)
            for (double out : table_.mu_out.values)
                for (double azimuth : table_.azimuth.values) {
                    const Geometry at{in, out, azimuth};
                    reflected_phase_.push_back(
                        recipe_.phase_function(cos_scattering_angle_reflected(at)));
                    boundary_phase_.push_back(boundary_phase_value(recipe_.lower_boundary, at));
                    transmitted_phase_.push_back(
                        recipe_.phase_function(cos_scattering_angle_transmitted(at)));
                }
    }

    void solve_unit(int run, int runs, int first_albedo, int albedo_count) {
        const AxisView tau = table_.optical_depth.view();
        std::vector<double> albedos;
        for (int a = first_albedo;
             a < std::min(first_albedo + albedo_count, table_.albedo.view().count); ++a)
            albedos.push_back(table_.albedo.values[static_cast<std::size_t>(a)]);
        DepthLadder ladder{1, 0, tau.ends_at_infinity};
        if (tau.count > 0) {
            ladder.first = table_.optical_depth.values[static_cast<std::size_t>(run)];
            ladder.octaves = (tau.count - 1 - run) / runs + 1;
            ladder.to_infinity = tau.ends_at_infinity && run == (tau.count - 1) % runs;
        }
        const auto depths = static_cast<std::size_t>(ladder.octaves + (ladder.to_infinity ? 1 : 0));
        std::vector<std::size_t> rows;  // over (albedo, depth)
        for (std::size_t a = 0; a < albedos.size(); ++a)
            for (std::size_t d = 0; d < depths; ++d) {
                const bool infinite = static_cast<int>(d) == ladder.octaves;
                const int depth = infinite ? tau.count : run + static_cast<int>(d) * runs;
                rows.push_back((static_cast<std::size_t>(first_albedo) + a) *
                                   table_.optical_depth.values.size() +
                               static_cast<std::size_t>(depth));
            }

        const std::string piece =
            "depths from " + std::to_string(run) + ", albedos from " + std::to_string(first_albedo);
        std::size_t count = 0;
        for (const std::size_t row : rows)
            visit_samples(row, [&](std::span<float> some) { count += some.size(); });
        if (const auto finished = find_finished<float>(options_.log, piece, count)) {
            const float* from = finished->data();
            for (const std::size_t row : rows) {
                visit_samples(row, [&](std::span<float> some) {
                    std::copy_n(from, some.size(), some.data());
                    from += some.size();
                });
                mirror(row);
            }
            return;
        }
        const auto solutions = solve_ladder(recipe_.phase_function, albedos, ladder,
                                            table_.mu_in.values, solver_, recipe_.lower_boundary);
        for (std::size_t n = 0; n < rows.size(); ++n)
            store(solutions[n / depths][n % depths], rows[n]);
        if (!options_.log.keep) return;
        std::vector<float> samples;
        samples.reserve(count);
        for (const std::size_t row : rows)
            visit_samples(row, [&](std::span<float> some) {
                samples.insert(samples.end(), some.begin(), some.end());
            });
        keep_finished(options_.log, piece, samples);
    }

    /// Calls visit(samples) for those of one (albedo, optical depth) from which `mirror` knows all.
    template <class Visit>
    void visit_samples(std::size_t row, const Visit& visit) {
        const std::size_t mus = table_.mu_in.values.size();
        for (std::vector<float>* side :
             {&table_.reflection_multiple, &table_.transmission_multiple})
            for (std::size_t i = 0; i < mus && !side->empty(); ++i) {
                const std::size_t begin = i * (mus + 1) * block_ / (mus * mus);
                visit(
                    std::span(*side).subspan(row * block_ + begin, (i + 1) * block_ / mus - begin));
            }
        for (std::vector<float>* flux : {&table_.plane_albedo, &table_.diffuse_transmittance})
            if (!flux->empty()) visit(std::span(*flux).subspan(row * mus, mus));
        visit(std::span(table_.spherical_albedo).subspan(row, 1));
    }

    /// Fills in what exchanging mu_in and mu_out gives.
    void mirror(std::size_t row) {
        const std::size_t mus = table_.mu_in.values.size(), azimuths = table_.azimuth.values.size();
        for (std::vector<float>* side :
             {&table_.reflection_multiple, &table_.transmission_multiple}) {
            if (side->empty()) continue;
            float* const block = side->data() + row * block_;
            for (std::size_t i = 0; i < mus; ++i)
                for (std::size_t j = 0; j < i; ++j)
                    std::copy_n(block + (j * mus + i) * azimuths, azimuths,
                                block + (i * mus + j) * azimuths);
        }
    }

    void store(const LayerSolution& solution, std::size_t row) {
        const auto mus = static_cast<Eigen::Index>(table_.mu_in.values.size());
        if (recipe_.reflection)
            store_side(
                solution.reflection_modes, reflected_phase_, cos_scattering_angle_reflected,
                [&](int i, int j) { return solution.reflection_correction(i, j); },
                solution.boundary_correction(), table_.reflection_multiple.data() + row * block_);
        if (recipe_.transmission)
            store_side(
                solution.transmission_modes, transmitted_phase_, cos_scattering_angle_transmitted,
                [&](int i, int j) { return solution.transmission_correction(i, j); }, {},
                table_.transmission_multiple.data() + row * block_);
        for (Eigen::Index i = 0; i < mus; ++i) {
            const std::size_t at =
                row * static_cast<std::size_t>(mus) + static_cast<std::size_t>(i);
            table_.plane_albedo[at] = static_cast<float>(solution.plane_albedo(i));
            if (recipe_.transmission)
                table_.diffuse_transmittance[at] =
                    static_cast<float>(solution.diffuse_transmittance(i));
        }
        table_.spherical_albedo[row] = static_cast<float>(solution.spherical_albedo);
    }

    /// Orders n >= 2 at all sample directions: the Fourier series, and what truncation took away
    /// from the layer and, per unit of its phase function, from what lies beneath.
    template <class Cosine, class Correction>
    void store_side(const std::vector<Eigen::MatrixXd>& modes, const std::vector<double>& phase,
                    Cosine cos_scattering_angle, Correction correction,
                    const Eigen::MatrixXd& boundary, float* out) const {
        const auto& mu = table_.mu_in.values;
        const auto mus = static_cast<Eigen::Index>(mu.size());
        const Eigen::Index azimuths = cosines_.cols();
        const auto count = std::min(cosines_.rows(), static_cast<Eigen::Index>(modes.size()));
        Eigen::VectorXd series(count);
        std::vector<double> directions(static_cast<std::size_t>(azimuths));
        for (Eigen::Index i = 0; i < mus; ++i)
            for (Eigen::Index j = i; j < mus; ++j) {
                for (Eigen::Index m = 0; m < count; ++m)
                    series(m) = modes[static_cast<std::size_t>(m)](i, j);
                const Eigen::VectorXd sum = cosines_.topRows(count).transpose() * series;
                const PeakCorrection correction_here =
                    correction(static_cast<int>(i), static_cast<int>(j));
                for (std::size_t k = 0; k < directions.size(); ++k)
                    directions[k] = cos_scattering_angle({mu[static_cast<std::size_t>(i)],
                                                          mu[static_cast<std::size_t>(j)],
                                                          table_.azimuth.values[k]});
                const std::vector<double> scattered_again =
                    sum_legendre(correction_here.legendre, directions);
                for (Eigen::Index k = 0; k < azimuths; ++k) {
                    const auto direction = static_cast<std::size_t>((i * mus + j) * azimuths + k);
                    double sample = sum(k) + correction_here.single * phase[direction] +
                                    scattered_again[static_cast<std::size_t>(k)];
                    if (boundary.size()) sample += boundary(i, j) * boundary_phase_[direction];
                    out[(i * mus + j) * azimuths + k] = out[(j * mus + i) * azimuths + k] =
                        rounded_(sample);
                }
            }
    }

    const Recipe& recipe_;
    const BakeOptions& options_;
    const Rounding rounded_;
    SolverOptions solver_;
    Table table_;
    std::size_t block_ = 0;
    Eigen::MatrixXd cosines_;
    std::vector<double> reflected_phase_, transmitted_phase_, boundary_phase_;
};

/// The tables of all mixtures, one after the other.
Table solve_mixtures(const Recipe& recipe, const BakeOptions& options) {
    const Axis mixture = mixture_axis(*recipe.mixture, recipe.discretisation.mixture_samples);
    const auto count = static_cast<double>(mixture.values.size());
    Table table;
    for (std::size_t m = 0; m < mixture.values.size(); ++m) {
        BakeOptions of_share = options;
        if (options.progress)
            of_share.progress = [&](double done, const std::string& stage) {
                options.progress((static_cast<double>(m) + done) / count, stage);
            };
        of_share.log = part_of(options.log, "mixture " + std::to_string(m));
        const Recipe alone = at_mixture(recipe, mixture.values[m]);
        Table one = TableSolver(alone, of_share).solve();
        if (m == 0) {
            table = std::move(one);
            for_each_of_mixtures(
                [&](auto& all) { all.reserve(mixture.values.size() * all.size()); }, table);
        } else {
            for_each_of_mixtures(
                [](auto& all, const auto& more) {
                    all.insert(all.end(), more.begin(), more.end());
                },
                table, one);
        }
    }
    table.mixture = mixture;
    table.phase_function = recipe.phase_function;
    table.second_phase_function = recipe.second_phase_function;
    table.extrapolation_length = extrapolation_length(recipe.phase_function, recipe.lower_boundary);
    table.second_extrapolation_length =
        extrapolation_length(recipe.second_phase_function, recipe.lower_boundary);
    return table;
}

/// A resolved recipe's table and how it did at the bake's own check.
struct Attempt {
    Table table;
    bool met = false;    // with a margin
    bool missed = true;  // the tolerance itself
};

Attempt attempt_bake(const Recipe& recipe, const Recipe& resolved, const BakeOptions& options) {
    Attempt attempt;
    Table& table = attempt.table;
    table = solve_table(resolved, options);
    table.tolerance = recipe.tolerance;
    table.attributes = conventions();
    if (recipe.lower_boundary.is_present())
        table.attributes["convention_below"] =
            "reflection is that of the layer and of what lies beneath it; light scattered once, by "
            "either, is added in closed form and not in reflection_multiple";
    if (recipe.mixture)
        table.attributes["convention_mixture"] =
            "mixture is the share that phase_function has in all that is scattered, the rest is "
            "second_phase_function's: phi = mixture phi_1 + (1 - mixture) phi_2";
    table.attributes["title"] = recipe.title;
    table.attributes["recipe"] = recipe.text;
    table.attributes["resolved_recipe"] = resolved_text(resolved);
    table.attributes["nodes"] = std::to_string(resolved.discretisation.nodes);
    table.attributes["modes"] = std::to_string(resolved.discretisation.modes);
    table.attributes["program_version"] = STRATUS_VERSION;

    VerifyOptions check;
    check.samples = check_samples;
    check.seed = check_seed;
    check.threads = options.threads;
    check.log = part_of(options.log, "check");
    if (options.progress) check.progress = [&](double done) { options.progress(done, "checking"); };
    Verification verification = verify(table, check);
    const std::string median = short_number(error_quantile(verification.samples, 0.5), 3);
    const std::string most = short_number(error_quantile(verification.samples, 0.999), 3);
    table.measured_error = error_quantile(verification.samples, 1);
    table.attributes["measured_error_median"] = median;
    table.attributes["measured_error_99.9_percent"] = most;
    if (options.note)
        options.note("checked at " + std::to_string(check_samples) + " random points: median " +
                     median + ", 99.9 % within " + most + ", largest " +
                     short_number(table.measured_error, 3));
    attempt.met = verification.meets(margin * recipe.tolerance);
    attempt.missed = !verification.meets(recipe.tolerance);
    return attempt;
}

}  // namespace

std::string baking_program() {
#ifdef __clang__
    const std::string compiler = "clang " __clang_version__;
#else
    const std::string compiler = "g++ " __VERSION__;
#endif
    return "stratus " STRATUS_VERSION ", " + compiler + ", " + name_of(chosen_instruction_set());
}

Recipe resolve(const Recipe& recipe, const BakeOptions& options) {
    return resolve_to(recipe, first_strictness, options);
}

Table solve_table(const Recipe& resolved, const BakeOptions& options) {
    const Discretisation& d = resolved.discretisation;
    std::vector<std::pair<const char*, int>> choices{{"nodes", d.nodes},
                                                     {"modes", d.modes},
                                                     {"mu_samples", d.mu_samples},
                                                     {"azimuth_samples", d.azimuth_samples},
                                                     {"albedo_samples", d.albedo_samples}};
    if (resolved.mixture) choices.push_back({"mixture_samples", d.mixture_samples});
    for (const auto& [name, count] : choices)
        require(count >= 1, "solve_table", name, "resolved", count);
    Table table = resolved.mixture ? solve_mixtures(resolved, options)
                                   : TableSolver(resolved, options).solve();
    prepare(table);
    return table;
}

Table bake(const Recipe& recipe, const BakeOptions& options) {
    auto note = [&](const char* line) {
        if (options.note) options.note(line);
    };
    Attempt attempt;
    std::string last;  // what the last attempt resolved to: the same again would be in vain
    double strictness = first_strictness;
    for (int n = 0; n < max_attempts && !attempt.met; ++n, strictness *= stricter) {
        if (n > 0) note("not within the tolerance everywhere: once more, stricter");
        BakeOptions of_attempt = options;
        of_attempt.log = part_of(options.log, "attempt " + std::to_string(n));
        const Recipe resolved = resolve_to(recipe, strictness, of_attempt);
        if (resolved_text(resolved) == last) {
            note("nothing is left to make finer");
            break;
        }
        last = resolved_text(resolved);
        attempt = attempt_bake(recipe, resolved, of_attempt);
    }
    if (attempt.missed) note("TOLERANCE NOT MET: the table states it, verify says where");
    return std::move(attempt.table);
}

}  // namespace stratus
