#include <stratus/layer/ground_law.h>

#include <stratus/base/constants.h>
#include <stratus/base/gauss_legendre.h>
#include <stratus/base/number_text.h>

#include "phase/kinds/phase_text.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>

namespace stratus {

namespace {

double to_sine(double cosine) { return std::sqrt((1 - cosine) * (1 + cosine)); }

double square(double x) { return x * x; }

// ---- fluxes

/// Cosines and weights that integrate over 2 mu dmu in [0, 1].
struct FluxRule {
    std::vector<double> mu, weight;

    FluxRule() {
        const GaussLegendre rule(48);
        for (std::size_t i = 0; i < rule.x.size(); ++i) {
            const double x = (1 + rule.x[i]) / 2;
            mu.push_back(x * x);
            weight.push_back(rule.weight[i] / 2 * 4 * x * x * x);
        }
    }
};

const FluxRule& flux_rule() {
    static const FluxRule rule;
    return rule;
}

double mean_over_azimuth(const GroundLaw& law, double mu_in, double mu_out) {
    static const AzimuthalModes mean(0, 1);
    return mean(law, mu_in, mu_out)[0];
}

struct Fluxes {
    double largest_plane_albedo, spherical_albedo;
};

/// At the cosines of the rule. Laws are reciprocal: each pair of cosines is evaluated once.
Fluxes fluxes(const GroundLaw& law) {
    const auto& [mu, weight] = flux_rule();
    std::vector<double> plane_albedo(mu.size(), 0.0);
    for (std::size_t i = 0; i < mu.size(); ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            const double R = mean_over_azimuth(law, mu[i], mu[j]);
            plane_albedo[i] += weight[j] * R;
            if (j < i) plane_albedo[j] += weight[i] * R;
        }
    const double spherical =
        std::inner_product(weight.begin(), weight.end(), plane_albedo.begin(), 0.0);
    return {*std::max_element(plane_albedo.begin(), plane_albedo.end()), spherical};
}

// ---- laws

using Parameters = std::map<std::string, double>;

class Ocean final : public GroundLaw {
  public:
    explicit Ocean(const Parameters& given)
        : wind_(given.at("wind")),
          index_(given.at("index")),
          albedo_(given.at("albedo")),
          variance_(0.003 + 0.00512 * wind_) {
        require_in("[0, 50] m/s", "ocean", "wind", wind_);
        require_in("[1, 3]", "ocean", "index", index_);
        require_in("[0, 1]", "ocean", "albedo", albedo_);
        // Smith's shadows leave the facets less than they receive.
        const auto [most, spherical] = fluxes(*this);
        require(most <= 1, "ocean", "albedo",
                "at most " + short_number(1 - (most - albedo_), 3) +
                    ", what the facets leave, at this wind and index",
                albedo_);
        spherical_albedo_ = spherical;
    }

    double operator()(const Geometry& at) const noexcept override {
        return Pair(*this, at.mu_in, at.mu_out)(at.azimuth);
    }

    void at_azimuths(double mu_in, double mu_out, const std::vector<double>& azimuths,
                     double* R) const noexcept override {
        const Pair pair(*this, mu_in, mu_out);
        for (const double azimuth : azimuths) *R++ = pair(azimuth);
    }

    std::string text() const override {
        return "ocean:wind=" + shortest_text(wind_) + ",index=" + shortest_text(index_) +
               ",albedo=" + shortest_text(albedo_);
    }

    double spherical_albedo() const override { return spherical_albedo_; }

  private:
    /// One pair of cosines.
    class Pair {
      public:
        Pair(const Ocean& ocean, double mu0, double mu) noexcept
            : ocean_(ocean),
              sum2_(square(mu + mu0)),
              apart2_(square(to_sine(mu) - to_sine(mu0))),
              sines_(to_sine(mu) * to_sine(mu0)),
              seen_(4 * ocean.variance_ * mu * mu0 * (1 + ocean.shadow(mu) + ocean.shadow(mu0))) {}

