// [lobes] and [lambert].
#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>

#include "sections.h"

#include <cmath>
#include <vector>

namespace stratus::scene_file {
namespace {

std::vector<double> read_short_list(const Section& section, const char* key, double min, double max,
                                    const char* allowed) {
    std::vector<double> numbers = section.numbers(key, min, max, allowed);
    require(!numbers.empty() && numbers.size() <= 8, caller, section.full_name(key),
            "a list of 1 to 8 numbers", numbers.size());
    return numbers;
}

}  // namespace

LobeFigure read_lobes(const Section& root, const Source& source) {
    const Section section =
        section_of(root, "lobes", {"phase_function", "incident_deg", "optical_depths", "albedos"});
    LobeFigure figure;
    figure.phase_function = source.phase_function(section.text("phase_function"));
    for (const double angle : read_short_list(section, "incident_deg", 0, 180, "in [0, 180]")) {
        require(std::abs(angle - 90) > 0.1, caller, "lobes.incident_deg", "not along the layer, 90",
                angle);
        figure.incident.push_back(radians(angle));
    }
    figure.optical_depths = read_short_list(section, "optical_depths", 0, infinity, "in [0, inf]");
    figure.albedos = read_short_list(section, "albedos", 0, 1, "in [0, 1]");
    return figure;
}

LambertFigure read_lambert(const Section& root, const Source& source) {
    const Section section =
        section_of(root, "lambert", {"phase_function", "albedo", "optical_depth", "mu_in"});
    LambertFigure figure;
    figure.phase_function = source.phase_function(section.text("phase_function"));
    figure.albedo = section.number("albedo", 0, 1, "in [0, 1]");
    figure.optical_depth = section.number("optical_depth", 0, infinity, "in [0, inf]");
    figure.mu_in = read_short_list(section, "mu_in", 1e-3, 1, "in [1e-3, 1]");
    return figure;
}

}  // namespace stratus::scene_file
