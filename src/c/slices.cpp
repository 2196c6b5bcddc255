// Slices: layers bound once, for short lookups.
#include <stratus/base/size.h>

#include "handles.h"

#include <memory>

namespace stratus::c {
namespace {

bool switched(int value, const char* name) {
    require(value == 0 || value == 1, "stratus_effects", name, "0 or 1", value);
    return value == 1;
}

Opposition::Law to_law(int law) {
    require(law >= STRATUS_NO_OPPOSITION && law <= STRATUS_HAPKE_OPPOSITION, "stratus_effects",
            "opposition", "one of the laws, 0 to 2", law);
    using Law = Opposition::Law;
    constexpr Law laws[] = {Law::none, Law::blinn, Law::hapke};
    return laws[law];
}

constexpr std::size_t first_effects_size = offsetof(stratus_effects, background);

Effects to_effects(const stratus_effects* asked, const char* function) {
    Effects effects;
    if (asked == nullptr) return effects;
    require_size(*asked, function, "effects", first_effects_size);
    const stratus_effects whole = completed(*asked);
    effects.single = switched(whole.single, "single");
    effects.multiple = switched(whole.multiple, "multiple");
    effects.reflection = switched(whole.reflection, "reflection");
    effects.transmission = switched(whole.transmission, "transmission");
    if (asked->size > first_effects_size)
        effects.background = switched(whole.background, "background");
    effects.density = whole.density;
    effects.opposition = {to_law(whole.opposition), whole.opposition_width,
                          whole.opposition_amplitude};
    return effects;
}

void require_channels(int channels, const char* function) {
    require(channels == 1 || channels == 3, function, "channels", "1 or 3", channels);
}

/// Binds `scatterer`, a table with `outside` or a phase function.
template <class Scatterer, class... Outside>
stratus_slice* bound(const Scatterer& scatterer, int channels, const double* optical_depth,
                     const double* albedo, const stratus_effects* asked, const char* function,
                     Outside... outside) {
    require_channels(channels, function);
    require_given(function, {{optical_depth, "optical_depth"}, {albedo, "albedo"}});
    const Effects effects = to_effects(asked, function);
    return new stratus_slice{AnySlice::with_channels(size(channels), [&](auto count) {
        return SliceOf<count>(scatterer, make_medium<count>(optical_depth, albedo), effects,
                              outside...);
    })};
}

int bind_table(const stratus_table* table, int channels, const double* optical_depth,
               const double* albedo, const stratus_effects* effects, stratus_slice** slice,
               const char* function, OutsideTable outside) noexcept {
    return make_guarded(function, slice, "slice", {{table, "table"}}, [&] {
        require_member(*table, function);
        return bound(table->view, channels, optical_depth, albedo, effects, function, outside);
    });
}

Vector vector_at(const float v[3]) { return {v[0], v[1], v[2]}; }

/// A lookup of a slice: `look_up` returns its value.
template <class LookUp>
int look_up_once(const stratus_slice* slice, float* value, const char* function,
                 const LookUp& look_up) noexcept {
    return run_guarded(function, {{slice, "slice"}, {value, "value"}}, [&] {
        slice->own.with_slice([&](const auto& of) { write(look_up(of), value); });
    });
}

int look_up_angles(const stratus_slice* slice, Side side, float mu_in, float mu_out, float azimuth,
                   float* value, const char* function) noexcept {
    return look_up_once(slice, value, function, [=](const auto& of) noexcept {
        return of.scattering(side, mu_in, mu_out, azimuth);
    });
}

int look_up_many(const stratus_slice* slice, Side side, std::size_t count, const float* mu_in,
                 const float* mu_out, const float* azimuth, float* value,
                 const char* function) noexcept {
    return run_guarded(function, {{slice, "slice"}}, [&] {
        require_arrays(count, {mu_in, mu_out, azimuth, value}, function);
        slice->own.with_slice(
            [&](const auto& of) { of.scattering(side, count, mu_in, mu_out, azimuth, value); });
    });
}

}  // namespace
}  // namespace stratus::c

