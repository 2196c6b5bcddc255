// BSDF "stratus" of Mitsuba 3, scalar variants: a layer of particles without thickness, seen from both
// sides. Light that it scatters is looked up in a table of Stratus; the beam that goes straight through,
// exp(-tau / mu), is a null component.
//
//   filename        a packed table (.stratus)
//   optical_depth   number or texture, 1 unless given; with scale, a number that multiplies it
//   albedo          number or texture, 1 unless given
//
// stratus_table.h lies in docs/examples.
#include <mitsuba/core/fresolver.h>
#include <mitsuba/core/properties.h>
#include <mitsuba/render/bsdf.h>
#include <mitsuba/render/texture.h>

#include "stratus_table.h"

#include <cmath>
#include <exception>
#include <memory>
#include <string>
#include <string_view>

NAMESPACE_BEGIN(mitsuba)

template <typename Float, typename Spectrum>
class StratusBSDF final : public BSDF<Float, Spectrum> {
    static_assert(!dr::is_jit_v<Float> && !is_polarized_v<Spectrum>,
                  "stratus: build scalar variants without polarization alone");

  public:
    MI_IMPORT_BASE(BSDF, m_components, m_flags)
    MI_IMPORT_TYPES(Texture)

    StratusBSDF(const Properties& props) : Base(props) {
        const auto path = file_resolver()->resolve(props.get<std::string_view>("filename"));
        try {
            m_table = std::make_unique<const StratusTable>(path.string());
        } catch (const std::exception& refusal) {
            Throw("stratus: %s", refusal.what());
        }
        m_depth = props.get_unbounded_texture<Texture>("optical_depth", 1.f);
        m_albedo = props.get_texture<Texture>("albedo", 1.f);
        m_scale = props.get<ScalarFloat>("scale", 1.f);
        const uint32_t sides = BSDFFlags::FrontSide | BSDFFlags::BackSide;
        m_components = {BSDFFlags::GlossyReflection | BSDFFlags::SpatiallyVarying | sides,
                        BSDFFlags::GlossyTransmission | BSDFFlags::SpatiallyVarying | sides,
                        BSDFFlags::Null | BSDFFlags::SpatiallyVarying | sides};
        m_flags = m_components[0] | m_components[1] | m_components[2];
    }

    void traverse(TraversalCallback* callback) override {
        callback->put("optical_depth", m_depth, ParamFlags::NonDifferentiable);
        callback->put("albedo", m_albedo, ParamFlags::NonDifferentiable);
    }

    std::pair<BSDFSample3f, Spectrum> sample(const BSDFContext& context,
                                             const SurfaceInteraction3f& si, Float sample1,
                                             const Point2f& sample2, Mask active) const override {
        BSDFSample3f drawn = dr::zeros<BSDFSample3f>();
        const Layer layer(*this, si, active);
        const Float share = beam_share(context, layer, si.wi);
        drawn.eta = 1;
        if (sample1 < share) {
            drawn.wo = -si.wi;
            drawn.pdf = share;
            drawn.sampled_type = +BSDFFlags::Null;
            drawn.sampled_component = 2;
            return {drawn, layer.beam / share};
        }
        const stratus_lookup::Sample scattered =
            layer.prepared->sample(turned(si.wi), float(sample2.x()), float(sample2.y()),
                                   float((sample1 - share) / (1 - share)));
        drawn.wo = {scattered.wo.x, scattered.wo.y, scattered.wo.z};
        drawn.pdf = (1 - share) * scattered.pdf;
        drawn.sampled_component = drawn.wo.z() * si.wi.z() > 0 ? 0 : 1;
        drawn.sampled_type = drawn.sampled_component == 0 ? +BSDFFlags::GlossyReflection
                                                          : +BSDFFlags::GlossyTransmission;
        if (!(drawn.pdf > 0) || !allows(context, drawn.wo, si.wi)) return {drawn, 0.f};
        return {drawn, light(layer, si.wi, drawn.wo) / drawn.pdf};
    }

