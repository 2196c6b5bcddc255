// [lobes] and [lambert].
#include <stratus/base/angle.h>
#include <stratus/base/argument.h>

#include "sections.h"

#include <cmath>

namespace stratus::scene_file {

LobeFigure read_lobes(const Section& root, const Source& source) {
    const Section section = root.section("lobes");
    LobeFigure figure;
    figure.phase_function = source.phase_function(section, "phase_function");
    for (const double angle : section.numbers("incident_deg", 1, 8)) {
        require(std::abs(angle - 90) > 0.1, caller, section.at("incident_deg"),
                "not along the layer, 90", angle);
        figure.incident.push_back(radians(angle));
    }
    figure.optical_depths = section.numbers("optical_depths", 1, 8);
    figure.albedos = section.numbers("albedos", 1, 8);
    figure.common_scale = section.flag("common_scale");
    figure.title = root.text("title");
    return figure;
}

LambertFigure read_lambert(const Section& root, const Source& source) {
    const Section section = root.section("lambert");
    LambertFigure figure;
    figure.phase_function = source.phase_function(section, "phase_function");
    figure.albedo = section.number("albedo");
    figure.optical_depth = section.number("optical_depth");
    figure.mu_in = section.numbers("mu_in", 1, 8);
    figure.title = root.text("title");
    return figure;
}

}  // namespace stratus::scene_file
