// Packing looks at most layers in a few directions only: what it finds must hold in all of them.
#include <stratus/table/packed_table.h>

#include <stratus/table/layer_samples.h>

#include "small_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace stratus {
namespace {

constexpr Counts sums_counts{15, 24, 20, 20, 13};
constexpr Depths sums_depths{0.05, 8, false};

double smooth(const SamplePoint& p) {
    return 2 + 0.5 * std::sin(2 * p.albedo + std::log(p.optical_depth)) * std::cos(p.azimuth);
}

/// R and T of a shape that both sides share.
Table table_of(const FunctionOfPoint& shape) {
    Table table = empty_table(sums_counts, sums_depths);
    table.tolerance = small_table_tolerance;
    fill(table, shape);
    return table;
}

/// The largest error of R at any sample of a packed table, relative to R but to not less than 1 % of
/// the largest of its layer.
double largest_error(const Table& table) {
    const Table unpacked = PackedTable(pack(table)).unpacked();
    const std::size_t block =
        table.mu_in.values.size() * table.mu_out.values.size() * table.azimuth.values.size();
    double worst = 0;
    for (std::size_t first = 0; first < table.sample_count(); first += block) {
        const auto begin = table.reflection_multiple.begin() + static_cast<std::ptrdiff_t>(first);
        const double largest =
            double{*std::max_element(begin, begin + static_cast<std::ptrdiff_t>(block))};
        for (std::size_t n = first; n < first + block; ++n) {
            const double expected = double{table.reflection_multiple[n]};
            worst = std::max(worst, std::abs(double{unpacked.reflection_multiple[n]} - expected) /
                                        std::max(expected, 0.01 * largest));
        }
    }
    return worst;
}

TEST(LayerSums, HoldAPeakOfFewDirections) {
    // Two samples of azimuth at four cosines: 32 of 2730 directions, whose light varies of its own.
    const Table table = table_of([](const SamplePoint& p) {
        const bool is_in_peak = p.azimuth < 0.3 && std::abs(p.mu_in - p.mu_out) < 1e-6 &&
                                p.mu_in > 0.3 && p.mu_in < 0.6;
        return smooth(p) * (is_in_peak ? 3 + std::sin(5 * std::log(p.optical_depth)) : 1);
    });
    EXPECT_LT(largest_error(table), 0.5 * small_table_tolerance);
}

TEST(LayerSums, HoldALayerUnlikeAllOthers) {
    const Table usual = table_of(smooth);
    const double albedo = usual.albedo.values[3], depth = usual.optical_depth.values[6];
    const Table table = table_of([&](const SamplePoint& p) {
        const bool is_unlike = p.albedo == albedo && p.optical_depth == depth;
        return smooth(p) * (is_unlike ? 1.5 + 0.4 * std::cos(4 * (p.mu_in + p.mu_out)) : 1);
    });
    EXPECT_LT(largest_error(table), 0.5 * small_table_tolerance);
}

/// Counts what packing asks for.
class CountedSamples : public LayerSamples {
  public:
    explicit CountedSamples(const Table& table) : table_(table), numbers_(table.view()) {}

    std::set<int> in_full_layers;
    std::size_t directions = 0;

    int in_full(std::vector<int> layers, const Use& use) override {
        DirectionList all;
        for (std::size_t n = 0; n < numbers_.count(); ++n) all.push_back(n);
        for (const int layer : layers) hand_over(layer, {all, all}, use);
        in_full_layers.insert(layers.begin(), layers.end());
        return static_cast<int>(layers.size());
    }

    void at(const PerSide<DirectionList>& at, const Use& use) override {
        if (at.reflection.empty()) return;
        directions = at.reflection.size();
        for (int layer = 0; layer < sums_counts.albedo * sums_counts.optical_depth; ++layer)
            hand_over(layer, at, use);
    }

  private:
    void hand_over(int layer, const PerSide<DirectionList>& at, const Use& use) const {
        const std::size_t cosines = table_.mu_in.values.size(),
                          azimuths = table_.azimuth.values.size();
        std::vector<float> samples;
        for (const std::size_t direction : at.reflection) {
            std::size_t in = 0;  // pairs before that of (in, 0): in (in + 1) / 2
            while ((in + 1) * (in + 2) / 2 <= direction / azimuths) ++in;
            const std::size_t out = direction / azimuths - in * (in + 1) / 2;
            samples.push_back(
                table_.reflection_multiple
                    [((static_cast<std::size_t>(layer) * cosines + in) * cosines + out) * azimuths +
                     direction % azimuths]);
        }
        use(layer, Side::reflection, std::move(samples));
    }

    const Table& table_;
    DirectionNumbers numbers_;
};

TEST(LayerSums, AskForMostLayersInFewDirections) {
    Table table = table_of(smooth);
    table.transmission_multiple.clear();
    CountedSamples samples(table);
    EXPECT_EQ(pack(table, samples), pack(table));
    EXPECT_LE(samples.in_full_layers.size(), 100u);  // of 360
    EXPECT_LT(samples.directions, DirectionNumbers(table.view()).count() / 4);
}

}  // namespace
}  // namespace stratus
