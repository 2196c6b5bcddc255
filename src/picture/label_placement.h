// Labels of points in a plot: each is placed near its point where it covers least.
#pragma once

#include "page.h"

#include <string>
#include <vector>

namespace stratus {

struct PointLabel {
    Point point;
    std::string text;
    bool is_required;  // drawn where it covers other things too, if need be
};

/// Areas that labels should not cover.
struct Obstacles {
    std::vector<Box> marks, lines;
};

/// Places labels in their order; those without room are left out unless required.
void draw_labels(const Page& page, const Box& plot, const Obstacles& obstacles,
                 const std::vector<PointLabel>& labels);

}  // namespace stratus
