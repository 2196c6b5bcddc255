// A layer of particles as a BxDF of pbrt-v4, on the CPU: light scattered by it, looked up in a table
// of Stratus, and the beam that goes straight through, a specular transmission.
//
// stratus_lookup.h is written by `stratus shader TABLE --language cpp -o DIR`.
#pragma once

#include <pbrt/base/bxdf.h>
#include <pbrt/util/pstd.h>
#include <pbrt/util/spectrum.h>
#include <pbrt/util/vecmath.h>

#include "stratus_lookup.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <string>

namespace pbrt {

/// A table, and grey layers of it that directions are drawn for: depths of all powers of two, a few
/// albedos. Each is prepared when it is first asked for.
class StratusTable {
  public:
    /// Errors   std::runtime_error for a file that is no packed table.
    explicit StratusTable(const std::string& path) : lookup(path) {}

    /// Returns the prepared layer nearest to one of this depth and albedo.
    const stratus_lookup::Layer& LayerNear(float depth, float albedo) const {
        constexpr float betweenPowersOfTwo = 1.41421356f, albedos[] = {0.5f, 0.8f, 0.95f, 1};
        int power = 0, brightness = 0;
        float nearest = shallowest;
        for (; power + 1 < depths && depth > nearest * betweenPowersOfTwo; ++power) nearest *= 2;
        while (brightness < 3 && albedo > (albedos[brightness] + albedos[brightness + 1]) / 2)
            ++brightness;
        Prepared& one = prepared[power][brightness];
        std::call_once(one.once, [&] {
            const float tau = std::min(nearest, lookup.most_depth()),
                        w = std::clamp(albedos[brightness], lookup.least_albedo(),
                                       lookup.most_albedo());
            one.layer = std::make_unique<stratus_lookup::Layer>(
                lookup, stratus_lookup::vec3(tau, tau, tau), stratus_lookup::vec3(w, w, w));
        });
        return *one.layer;
    }

    const stratus_lookup::Table lookup;

  private:
    static constexpr int depths = 17;
    static constexpr float shallowest = 1.0f / 256;

    struct Prepared {
        std::once_flag once;
        std::unique_ptr<stratus_lookup::Layer> layer;
    };
    mutable Prepared prepared[depths][4];
};

class StratusBxDF {
  public:
    StratusBxDF() = default;
    StratusBxDF(const StratusTable* table, SampledSpectrum depth, SampledSpectrum albedo)
        : table(table),
          layer(&table->LayerNear(float(depth.Average()), float(albedo.Average()))),
          depth(depth),
          albedo(albedo) {}

    BxDFFlags Flags() const {
        return BxDFFlags(BxDFFlags::GlossyReflection | BxDFFlags::GlossyTransmission |
                         BxDFFlags::SpecularTransmission);
    }

    SampledSpectrum f(Vector3f wo, Vector3f wi, TransportMode) const {
        SampledSpectrum light;
        for (int i = 0; i < NSpectrumSamples; ++i)
            light[i] =
                i > 0 && depth[i] == depth[i - 1] && albedo[i] == albedo[i - 1]
                    ? light[i - 1]
                    : table->lookup.bsdf(Turned(wi), Turned(wo), float(albedo[i]), float(depth[i]));
        return light;
    }

    pstd::optional<BSDFSample> Sample_f(
        Vector3f wo, Float uc, Point2f u, TransportMode mode,
        BxDFReflTransFlags sampleFlags = BxDFReflTransFlags::All) const {
        const SampledSpectrum beam = Beam(wo);
        const Float share = BeamShare(wo, beam);
        BSDFSample drawn;
        if (uc < share) {
            drawn = BSDFSample(beam / std::abs(wo.z), -wo, share, BxDFFlags::SpecularTransmission);
        } else {
            const stratus_lookup::Sample scattered = layer->sample(
                Turned(wo), float(u[0]), float(u[1]), float((uc - share) / (1 - share)));
            if (!(scattered.pdf > 0)) return {};
            const Vector3f wi(scattered.wo.x, scattered.wo.y, scattered.wo.z);
            drawn = BSDFSample(
                f(wo, wi, mode), wi, (1 - share) * scattered.pdf,
                wi.z * wo.z > 0 ? BxDFFlags::GlossyReflection : BxDFFlags::GlossyTransmission);
        }
        if (!IsAllowed(drawn.IsReflection(), sampleFlags)) return {};
        return drawn;
    }

    Float PDF(Vector3f wo, Vector3f wi, TransportMode,
              BxDFReflTransFlags sampleFlags = BxDFReflTransFlags::All) const {
        if (!IsAllowed(wi.z * wo.z > 0, sampleFlags)) return 0;
        return (1 - BeamShare(wo, Beam(wo))) * layer->pdf(Turned(wo), Turned(wi));
    }

    static constexpr const char* Name() { return "StratusBxDF"; }
    std::string ToString() const {
        return "[ StratusBxDF depth: " + depth.ToString() + " albedo: " + albedo.ToString() + " ]";
    }
    void Regularize() {}

  private:
    static stratus_lookup::vec3 Turned(Vector3f v) { return {float(v.x), float(v.y), float(v.z)}; }

    static bool IsAllowed(bool reflects, BxDFReflTransFlags flags) {
        return (flags & (reflects ? BxDFReflTransFlags::Reflection
                                  : BxDFReflTransFlags::Transmission)) != 0;
    }

    SampledSpectrum Beam(Vector3f wo) const {
        SampledSpectrum beam;
        for (int i = 0; i < NSpectrumSamples; ++i)
            beam[i] = table->lookup.direct(float(depth[i]), float(std::abs(wo.z)));
        return beam;
    }

    /// How often the beam is drawn: about the share of the light that leaves along it.
    Float BeamShare(Vector3f wo, SampledSpectrum beam) const {
        const Float through = beam.Average();
        if (wo.z < 0 && table->lookup.is_one_sided()) return through > 0 ? 1 : 0;
        const Float scattered = albedo.Average() * (1 - through);
        return through > 0 ? through / (through + scattered) : 0;
    }

    const StratusTable* table = nullptr;
    const stratus_lookup::Layer* layer = nullptr;
    SampledSpectrum depth, albedo;
};

}  // namespace pbrt
