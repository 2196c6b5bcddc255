// Material "stratus" of pbrt-v4: a layer of particles without thickness. pbrt/materials.h includes this,
// below its own materials.
#pragma once

#include "stratus_bxdf.h"

#include <string>

namespace pbrt {

/// A number of a layer that varies from place to place: a float texture, or one of spectra.
struct StratusTexture {
    FloatTexture number;
    SpectrumTexture spectrum;

    template <typename TextureEvaluator>
    SampledSpectrum operator()(TextureEvaluator evaluate, const MaterialEvalContext& at,
                               const SampledWavelengths& lambda) const {
        return spectrum ? evaluate(spectrum, at, lambda) : SampledSpectrum(evaluate(number, at));
    }
};

class StratusMaterial {
  public:
    using BxDF = StratusBxDF;
    using BSSRDF = void;

    StratusMaterial(const StratusTable* table, StratusTexture depth, StratusTexture albedo,
                    Float scale, FloatTexture displacement, Image* normalMap)
        : table(table),
          depth(depth),
          albedo(albedo),
          scale(scale),
          displacement(displacement),
          normalMap(normalMap) {}

    static StratusMaterial* Create(const TextureParameterDictionary& parameters, Image* normalMap,
                                   const FileLoc* loc, Allocator alloc);

    template <typename TextureEvaluator>
    StratusBxDF GetBxDF(TextureEvaluator evaluate, MaterialEvalContext at,
                        SampledWavelengths& lambda) const {
        return StratusBxDF(table, ClampZero(scale * depth(evaluate, at, lambda)),
                           Clamp(albedo(evaluate, at, lambda), 0, 1));
    }
    template <typename TextureEvaluator>
    bool CanEvaluateTextures(TextureEvaluator evaluate) const {
        return evaluate.CanEvaluate({depth.number, albedo.number},
                                    {depth.spectrum, albedo.spectrum});
    }
    template <typename TextureEvaluator>
    void GetBSSRDF(TextureEvaluator, MaterialEvalContext, SampledWavelengths&) const {}

    static const char* Name() { return "StratusMaterial"; }
    static constexpr bool HasSubsurfaceScattering() { return false; }
    FloatTexture GetDisplacement() const { return displacement; }
    const Image* GetNormalMap() const { return normalMap; }
    std::string ToString() const { return "[ StratusMaterial ]"; }

  private:
    const StratusTable* table;
    StratusTexture depth, albedo;
    Float scale;
    FloatTexture displacement;
    Image* normalMap;
};

}  // namespace pbrt