using namespace stratus;
using namespace stratus::c;

int stratus_effects_default(stratus_effects* effects) {
    return run_guarded(__func__, {{effects, "effects"}}, [&, function = __func__] {
        require_size(*effects, function, "effects", first_effects_size);
        const Effects usual;
        fill(*effects, {sizeof(stratus_effects), usual.single, usual.multiple, usual.reflection,
                        usual.transmission, usual.density, STRATUS_NO_OPPOSITION,
                        usual.opposition.width, usual.opposition.amplitude, usual.background});
    });
}

int stratus_slice_bind(const stratus_table* table, int channels, const double* optical_depth,
                       const double* albedo, const stratus_effects* effects,
                       stratus_slice** slice) {
    return bind_table(table, channels, optical_depth, albedo, effects, slice, __func__,
                      OutsideTable::refuse);
}

int stratus_slice_bind_clamped(const stratus_table* table, int channels,
                               const double* optical_depth, const double* albedo,
                               const stratus_effects* effects, stratus_slice** slice) {
    return bind_table(table, channels, optical_depth, albedo, effects, slice, __func__,
                      OutsideTable::clamp);
}

int stratus_slice_bind_single(const char* phase_function, int channels, const double* optical_depth,
                              const double* albedo, const stratus_effects* effects,
                              stratus_slice** slice) {
    const char* const function = __func__;
    return make_guarded(function, slice, "slice", {{phase_function, "phase_function"}}, [&] {
        return bound(read_phase_function(phase_function), channels, optical_depth, albedo, effects,
                     function);
    });
}

int stratus_slice_bind_single_stack(size_t layer_count, const stratus_layer* layers, int channels,
                                    const stratus_effects* effects, stratus_slice** slice) {
    return make_guarded(__func__, slice, "slice", {}, [&, function = __func__] {
        const StackLayers stack = make_layers(layers, layer_count, function);
        require_channels(channels, function);
        const Effects asked = to_effects(effects, function);
        return new stratus_slice{AnySlice::with_channels(
            size(channels), [&](auto count) { return SliceOf<count>(stack, asked); })};
    });
}

void stratus_slice_free(stratus_slice* slice) { delete slice; }

int stratus_slice_channels(const stratus_slice* slice) {
    return slice == nullptr ? 0 : slice->own.channels();
}

size_t stratus_slice_bytes(const stratus_slice* slice) {
    if (slice == nullptr) return 0;
    return slice->own.with_slice([](const auto& of) { return of.bytes(); });
}

int stratus_slice_clamped(const stratus_slice* slice) {
    if (slice == nullptr) return 0;
    return slice->own.with_slice([](const auto& of) { return of.clamped() ? 1 : 0; });
}

int stratus_slice_reflection(const stratus_slice* slice, float mu_in, float mu_out, float azimuth,
                             float* value) {
    return look_up_angles(slice, Side::reflection, mu_in, mu_out, azimuth, value, __func__);
}

int stratus_slice_transmission(const stratus_slice* slice, float mu_in, float mu_out, float azimuth,
                               float* value) {
    return look_up_angles(slice, Side::transmission, mu_in, mu_out, azimuth, value, __func__);
}

int stratus_slice_eval(const stratus_slice* slice, const float wi[3], const float wo[3],
                       float* value) {
    return run_guarded(__func__, {{slice, "slice"}, {value, "value"}, {wi, "wi"}, {wo, "wo"}}, [&] {
        slice->own.with_slice(
            [&](const auto& of) { write(of.eval(vector_at(wi), vector_at(wo)), value); });
    });
}

int stratus_slice_reflection_many(const stratus_slice* slice, size_t count, const float* mu_in,
                                  const float* mu_out, const float* azimuth, float* value) {
    return look_up_many(slice, Side::reflection, count, mu_in, mu_out, azimuth, value, __func__);
}

