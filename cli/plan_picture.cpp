#include "plan_picture.h"

#include <stratus/base/number_text.h>
#include <stratus/io/atomic_file.h>
#include <stratus/picture/png.h>

#include "scene_options.h"
#include "signals_held.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace stratus {
namespace {

constexpr double least_change = 1e-4;  // where the scale begins; it ends at 1
constexpr int panels_a_row = 4, panel_width = 256, title_height = 24, scale_height = 74;

/// From black over purple, red and orange to pale yellow, ever brighter.
std::array<float, 3> false_colour(double change) {
    constexpr std::array<std::array<double, 3>, 5> stops{{{0, 0, 0.02},
                                                          {0.34, 0.06, 0.43},
                                                          {0.73, 0.21, 0.33},
                                                          {0.98, 0.56, 0.04},
                                                          {0.99, 1, 0.64}}};
    const double place =
        std::clamp(1 - std::log10(std::max(change, least_change)) / std::log10(least_change), 0.0,
                   1.0) *
        (stops.size() - 1);
    const std::size_t first = std::min(stops.size() - 2, static_cast<std::size_t>(place));
    const double share = place - static_cast<double>(first);
    std::array<float, 3> colour;
    for (std::size_t c = 0; c < 3; ++c)
        colour[c] = static_cast<float>(
            srgb_decoded((1 - share) * stops[first][c] + share * stops[first + 1][c]));
    return colour;
}

/// A picture under construction, with the labels of its panels.
struct Page {
    Image image;
    std::vector<Label> labels;

    /// Fills a rectangle: colour_at(x, y), in pixels from its upper left corner.
    template <class ColourAt>
    void fill(int left, int top, int width, int height, const ColourAt& colour_at) {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                std::ranges::copy(colour_at(x, y), image.pixel(left + x, top + y));
    }
};

int panel_height(const Image& picture) {
    return std::max(1, picture.height * panel_width / picture.width);
}

std::vector<const EffectShare*> shown_effects(const PlanReport& report) {
    std::vector<const EffectShare*> shown;
    for (const EffectShare& share : report.shares)
        if (!share.changes.empty() && std::ranges::max(share.changes) > 0) shown.push_back(&share);
    return shown;
}

/// Draws the scene's picture and its effects from a row on.
void draw_scene(const PlanReport& report, const std::string& title, double white, int top,
                Page& page) {
    const Image& picture = report.picture;
    const int height = panel_height(picture);
    const std::vector<const EffectShare*> shown = shown_effects(report);
    for (int k = 0; k <= static_cast<int>(shown.size()); ++k) {
        const EffectShare* const share = k == 0 ? nullptr : shown[static_cast<std::size_t>(k) - 1];
        const int left = k % panels_a_row * panel_width,
                  above = top + k / panels_a_row * (height + title_height);
        page.labels.push_back(
            {left + 6.0, above + title_height - 7.0, panel_width - 12.0,
             share ? share->name + ", " + short_number(share->max, 2) + " at most" : title});
        page.fill(left, above + title_height, panel_width, height, [&](int x, int y) {
            const int across = x * picture.width / panel_width,
                      down = std::min(picture.height - 1, y * picture.height / height);
            const float* const pixel = picture.pixel(across, down);
            if (share)
                return false_colour(double{
                    share->changes[static_cast<std::size_t>(down * picture.width + across)]});
            const auto scale = static_cast<float>(1 / white);
            return std::array<float, 3>{scale * pixel[0], scale * pixel[1], scale * pixel[2]};
        });
    }
}

void draw_scale(int top, Page& page) {
    const int width = panels_a_row * panel_width - 2 * 60;
    page.fill(60, top + 4, width, 16, [&](int x, int) {
        return false_colour(std::pow(least_change, 1 - static_cast<double>(x) / (width - 1)));
    });
    for (int k = 0; k <= 4; ++k)
        page.labels.push_back({50.0 + width * k / 4.0, top + 38.0, 100,
                               short_number(least_change * std::pow(10, k))});
    page.labels.push_back({50, top + 62.0, static_cast<double>(width),
                           "relative change of each pixel's light without the effect"});
}

}  // namespace

void write_change_picture(const SceneFile& file, const std::vector<PlanReport>& reports,
                          const std::string& path) {
    std::vector<int> tops{0};
    for (const PlanReport& report : reports) {
        const int panels = 1 + static_cast<int>(shown_effects(report).size());
        tops.push_back(tops.back() + (panels + panels_a_row - 1) / panels_a_row *
                                         (panel_height(report.picture) + title_height));
    }
    Page page{Image(panels_a_row * panel_width, tops.back() + scale_height), {}};
    for (std::size_t k = 0; k < reports.size(); ++k)
        draw_scene(reports[k], panel_name(file, k), file.panels[k].white, tops[k], page);
    draw_scale(tops.back(), page);
    const SignalsHeld held;
    write_atomically(path, [&](const std::filesystem::path& temporary) {
        write_png(page.image, 1, page.labels, temporary);
    });
}

}  // namespace stratus
