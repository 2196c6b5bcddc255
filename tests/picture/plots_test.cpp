// Everything is drawn: each mark is a path of the SVG and each letter a use of a glyph. Its looks
// are checked visually.
#include <stratus/base/constants.h>
#include <stratus/picture/plots.h>

#include "refusal.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

/// Fontconfig never frees its cache, in any test of the program.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig"; }

namespace stratus::test {
namespace {

using Role = PlotSeries::Role;

class CostPlot : public ::testing::Test {
  protected:
    std::string drawn(const std::vector<PlotPanel>& panels) const {
        draw_cost_plot(panels, folder / "cost.svg");
        return content(folder / "cost.svg");
    }

    TemporaryFolder folder;
};

/// Points that a test adds between the first and the last leave the axes as they are.
PlotPanel panel() {
    PlotPanel one{"Panel", "time (s)", "error", {}};
    one.series.push_back({"first", Role::measured, {{1e-3, 0.5, ""}, {1e-2, 1e-4, ""}}});
    return one;
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++found;
    return found;
}

std::size_t letters(const std::string& svg) { return count(svg, "<use "); }

/// Without the outlines that define the letters.
std::size_t paths(const std::string& svg) {
    const std::size_t from = svg.find("<defs>"), to = svg.rfind("</defs>");
    return count(svg, "<path ") - count(svg.substr(from, to - from), "<path ");
}

TEST_F(CostPlot, IsSixteenCentimetresWide) {
    const std::string svg = drawn({panel(), panel()});
    const std::size_t at = svg.find("<svg ");
    ASSERT_NE(at, std::string::npos);
    const std::size_t width = svg.find("width=\"", at);
    ASSERT_NE(width, std::string::npos);
    EXPECT_NEAR(std::stod(svg.substr(width + 7)), 16 / 2.54 * 72, 0.01);  // points
    EXPECT_EQ(svg.substr(svg.find_first_not_of("0123456789.", width + 7), 3), "pt\"");
}

TEST_F(CostPlot, ShowsEveryTitleAndName) {
    const std::size_t before = letters(drawn({panel()}));
    for (std::string PlotPanel::*title :
         {&PlotPanel::title, &PlotPanel::x_title, &PlotPanel::y_title}) {
        PlotPanel longer = panel();
        longer.*title += "abcde";
        EXPECT_EQ(letters(drawn({longer})), before + 5);
    }
    PlotPanel renamed = panel();
    renamed.series[0].name += "abcde";
    EXPECT_EQ(letters(drawn({renamed})), before + 5);
}

TEST_F(CostPlot, LabelsEveryDecade) {
    PlotPanel wider = panel();  // 10^-3 .. 10^-2 becomes 10^-3 .. 10^0
    wider.series[0].points[1].x = 0.5;
    EXPECT_EQ(letters(drawn({wider})), letters(drawn({panel()})) + 4 + 3);  // 10-1, 100
}

TEST_F(CostPlot, DrawsEveryPointOfEverySeries) {
    const std::size_t before = paths(drawn({panel()}));
    PlotPanel more = panel();
    more.series[0].points.push_back({2e-3, 0.01, ""});
    EXPECT_EQ(paths(drawn({more})), before + 1);
    PlotPanel second = panel();
    const std::vector<PlotPoint> three{{2e-3, 0.01, ""}, {3e-3, 0.02, ""}, {4e-3, 0.01, ""}};
    for (int n = 0; n < 9; ++n)  // more than there are shapes
        second.series.push_back({"more", Role::measured, three});
    EXPECT_EQ(paths(drawn({second})), before + 9 * (3 + 1)) << "one mark each in the legend";
}

TEST_F(CostPlot, DrawsAFrontierAsOneLineOfSteps) {
    PlotPanel stepped = panel();
    stepped.series.push_back(
        {"frontier", Role::frontier, {{1e-3, 0.5, ""}, {2e-3, 0.1, ""}, {1e-2, 1e-4, ""}}});
    EXPECT_EQ(paths(drawn({stepped})), paths(drawn({panel()})) + 2) << "and one in the legend";
}

TEST_F(CostPlot, DrawsEveryLabel) {
    for (const Role role : {Role::measured, Role::frontier, Role::chosen}) {
        PlotPanel crowded = panel();
        crowded.series.push_back({"", role, {}});
        for (int n = 0; n < 30; ++n)
            crowded.series[1].points.push_back({2e-3 + 1e-5 * n, 0.01, ""});
        const std::size_t bare = paths(drawn({crowded}));
        crowded.series[1].points[0].label = "label";
        const std::size_t of_one = paths(drawn({crowded})) - bare;
        EXPECT_GT(of_one, 0u);
        for (PlotPoint& point : crowded.series[1].points) point.label = "label";
        EXPECT_EQ(paths(drawn({crowded})), bare + 30 * of_one);
    }
}

TEST_F(CostPlot, OmitsEmptySeriesFromTheLegend) {
    PlotPanel with_empty = panel();
    with_empty.series.push_back({"nothing", Role::measured, {}});
    EXPECT_EQ(letters(drawn({with_empty})), letters(drawn({panel()})));
}

TEST_F(CostPlot, DrawsASinglePoint) {
    PlotPanel single{"", "", "", {{"", Role::chosen, {{1, 1, ""}}}}};
    EXPECT_GT(paths(drawn({single})), 0u);
}

TEST_F(CostPlot, RefusesPanelsWithoutPoints) {
    expect_refusal([&] { drawn({}); }, "draw_cost_plot: panels must be at least one, got none");
    PlotPanel empty = panel();
    empty.series[0].points.clear();
    expect_refusal(
        [&] {
            drawn({panel(), empty});
        },
        "draw_cost_plot: panel 'Panel' must be one with points, got none");
    EXPECT_FALSE(std::filesystem::exists(folder / "cost.svg"));
}

TEST_F(CostPlot, RefusesValuesThatAreNotPositiveAndFinite) {
    for (double PlotPoint::*value : {&PlotPoint::x, &PlotPoint::y})
        for (const double bad : {0.0, -1.0, infinity, double{NAN}}) {
            PlotPanel wrong = panel();
            wrong.series[0].points[1].*value = bad;
            const char* const name = value == &PlotPoint::x ? "x of 'first'" : "y of 'first'";
            expect_refusal([&] { drawn({wrong}); },
                           {"draw_cost_plot", name, "above 0 and finite", "got "});
        }
    EXPECT_FALSE(std::filesystem::exists(folder / "cost.svg"));
}

TEST_F(CostPlot, RefusesAPathThatCannotBeWritten) {
    expect_refusal<std::runtime_error>(
        [&] { draw_cost_plot({panel()}, folder / "absent" / "cost.svg"); },
        "cost.svg: No such file");
}

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
