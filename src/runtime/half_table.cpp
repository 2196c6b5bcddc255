#include <stratus/runtime/half_table.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace stratus {
namespace {

/// The samples of one (albedo, optical_depth), over both cosines and azimuth.
struct Block {
    const float* samples;
    const float* in_weight;
    const float* out_weight;
    std::size_t ins, outs, azimuths;

    /// Calls `use` with each sample's place and what a lookup interpolates there, but for the
    /// weight of the whole block.
    template <class Use>
    void each(const Use& use) const {
        for (std::size_t i = 0; i < ins; ++i)
            for (std::size_t j = 0; j < outs; ++j)
                for (std::size_t k = 0; k < azimuths; ++k) {
                    const std::size_t at = (i * outs + j) * azimuths + k;
                    use(at, double{samples[at]} * double{in_weight[i]} * double{out_weight[j]});
                }
    }
};

/// Writes a block's halves, and makes its weight that of these.
void halve(const Block& block, float& weight, Half* into) {
    double largest = 0;
    block.each([&](std::size_t, double value) { largest = std::max(largest, std::abs(value)); });
    int exponent = 0;
    std::frexp(largest * double{weight}, &exponent);
    constexpr int largest_exponent = 15, min_exponent = -100;  // of halves; where float has bits
    const int scale = largest_exponent - std::max(exponent, min_exponent);
    const double factor = std::ldexp(double{weight}, scale);
    block.each([&](std::size_t at, double value) {
        const auto scaled = static_cast<float>(value * factor);
        // Subnormal numbers are slow, and to some programs' settings zero: zero to all.
        into[at] = to_half(std::abs(scaled) < min_normal_half ? 0 : scaled);
    });
    if (weight != 0) weight = static_cast<float>(std::ldexp(1.0, -scale));
}

std::vector<Half> halves_of(const Table& table, const std::vector<float>& samples,
                            std::vector<float>& weight) {
    Block block{nullptr,
                nullptr,
                nullptr,
                table.mu_in.values.size(),
                table.mu_out.values.size(),
                table.azimuth.values.size()};
    const std::size_t depths = table.optical_depth.values.size();
    const std::size_t size = block.ins * block.outs * block.azimuths;
    std::vector<Half> halves(samples.size());
    for (std::size_t at = 0; at < samples.size() / size; ++at) {
        block.samples = samples.data() + at * size;
        block.in_weight = table.mu_in_weight.data() + at % depths * block.ins;
        block.out_weight = table.mu_out_weight.data() + at % depths * block.outs;
        halve(block, weight[at], halves.data() + at * size);
    }
    return halves;
}

}  // namespace

TableView HalfTable::view() const noexcept {
    TableView view = table.view();
    if (!reflection_multiple.empty()) view.reflection_multiple.halves = reflection_multiple.data();
    if (!transmission_multiple.empty())
        view.transmission_multiple.halves = transmission_multiple.data();
    return view;
}

HalfTable halved(Table table) {
    HalfTable half;
    const auto take = [&](std::vector<float>& samples, std::vector<float>& weight) {
        const std::vector<float> floats = std::move(samples);
        samples.clear();
        return halves_of(table, floats, weight);
    };
    half.reflection_multiple = take(table.reflection_multiple, table.reflection_weight);
    half.transmission_multiple = take(table.transmission_multiple, table.transmission_weight);
    for (std::vector<float>* weight : {&table.mu_in_weight, &table.mu_out_weight})
        std::fill(weight->begin(), weight->end(), 1.0f);
    half.table = std::move(table);
    return half;
}

}  // namespace stratus
