#include "sphere_sums.h"

namespace stratus {
namespace STRATUS_ISA {
extern const SphereSums sphere_sums;
}

namespace {

#if defined(__AVX__)
constexpr int width = 4;
#else
constexpr int width = 2;
#endif
constexpr int angles_at_once = 2;  // as many as sums fit into the registers

/// One number for each sphere, of as many as a register holds.
using Lanes = double __attribute__((vector_size(width * sizeof(double))));

inline Lanes load(const double* from) {
    Lanes lanes;
    __builtin_memcpy(&lanes, from, sizeof lanes);
    return lanes;
}

inline void store(Lanes lanes, double* to) { __builtin_memcpy(to, &lanes, sizeof lanes); }

/// Of the spheres from `first` on.
template <int at_once>
inline void sum(int first, const SphereTerm* terms, std::size_t count, const AngleTerm* angle,
                std::size_t stride, SphereAmplitudes* S) {
    Lanes sum_re[at_once] = {}, sum_im[at_once] = {};
    Lanes difference_re[at_once] = {}, difference_im[at_once] = {};
    for (std::size_t n = 0; n < count; ++n) {
        const Lanes plus_re = load(terms[n].sum_re + first),
                    plus_im = load(terms[n].sum_im + first);
        const Lanes minus_re = load(terms[n].difference_re + first);
        const Lanes minus_im = load(terms[n].difference_im + first);
        for (int j = 0; j < at_once; ++j) {
            const AngleTerm at = angle[static_cast<std::size_t>(j) * stride + n];
            sum_re[j] += plus_re * at.sum;
            sum_im[j] += plus_im * at.sum;
            difference_re[j] += minus_re * at.difference;
            difference_im[j] += minus_im * at.difference;
        }
    }
    for (int j = 0; j < at_once; ++j) {
        store(sum_re[j], S[j].sum_re + first);
        store(sum_im[j], S[j].sum_im + first);
        store(difference_re[j], S[j].difference_re + first);
        store(difference_im[j], S[j].difference_im + first);
    }
}

void amplitudes(const SphereTerm* terms, std::size_t count, const AngleTerm* angle,
                std::size_t stride, std::size_t angles, SphereAmplitudes* S) {
    for (int first = 0; first < spheres_at_once; first += width) {
        std::size_t j = 0;
        for (; j + angles_at_once <= angles; j += angles_at_once)
            sum<angles_at_once>(first, terms, count, angle + j * stride, stride, S + j);
        for (; j < angles; ++j) sum<1>(first, terms, count, angle + j * stride, stride, S + j);
    }
}

}  // namespace

namespace STRATUS_ISA {
const SphereSums sphere_sums{amplitudes};
}

}  // namespace stratus
