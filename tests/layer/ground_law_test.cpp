#include <stratus/layer/ground_law.h>

#include <stratus/base/constants.h>
#include <stratus/base/gauss_legendre.h>

#include "indices.h"
#include "refusal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace stratus {
namespace {

const std::vector<std::string> laws{"ocean:wind=0.5", "ocean:wind=5", "ocean:wind=30,albedo=0.2",
                                    "rpv:rho0=0.1,k=0.7,theta=-0.1,rho_c=0.3",
                                    "rpv:rho0=0.3,k=1.2,theta=0.2"};

TEST(GroundLaw, IsReciprocal) {
    for (const std::string& text : laws) {
        const auto law = read_ground_law(text);
        for (const double mu : {1e-3, 0.05, 0.4, 1.0})
            for (const double mu0 : {0.01, 0.3, 0.7})
                for (const double azimuth : {0.0, 0.1, 2.0, 3.1}) {
                    const double there = (*law)({mu, mu0, azimuth});
                    EXPECT_NEAR(there, (*law)({mu0, mu, azimuth}), 1e-14 * there) << text;
                }
    }
}

TEST(GroundLaw, ReflectsNoMoreThanItReceives) {
    std::vector<std::string> all = laws;
    for (const char* wind : {"1", "2", "10", "20"})
        all.push_back(std::string("ocean:wind=") + wind);
    for (const std::string& text : all) {
        const auto law = read_ground_law(text);
        for (double mu = 1; mu > 1e-3; mu *= 0.8) {
            const double albedo = plane_albedo(*law, mu);
            EXPECT_GT(albedo, 0) << text << ' ' << mu;
            EXPECT_LE(albedo, 1.001) << text << ' ' << mu;  // an RPV law is held where it is 1
        }
    }
}

/// Mean over facets whose slopes are normally distributed, of what each mirrors: no density of
/// directions, Fresnel's equations by Snell's law, shadows by integrals over slopes.
double albedo_of_facets(double wind, double index, double mu0) {
    const double variance = 0.003 + 0.00512 * wind, s0 = std::sqrt(1 - mu0 * mu0);
    const GaussLegendre rule(500), some(40);
    const auto shadow = [&](double mu) {
        const double cot = mu / std::sqrt(1 - mu * mu), width = 7 * std::sqrt(variance / 2);
        double sum = 0;
        for (const auto i : indices(some.x)) {
            const double q = cot + width * (1 + some.x[i]) / 2;
            sum += some.weight[i] * width / 2 * (q - cot) * std::exp(-q * q / variance);
        }
        return sum / (cot * std::sqrt(pi * variance));
    };
    const double shadow_in = shadow(mu0), most = 6 * std::sqrt(variance / 2);
    double sum = 0;
    for (const auto i : indices(rule.x))
        for (const auto j : indices(rule.x)) {
            const double zx = most * rule.x[i], zy = most * rule.x[j];
            const double n = 1 / std::sqrt(1 + zx * zx + zy * zy);  // the normal: n (-zx, -zy, 1)
            const double c = n * (mu0 - zx * s0);                   // the sun towards +x
            const double mu = 2 * c * n - mu0;
            if (c <= 0 || mu <= 0) continue;
            const double t = std::sqrt(1 - (1 - c * c) / (index * index));
            const double across = (c - index * t) / (c + index * t),
                         along = (index * c - t) / (index * c + t);
            sum += rule.weight[i] * rule.weight[j] * most * most *
                   std::exp(-(zx * zx + zy * zy) / variance) / (pi * variance) * c / (mu0 * n) *
                   (across * across + along * along) / 2 / (1 + shadow_in + shadow(mu));
        }
    return sum;
}

TEST(GroundLaw, MirrorsAsManyFacetsDo) {
    for (const double wind : {2.0, 10.0})
        for (const double mu0 : {0.3, 0.6, 0.95}) {
            const auto law = read_ground_law("ocean:index=1.4,wind=" + std::to_string(wind));
            const double facets = albedo_of_facets(wind, 1.4, mu0);
            // The rule errs at the edge of what is mirrored upward.
            EXPECT_NEAR(plane_albedo(*law, mu0), facets, 2e-4 * facets) << wind << ' ' << mu0;
        }
}

TEST(GroundLaw, ReflectsTheMeanOfItsPlaneAlbedosUnderUniformLight) {
    for (const char* text : {"ocean:wind=4,albedo=0.1", "rpv:rho0=0.2,k=0.7,theta=-0.2"}) {
        const auto law = read_ground_law(text);
        const GaussLegendre rule(40);
        double mean = 0;
        for (const auto i : indices(rule.x)) {
            const double mu = (1 + rule.x[i]) / 2;
            mean += rule.weight[i] * mu * plane_albedo(*law, mu);
        }
        EXPECT_NEAR(law->spherical_albedo(), mean, 1e-4 * mean) << text;
    }
}

TEST(GroundLaw, OfRahmanPintyAndVerstraeteHasItsLimits) {
    const auto lambert = read_ground_law("rpv:rho0=0.3,k=1,theta=0,rho_c=1");
    EXPECT_DOUBLE_EQ((*lambert)({0.2, 0.7, 1}), 0.3);
    EXPECT_NEAR(lambert->spherical_albedo(), 0.3, 1e-12);
    // With the sun in the back the hot spot doubles R but for rho_c, and the lobe is
    // (1 - T^2) / (1 + T)^3.
    const auto backward = read_ground_law("rpv:rho0=0.2,k=0.8,theta=-0.2");
    EXPECT_NEAR((*backward)({0.6, 0.6, pi}),
                0.2 * std::pow(0.6 * 0.6 * 1.2, -0.2) * 0.96 / std::pow(0.8, 3) * 1.8, 1e-12);
    EXPECT_GT((*backward)({0.6, 0.6, pi}), 1.5 * (*backward)({0.6, 0.6, 0}));
}

TEST(GroundLaw, IsTheSumOfItsModes) {
    for (const std::string& text : laws) {
        const auto law = read_ground_law(text);
        const double mu0 = 0.4, mu = 0.6;
        constexpr int points = 1 << 15;
        for (const int first : {0, 16}) {
            const std::vector<double> modes = AzimuthalModes(first, first + 16)(*law, mu0, mu);
            for (const int m : {first, first + 1, first + 15}) {
                double mean = 0;  // by the trapezoidal rule
                for (int k = 0; k < points; ++k) {
                    const double azimuth = 2 * pi * k / points;
                    mean += (*law)({mu0, mu, azimuth}) * std::cos(m * azimuth) / points;
                }
                EXPECT_NEAR(modes[static_cast<std::size_t>(m - first)], mean,
                            1e-9 * (*law)({mu0, mu, 0}))
                    << text << ' ' << m;
            }
        }
    }
}

TEST(GroundLaw, ReadsItsOwnText) {
    for (const std::string& text : laws) {
        const auto law = read_ground_law(text), again = read_ground_law(law->text());
        EXPECT_EQ(law->text(), again->text());
        EXPECT_EQ((*law)({0.3, 0.5, 0.2}), (*again)({0.3, 0.5, 0.2}));
    }
}

TEST(GroundLaw, RefusesWhatIsNone) {
    for (const auto& [text, part] : std::vector<std::pair<const char*, const char*>>{
             {"lake:wind=3", "kind must be ocean:"},
             {"ocean", "ocean needs wind="},
             {"ocean:index=1.3", "ocean needs wind=..., got none"},
             {"ocean:wind=51", "wind must be in [0, 50] m/s, got 51"},
             {"ocean:wind=5,index=0.9", "index must be in [1, 3], got 0.9"},
             {"ocean:wind=5,wind=6", "wind must stand once"},
             {"ocean:wind=5 m", "nothing may follow, got 'm'"},
             {"ocean:wind=5,albedo=0.9", "albedo must be at most 0."},
             {"rpv:rho0=0.1,k=0.8", "rpv needs theta=..., got none"},
             {"rpv:rho0=1.1,k=0.8,theta=0", "rho0 must be in [0, 1], got 1.1"},
             {"rpv:rho0=0.1,k=2.1,theta=0", "k must be in [0, 2], got 2.1"},
             {"rpv:rho0=0.1,k=0.8,theta=1", "theta must be in (-1, 1), got 1"},
             {"rpv:rho0=0.1,k=0.8,theta=0,rho_c=2", "rho_c must be in [0, 1], got 2"},
             {"rpv:rho0=1,k=0.5,theta=0", "rho0 must be so small"}})
        expect_refusal([text = text] { read_ground_law(text); }, part);
}

}  // namespace
}  // namespace stratus
