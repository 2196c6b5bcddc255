// A slice or a BSDF of one channel or of three, for callers who choose at run time.
#pragma once

#include <stratus/bsdf/bsdf.h>
#include <stratus/bsdf/slice.h>

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <variant>

namespace stratus {

template <int channels>
Medium<channels> make_medium(const double* optical_depth, const double* albedo) {
    Medium<channels> medium;
    std::copy_n(optical_depth, channels, medium.optical_depth);
    std::copy_n(albedo, channels, medium.albedo);
    return medium;
}

class AnySlice {
  public:
    template <int channels>
    explicit AnySlice(SliceOf<channels> slice) : own_(std::move(slice)) {}
    template <int channels>
    explicit AnySlice(BsdfOf<channels> bsdf) : own_(std::move(bsdf)) {}

    /// Returns make(channels), whose argument is a constant: a slice of so many.
    ///
    /// Range    channels 1 or 3.
    template <class Make>
    static AnySlice with_channels(std::size_t channels, const Make& make) {
        return channels == 1 ? AnySlice(make(std::integral_constant<int, 1>()))
                             : AnySlice(make(std::integral_constant<int, 3>()));
    }

    int channels() const { return own_.index() % 2 == 0 ? 1 : 3; }

    /// use(slice), of a BSDF its own.
    template <class Use>
    auto with_slice(const Use& use) const {
        return std::visit([&](const auto& own) { return use(as_slice(own)); }, own_);
    }

    /// use(bsdf).
    ///
    /// Range    of a BSDF.
    template <class Use>
    auto with_bsdf(const Use& use) const {
        const auto* const one = std::get_if<Bsdf>(&own_);
        return one != nullptr ? use(*one) : use(std::get<RgbBsdf>(own_));
    }

    /// Returns the BSDF of a slice, which is moved into it.
    ///
    /// Errors   those of BsdfOf.
    AnySlice to_bsdf() && {
        auto* const one = std::get_if<Slice>(&own_);
        return one != nullptr ? AnySlice(Bsdf(std::move(*one)))
                              : AnySlice(RgbBsdf(std::get<RgbSlice>(std::move(own_))));
    }

  private:
    template <int channels>
    static const SliceOf<channels>& as_slice(const SliceOf<channels>& slice) {
        return slice;
    }
    template <int channels>
    static const SliceOf<channels>& as_slice(const BsdfOf<channels>& bsdf) {
        return bsdf.slice();
    }

    std::variant<Slice, RgbSlice, Bsdf, RgbBsdf> own_;  // those of one channel at even places
};

}  // namespace stratus
