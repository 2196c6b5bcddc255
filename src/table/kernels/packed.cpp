#include <stratus/table/kernels/packed.h>

#include "packed_plan.h"

#include <utility>

namespace stratus::STRATUS_ISA {
namespace {

// ---- sums of functions

// In registers of `lanes` numbers. One lookup takes the widest that all of a processor's vector units
// work on, many those of all lanes.

template <int lanes>
using Word = typename SimdRegister<lanes>::Floats;

constexpr int word_width = lane_width < 8 ? lane_width : 8;

template <int lanes>
STRATUS_INLINE Word<lanes> load_word(const float* row, int word) {
    Word<lanes> values;
    __builtin_memcpy(&values, row + word * lanes, sizeof values);
    return values;
}

/// Halves: the values are these times `half_scale`. Where the processor takes subnormal floats for 0, those
/// of `half_scale` 2^112 lack subnormal halves, 2^-29 of the largest function.
template <int lanes>
STRATUS_INLINE Word<lanes> load_word(const Half* row, int word) {
    const Half* const from = row + word * lanes;
#if defined(__AVX512F__)
    if constexpr (lanes == 16)
        return _mm512_maskz_cvtph_ps(0xffff,
                                     _mm256_load_si256(reinterpret_cast<const __m256i*>(from)));
    else
#endif
    {
#if defined(__F16C__)
        return _mm256_cvtph_ps(_mm_load_si128(reinterpret_cast<const __m128i*>(from)));
#else
        using Bits = typename SimdRegister<lanes>::Ints;
        std::int16_t halves __attribute__((vector_size(2 * lanes)));
        __builtin_memcpy(&halves, from, sizeof halves);
        // Sign extension copies the sign to four bits; the mask keeps the one that is a float's.
        const Bits shifted = (__builtin_convertvector(halves, Bits) << half_shift) & ~0x70000000;
        return reinterpret_cast<Word<lanes> >(shifted);
#endif
    }
}
#if defined(__F16C__)
constexpr float half_scale = 1;
#else
constexpr float half_scale = 0x1p112f;  // the difference of the exponents' biases
#endif

template <int width>
STRATUS_INLINE float reduce_sum(Word<width> lanes) {
    if constexpr (width == 4) {
        return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    } else {
        Word<width / 2> half[2];
        __builtin_memcpy(half, &lanes, sizeof lanes);
        return reduce_sum<width / 2>(half[0] + half[1]);
    }
}

/// Registers of a row that are summed together: as many as there is room for.
template <int lanes>
constexpr int words_at_once = lanes < fewest_functions ? 2 : 1;

template <int lanes>
struct Words {
    Word<lanes> word[words_at_once<lanes>];
};

/// Four sums side by side, so that none waits for another.
template <int lanes>
class Sums {
  public:
    template <class Number>
    STRATUS_INLINE void add(int which, float weight, const Number* row) {
        for (int w = 0; w < words_at_once<lanes>; ++w)
            sum_[which].word[w] += weight * load_word<lanes>(row, w);
    }
    STRATUS_INLINE void scale(int which, float weight) {
        for (Word<lanes>& word : sum_[which].word) word *= weight;
    }
    STRATUS_INLINE Words<lanes> total() const {
        Words<lanes> total;
        for (int w = 0; w < words_at_once<lanes>; ++w)
            total.word[w] =
                (sum_[0].word[w] + sum_[1].word[w]) + (sum_[2].word[w] + sum_[3].word[w]);
        return total;
    }