int stratus_slice_transmission_many(const stratus_slice* slice, size_t count, const float* mu_in,
                                    const float* mu_out, const float* azimuth, float* value) {
    return look_up_many(slice, Side::transmission, count, mu_in, mu_out, azimuth, value, __func__);
}

int stratus_slice_eval_many(const stratus_slice* slice, size_t count, const float* const wi[3],
                            const float* const wo[3], float* value) {
    return run_guarded(
        __func__, {{slice, "slice"}, {wi, "wi"}, {wo, "wo"}}, [&, function = __func__] {
            require_arrays(count, {wi[0], wi[1], wi[2], wo[0], wo[1], wo[2], value}, function);
            slice->own.with_slice([&](const auto& of) { of.eval(count, wi, wo, value); });
        });
}

int stratus_slice_direct(const stratus_slice* slice, float mu, float* value) {
    return look_up_once(slice, value, __func__,
                        [=](const auto& of) noexcept { return of.direct(mu); });
}

int stratus_slice_background(const stratus_slice* slice, float mu, float* value) {
    return look_up_once(slice, value, __func__,
                        [=](const auto& of) noexcept { return of.background(mu); });
}

int stratus_slice_source_behind(const stratus_slice* slice, float mu, float* value) {
    return look_up_once(slice, value, __func__,
                        [=](const auto& of) noexcept { return of.source_behind(mu); });
}

// BSDFs: slices that draw directions, too.

int stratus_bsdf_build(stratus_slice** slice, stratus_bsdf** bsdf) {
    return make_guarded(__func__, bsdf, "bsdf", {{slice, "slice"}}, [&, function = __func__] {
        require_given(function, {{*slice, "*slice"}});
        const std::unique_ptr<stratus_slice> given(std::exchange(*slice, nullptr));
        return new stratus_bsdf{{std::move(given->own).to_bsdf()}};
    });
}

void stratus_bsdf_free(stratus_bsdf* bsdf) { delete bsdf; }

const stratus_slice* stratus_bsdf_slice(const stratus_bsdf* bsdf) { return bsdf; }

size_t stratus_bsdf_bytes(const stratus_bsdf* bsdf) {
    if (bsdf == nullptr) return 0;
    return bsdf->own.with_bsdf([](const auto& of) { return of.bytes(); });
}

int stratus_bsdf_sample(const stratus_bsdf* bsdf, const float wi[3], const float random[3],
                        float wo[3], float* value, float* pdf) {
    return run_guarded(__func__,
                       {{bsdf, "bsdf"},
                        {wi, "wi"},
                        {random, "random"},
                        {wo, "wo"},
                        {value, "value"},
                        {pdf, "pdf"}},
                       [&] {
                           bsdf->own.with_bsdf([&](const auto& of) {
                               const auto drawn =
                                   of.sample(vector_at(wi), random[0], random[1], random[2]);
                               wo[0] = drawn.wo.x;
                               wo[1] = drawn.wo.y;
                               wo[2] = drawn.wo.z;
                               write(drawn.value, value);
                               *pdf = drawn.pdf;
                           });
                       });
}

int stratus_bsdf_pdf(const stratus_bsdf* bsdf, const float wi[3], const float wo[3], float* pdf) {
    return run_guarded(__func__, {{bsdf, "bsdf"}, {wi, "wi"}, {wo, "wo"}, {pdf, "pdf"}}, [&] {
        *pdf = bsdf->own.with_bsdf(
            [&](const auto& of) { return of.pdf(vector_at(wi), vector_at(wo)); });
    });
}

int stratus_bsdf_albedo(const stratus_bsdf* bsdf, const float wi[3], float* reflected,
                        float* transmitted) {
    return run_guarded(
        __func__,
        {{bsdf, "bsdf"}, {wi, "wi"}, {reflected, "reflected"}, {transmitted, "transmitted"}}, [&] {
            bsdf->own.with_bsdf([&](const auto& of) {
                const auto shares = of.albedo(vector_at(wi));
                write(shares.reflected, reflected);
                write(shares.transmitted, transmitted);
            });
        });
}
