// BSDFs: slices that draw directions, too.
#include "handles.h"

#include <memory>
#include <utility>

using namespace stratus::c;

int stratus_bsdf_build(stratus_slice** slice, stratus_bsdf** bsdf) {
    const char* const function = __func__;
    return run_guarded([&] {
        require_given(bsdf, function, "bsdf");
        *bsdf = nullptr;
        require_given(slice, function, "slice");
        require_given(*slice, function, "*slice");
        const std::unique_ptr<stratus_slice> given(std::exchange(*slice, nullptr));
        auto built = std::make_unique<stratus_bsdf>();
        if (given->one != nullptr)
            built->slice.one =
                &built->own.emplace<stratus::Bsdf>(std::get<stratus::Slice>(std::move(given->own)))
                     .slice();
        else
            built->slice.three =
                &built->own
                     .emplace<stratus::RgbBsdf>(std::get<stratus::RgbSlice>(std::move(given->own)))
                     .slice();
        *bsdf = built.release();
    });
}

void stratus_bsdf_free(stratus_bsdf* bsdf) { delete bsdf; }

const stratus_slice* stratus_bsdf_slice(const stratus_bsdf* bsdf) {
    return bsdf == nullptr ? nullptr : &bsdf->slice;
}

size_t stratus_bsdf_bytes(const stratus_bsdf* bsdf) {
    if (bsdf == nullptr) return 0;
    return with(*bsdf, [](const auto& of) { return of.bytes(); });
}

int stratus_bsdf_sample(const stratus_bsdf* bsdf, const float wi[3], const float random[3],
                        float wo[3], float* value, float* pdf) {
    const char* const function = __func__;
    return run_guarded([&] {
        require_given(bsdf, function, "bsdf");
        require_given(wi, function, "wi");
        require_given(random, function, "random");
        require_given(wo, function, "wo");
        require_given(value, function, "value");
        require_given(pdf, function, "pdf");
        with(*bsdf, [&](const auto& of) {
            const auto drawn = of.sample({wi[0], wi[1], wi[2]}, random[0], random[1], random[2]);
            wo[0] = drawn.wo.x;
            wo[1] = drawn.wo.y;
            wo[2] = drawn.wo.z;
            write(drawn.value, value);
            *pdf = drawn.pdf;
        });
    });
}

int stratus_bsdf_pdf(const stratus_bsdf* bsdf, const float wi[3], const float wo[3], float* pdf) {
    const char* const function = __func__;
    return run_guarded([&] {
        require_given(bsdf, function, "bsdf");
        require_given(wi, function, "wi");
        require_given(wo, function, "wo");
        require_given(pdf, function, "pdf");
        *pdf = with(*bsdf, [&](const auto& of) {
            return of.pdf({wi[0], wi[1], wi[2]}, {wo[0], wo[1], wo[2]});
        });
    });
}

int stratus_bsdf_albedo(const stratus_bsdf* bsdf, const float wi[3], float* reflected,
                        float* transmitted) {
    const char* const function = __func__;
    return run_guarded([&] {
        require_given(bsdf, function, "bsdf");
        require_given(wi, function, "wi");
        require_given(reflected, function, "reflected");
        require_given(transmitted, function, "transmitted");
        with(*bsdf, [&](const auto& of) {
            const auto shares = of.albedo(stratus::Vector{wi[0], wi[1], wi[2]});
            write(shares.reflected, reflected);
            write(shares.transmitted, transmitted);
        });
    });
}