    Spectrum eval(const BSDFContext& context, const SurfaceInteraction3f& si, const Vector3f& wo,
                  Mask active) const override {
        return eval_pdf(context, si, wo, active).first;
    }

    Float pdf(const BSDFContext& context, const SurfaceInteraction3f& si, const Vector3f& wo,
              Mask active) const override {
        if (!allows(context, wo, si.wi)) return 0;
        return pdf(context, Layer(*this, si, active), si.wi, wo);
    }

    std::pair<Spectrum, Float> eval_pdf(const BSDFContext& context, const SurfaceInteraction3f& si,
                                        const Vector3f& wo, Mask active) const override {
        if (!allows(context, wo, si.wi)) return {0.f, 0};
        const Layer layer(*this, si, active);
        return {light(layer, si.wi, wo), pdf(context, layer, si.wi, wo)};
    }

    Spectrum eval_null_transmission(const SurfaceInteraction3f& si, Mask active) const override {
        return Layer(*this, si, active).beam;
    }

    std::string to_string() const override { return "StratusBSDF[]"; }

    MI_DECLARE_CLASS(StratusBSDF)

  private:
    /// The layer at a place: depth, albedo and beam of every channel, and one to draw directions from.
    struct Layer {
        Spectrum depth, albedo, beam;
        const stratus_lookup::Layer* prepared;

        Layer(const StratusBSDF& of, const SurfaceInteraction3f& si, Mask active)
            : depth(dr::maximum(of.m_scale * of.m_depth->eval(si, active), 0)),
              albedo(dr::clip(of.m_albedo->eval(si, active), 0, 1)) {
            for (size_t k = 0; k < depth.size(); ++k)
                beam[k] = of.m_table->lookup.direct(float(depth[k]), float(std::abs(si.wi.z())));
            prepared = &of.m_table->layer_near(float(dr::mean(depth)), float(dr::mean(albedo)));
        }
    };

    static stratus_lookup::vec3 turned(const Vector3f& v) {
        return {float(v.x()), float(v.y()), float(v.z())};
    }

    static bool allows(const BSDFContext& context, const Vector3f& wo, const Vector3f& wi) {
        return wo.z() * wi.z() > 0 ? context.is_enabled(BSDFFlags::GlossyReflection, 0)
                                   : context.is_enabled(BSDFFlags::GlossyTransmission, 1);
    }

    /// The BSDF times the cosine of the light's direction.
    Spectrum light(const Layer& layer, const Vector3f& wi, const Vector3f& wo) const {
        Spectrum found;
        for (size_t k = 0; k < layer.depth.size(); ++k)
            found[k] = std::abs(wo.z()) * m_table->lookup.bsdf(turned(wo), turned(wi),
                                                               float(layer.albedo[k]),
                                                               float(layer.depth[k]));
        return found;
    }

    Float pdf(const BSDFContext& context, const Layer& layer, const Vector3f& wi,
              const Vector3f& wo) const {
        return (1 - beam_share(context, layer, wi)) * layer.prepared->pdf(turned(wi), turned(wo));
    }

    /// How often the beam is drawn: about the share of the light that leaves along it.
    Float beam_share(const BSDFContext& context, const Layer& layer, const Vector3f& wi) const {
        const Float through = dr::mean(layer.beam);
        if (!context.is_enabled(BSDFFlags::Null, 2) || !(through > 0)) return 0;
        if (wi.z() < 0 && m_table->lookup.is_one_sided()) return 1;
        return through / (through + dr::mean(layer.albedo) * (1 - through));
    }

    std::unique_ptr<const StratusTable> m_table;
    ref<Texture> m_depth, m_albedo;
    ScalarFloat m_scale;

    MI_TRAVERSE_CB(Base, m_depth, m_albedo)
};

MI_EXPORT_PLUGIN(StratusBSDF)
NAMESPACE_END(mitsuba)
