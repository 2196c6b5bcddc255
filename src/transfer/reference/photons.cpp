#include <stratus/transfer/reference/solvers.h>

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>

#include "photon_path.h"

#include <boost/math/special_functions/expint.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace stratus {

namespace {

Direction beam_direction(double mu, double azimuth, double up) {
    const double sine = std::sqrt((1 - mu) * (1 + mu));
    return {sine * std::cos(azimuth), sine * std::sin(azimuth), up * mu};
}

enum Face { lit, far };

/// Contributions of one photon, or tallies of many: R and T of order 1 and of orders n >= 2 in
/// every exit direction, and the fluxes.
template <class Number>
struct Tallies {
    struct Radiance {
        std::array<Number, 2> single{}, multiple{};  // by side
    };
    std::vector<Radiance> exits;
    std::array<Number, 2> flux{};
    Number absorbed{};

    template <class Other>
    void add(const Tallies<Other>& other) {
        for (std::size_t e = 0; e < exits.size(); ++e)
            for (const Face side : {lit, far}) {
                exits[e].single[side].add(other.exits[e].single[side]);
                exits[e].multiple[side].add(other.exits[e].multiple[side]);
            }
        for (const Face side : {lit, far}) flux[side].add(other.flux[side]);
        absorbed.add(other.absorbed);
    }
};

/// One mu_in (0: uniform illumination) and the geometries estimated from its photons.
struct IncidentBeam {
    double mu_in = 0;
    std::vector<Geometry> geometries;
    std::vector<std::size_t> asked_at;  // position of each geometry in the request
};

class PhotonRun {
  public:
    PhotonRun(const PhaseFunction& phase_function, double albedo, double optical_depth,
              const PhotonOptions& options)
        : phase_(phase_function),
          albedo_(albedo),
          optical_depth_(optical_depth),
          highest_order_(options.highest_order),
          backward_collisions_(options.backward_collisions),
          along_share_(optical_depth < thin_depth ? 0.25 : 0),
          along_norm_(1 - std::log(std::min(optical_depth, 1.0))),
          angles_(phase_) {}

    Tallies<Tally> run(const IncidentBeam& beam, std::uint64_t photons, Random& random) const {
        Tallies<Tally> tallies;
        tallies.exits.resize(beam.geometries.size());
        Tallies<double> photon;
        std::vector<Exit> exits(beam.geometries.size());
        for (std::uint64_t i = 0; i < photons; ++i) {
            photon = {std::move(photon.exits)};
            photon.exits.assign(exits.size(), {});
            for (std::size_t e = 0; e < exits.size(); ++e) {
                const Geometry& of = beam.geometries[e];
                for (const Face side : {lit, far})
                    follow_back(beam_direction(of.mu_out, of.azimuth + pi, side == lit ? -1 : 1),
                                side == lit ? 0 : optical_depth_, random, exits[e][side]);
            }
            // Uniform illumination has the density 2 mu dmu.
            const double mu_in = beam.mu_in > 0 ? beam.mu_in : std::sqrt(1 - random());
            follow(mu_in, exits, random, photon);
            tallies.add(photon);
        }
        return tallies;
    }

  private:
    /// A photon on its way to its next collision.
    struct Flight {
        Direction direction{};
        double depth = 0;       // where it began
        double weight = 1;      // of the photon
        Face ahead = far;       // the face it moves towards
        double mu = 1;          // cosine to the normal
        double before = 0;      // vertical optical depth from its beginning to the face ahead
        double slant = 0;       // before/mu
        double min_weight = 0;  // Russian roulette begins below it
        double inverse = 0;     // sum of 1/phi over the collisions so far, of paths followed back
    };
    /// Paths followed back from one exit direction on both sides: a flight after each collision.
    using Exit = std::array<std::vector<Flight>, 2>;

    /// Russian roulette begins below this share of the weight at the second collision.
    static constexpr double roulette_share = 0.3;
    /// Share of first flights drawn uniformly over the path ahead: in deep layers, transmission in
    /// few orders would otherwise depend on a few photons.
    static constexpr double even_share = 0.1;
    static constexpr double thin_depth = 0.1;  // below it, see `scatter`
    static constexpr int max_collisions = 100'000'000;

