// A layer of particles as a BxDF of pbrt-v4, on the CPU: light scattered by it, looked up in a table
// of Stratus, and the beam that goes straight through, a specular transmission.
//
// stratus_table.h lies in docs/examples.
#pragma once

#include <pbrt/base/bxdf.h>
#include <pbrt/util/pstd.h>
#include <pbrt/util/spectrum.h>
#include <pbrt/util/vecmath.h>

#include "stratus_table.h"

#include <cmath>
#include <string>

namespace pbrt {

class StratusBxDF {
  public:
    StratusBxDF() = default;
    StratusBxDF(const StratusTable* table, SampledSpectrum depth, SampledSpectrum albedo)
        : table(table),
          layer(&table->layer_near(float(depth.Average()), float(albedo.Average()))),
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
