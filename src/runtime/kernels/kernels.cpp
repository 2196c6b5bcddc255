#include "kernels.h"

#include "lanes.h"

#include <utility>

namespace stratus::STRATUS_ISA {
namespace {

template <Side which, PhaseForm form, Orders orders, int channels, class F>
[[gnu::always_inline]] inline void evaluate(const SideView<channels>& view,
                                            const LightPathOf<F>& path, F* value) {
    if constexpr (which == Side::reflection)
        reflected<form, orders>(view, path, value);
    else
        transmitted<form, orders>(view, path, value);
}

/// At one light path: plain floats, or all channels at once.
template <Side which, PhaseForm form, Orders orders, int channels>
[[gnu::always_inline]] inline void evaluate_one(const SideView<channels>& view,
                                                const LightPath& path, float* value) {
    if constexpr (channels == 1) {
        evaluate<which, form, orders>(view, path, value);
    } else {
        Channels here;
        evaluate<which, form, orders>(
            view,
            LightPathOf<Channels>{Channels(path.mu_in), Channels(path.mu_out),
                                  Channels(path.forward), Channels(path.backward),
                                  Channels(path.half_azimuth)},
            &here);
        for (int c = 0; c < channels; ++c) value[c] = here.v[c];
    }
}

template <Side which, PhaseForm form, Orders orders, int channels>
void at_angles(const SideView<channels>& view, float mu_in, float mu_out, float azimuth,
               float* value) {
    evaluate_one<which, form, orders>(view, light_path<which>(mu_in, mu_out, azimuth), value);
}

template <Side which, PhaseForm form, Orders orders, int channels>
void at_vectors(const SideView<channels>& view, const Vector& wi, const Vector& wo, float* value) {
    evaluate_one<which, form, orders>(view, light_path(wi.x, wi.y, wi.z, wo.x, wo.y, wo.z), value);
}

void store(const LightPathOf<Lookups>& path, LightPaths& paths, int i) {
    store(path.mu_in, paths.mu_in + i);
    store(path.mu_out, paths.mu_out + i);
    store(path.forward, paths.forward + i);
    store(path.backward, paths.backward + i);
    store(path.half_azimuth, paths.half_azimuth + i);
}

template <Side which, PhaseForm form, Orders orders, int channels>
void evaluate_many(const SideView<channels>& view, const LightPaths& paths, float* value) {
    for (int i = 0; i < paths_at_once; i += lane_width) {
        const LightPathOf<Lookups> path{
            load<Lookups>(paths.mu_in + i), load<Lookups>(paths.mu_out + i),
            load<Lookups>(paths.forward + i), load<Lookups>(paths.backward + i),
            load<Lookups>(paths.half_azimuth + i)};
        Lookups here[channels];
        evaluate<which, form, orders>(view, path, here);
        for (int c = 0; c < channels; ++c) store(here[c], value + c * paths_at_once + i);
    }
}

template <Side which, PhaseForm form, Orders orders, int channels>
constexpr SideKernel<channels> kernel() {
    constexpr bool nothing = form == PhaseForm::none && orders == Orders::none;
    constexpr bool unknown = which == Side::transmission && form == PhaseForm::composed;
    if constexpr (nothing || unknown)
        return {nullptr, nullptr, nullptr};
    else
        return {at_angles<which, form, orders, channels>, at_vectors<which, form, orders, channels>,
                evaluate_many<which, form, orders, channels>};
}

template <Side which, int channels, int... place>
constexpr SideKernels<channels> all_kernels(std::integer_sequence<int, place...>) {
    return {{kernel<which, static_cast<PhaseForm>(place / order_forms),
                    static_cast<Orders>(place % order_forms), channels>()...}};
}
template <Side which, int channels>
constexpr SideKernels<channels> all_kernels() {
    return all_kernels<which, channels>(
        std::make_integer_sequence<int, phase_forms * order_forms>());
}

template <Side which>
void paths_of_angles(const float* mu_in, const float* mu_out, const float* azimuth,
                     LightPaths& paths) {
    for (int i = 0; i < paths_at_once; i += lane_width)
        store(light_path<which>(load<Lookups>(mu_in + i), load<Lookups>(mu_out + i),
                                load<Lookups>(azimuth + i)),
              paths, i);
}

void paths_of_vectors(const float* const wi[3], const float* const wo[3], LightPaths& paths) {
    for (int i = 0; i < paths_at_once; i += lane_width)
        store(light_path(load<Lookups>(wi[0] + i), load<Lookups>(wi[1] + i),
                         load<Lookups>(wi[2] + i), load<Lookups>(wo[0] + i),
                         load<Lookups>(wo[1] + i), load<Lookups>(wo[2] + i)),
              paths, i);
}

}  // namespace

extern const TexturedKernels textured_kernels;
extern const Kernels kernels;
constexpr Kernels kernels{all_kernels<Side::reflection, 1>(),
                          all_kernels<Side::transmission, 1>(),
                          all_kernels<Side::reflection, 3>(),
                          all_kernels<Side::transmission, 3>(),
                          {paths_of_angles<Side::reflection>, paths_of_angles<Side::transmission>},
                          paths_of_vectors,
                          &textured_kernels};

}  // namespace stratus::STRATUS_ISA
