#include <stratus/runtime/slice.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/diffuse_transmittance.h>
#include <stratus/runtime/diffusion.h>
#include <stratus/runtime/packed_table.h>
#include <stratus/runtime/single_scattering.h>

#include "kernels/kernels.h"
#include "layer_blend.h"
#include "layer_coverage.h"
#include "slice_refinement.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace stratus {
namespace {

constexpr const char* bind_caller = "bind";

template <int channels>
const SideKernel<channels>& kernel_of(Side which, PhaseForm form, Orders orders) {
    const Kernels& all = kernels();
    const bool reflected = which == Side::reflection;
    if constexpr (channels == 1)
        return (reflected ? all.reflected : all.transmitted).of(form, orders);
    else
        return (reflected ? all.reflected_rgb : all.transmitted_rgb).of(form, orders);
}

/// Particles of a stack's layers may differ in all that these effects ask about.
void check_stack_effects(const Effects& effects) {
    require(effects.density == 0, bind_caller, "density", "0 of a stack", effects.density);
    require(effects.opposition.law == Opposition::Law::none, bind_caller, "opposition",
            "none of a stack", "a law");
}

template <int channels>
Medium<channels> medium_of(const std::vector<StackLayer>& layers) {
    const StackLayer mean = mean_layer(layers);
    Medium<channels> medium;
    std::fill(medium.optical_depth, medium.optical_depth + channels, mean.optical_depth);
    std::fill(medium.albedo, medium.albedo + channels, mean.albedo);
    return medium;
}

/// A depth in single precision, finite. exp(-tau) is 0 in float from 104 on.
float in_single(double optical_depth, Side which) {
    return static_cast<float>(std::min(optical_depth, which == Side::reflection ? 1e30 : 1e4));
}

/// What a layer deeper than the deepest sample scatters, over what one as deep does.
double beyond_deepest(const TableView& table, Side which, double albedo, double optical_depth) {
    const Stencil around = table.albedo.stencil(albedo);
    double exponent = 0;
    for (int m = 0; m < table.members.count; ++m)
        for (int l = 0; l < std::min(stencil_size, table.albedo.count); ++l)
            exponent += double{table.members.weight[m]} * double{around.weight[l]} *
                        table.diffusion_exponent[table.members.member[m] * table.albedo.count +
                                                 around.first + l];
    const auto scale = which == Side::reflection ? reflection_scale : transmission_scale;
    const auto at = [&](double depth) {
        return scale(depth, std::max(0.0, exponent), table.extrapolation_length);
    };
    const double deepest = at(table.optical_depth.highest);
    return deepest > 0 ? at(optical_depth) / deepest : 0;
}

/// The orders n >= 2 of a layer on one side, from a packed table.
ChannelOrders packed_orders(const TableView& table, Side which, double albedo,
                            double optical_depth) {
    const AxisView& depths = table.optical_depth;
    const bool is_deep = !depths.ends_at_infinity && optical_depth > depths.highest;
    const double depth = is_deep ? depths.highest : optical_depth;
    const bool follows = is_deep && is_depth_known(table, which, albedo, optical_depth);
    ChannelOrders orders;
    orders.blend.optical_depth = follows ? optical_depth : depth;
    if (is_scattered_once(table, albedo, optical_depth)) {
        orders.sheet.assign(static_cast<std::size_t>(table.mu_in.count) *
                                static_cast<std::size_t>(table.mu_out.count) *
                                static_cast<std::size_t>(table.azimuth.count),
                            0.0f);
        return orders;
    }
    orders.sheet = table.packed->layer(which, albedo, depth, table.members);
    if (follows) {
        const double factor = beyond_deepest(table, which, albedo, optical_depth);
        for (float& value : orders.sheet) value *= static_cast<float>(factor);
    }
    return orders;
}

/// The orders n >= 2 of a layer on one side.
ChannelOrders orders_of(const TableView& table, Side which, double albedo, double optical_depth) {
    if (table.packed != nullptr) return packed_orders(table, which, albedo, optical_depth);
    const auto blend = which == Side::reflection ? reflection_blend : transmission_blend;
    const bool is_deep = optical_depth > table.optical_depth.highest;
    const BeyondDeepest beyond = is_deep && is_depth_known(table, which, albedo, optical_depth)
                                     ? BeyondDeepest::follows_diffusion
                                     : BeyondDeepest::is_clamped;
    LayerBlend found = blend(table, albedo, optical_depth, beyond);
    if (is_scattered_once(table, albedo, optical_depth)) found.count = 0;
    return {found, {}};
}

/// Cosines of a background's curve where no table gives them.
AxisView background_axis() {
    static const AxisView axis = make_axis(AxisScale::arcsine_of_fourth_root, 0.01, 1, 24).view();
    return axis;
}

/// The beam and the diffuse transmittance; `diffuse` is divided by the share intercepted.
float background_share(const AxisView& cosines, const std::vector<float>& diffuse,
                       double optical_depth, double mu) noexcept {
    double share = direct_transmittance(optical_depth, mu);
    if (!diffuse.empty()) {
        const Stencil stencil = cosines.stencil(mu);
        float ratio = 0;
        for (int i = 0; i < std::min(stencil_size, cosines.count); ++i)
            ratio += stencil.weight[i] * diffuse[static_cast<std::size_t>(stencil.first + i)];
        share += intercepted_share(optical_depth, mu) * double{std::max(ratio, 0.0f)};
    }
    return static_cast<float>(std::min(share, 1.0));
}

template <int channels>
auto value_of(const float (&value)[channels], float factor) noexcept {
    if constexpr (channels == 1)
        return value[0] * factor;
    else
        return Rgb{value[0] * factor, value[1] * factor, value[2] * factor};
}

}  // namespace