    void follow(double mu_in, const std::vector<Exit>& exits, Random& random,
                Tallies<double>& photon) const {
        Flight flight;
        set_out(flight, beam_direction(mu_in, 0, -1));
        // recent[k]: sum of 1/phi over the last k collisions
        std::vector<double> recent(size(backward_collisions_) + 1);
        tally_flight(flight, 0, recent, exits, photon);
        for (int order = 1; order <= max_collisions; ++order) {
            if (!collide(flight, order, random)) return;
            photon.absorbed += flight.weight * (1 - albedo_);
            flight.weight *= albedo_;
            if (order == 1) tally_collision(flight, exits, photon);
            const double inverse = scatter(flight, random);
            for (std::size_t k = recent.size(); k-- > 1;) recent[k] = recent[k - 1] + inverse;
            photon.flux[flight.ahead] += flight.weight * std::exp(-flight.slant);
            if (order == highest_order_) return;
            tally_flight(flight, order, recent, exits, photon);
        }
        throw std::runtime_error("photons: a photon was still inside after 1e8 collisions");
    }

    /// A path from a face against the light, `backward_collisions` long or until it ends.
    void follow_back(const Direction& direction, double depth, Random& random,
                     std::vector<Flight>& flights) const {
        flights.clear();
        if (std::isinf(depth)) return;  // nothing is transmitted
        Flight flight;
        flight.depth = depth;
        set_out(flight, direction);
        flights.push_back(flight);
        for (int order = 1; order <= backward_collisions_; ++order) {
            if (!collide(flight, order, random)) return;
            flight.weight *= albedo_;
            flight.inverse += scatter(flight, random);
            flights.push_back(flight);
        }
    }

    void set_out(Flight& flight, const Direction& direction) const {
        flight.direction = direction;
        flight.mu = std::max(std::abs(direction.z), 1e-100);  // avoids 0/0
        flight.ahead = direction.z > 0 ? lit : far;
        flight.before = direction.z > 0 ? flight.depth : optical_depth_ - flight.depth;
        flight.slant = flight.before / flight.mu;
    }

    /// Moves a photon to its next collision; false when Russian roulette ends its path.
    bool collide(Flight& flight, int order, Random& random) const {
        double& weight = flight.weight;
        weight *= -std::expm1(-flight.slant);  // the flight is forced to end inside
        if (order == 2) flight.min_weight = roulette_share * std::abs(weight);
        if (order > 2 && std::abs(weight) < flight.min_weight) {
            if (random() * flight.min_weight >= std::abs(weight)) return false;
            weight = std::copysign(flight.min_weight, weight);
        }
        if (weight == 0) return false;
        const double length = fly(flight.slant, order == 1 ? even_share : 0, random, weight);
        flight.depth = std::clamp(flight.depth - flight.direction.z * length, 0.0, optical_depth_);
        return true;
    }

    /// The length of a flight, of density exp(-x) on (0, slant) or of a mixture of that and a
    /// uniform density, for which `weight` is corrected.
    static double fly(double slant, double even, Random& random, double& weight) {
        const double hit = -std::expm1(-slant);
        if (even == 0 || std::isinf(slant)) return -std::log1p(-random() * hit);
        const double x = random() < even ? random() * slant : -std::log1p(-random() * hit);
        weight /= 1 - even + even * std::exp(x) * hit / slant;
        return x;
    }

    /// Turns a photon at a collision; returns 1/phi. In thin layers only grazing photons collide
    /// again, so a share of the directions is drawn from the density 1/max(|z|, tau) instead.
    double scatter(Flight& flight, Random& random) const {
        const Direction& from = flight.direction;
        Direction to{};
        AngleSampler::Sample angle{};
        const double azimuth = 2 * pi * random();
        if (along_share_ > 0 && random() < along_share_) {
            const double u = random() * along_norm_;
            const double z = optical_depth_ * (u < 1 ? u : std::exp(u - 1));
            to = beam_direction(std::min(z, 1.0), azimuth, random() < 0.5 ? 1 : -1);
            angle.v = std::clamp((1 - dot(from, to)) / 2, 0.0, 1.0);
            angle.density = angles_.density(angle.v);
        } else {
            const double bin_number = random();
            angle = angles_.sample(bin_number, random());
            to = scattered(from, angle.v, azimuth);
        }
        if (along_share_ > 0)
            angle.density +=
                along_share_ *
                (1 / (std::max(std::abs(to.z), optical_depth_) * along_norm_) - angle.density);
        const double phase = phase_(1 - 2 * angle.v);
        flight.weight *= phase / angle.density;
        set_out(flight, to);
        return capped_inverse(phase);
    }

    /// 1/|phi|, kept finite: shares may be any that sum to 1.
    static double capped_inverse(double phase) { return 1 / std::max(std::abs(phase), 1e-3); }

