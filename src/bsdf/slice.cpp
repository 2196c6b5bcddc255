#include <stratus/bsdf/slice.h>

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/bsdf/any_slice.h>
#include <stratus/layer/single_scattering.h>

#include "layer/reflected_curve.h"
#include "slice_parts.h"
#include "table/layer_blend.h"
#include "table/lookup_arguments.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace stratus {
namespace {

constexpr const char* bind_caller = "bind";

template <int channels>
const SideKernel<channels>& find_kernel(Side which, PhaseForm form, Orders orders) {
    if constexpr (channels == 1)
        return chosen_functions<Kernels>().grey[which].of(form, orders);
    else
        return chosen_functions<Kernels>().rgb[which].of(form, orders);
}

/// Particles of a stack's layers may differ in all that these effects ask about.
void check_stack_effects(const Effects& effects) {
    require(effects.density == 0, bind_caller, "density", "0 of a stack", effects.density);
    require(!effects.opposition.is_present(), bind_caller, "opposition", "none of a stack",
            "a law");
}

template <int channels>
Medium<channels> make_medium(const StackLayers& layers) {
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
    : medium_(medium), sides_{std::make_unique<BoundSide>(), std::make_unique<BoundSide>()} {
    check_effects(effects);
    for (int c = 0; c < channels; ++c) {
        require_in("[0, inf]", bind_caller, "optical_depth", medium.optical_depth[c]);
        require_in("[0, 1]", bind_caller, "albedo", medium.albedo[c]);
        medium_.optical_depth[c] =
            effective_optical_depth(medium.optical_depth[c], effects.density);
    }
    over_boundary_ = one_sided_ = boundary != nullptr && boundary->is_present();
    if (effects.single) forward_phase_ = static_cast<float>(phase_function(1));
    for (const Side which : both_sides) {
        const bool is_lit = which == Side::reflection;
        if (is_lit ? !effects.reflection : one_sided_ || !effects.transmission) continue;
        BoundSide& side = *sides_[which];
        SliceSide<channels>& view = side.view;
        for (int c = 0; c < channels; ++c) {
            view.optical_depth[c] = in_single(medium_.optical_depth[c], which);
            view.quarter_albedo[c] = static_cast<float>(medium_.albedo[c] / 4);
        }
        view.level = one_sided_ ? 1 : 0;
        view.slope = one_sided_ ? 0 : 1;
        if (!effects.single) continue;
        side.phase = curve;
        if (is_lit) {
            const auto kind = one_sided_ ? boundary->kind : LowerBoundary::Kind::none;
            const bool layer_below = kind == LowerBoundary::Kind::layer;
            const Opposition opposition = seen_opposition(effects.opposition, effects.density);
            if (opposition.is_present() || layer_below)
                side.phase = reflected_curve(phase_function, opposition, boundary);
            side.opposition = OppositionTable(opposition);
            view.opposition = side.opposition.view();
            for (int c = 0; c < channels; ++c) {
                const float albedo = one_sided_ ? static_cast<float>(boundary->albedo) : 0;
                view.surface_albedo[c] = kind == LowerBoundary::Kind::surface ? albedo : 0;
                view.boundary_quarter_albedo[c] = layer_below ? albedo / 4 : 0;
            }
        }
        side.form = side.phase.form();
    }
    for (const Side which : both_sides) sides_[which]->view.phase = sides_[which]->phase.view();
    set_kernels();
}

template <int channels>
SliceOf<channels>::SliceOf(const PhaseFunction& phase_function, const Medium<channels>& medium,
                           const Effects& effects)
    : SliceOf(phase_function, PhaseCurve(phase_function), nullptr, medium, effects) {
    bind_background(nullptr, phase_function, nullptr, effects);
}

template <int channels>
SliceOf<channels>::SliceOf(const StackLayers& layers, const Effects& effects)
    : SliceOf(mean_layer(layers).phase_function, PhaseCurve(mean_layer(layers).phase_function),
              nullptr, make_medium<channels>(layers), effects) {
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
        for (const Side which : both_sides) {
            const bool asked =
                which == Side::reflection ? effects.reflection : effects.transmission;
            if (asked && table.has(which)) {
                check_coverage(table, which, outside);
                bind_orders(table, which);
            } else {
                sides_[which]->form = PhaseForm::none;  // order 1 alone would pass for all light
            }
        }
        set_kernels();
    }
    if (effects.background && effects.multiple && table.diffuse_transmittance != nullptr)
        check_coverage(table, Side::transmission, outside);
    bind_background(&table, table.chosen_phase_function(), table.layers, effects);
}

template <int channels>
void SliceOf<channels>::bind_stack(const StackLayers& layers, const LowerBoundary* boundary) {
    medium_ = make_medium<channels>(layers);  // clamped to it
    for (const Side which : both_sides)
        for (int c = 0; c < channels; ++c)
            sides_[which]->view.optical_depth[c] = in_single(medium_.optical_depth[c], which);
    one_sided_ = true;
    if (sides_.transmission->form != PhaseForm::none) bind_layers(layers, Side::transmission);
    if (sides_.reflection->form != PhaseForm::none) {
        StackLayers all = layers;
        if (over_boundary_ && boundary->is_layer())
            all.push_back({boundary->phase_function, boundary->albedo, infinity});
        bind_layers(all, Side::reflection);
    }
    set_kernels();
}

template <int channels>
void SliceOf<channels>::bind_layers(const StackLayers& layers, Side which) {
    BoundSide& side = *sides_[which];
    double above = 0, below = medium_.optical_depth[0];
    for (const StackLayer& layer : layers) {
        below = layer.optical_depth < infinity ? std::max(0.0, below - layer.optical_depth) : 0;
        side.layer_phases.push_back(PhaseCurve::sampled(layer.phase_function));
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
    const auto check = [&](bool known, const char* argument, const auto& allowed, double value) {
        if (known) return;
        if (outside == OutsideTable::refuse)
            require(false, bind_caller, argument, allowed(), value);
        clamped_ = true;
    };
    for (std::size_t k = 0; k < table.chosen.size(); ++k) {
        const FamilyAxis& axis = (*table.family)[k];
        check(
            holds(axis, table.chosen[k]), axis.name(), [&] { return allowed_text(axis); },
            table.chosen[k]);
    }
    for (int c = 0; c < channels; ++c) {
        const double albedo = medium_.albedo[c], depth = medium_.optical_depth[c];
        if (is_scattered_once(table, albedo, depth)) continue;
        check(
            holds(table.albedo, albedo), "albedo", [&] { return allowed_albedo(table); }, albedo);
        check(
            is_depth_known(table, which, albedo, depth), "optical_depth",
            [&] { return allowed_depth(table); }, depth);
    }
}

namespace {

/// The azimuths of one step, and those beyond its ends.
constexpr int fewest_azimuths = 4;

/// Rows 0 and 1 over mu.
constexpr std::size_t no_samples = (2 + 3) * fewest_azimuths;

/// Samples without azimuth as samples that are the same at all azimuths.
template <int channels>
void repeat_over_azimuth(RefinedSamples& refined) {
    std::vector<float> repeated;
    for (std::size_t at = 0; at + channels < refined.sample.size(); at += channels) {
        const float* const here = &refined.sample[at];
        for (int azimuth = 0; azimuth < fewest_azimuths; ++azimuth)
            repeated.insert(repeated.end(), here, here + channels);
    }
    repeated.push_back(0);  // the number to spare
    refined.sample = std::move(repeated);
    refined.azimuths = fewest_azimuths;
    refined.places.scale[2] = refined.places.offset[2] = refined.places.last[2] = 0;
}

}  // namespace

template <int channels>
void SliceOf<channels>::bind_orders(const TableView& table, Side which) {
    BoundSide& side = *sides_[which];
    std::vector<ChannelOrders> orders;
    for (int c = 0; c < channels; ++c)
        orders.push_back(find_orders(table, which, medium_.albedo[c], medium_.optical_depth[c]));
    const auto closed_form = [&](int c, double mu_in, double mu_out, double azimuth) {
        if (side.kernel.at_angles == nullptr) return 0.0;
        const ChannelValues<channels> value =
            side.kernel.at_angles(side.view, static_cast<float>(mu_in), static_cast<float>(mu_out),
                                  static_cast<float>(azimuth));
        return double{value.of[c]};
    };
    side.orders = table.path_law != nullptr ? Orders::with_azimuth_and_path
                  : table.azimuth.count > 1 ? Orders::with_azimuth
                                            : Orders::without_azimuth;
    if (side.form == PhaseForm::constant && side.orders == Orders::with_azimuth)
        side.form = PhaseForm::polynomial;
    if (side.orders == Orders::with_azimuth_and_path &&
        (side.form == PhaseForm::constant || side.form == PhaseForm::polynomial))
        side.form = PhaseForm::one_lobe;  // of weight 0
    if (table.path_law != nullptr) {
        if (path_.sample_count() == 0)
            path_ = PathSheet(*table.path_law, medium_.albedo, channels, table.highest_order);
        side.view.path = path_.view();
        // The kernel itself, without samples, gives the closed forms that lookups add.
        side.sample.assign(no_samples * channels + 1, 0.0f);
        side.view.sample = side.sample.data();
        side.view.symmetric = true;
        side.view.azimuths = fewest_azimuths;
        set_kernels();
    }
    side.view.least = -std::numeric_limits<float>::infinity();
    RefinedSamples refined = refine(table, orders, closed_form);
    side.view.least = 0;
    if (!has_kernel(side.form, side.orders)) {  // without azimuth
        side.orders = Orders::with_azimuth;
        repeat_over_azimuth<channels>(refined);
    }
    if (side.form == PhaseForm::constant)
        for (float& sample : refined.sample) sample = std::max(sample, 0.0f);
    side.sample = std::move(refined.sample);
    side.view.sample = side.sample.data();
    static_cast<SampleShape&>(side.view) = refined;
}

template <int channels>
void SliceOf<channels>::bind_background(const TableView* table, const PhaseFunction& phase_function,
                                        const StackLayers* layers, const Effects& effects) {
    if (over_boundary_ || !effects.background) return;
    const bool all_orders = effects.multiple && table && table->diffuse_transmittance;
    if (!all_orders && !effects.single) return;
    SliceBackground background(all_orders ? table : nullptr, effects.single, phase_function,
                               layers);
    background_mu_ = background.cosines();
    for (std::size_t c = 0; c < channels; ++c)
        background_[c] = background.curve(medium_.albedo[c], medium_.optical_depth[c]);
}

template <int channels>
void SliceOf<channels>::set_kernels() {
    for (const Side which : both_sides) {
        BoundSide& side = *sides_[which];
        side.kernel = find_kernel<channels>(which, side.form, side.orders);
    }
}

template <int channels>
auto SliceOf<channels>::scattering(Side which, float mu_in, float mu_out,
                                   float azimuth) const noexcept -> Value {
    check_angles(mu_in, mu_out, azimuth);
    const BoundSide& side = *sides_[which];
    if (side.kernel.at_angles == nullptr)
        return all_channels<Value>(dark_at(mu_in, mu_out, azimuth));
    return from_channels<Value>(side.kernel.at_angles(side.view, mu_in, mu_out, azimuth).of);
}

template <int channels>
auto SliceOf<channels>::eval(const Vector& wi, const Vector& wo) const noexcept -> Value {
    check_vectors(wi, wo);
    const auto dark = [&] {
        return all_channels<Value>(zero_or_nan(wi.x, wi.y, wi.z, wo.x, wo.y, wo.z));
    };
    if (one_sided_ && !(wi.z > 0)) return dark();
    const auto between = [&](const BoundSide& side) {
        if (side.kernel.at_vectors == nullptr) return dark();
        return from_channels<Value>(side.kernel.at_vectors(side.view, wi, wo).of) *
               static_cast<float>(1 / pi);
    };
    const float sides = wi.z * wo.z;
    if (sides > 0) return between(*sides_.reflection);
    if (sides == 0) return dark();
    return between(*sides_.transmission);
}

namespace {

/// `count` numbers, `paths_at_once` at most, where a kernel reads as many as fill its registers: themselves, or a copy that
/// ends in the last.
class Block {
  public:
    const float* of(const float* numbers, std::size_t count) noexcept {
        const std::size_t rest = count % most_lanes;
        if (rest == 0) return numbers;
        std::copy(numbers, numbers + count, copy_);
        std::fill(copy_ + count, copy_ + count - rest + most_lanes, numbers[count - 1]);
        return copy_;
    }

  private:
    float copy_[paths_at_once];
};

}  // namespace

template <int channels>
void SliceOf<channels>::scattering(Side which, std::size_t count, const float* mu_in,
                                   const float* mu_out, const float* azimuth,
                                   float* value) const noexcept {
    for (std::size_t i = 0; i < count; ++i) check_angles(mu_in[i], mu_out[i], azimuth[i]);
    const BoundSide& side = *sides_[which];
    if (side.kernel.many == nullptr) {
        for (int c = 0; c < channels; ++c)
            for (std::size_t i = 0; i < count; ++i)
                *value++ = dark_at(mu_in[i], mu_out[i], azimuth[i]);
        return;
    }
    const Kernels& all = chosen_functions<Kernels>();
    for (std::size_t first = 0; first < count; first += paths_at_once) {
        const std::size_t here = std::min<std::size_t>(paths_at_once, count - first);
        Block in, out, around;
        LightPaths paths;
        alignas(64) float found[channels * path_room];
        const int some = static_cast<int>(here);
        all.paths_of_angles[which == Side::transmission](
            in.of(mu_in + first, here), out.of(mu_out + first, here),
            around.of(azimuth + first, here), some, paths);
        side.kernel.many(side.view, paths, some, found);
        for (int c = 0; c < channels; ++c)
            std::copy(found + c * path_room, found + c * path_room + here,
                      value + size(c) * count + first);
    }
}

template <int channels>
void SliceOf<channels>::eval(std::size_t count, const float* const wi[3], const float* const wo[3],
                             float* value) const noexcept {
    constexpr std::size_t room = channels * path_room;
    for (std::size_t i = 0; i < count; ++i)
        check_vectors({wi[0][i], wi[1][i], wi[2][i]}, {wo[0][i], wo[1][i], wo[2][i]});
    const Kernels& all = chosen_functions<Kernels>();
    for (std::size_t first = 0; first < count; first += paths_at_once) {
        const std::size_t here = std::min<std::size_t>(paths_at_once, count - first);
        Block blocks[6];
        const float *in[3], *out[3];
        for (int d = 0; d < 3; ++d) {
            in[d] = blocks[d].of(wi[d] + first, here);
            out[d] = blocks[d + 3].of(wo[d] + first, here);
        }
        PartedPaths paths;
        all.paths_of_vectors(in, out, static_cast<int>(here), one_sided_, paths);
        alignas(64) float found[2][room];
        for (const Side which : both_sides) {
            const BoundSide& side = *sides_[which];
            const int k = static_cast<int>(which);
            if (side.kernel.many == nullptr)
                std::fill(found[k], found[k] + room, 0.0f);
            else if (paths.count[k] > 0)
                side.kernel.many(side.view, paths.paths[k], paths.count[k], found[k]);
        }
        for (int c = 0; c < channels; ++c)
            all.joined(paths, found[0] + c * path_room, found[1] + c * path_room,
                       static_cast<int>(here), value + size(c) * count + first);
    }
}

template <int channels>
template <class OfChannel>
auto SliceOf<channels>::seen_through(float mu, const OfChannel& of) const noexcept -> Value {
    const double cosine = cosine_in_range("mu", double{mu});
    float value[channels];
    for (int c = 0; c < channels; ++c)
        value[c] = static_cast<float>(over_boundary_ ? zero_or_nan(cosine) : of(c, cosine));
    return from_channels<Value>(value);
}

template <int channels>
auto SliceOf<channels>::direct(float mu) const noexcept -> Value {
    return seen_through(mu, [&](int c, double cosine) {
        return direct_transmittance(medium_.optical_depth[c], cosine);
    });
}

template <int channels>
auto SliceOf<channels>::background(float mu) const noexcept -> Value {
    return seen_through(mu, [&](int c, double cosine) {
        const double depth = medium_.optical_depth[c], beam = direct_transmittance(depth, cosine);
        const std::vector<float>& curve = background_[size(c)];
        if (curve.empty()) return beam;
        const Stencil stencil = background_mu_.stencil(cosine);
        float ratio = 0;
        for (int i = 0; i < std::min(stencil_size, background_mu_.count); ++i)
            ratio += stencil.weight[i] * curve[size(stencil.first + i)];
        return std::min(beam + intercepted_share(depth, cosine) * double{std::max(ratio, 0.0f)},
                        1.0);
    });
}

template <int channels>
auto SliceOf<channels>::source_behind(float mu) const noexcept -> Value {
    return seen_through(mu, [&](int c, double cosine) {
        return source_seen_through(double{forward_phase_}, medium_.albedo[c],
                                   medium_.optical_depth[c], cosine);
    });
}

template <int channels>
std::size_t SliceOf<channels>::bytes() const noexcept {
    std::size_t numbers = path_.sample_count();
    for (const Side which : both_sides) {
        const BoundSide& side = *sides_[which];
        numbers += side.sample.size() + side.phase.sample_count() + side.opposition.sample_count();
        for (const PhaseCurve& phase : side.layer_phases) numbers += phase.sample_count();
    }
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
    return RgbSlice(table, make_medium<3>(optical_depth, albedo), effects, outside);
}

}  // namespace stratus