template <int channels>
struct SliceOf<channels>::BoundSide {
    SliceSide<channels> view{};
    PhaseForm form = PhaseForm::none;
    Orders orders = Orders::none;
    SideKernel<channels> kernel{};  // null functions: nothing comes this way
    std::vector<float> sample;
    PhaseCurve phase;
    OppositionTable opposition;
    std::vector<PhaseCurve> layer_phases;  // of a stack
    std::vector<SliceLayer> layers;
};

template <int channels>
SliceOf<channels>::SliceOf(SliceOf&&) noexcept = default;
template <int channels>
SliceOf<channels>& SliceOf<channels>::operator=(SliceOf&&) noexcept = default;
template <int channels>
SliceOf<channels>::~SliceOf() = default;

template <int channels>
SliceOf<channels>::SliceOf(const PhaseFunction& phase_function, const PhaseCurve& curve,
                           const LowerBoundary* boundary, const Medium<channels>& medium,
                           const Effects& effects)
    : medium_(medium),
      reflection_(std::make_unique<BoundSide>()),
      transmission_(std::make_unique<BoundSide>()) {
    check_effects(effects);
    for (int c = 0; c < channels; ++c) {
        require(medium.optical_depth[c] >= 0, bind_caller, "optical_depth", "in [0, inf]",
                medium.optical_depth[c]);
        require(medium.albedo[c] >= 0 && medium.albedo[c] <= 1, bind_caller, "albedo", "in [0, 1]",
                medium.albedo[c]);
        medium_.optical_depth[c] =
            effective_optical_depth(medium.optical_depth[c], effects.density);
    }
    over_boundary_ = one_sided_ = boundary != nullptr && boundary->is_present();
    if (effects.single) forward_phase_ = static_cast<float>(phase_function(1));
    const auto set_medium = [&](SliceSide<channels>& view, Side which) {
        for (int c = 0; c < channels; ++c) {
            view.optical_depth[c] = in_single(medium_.optical_depth[c], which);
            view.quarter_albedo[c] = static_cast<float>(medium_.albedo[c] / 4);
        }
        view.level = one_sided_ ? 1 : 0;
        view.slope = one_sided_ ? 0 : 1;
    };
    if (effects.reflection) {
        SliceSide<channels>& view = reflection_->view;
        set_medium(view, Side::reflection);
        if (effects.single) {
            const bool layer_below = one_sided_ && boundary->kind == LowerBoundary::Kind::layer;
            const bool plain = effects.opposition.law == Opposition::Law::none && !layer_below;
            const Opposition opposition = seen_opposition(effects.opposition, effects.density);
            reflection_->phase =
                plain ? curve : PhaseCurve::reflected(phase_function, opposition, boundary);
            reflection_->opposition = OppositionTable(opposition);
            view.opposition = reflection_->opposition.view();
            reflection_->form = reflection_->phase.form();
            for (int c = 0; c < channels; ++c) {
                view.surface_albedo[c] =
                    one_sided_ && !layer_below ? static_cast<float>(boundary->albedo) : 0;
                view.boundary_quarter_albedo[c] =
                    layer_below ? static_cast<float>(boundary->albedo / 4) : 0;
            }
        }
    }
    if (effects.transmission && !one_sided_) {
        set_medium(transmission_->view, Side::transmission);
        if (effects.single) {
            transmission_->phase = curve;
            transmission_->form = curve.form();
        }
    }
    for (BoundSide* side : {reflection_.get(), transmission_.get()})
        side->view.phase = side->phase.view();
    set_kernels();
}