    /// A first collision that scatters `weight` at depth t adds (weight phi/4) exp(-t/mu)/mu to R.
    void tally_collision(const Flight& flight, const std::vector<Exit>& exits,
                         Tallies<double>& photon) const {
        for (std::size_t e = 0; e < exits.size(); ++e)
            for (const Face side : {lit, far}) {
                if (exits[e][side].empty()) continue;
                const Flight& exit = exits[e][side].front();
                const double height = std::abs(flight.depth - exit.depth);
                photon.exits[e].single[side] += flight.weight / 4 *
                                                phase_(-dot(flight.direction, exit.direction)) *
                                                std::exp(-height / exit.mu) / exit.mu;
            }
    }

    /// Joins a flight after `order` collisions to the paths followed back from every exit.
    void tally_flight(const Flight& flight, int order, const std::vector<double>& recent,
                      const std::vector<Exit>& exits, Tallies<double>& photon) const {
        for (std::size_t e = 0; e < exits.size(); ++e)
            for (const Face side : {lit, far}) {
                const std::vector<Flight>& back = exits[e][side];
                for (std::size_t j = order == 0 ? 1 : 0; j < back.size();
                     ++j) {  // order 1 is the closed form
                    if (highest_order_ > 0 && order + static_cast<int>(j) >= highest_order_) break;
                    const auto [value, phase] = join(flight, back[j]);
                    const double inverse = capped_inverse(phase);
                    photon.exits[e].multiple[side] +=
                        value * inverse /
                        (inverse + back[j].inverse + recent[recent.size() - 1 - j]);
                }
            }
    }

    struct Joined {
        double value, phase;
    };

    /// One collision between a flight and one followed back: single scattering, in closed form, by
    /// the part of the layer that both cross, attenuated on the way there.
    Joined join(const Flight& flight, const Flight& back) const {
        const double w = flight.weight * back.weight * albedo_;
        const double below = back.depth - flight.depth,
                     apart = flight.ahead == far ? below : -below;
        const bool leaves_ahead = flight.ahead != back.ahead;
        if (leaves_ahead && apart <= 0) return {0, 1};
        const double phase = phase_(-dot(flight.direction, back.direction));
        if (!leaves_ahead) {
            const double common = std::min(flight.before, back.before);
            const double farther = (below > 0) == (flight.ahead == far) ? flight.mu : back.mu;
            return {single_reflection(phase, w, common, flight.mu, back.mu) *
                        direct_transmittance(std::abs(below), farther),
                    phase};
        }
        return {single_transmission(phase, w, apart, flight.mu, back.mu), phase};
    }

