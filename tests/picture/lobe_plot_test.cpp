#include <stratus/picture/plots.h>

#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

/// Two rows of one panel with lobes of one shape, of these radii.
LobePlot two_rows(double first, double second) {
    LobePlot plot{"Lobes", {"w = 1"}, {"thick", "thin"}, {{"once", {}}}};
    for (const double radius : {first, second})
        plot.blocks[0].rows.push_back({{0.6, {{{0, radius, 0}, {0, radius / 2, 0}}}}});
    return plot;
}

std::string svg_of(LobePlot plot, bool common_scale) {
    const TemporaryFolder folder;
    plot.common_scale = common_scale;
    draw_lobe_plot(plot, folder / "plot.svg");
    return content(folder / "plot.svg");
}

/// The outlines drawn; cairo numbers the rest of a file anew in each.
std::string paths_of(const std::string& svg) {
    std::string paths;
    for (std::size_t d = svg.find(" d=\""); d != svg.npos; d = svg.find(" d=\"", d + 1))
        paths += svg.substr(d, svg.find('"', d + 4) - d);
    return paths;
}

double width_of(const std::string& svg) {
    const std::string start = "<svg";
    const std::size_t width = svg.find("width=\"", svg.find(start)) + 7;
    return std::stod(svg.substr(width));
}

TEST(LobePlot, ShowsAThinLayerDimOnACommonScale) {
    const auto paths = [](double thin, bool common_scale) {
        return paths_of(svg_of(two_rows(2, thin), common_scale));
    };
    EXPECT_FALSE(paths(2, false).empty());
    EXPECT_EQ(paths(2, true), paths(2, false));
    EXPECT_NE(paths(1, true), paths(1, false));
    EXPECT_NE(paths(1, true), paths(2, true));
}

TEST(LobePlot, IsAsWideAsItsTitleAndItsNames) {
    LobePlot plot = two_rows(1, 1);
    const double narrow = width_of(svg_of(plot, false));
    plot.title = std::string(200, 'm');
    const double titled = width_of(svg_of(plot, false));
    EXPECT_GT(titled, 1000) << "200 letters of at least 5 points";
    plot.names = std::vector<std::string>(100, "w = 0.5");
    EXPECT_GT(width_of(svg_of(plot, false)), titled);
    EXPECT_LT(narrow, 300);
}

}  // namespace
}  // namespace stratus::test