template <int channels>
SliceOf<channels>::SliceOf(const PhaseFunction& phase_function, const Medium<channels>& medium,
                           const Effects& effects)
    : SliceOf(phase_function, PhaseCurve(phase_function), nullptr, medium, effects) {
    bind_background(nullptr, phase_function, nullptr, effects);
}

template <int channels>
SliceOf<channels>::SliceOf(const std::vector<StackLayer>& layers, const Effects& effects)
    : SliceOf(mean_layer(layers).phase_function, PhaseCurve(mean_layer(layers).phase_function),
              nullptr, medium_of<channels>(layers), effects) {
    check_layers(layers, false, bind_caller);
    check_stack_effects(effects);
    bind_stack(layers, nullptr);
    bind_background(nullptr, {}, &layers, effects);
}

template <int channels>
SliceOf<channels>::SliceOf(const TableView& table, const Medium<channels>& medium,
                           const Effects& effects, OutsideTable outside)
    : SliceOf(table.chosen_phase_function(),
              table.has_family() ? PhaseCurve(table.chosen_phase_function()) : *table.phase_curve,
              table.lower_boundary, medium, effects) {
    if (table.is_stack()) {
        check_stack_effects(effects);
        check_coverage(table, Side::reflection, outside);
        bind_stack(*table.layers, table.lower_boundary);
    }
    if (effects.multiple) {
        has_all_directions_ = table.has_all_directions();
        const auto take = [&](Side which, bool asked, bool held, BoundSide& side) {
            if (!asked || !held) return;
            check_coverage(table, which, outside);
            bind_orders(table, which, side);
        };
        take(Side::reflection, effects.reflection, table.has_reflection(), *reflection_);
        take(Side::transmission, effects.transmission, table.has_transmission(), *transmission_);
        set_kernels();
    }
    if (effects.background && effects.multiple && table.diffuse_transmittance != nullptr)
        check_coverage(table, Side::transmission, outside);
    bind_background(&table, table.chosen_phase_function(), table.layers, effects);
}

template <int channels>
void SliceOf<channels>::bind_stack(const std::vector<StackLayer>& layers,
                                   const LowerBoundary* boundary) {
    medium_ = medium_of<channels>(layers);  // clamped to it
    for (int c = 0; c < channels; ++c) {
        const double depth = medium_.optical_depth[c];
        reflection_->view.optical_depth[c] = in_single(depth, Side::reflection);
        transmission_->view.optical_depth[c] = in_single(depth, Side::transmission);
    }
    one_sided_ = true;
    if (transmission_->form != PhaseForm::none) bind_layers(layers, *transmission_);
    if (reflection_->form != PhaseForm::none) {
        std::vector<StackLayer> all = layers;
        if (over_boundary_ && boundary->kind == LowerBoundary::Kind::layer)
            all.push_back({boundary->phase_function, boundary->albedo, infinity});
        bind_layers(std::move(all), *reflection_);
    }
    set_kernels();
}

template <int channels>
void SliceOf<channels>::bind_layers(std::vector<StackLayer> layers, BoundSide& side) {
    const Side which = &side == reflection_.get() ? Side::reflection : Side::transmission;
    double above = 0, below = medium_.optical_depth[0];
    for (const StackLayer& layer : layers) {
        below = below < infinity ? std::max(0.0, below - layer.optical_depth) : 0;
        side.layer_phases.push_back(PhaseCurve::sampled(
            1, [&](double c, double* value) { *value = layer.phase_function(c); }));
        side.layers.push_back({side.layer_phases.back().view(), in_single(above, which),
                               in_single(below, which), in_single(layer.optical_depth, which),
                               static_cast<float>(layer.albedo / 4)});
        above += layer.optical_depth;
    }
    side.form = PhaseForm::of_stack;
    side.view.layer = side.layers.data();
    side.view.layers = static_cast<int>(side.layers.size());
}

