#include <stratus/base/size.h>

#include "slice_parts.h"
#include "table/lookup_arguments.h"

#include <algorithm>

namespace stratus {
namespace {

/// Blocks of `paths_at_once` lookups; the last may be shorter. use(first, count).
template <class Use>
void in_blocks(std::size_t count, const Use& use) noexcept {
    for (std::size_t first = 0; first < count; first += paths_at_once)
        use(first, std::min<std::size_t>(paths_at_once, count - first));
}

/// `count` numbers where a kernel reads as many as fill its registers: themselves, or a copy that
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
void look_up_angles(Side which, const BatchSide<channels>& side, std::size_t count,
                    const float* mu_in, const float* mu_out, const float* azimuth,
                    float* value) noexcept {
    for (std::size_t i = 0; i < count; ++i) check_angles(mu_in[i], mu_out[i], azimuth[i]);
    if (side.many == nullptr) {
        for (int c = 0; c < channels; ++c)
            for (std::size_t i = 0; i < count; ++i)
                *value++ = dark_at(mu_in[i], mu_out[i], azimuth[i]);
        return;
    }
    const Kernels& all = chosen_functions<Kernels>();
    in_blocks(count, [&](std::size_t first, std::size_t here) {
        Block in, out, around;
        LightPaths paths;
        alignas(64) float found[channels * path_room];
        const int some = static_cast<int>(here);
        all.paths_of_angles[which == Side::transmission](
            in.of(mu_in + first, here), out.of(mu_out + first, here),
            around.of(azimuth + first, here), some, paths);
        side.many(side.view, paths, some, found);
        for (int c = 0; c < channels; ++c)
            std::copy(found + c * path_room, found + c * path_room + here,
                      value + size(c) * count + first);
    });
}

template <int channels>
void look_up_vectors(const BatchSide<channels>& reflection, const BatchSide<channels>& transmission,
                     bool one_sided, std::size_t count, const float* const wi[3],
                     const float* const wo[3], float* value) noexcept {
    constexpr std::size_t room = channels * path_room;
    for (std::size_t i = 0; i < count; ++i)
        check_vectors({wi[0][i], wi[1][i], wi[2][i]}, {wo[0][i], wo[1][i], wo[2][i]});
    const Kernels& all = chosen_functions<Kernels>();
    in_blocks(count, [&](std::size_t first, std::size_t here) {
        Block blocks[6];
        const float *in[3], *out[3];
        for (int d = 0; d < 3; ++d) {
            in[d] = blocks[d].of(wi[d] + first, here);
            out[d] = blocks[d + 3].of(wo[d] + first, here);
        }
        PartedPaths paths;
        all.paths_of_vectors(in, out, static_cast<int>(here), one_sided, paths);
        alignas(64) float found[2][room];
        for (const int which : {0, 1}) {
            const BatchSide<channels>& side = which == 0 ? reflection : transmission;
            if (side.many == nullptr)
                std::fill(found[which], found[which] + room, 0.0f);
            else if (paths.count[which] > 0)
                side.many(side.view, paths.paths[which], paths.count[which], found[which]);
        }
        for (int c = 0; c < channels; ++c)
            all.joined(paths, found[0] + c * path_room, found[1] + c * path_room,
                       static_cast<int>(here), value + size(c) * count + first);
    });
}

template void look_up_angles(Side, const BatchSide<1>&, std::size_t, const float*, const float*,
                             const float*, float*) noexcept;
template void look_up_angles(Side, const BatchSide<3>&, std::size_t, const float*, const float*,
                             const float*, float*) noexcept;
template void look_up_vectors(const BatchSide<1>&, const BatchSide<1>&, bool, std::size_t,
                              const float* const[3], const float* const[3], float*) noexcept;
template void look_up_vectors(const BatchSide<3>&, const BatchSide<3>&, bool, std::size_t,
                              const float* const[3], const float* const[3], float*) noexcept;

}  // namespace stratus