    const PhaseValues phase_;
    const double albedo_, optical_depth_;
    const int highest_order_, backward_collisions_;
    const double along_share_, along_norm_;
    const AngleSampler angles_;
};

void check(double albedo, double optical_depth, const std::vector<Geometry>& geometries,
           const PhotonOptions& options) {
    const char* const caller = "photons";
    require_in("[0, 1]", caller, "albedo", albedo);
    require_in("[0, inf]", caller, "optical_depth", optical_depth);
    require(options.highest_order >= 0, caller, "highest_order", ">= 0", options.highest_order);
    require_in("[0, 100]", caller, "backward_collisions", options.backward_collisions);
    require(options.photons >= 2, caller, "photons", ">= 2", options.photons);
    if (albedo == 1 && options.highest_order == 0)
        require(!std::isinf(optical_depth), caller, "optical_depth",
                "finite at albedo 1 (paths in an infinite layer have no mean length)",
                optical_depth);
    for (const Geometry& of : geometries) {
        require_in("(0, 1]", caller, "mu_in", of.mu_in);
        require_in("(0, 1]", caller, "mu_out", of.mu_out);
        require(std::isfinite(of.azimuth), caller, "azimuth", "finite", of.azimuth);
    }
}

/// One beam for each distinct mu_in, then uniform illumination.
std::vector<IncidentBeam> sort_by_beam(const std::vector<Geometry>& geometries) {
    std::vector<IncidentBeam> beams;
    for (std::size_t i = 0; i < geometries.size(); ++i) {
        auto beam = std::ranges::find(beams, geometries[i].mu_in, &IncidentBeam::mu_in);
        if (beam == beams.end()) beam = beams.insert(beam, {geometries[i].mu_in, {}, {}});
        beam->geometries.push_back(geometries[i]);
        beam->asked_at.push_back(i);
    }
    beams.emplace_back();
    return beams;
}

/// Tallies of every beam; its batches are summed in a fixed order, whichever finished first.
std::vector<Tallies<Tally>> run_beams(const PhotonRun& run, const std::vector<IncidentBeam>& beams,
                                      const PhotonOptions& options) {
    constexpr std::uint64_t min_batch = 1024, max_batches = 256;
    const std::uint64_t batches =
        std::clamp(options.photons / min_batch, std::uint64_t{1}, max_batches);
    std::vector<Tallies<Tally>> slots(beams.size() * batches);
    const auto work = [&](int at) {
        const IncidentBeam& beam = beams[size(at) / batches];
        const std::uint64_t batch = size(at) % batches;
        Random random(options.seed, std::bit_cast<std::uint64_t>(beam.mu_in), batch);
        const std::uint64_t photons =
            options.photons / batches + (batch < options.photons % batches ? 1 : 0);
        slots[size(at)] = run.run(beam, photons, random);
    };
    const auto count = int_size(slots);
    if (options.parallel_for)
        options.parallel_for(count, work);
    else
        for (int i = 0; i < count; ++i) work(i);
    std::vector<Tallies<Tally>> totals;
    for (std::size_t b = 0; b < beams.size(); ++b) {
        totals.push_back(std::move(slots[b * batches]));
        for (std::size_t i = 1; i < batches; ++i) totals[b].add(slots[b * batches + i]);
    }
    return totals;
}

/// The unscattered light and the closed forms of order 1, to which photons add the rest.
PhotonSolution unscattered(const PhaseFunction& phase_function, double albedo, double tau,
                           const std::vector<Geometry>& geometries,
                           const std::vector<IncidentBeam>& beams) {
    PhotonSolution solution;
    for (const Geometry& of : geometries) {
        const auto single = [&](Side side) -> PhotonValue {
            const double phase = phase_function(cos_scattering_angle(side, of));
            const double once = single_scattering(side, phase, albedo, tau, of.mu_in, of.mu_out);
            return {{once, once, 0}, 0, {}};
        };
        solution.geometries.push_back({of, single(Side::reflection), single(Side::transmission)});
    }
    for (const IncidentBeam& beam : beams) {
        PhotonFluxes fluxes;
        // Uniform illumination: 2 int exp(-tau/mu) mu dmu = 2 E_3(tau).
        fluxes.direct_transmittance = beam.mu_in > 0    ? direct_transmittance(tau, beam.mu_in)
                                      : std::isinf(tau) ? 0
                                                        : 2 * boost::math::expint(3, tau);
        // Without scattering, all light that is not transmitted is absorbed.
        if (albedo == 0) fluxes.absorptance.value = 1 - fluxes.direct_transmittance;
        if (beam.mu_in == 0) {
            solution.uniform = fluxes;
            continue;
        }
        solution.mu_in.push_back(beam.mu_in);
        solution.plane.push_back(fluxes);
    }
    return solution;
}

}  // namespace

PhotonSolution solve_photons(const PhaseFunction& phase_function, double albedo,
                             double optical_depth, const std::vector<Geometry>& geometries,
                             const PhotonOptions& options) {
    check(albedo, optical_depth, geometries, options);
    const std::vector<IncidentBeam> beams = sort_by_beam(geometries);
    PhotonSolution solution = unscattered(phase_function, albedo, optical_depth, geometries, beams);
    if (optical_depth == 0 || albedo == 0) return solution;

    const PhotonRun run(phase_function, albedo, optical_depth, options);
    const std::vector<Tallies<Tally>> totals = run_beams(run, beams, options);
    for (std::size_t b = 0; b < beams.size(); ++b) {
        const auto estimate = [&](const Tally& of) { return of.estimate(options.photons); };
        PhotonFluxes& fluxes = beams[b].mu_in > 0 ? solution.plane[b] : solution.uniform;
        fluxes.albedo = estimate(totals[b].flux[lit]);
        fluxes.transmittance = estimate(totals[b].flux[far]);
        fluxes.absorptance = estimate(totals[b].absorbed);
        for (std::size_t e = 0; e < beams[b].geometries.size(); ++e) {
            PhotonGeometry& at = solution.geometries[beams[b].asked_at[e]];
            for (const Face side : {lit, far}) {
                PhotonValue& of = side == lit ? at.reflection : at.transmission;
                const Estimate multiple = estimate(totals[b].exits[e].multiple[side]);
                of.value.multiple = multiple.value;
                of.value.total = of.value.single + multiple.value;
                of.standard_error = multiple.standard_error;
                of.single = estimate(totals[b].exits[e].single[side]);
            }
        }
    }
    return solution;
}

}  // namespace stratus