template <int channels>
void SliceOf<channels>::check_coverage(const TableView& table, Side which, OutsideTable outside) {
    const auto check = [&](bool known, const char* argument, const std::string& allowed,
                           double value) {
        if (known) return;
        if (outside == OutsideTable::refuse) require(false, bind_caller, argument, allowed, value);
        clamped_ = true;
    };
    for (std::size_t k = 0; k < table.chosen.size(); ++k)
        check(holds((*table.family)[k], table.chosen[k]), (*table.family)[k].name(),
              allowed_text((*table.family)[k]), table.chosen[k]);
    for (int c = 0; c < channels; ++c) {
        const double albedo = medium_.albedo[c], depth = medium_.optical_depth[c];
        if (is_scattered_once(table, albedo, depth)) continue;
        check(holds(table.albedo, albedo), "albedo", allowed_albedo(table), albedo);
        check(is_depth_known(table, which, albedo, depth), "optical_depth", allowed_depth(table),
              depth);
    }
}

namespace {

/// Rows 0 and 1 over mu, 2 azimuths.
constexpr std::size_t no_samples = (2 + 3) * 2;

}  // namespace

template <int channels>
void SliceOf<channels>::bind_orders(const TableView& table, Side which, BoundSide& side) {
    std::vector<ChannelOrders> orders;
    for (int c = 0; c < channels; ++c)
        orders.push_back(orders_of(table, which, medium_.albedo[c], medium_.optical_depth[c]));
    const auto closed_form = [&](int c, double mu_in, double mu_out, double azimuth) {
        if (side.kernel.at_angles == nullptr) return 0.0;
        float value[channels];
        side.kernel.at_angles(side.view, static_cast<float>(mu_in), static_cast<float>(mu_out),
                              static_cast<float>(azimuth), value);
        return double{value[c]};
    };
    side.orders = table.path_law != nullptr ? Orders::with_azimuth_and_path
                  : table.azimuth.count > 1 ? Orders::with_azimuth
                                            : Orders::without_azimuth;
    if (table.path_law != nullptr) {
        if (path_.sample_count() == 0)
            path_ = PathSheet(*table.path_law, medium_.albedo, channels, table.highest_order);
        side.view.path = path_.view();
        // What lookups know in closed form: the kernel itself, of no samples.
        side.sample.assign(no_samples * channels + 1, 0.0f);
        side.view.sample = side.sample.data();
        side.view.symmetric = true;
        side.view.azimuths = 2;
        set_kernels();
    }
    RefinedSamples refined = refine(table, orders, closed_form);
    side.sample = std::move(refined.sample);
    side.view.sample = side.sample.data();
    side.view.symmetric = refined.symmetric;
    side.view.columns = refined.columns;
    side.view.azimuths = refined.azimuths;
    side.view.mu_in = refined.mu_in;
    side.view.mu_out = refined.mu_out;
    side.view.azimuth = refined.azimuth;
}

template <int channels>
void SliceOf<channels>::bind_background(const TableView* table, const PhaseFunction& phase_function,
                                        const std::vector<StackLayer>* layers,
                                        const Effects& effects) {
    if (over_boundary_ || !effects.background) return;
    const bool all_orders = effects.multiple && table && table->diffuse_transmittance;
    if (!all_orders && !effects.single) return;
    background_mu_ = all_orders ? table->mu_in : background_axis();
    std::vector<SingleDiffuseTransmittance> order_1;  // of the layer, or of each
    if (all_orders != effects.single) {
        if (layers)
            for (const StackLayer& layer : *layers) order_1.emplace_back(layer.phase_function);
        else
            order_1.emplace_back(phase_function);
    }
    const auto once = [&](double albedo, double depth, double mu) {
        if (!layers) return albedo * order_1[0](depth, mu);
        Surroundings around{0, depth};
        double sum = 0;
        for (std::size_t k = 0; k < layers->size(); ++k) {
            const StackLayer& layer = (*layers)[k];
            around.below = std::max(0.0, around.below - layer.optical_depth);
            sum += layer.albedo * direct_transmittance(around.above, mu) *
                   order_1[k](layer.optical_depth, mu, around.below);
            around.above += layer.optical_depth;
        }
        return sum;
    };
    for (int c = 0; c < channels; ++c) {
        const double albedo = medium_.albedo[c], depth = medium_.optical_depth[c];
        if (albedo == 0 || depth == 0 || depth == infinity) continue;
        std::vector<double> diffuse(static_cast<std::size_t>(background_mu_.count));
        if (all_orders) diffuse = diffuse_transmittance(*table, albedo, depth);
        for (int i = 0; i < background_mu_.count; ++i) {
            const double mu = background_mu_.value(i);
            double& value = diffuse[static_cast<std::size_t>(i)];
            if (!order_1.empty()) value += (all_orders ? -1 : 1) * once(albedo, depth, mu);
            background_[static_cast<std::size_t>(c)].push_back(
                static_cast<float>(value / intercepted_share(depth, mu)));
        }
    }
}

