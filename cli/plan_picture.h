// Where each effect changes a picture, in false colours.
#pragma once

#include <stratus/scene/plan.h>

#include <string>
#include <vector>

namespace stratus {

/// Draws, for each scene, its sparse picture and beside it a panel for each effect that shows there:
/// the relative change of each pixel without the effect, on one logarithmic scale below.
///
/// Errors   std::runtime_error naming the path and the reason.
void write_change_picture(const SceneFile& file, const std::vector<PlanReport>& reports,
                          const std::string& path);

}  // namespace stratus