        double operator()(double azimuth) const noexcept {
            constexpr double longest_exponent = 700;
            const double aside2 = apart2_ + 4 * sines_ * square(std::sin(azimuth / 2)),
                         tan2 = aside2 / sum2_;
            if (tan2 > longest_exponent * ocean_.variance_) return ocean_.albedo_;
            // Half the angle between sun and eye: sum and difference of their unit vectors are 2 cos and
            // 2 sin of it.
            const double incidence = std::min(1.0, std::sqrt(sum2_ + aside2) / 2);
            return ocean_.albedo_ + ocean_.fresnel(incidence) * std::exp(-tan2 / ocean_.variance_) *
                                        square(1 + tan2) / seen_;
        }

      private:
        const Ocean& ocean_;
        double sum2_, apart2_, sines_;
        double seen_;  // what divides the facets' light
    };

    /// Reflectance of unpolarised light.
    double fresnel(double c) const noexcept {
        if (index_ == 1) return 0;
        const double g = std::sqrt(square(index_) - 1 + square(c));
        return square((g - c) / (g + c)) / 2 * (1 + square((c * (g + c) - 1) / (c * (g - c) + 1)));
    }

    /// Smith's Lambda: the shadowed area over the visible one.
    double shadow(double mu) const noexcept {
        const double a = mu / (to_sine(mu) * std::sqrt(variance_));
        constexpr double none = 26;  // erfc(26) is below the smallest double
        if (!(a < none)) return 0;
        return (std::exp(-a * a) / (a * std::sqrt(pi)) - std::erfc(a)) / 2;
    }

    double wind_, index_, albedo_, variance_;
    double spherical_albedo_ = 0;
};

class Rpv final : public GroundLaw {
  public:
    explicit Rpv(const Parameters& given)
        : rho0_(given.at("rho0")),
          k_(given.at("k")),
          theta_(given.at("theta")),
          rho_c_(given.count("rho_c") ? given.at("rho_c") : rho0_) {
        require_in("[0, 1]", "rpv", "rho0", rho0_);
        require_in("[0, 2]", "rpv", "k", k_);
        require_in("(-1, 1)", "rpv", "theta", theta_);
        require_in("[0, 1]", "rpv", "rho_c", rho_c_);
        constexpr double lowest = 1e-6, highest = 0.2;
        if (reflects_no_more_than_it_receives(lowest)) return;
        double above = highest;
        require(reflects_no_more_than_it_receives(above), "rpv", "rho0",
                "so small that light from cosines above " + short_number(highest) +
                    " is not reflected to more than all of it",
                rho0_);
        double below = lowest;
        while (above > 1.001 * below) {
            const double between = std::sqrt(above * below);
            (reflects_no_more_than_it_receives(between) ? above : below) = between;
        }
        held_below_ = above;
    }

    double operator()(const Geometry& at) const noexcept override {
        const double mu0 = std::max(at.mu_in, held_below_), mu = std::max(at.mu_out, held_below_);
        const double cos_phase = -cos_scattering_angle_reflected({mu0, mu, at.azimuth});
        const double t0 = to_sine(mu0) / mu0, t = to_sine(mu) / mu;
        const double G = std::sqrt(square(t - t0) + 4 * t * t0 * square(std::cos(at.azimuth / 2)));
        const double off_phase = 1 + 2 * theta_ * cos_phase + square(theta_);
        return rho0_ * std::pow(mu * mu0 * (mu + mu0), k_ - 1) * (1 - square(theta_)) /
               (off_phase * std::sqrt(off_phase)) * (1 + (1 - rho_c_) / (1 + G));
    }

    std::string text() const override {
        return "rpv:rho0=" + shortest_text(rho0_) + ",k=" + shortest_text(k_) +
               ",theta=" + shortest_text(theta_) + ",rho_c=" + shortest_text(rho_c_);
    }

  private:
    bool reflects_no_more_than_it_receives(double held_below) {
        held_below_ = held_below;
        for (const double mu : {held_below, 0.01, 0.03, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0})
            if (mu >= held_below && stratus::plane_albedo(*this, mu) > 1) return false;
        return true;
    }