template <int channels>
void SliceOf<channels>::set_kernels() {
    reflection_->kernel =
        kernel_of<channels>(Side::reflection, reflection_->form, reflection_->orders);
    transmission_->kernel =
        kernel_of<channels>(Side::transmission, transmission_->form, transmission_->orders);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::at(const BoundSide& side, float mu_in,
                                                        float mu_out,
                                                        float azimuth) const noexcept {
    float value[channels] = {};
    if (side.kernel.at_angles != nullptr)
        side.kernel.at_angles(side.view, mu_in, mu_out, azimuth, value);
    return value_of(value, 1);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::reflection(float mu_in, float mu_out,
                                                                float azimuth) const noexcept {
    return at(*reflection_, mu_in, mu_out, azimuth);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::transmission(float mu_in, float mu_out,
                                                                  float azimuth) const noexcept {
    return at(*transmission_, mu_in, mu_out, azimuth);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::eval(const Vector& wi,
                                                          const Vector& wo) const noexcept {
    const float sides = wi.z * wo.z;
    if (!(sides != 0) || (one_sided_ && !(wi.z > 0))) return Value{};
    const BoundSide& side = *(sides > 0 ? reflection_ : transmission_);
    float value[channels] = {};
    if (side.kernel.at_angles != nullptr) side.kernel.at_vectors(side.view, wi, wo, value);
    return value_of(value, static_cast<float>(1 / pi));
}

namespace {

/// Blocks of `paths_at_once` lookups; the last may be shorter. use(first, count).
template <class Use>
void in_blocks(std::size_t count, const Use& use) noexcept {
    for (std::size_t first = 0; first < count; first += paths_at_once)
        use(first, std::min<std::size_t>(paths_at_once, count - first));
}

/// `count` numbers where a kernel wants `paths_at_once`: themselves, or a copy that ends in the
/// last.
class Block {
  public:
    const float* of(const float* numbers, std::size_t count) noexcept {
        if (count == paths_at_once) return numbers;
        std::copy(numbers, numbers + count, copy_);
        std::fill(copy_ + count, copy_ + paths_at_once, numbers[count - 1]);
        return copy_;
    }

  private:
    float copy_[paths_at_once];
};

}  // namespace

template <int channels>
void SliceOf<channels>::many(const BoundSide& side, std::size_t count, const float* mu_in,
                             const float* mu_out, const float* azimuth,
                             float* value) const noexcept {
    if (side.kernel.at_angles == nullptr) {
        std::fill(value, value + channels * count, 0.0f);
        return;
    }
    const Kernels& all = kernels();
    in_blocks(count, [&](std::size_t first, std::size_t here) {
        Block in, out, around;
        LightPaths paths;
        alignas(64) float found[channels * paths_at_once];
        all.paths_of_angles[&side == transmission_.get()](in.of(mu_in + first, here),
                                                          out.of(mu_out + first, here),
                                                          around.of(azimuth + first, here), paths);
        side.kernel.many(side.view, paths, found);
        for (int c = 0; c < channels; ++c)
            std::copy(found + c * paths_at_once, found + c * paths_at_once + here,
                      value + static_cast<std::size_t>(c) * count + first);
    });
}

template <int channels>
void SliceOf<channels>::reflection(std::size_t count, const float* mu_in, const float* mu_out,
                                   const float* azimuth, float* value) const noexcept {
    many(*reflection_, count, mu_in, mu_out, azimuth, value);
}

template <int channels>
void SliceOf<channels>::transmission(std::size_t count, const float* mu_in, const float* mu_out,
                                     const float* azimuth, float* value) const noexcept {
    many(*transmission_, count, mu_in, mu_out, azimuth, value);
}

template <int channels>
void SliceOf<channels>::eval(std::size_t count, const float* const wi[3], const float* const wo[3],
                             float* value) const noexcept {
    const Kernels& all = kernels();
    in_blocks(count, [&](std::size_t first, std::size_t here) {
        Block blocks[6];
        const float *in[3], *out[3];
        for (int d = 0; d < 3; ++d) {
            in[d] = blocks[d].of(wi[d] + first, here);
            out[d] = blocks[d + 3].of(wo[d] + first, here);
        }
        LightPaths paths;
        alignas(64) float reflected[channels * paths_at_once] = {},
                                               transmitted[channels * paths_at_once] = {};
        all.paths_of_vectors(in, out, paths);
        bool any[2] = {false, false};
        for (std::size_t i = 0; i < here; ++i) any[in[2][i] * out[2][i] > 0 ? 0 : 1] = true;
        if (any[0] && reflection_->kernel.at_angles != nullptr)
            reflection_->kernel.many(reflection_->view, paths, reflected);
        if (any[1] && transmission_->kernel.at_angles != nullptr)
            transmission_->kernel.many(transmission_->view, paths, transmitted);
        for (std::size_t i = 0; i < here; ++i) {
            const float sides = in[2][i] * out[2][i];
            const bool seen = sides != 0 && (!one_sided_ || in[2][i] > 0);
            const float scale = seen ? static_cast<float>(1 / pi) : 0.0f;
            for (std::size_t c = 0; c < channels; ++c)
                value[c * count + first + i] =
                    scale * (sides > 0 ? reflected : transmitted)[c * paths_at_once + i];
        }
    });
}

template <int channels>
template <class OfChannel>
typename SliceOf<channels>::Value SliceOf<channels>::seen_through(
    const OfChannel& of) const noexcept {
    float value[channels] = {};
    for (int c = 0; c < channels && !over_boundary_; ++c) value[c] = static_cast<float>(of(c));
    return value_of(value, 1);
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::direct(float mu) const noexcept {
    return seen_through(
        [&](int c) { return direct_transmittance(medium_.optical_depth[c], double{mu}); });
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::background(float mu) const noexcept {
    return seen_through([&](int c) {
        return background_share(background_mu_, background_[static_cast<std::size_t>(c)],
                                medium_.optical_depth[c], double{mu});
    });
}

template <int channels>
typename SliceOf<channels>::Value SliceOf<channels>::source_behind(float mu) const noexcept {
    return seen_through([&](int c) {
        return source_seen_through(double{forward_phase_}, medium_.albedo[c],
                                   medium_.optical_depth[c], double{mu});
    });
}

namespace {

std::size_t sample_count(const std::vector<PhaseCurve>& curves) noexcept {
    std::size_t count = 0;
    for (const PhaseCurve& curve : curves) count += curve.sample_count();
    return count;
}

}  // namespace

template <int channels>
std::size_t SliceOf<channels>::bytes() const noexcept {
    std::size_t numbers = path_.sample_count();
    for (const BoundSide* side : {reflection_.get(), transmission_.get()})
        numbers += stratus::sample_count(side->layer_phases) + side->sample.size() +
                   side->phase.sample_count() + side->opposition.sample_count();
    for (const std::vector<float>& curve : background_) numbers += curve.size();
    return sizeof *this + 2 * sizeof(BoundSide) + numbers * sizeof(float);
}

template class SliceOf<1>;
template class SliceOf<3>;

Slice bind(const TableView& table, double optical_depth, double albedo, const Effects& effects,
           OutsideTable outside) {
    return Slice(table, {{optical_depth}, {albedo}}, effects, outside);
}

Slice bind(const TableView& table, double optical_depth, double albedo,
           std::initializer_list<double> parameters, const Effects& effects, OutsideTable outside) {
    return bind(table.at(parameters), optical_depth, albedo, effects, outside);
}

RgbSlice bind_rgb(const TableView& table, const double (&optical_depth)[3],
                  const double (&albedo)[3], const Effects& effects, OutsideTable outside) {
    Medium<3> medium;
    std::copy(optical_depth, optical_depth + 3, medium.optical_depth);
    std::copy(albedo, albedo + 3, medium.albedo);
    return RgbSlice(table, medium, effects, outside);
}

}  // namespace stratus