  private:
    Words<lanes> sum_[stencil_size] = {};
};

/// Returns use(functions, number, unit): how many functions a row of a side has and what they are stored as,
/// both as types, for loops that the compiler unrolls; and what to multiply their sums by.
template <class Use>
STRATUS_INLINE auto with_rows(const PackedSide& side, const Use& use) {
    const auto with_numbers = [&](auto functions) {
        return side.halves ? use(functions, Half{}, half_scale) : use(functions, 0.0f, 1.0f);
    };
    return side.functions == fewest_functions
               ? with_numbers(std::integral_constant<int, fewest_functions>())
               : with_numbers(std::integral_constant<int, most_functions>());
}

/// The coefficients of lookup n of a plan, from the `first` on.
template <int functions, int lanes, int width>
STRATUS_INLINE Words<lanes> blend_coefficients(const Plan<width>& plan, int n, int first) {
    Sums<lanes> sums;
    const float* row = plan.coefficient[n] + first;
    for (int l = 0; l < stencil_size; ++l) {
        for (int t = 0; t < stencil_size; ++t)
            sums.add(t, plan.layer_weight[stencil_size * l + t][n], row + t * functions);
        row += plan.coefficient_stride[n];
    }
    return sums.total();
}

/// The functions at the directions of lookup n of a plan, from the `first` on.
template <int functions, int lanes, class Number, bool azimuthal, int width>
STRATUS_INLINE Words<lanes> blend_functions(const PackedSide& side, const Plan<width>& plan, int n,
                                            int first) {
    Sums<lanes> sums;
    const std::ptrdiff_t column = std::ptrdiff_t{side.column_step} * functions;
    const auto* row = reinterpret_cast<const Number*>(plan.function[n]) + first;
    // Each row of symmetric R and T is one (mu, mu') longer than the one before.
    const std::ptrdiff_t longer = side.symmetric ? values_per_pair<azimuthal>(side) * functions : 0;
    std::ptrdiff_t next = std::ptrdiff_t{plan.next_mu[n]} * functions;
    for (int r = 0; r < stencil_size; ++r) {
        const Number* at = row;
        for (int c = 0; c < stencil_size; ++c) {
            const float weight = plan.cosine_weight[stencil_size * r + c][n];
            if constexpr (azimuthal)
                for (int a = 0; a < stencil_size; ++a) sums.add(a, weight, at + a * functions);
            else
                sums.add(c, weight, at);
            at += column;
        }
        row += next;
        next += longer;
    }
    if constexpr (azimuthal)
        for (int a = 0; a < stencil_size; ++a) sums.scale(a, plan.azimuth_weight[a][n]);
    return sums.total();
}

/// Orders n >= 2 of lookup n of a plan, but for the factor.
template <int functions, int lanes, class Number, bool azimuthal, int width>
STRATUS_INLINE float contracted_rows(const PackedSide& side, const Plan<width>& plan, int n) {
    Word<lanes> sum{};
    for (int first = 0; first < functions; first += lanes * words_at_once<lanes>) {
        const Words<lanes> coefficient = blend_coefficients<functions, lanes>(plan, n, first),
                           function = blend_functions<functions, lanes, Number, azimuthal>(
                               side, plan, n, first);
        for (int w = 0; w < words_at_once<lanes>; ++w)
            sum += coefficient.word[w] * function.word[w];
    }
    return reduce_sum<lanes>(sum);
}

template <int lanes, bool azimuthal, int width>
STRATUS_INLINE float contracted(const PackedSide& side, const Plan<width>& plan, int n) {
    return plan.factor[n] * with_rows(side, [&](auto functions, auto number, float unit) {
               return unit *
                      contracted_rows<functions, lanes, decltype(number), azimuthal>(side, plan, n);
           });
}

/// All words of a row times a factor: of(first) gives those from the `first` number on.
template <int functions, int lanes, class Of>
STRATUS_INLINE void store_row(float factor, const Of& of, float* row) {
    for (int first = 0; first < functions; first += lanes * words_at_once<lanes>) {
        Words<lanes> words = of(first);
        for (Word<lanes>& word : words.word) word *= factor;
        __builtin_memcpy(row + first, words.word, sizeof words.word);
    }
}

template <Side which, PhaseForm form, bool azimuthal>
void evaluate_one(const PackedSide& side, const PackedPoint& at, float* single_multiple) {
    Plan<1> plan;
    prepare<which, form, azimuthal>(side, at, 0, plan);
    single_multiple[0] = plan.single[0];
    single_multiple[1] = contracted<word_width, azimuthal>(side, plan, 0) + plan.along_path[0];
}

template <Side which, PhaseForm form, bool azimuthal>
void prepare_many(const PackedSide& side, const PackedPoints& at, std::size_t first,
                  Plan<points_at_once>& plan) {
    for (int n = 0; n < points_at_once; n += lane_width) {
        const std::size_t from = first + static_cast<std::size_t>(n);
        const auto albedo = at_least(0, at_most(1, load<LookupLanes>(at.albedo + from)));
        prepare<which, form, azimuthal>(
            side,
            PackedPointOf<LookupLanes>{
                albedo, 1.0f - albedo, load<LookupLanes>(at.optical_depth + from),
                load<LookupLanes>(at.mu_in + from), load<LookupLanes>(at.mu_out + from),
                load<LookupLanes>(at.azimuth + from)},
            n, plan);
    }
}

template <Side which, PhaseForm form, bool azimuthal>
void evaluate_many(const PackedSide& side, const PackedPoints& at, std::size_t count,
                   float* total) {
    Plan<points_at_once> plan;
    for (std::size_t first = 0; first < count; first += std::size_t{points_at_once}) {
        prepare_many<which, form, azimuthal>(side, at, first, plan);
        for (int n = 0; n < points_at_once; ++n)
            total[first + static_cast<std::size_t>(n)] =
                plan.single[n] +
                (contracted<lane_width, azimuthal>(side, plan, n) + plan.along_path[n]);
    }
}

template <Side which, PhaseForm form, bool azimuthal, int functions, class Number>
STRATUS_INLINE void evaluate_layers(const PackedSide& side, float unit, const PackedPoint (&at)[3],
                                    float (&multiple)[3]) {
    const LightPath path = light_path<which>(at[0].mu_in, at[0].mu_out, at[0].azimuth);
    const DirectionWindow<float> directions =
        direction_window<azimuthal>(side, path, at[0].azimuth);
    float function[functions] = {};
    const char* summed = nullptr;
    for (int k = 0; k < 3; ++k) {
        if (k > 0 && at[k].albedo == at[k - 1].albedo &&
            at[k].optical_depth == at[k - 1].optical_depth) {
            multiple[k] = multiple[k - 1];
            continue;
        }
        Plan<1> plan;
        prepare<which, form, azimuthal>(side, at[k], path, directions, 0, plan);
        if (plan.function[0] != summed)  // else of the same block
            store_row<functions, word_width>(
                unit,
                [&](int first) {
                    return blend_functions<functions, word_width, Number, azimuthal>(side, plan, 0,
                                                                                     first);
                },
                function);
        summed = plan.function[0];
        float coefficient[functions];
        store_row<functions, word_width>(
            1, [&](int first) { return blend_coefficients<functions, word_width>(plan, 0, first); },
            coefficient);
        Word<word_width> sum{};
        for (int word = 0; word < functions / word_width; ++word)
            sum += load_word<word_width>(coefficient, word) * load_word<word_width>(function, word);
        multiple[k] = plan.factor[0] * reduce_sum<word_width>(sum) + plan.along_path[0];
    }
}

template <Side which, PhaseForm form, bool azimuthal>
void evaluate_layers(const PackedSide& side, const PackedPoint (&at)[3], float (&multiple)[3]) {
    with_rows(side, [&](auto functions, auto number, float unit) {
        evaluate_layers<which, form, azimuthal, functions, decltype(number)>(side, unit, at,
                                                                             multiple);
    });
}

template <Side which, PhaseForm form, bool azimuthal>
void evaluate_rows(const PackedSide& side, const PackedPoint& at, std::size_t rows,
                   float* multiple) {
    Plan<1> plan;
    prepare<which, form, azimuthal>(side, at, 0, plan);
    float factor = plan.factor[0];
    if (side.divided) factor = factor / shares_at(at.optical_depth, at.mu_in, at.mu_out);
    const auto cell = layer_window(side, at.co_albedo, at.optical_depth).cell;
    const LayerBlock& block = side.block[truncated(side.block_of_cell[cell])];
    with_rows(side, [&](auto functions, auto number, float unit) {
        float coefficient[functions];
        store_row<functions, word_width>(
            factor * unit,
            [&](int first) { return blend_coefficients<functions, word_width>(plan, 0, first); },
            coefficient);
        const auto* row = static_cast<const decltype(number)*>(block.function);
        for (std::size_t n = 0; n < rows; ++n, row += functions) {
            Word<lane_width> sum{};
            for (int word = 0; word < functions / lane_width; ++word)
                sum += load_word<lane_width>(coefficient, word) * load_word<lane_width>(row, word);
            multiple[n] = reduce_sum<lane_width>(sum);
        }
    });
}

template <Side which, PhaseForm form, bool azimuthal>
constexpr PackedKernel kernel() {
    if constexpr (form != packed_form(form) || form == PhaseForm::none ||
                  form == PhaseForm::of_stack || form == PhaseForm::with_opposition_and_boundary ||
                  (form == PhaseForm::with_boundary && which == Side::transmission))
        return {};
    else if constexpr (form == PhaseForm::polynomial)  // which phase function does not matter
        return {evaluate_one<which, form, azimuthal>, evaluate_many<which, form, azimuthal>,
                evaluate_layers<which, form, azimuthal>, evaluate_rows<which, form, azimuthal>};
    else
        return {evaluate_one<which, form, azimuthal>, evaluate_many<which, form, azimuthal>,
                nullptr, nullptr};
}

template <Side which, int... place>
constexpr PackedSideKernels all_kernels(std::integer_sequence<int, place...>) {
    return {{kernel<which, static_cast<PhaseForm>(place / 2), place % 2 == 1>()...}};
}
template <Side which>
constexpr PackedSideKernels all_kernels() {
    return all_kernels<which>(std::make_integer_sequence<int, 2 * phase_forms>());
}

}  // namespace
}  // namespace stratus::STRATUS_ISA

namespace stratus {

template <>
const PackedKernels& functions_for<PackedKernels, InstructionSet::STRATUS_ISA>() noexcept {
    using namespace STRATUS_ISA;
    static constexpr PackedKernels packed_kernels{all_kernels<Side::reflection>(),
                                                  all_kernels<Side::transmission>()};
    return packed_kernels;
}

}  // namespace stratus
