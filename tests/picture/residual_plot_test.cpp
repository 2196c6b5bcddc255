#include <stratus/picture/plots.h>

#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>

namespace stratus::test {
namespace {

std::size_t count_paths(const ResidualPlot& plot) {
    const TemporaryFolder folder;
    draw_residual_plot(plot, folder / "plot.svg");
    const std::string svg = content(folder / "plot.svg");
    std::size_t count = 0;
    for (std::size_t at = svg.find("<path"); at != svg.npos; at = svg.find("<path", at + 1))
        ++count;
    return count;
}

TEST(ResidualPlot, DrawsEveryPointTwiceAndItsModel) {
    ResidualPlot plot{"Fit", "phase angle", "I/F", {{"lit", {{10, 0.4, 0.02, 0.41}}}}};
    const std::size_t one = count_paths(plot);
    plot.series[0].points.push_back({10, 0.4, 0.02, 0.41});  // the axes stay as they are
    EXPECT_EQ(count_paths(plot), one + 5);                   // two bars, two circles, a cross
}

TEST(ResidualPlot, TakesValuesOfOneSizeAndOfEitherSign) {
    for (const double value : {0.0, -3e-4, 1e5})
        EXPECT_GT(count_paths({"Fit", "x", "y", {{"beam", {{0, value, 1e-6, value}}}}}), 10u);
}

}  // namespace
}  // namespace stratus::test
