#include "label_placement.h"

#include "plot_axes.h"

#include <cmath>

namespace stratus {
namespace {

constexpr double label_size = 7, padding = 0.8, descent = 1.2, ascent = 5.4;
constexpr double near = 8, far = 32;  // from the point

bool overlap(const Box& a, const Box& b) {
    return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

bool contains(const Box& outer, const Box& inner) {
    return outer.x0 <= inner.x0 && inner.x1 <= outer.x1 && outer.y0 <= inner.y0 &&
           inner.y1 <= outer.y1;
}

double penalty(const Box& label, const Box& plot, const Obstacles& obstacles,
               const std::vector<Box>& placed) {
    constexpr double mark = 2, line = 1, other_label = 100, outside = 1000;
    double sum = contains(plot, label) ? 0 : outside;
    const auto add = [&](const std::vector<Box>& boxes, double each) {
        for (const Box& box : boxes) sum += overlap(label, box) ? each : 0;
    };
    add(obstacles.marks, mark);
    add(obstacles.lines, line);
    add(placed, other_label);
    return sum;
}

}  // namespace

void draw_labels(const Page& page, const Box& plot, const Obstacles& obstacles,
                 const std::vector<PointLabel>& labels) {
    constexpr double max_optional_penalty = 2;  // from here on a label is left out
    std::vector<Box> placed;
    for (const PointLabel& label : labels) {
        const double width = page.text_width(label.text, label_size) + 2 * padding;
        const double height = ascent + descent + 2 * padding;
        Box best{};
        double best_penalty = infinity;
        for (int distance = 5; distance <= (label.is_required ? far : near); distance += 3)
            for (const double angle : {-0.25, 0.0, 0.25, 0.75, 1.0, -0.75, 0.5, -0.5}) {
                const double across = std::cos(pi * angle), down = -std::sin(pi * angle);
                const double x = label.point.x + distance * across + across * width / 2;
                const double y = label.point.y + distance * down + down * height / 2;
                const Box box{x - width / 2, y - height / 2, x + width / 2, y + height / 2};
                const double met = penalty(box, plot, obstacles, placed) + 0.02 * distance;
                if (met >= best_penalty) continue;
                best_penalty = met;
                best = box;
            }
        if (!label.is_required && penalty(best, plot, obstacles, placed) >= max_optional_penalty)
            continue;
        placed.push_back(best);
        page.fill(best, white);
        page.text({best.x0 + padding, best.y1 - padding - descent}, label.text, label_size,
                  label.is_required ? black : grey);
    }
}

}  // namespace stratus