    double rho0_, k_, theta_, rho_c_;
    double held_below_ = 0;  // a cosine
};

/// Reads NAME=NUMBER, comma between; those with defaults may be absent.
Parameters read_parameters(PhaseText& text, const std::string& owner,
                           const std::vector<std::string>& allowed, Parameters given,
                           const std::vector<std::string>& required) {
    if (!text.accept(':')) text.refuse(owner + " needs " + joined(required, "=..., ") + "=...");
    Parameters met = text.numbers(owner, allowed);
    for (const std::string& name : required)
        if (met.count(name) == 0) text.refuse(owner + " needs " + name + "=..., got none");
    met.merge(given);
    return met;
}

}  // namespace

void GroundLaw::at_azimuths(double mu_in, double mu_out, const std::vector<double>& azimuths,
                            double* R) const noexcept {
    for (const double azimuth : azimuths) *R++ = (*this)({mu_in, mu_out, azimuth});
}

double GroundLaw::spherical_albedo() const { return fluxes(*this).spherical_albedo; }

std::shared_ptr<const GroundLaw> read_ground_law(const std::string& text) {
    PhaseText rest{text, 0, {}, "ground"};
    const std::string name = rest.name();
    if (name == "ocean")
        return std::make_shared<Ocean>(read_parameters(rest, name, {"wind", "index", "albedo"},
                                                       {{"index", 1.34}, {"albedo", 0}}, {"wind"}));
    if (name == "rpv")
        return std::make_shared<Rpv>(read_parameters(rest, name, {"rho0", "k", "theta", "rho_c"},
                                                     {}, {"rho0", "k", "theta"}));
    rest.refuse("kind must be ocean:wind=... or rpv:rho0=...,k=...,theta=..., got '" + text + "'");
}

std::string ground_law_help() {
    return "ocean:wind=5,index=1.34,albedo=0   water, mirrors after Cox and Munk; wind in m/s, "
           "[0, 50]\n"
           "rpv:rho0=0.1,k=0.8,theta=-0.1,rho_c=0.1   Rahman, Pinty and Verstraete";
}

AzimuthalModes::AzimuthalModes(int first, int end) : count_(static_cast<std::size_t>(end - first)) {
    // Laws may be peaked at both ends: by the mirrored sun, and with the sun in the back.
    constexpr int halvings = 16, fewest_points = 8, radians_to_a_point = 3;
    const auto add_point = [&](double azimuth, double weight) {
        azimuth_.push_back(azimuth);
        for (int mode = first; mode < end; ++mode)
            share_.push_back(weight * std::cos(mode * azimuth));
    };
    const auto add_interval = [&](double begin, double length) {
        const GaussLegendre rule(
            static_cast<std::size_t>(fewest_points + std::ceil(end * length / radians_to_a_point)));
        for (std::size_t i = 0; i < rule.x.size(); ++i) {
            const double from_end = begin + length / 2 * (1 + rule.x[i]);
            for (const double azimuth : {from_end, pi - from_end})
                add_point(azimuth, rule.weight[i] * length / (2 * pi));
        }
    };
    double length = pi / 4;
    for (int k = 0; k < halvings; ++k, length /= 2) add_interval(length, length);
    add_interval(0, 2 * length);
}

std::vector<double> AzimuthalModes::operator()(const GroundLaw& law, double mu_in,
                                               double mu_out) const {
    std::vector<double> modes(count_), R(azimuth_.size());
    law.at_azimuths(mu_in, mu_out, azimuth_, R.data());
    const double* share = share_.data();
    for (const double each : R)
        for (double& mode : modes) mode += each * *share++;
    return modes;
}

double plane_albedo(const GroundLaw& law, double mu_in) {
    const auto& [mu, weight] = flux_rule();
    double sum = 0;
    for (std::size_t i = 0; i < mu.size(); ++i)
        sum += weight[i] * mean_over_azimuth(law, mu_in, mu[i]);
    return sum;
}

}  // namespace stratus
