// [picture], [camera] and [sun].
#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>

#include "sections.h"

#include <cmath>

namespace stratus::scene_file {
namespace {

Vector3 read_position(const Section& section, const Vector3& look_at) {
    require_exactly_one(section, "position", "distance");
    if (section.has("position")) {
        require(!section.has("elevation_deg") && !section.has("azimuth_deg"), caller,
                "camera.position", "without elevation_deg and azimuth_deg", "them");
        return read_vector(section, "position");
    }
    const double distance = section.number("distance", 1e-6, max_length, "in [1e-6, 1e12]");
    double elevation = 0, azimuth = 0;
    read_optional(elevation, section, "elevation_deg", -90, 90, "in [-90, 90]");
    read_optional(azimuth, section, "azimuth_deg", -360, 360, "in [-360, 360]");
    return look_at + distance * direction_at(radians(elevation), radians(azimuth));
}

}  // namespace

void read_picture(const Section& root, Scene& scene) {
    const Section section = section_of(root, "picture", {"width", "height", "samples", "white"});
    if (section.has("width")) scene.width = section.count("width", 1, 16384);
    if (section.has("height")) scene.height = section.count("height", 1, 16384);
    if (section.has("samples")) scene.samples = section.count("samples", 1, 16);
    read_optional(scene.white, section, "white", 1e-6, 1e6, "in [1e-6, 1e6]");
}

Camera read_camera(const Section& root) {
    const Section section = section_of(root, "camera",
                                       {"position", "distance", "elevation_deg", "azimuth_deg",
                                        "look_at", "field_of_view_deg", "orthographic_width"});
    Camera camera;
    if (section.has("look_at")) camera.look_at = read_vector(section, "look_at");
    camera.position = read_position(section, camera.look_at);
    require(length(camera.look_at - camera.position) > 0, caller, "camera.position",
            "another point than look_at", "the same");
    require_exactly_one(section, "field_of_view_deg", "orthographic_width");
    camera.orthographic = section.has("orthographic_width");
    camera.width = camera.orthographic
                       ? section.number("orthographic_width", 1e-9, max_length, "in [1e-9, 1e12]")
                       : read_angle(section, "field_of_view_deg", 1e-3, 170, "in [1e-3, 170]");
    return camera;
}

void read_sun(const Section& root, Scene& scene) {
    const Section section =
        section_of(root, "sun",
                   {"direction", "elevation_deg", "azimuth_deg", "phase_angle_deg",
                    "angular_diameter_deg", "colour", "visible"});
    const bool by_angles = section.has("elevation_deg") || section.has("azimuth_deg");
    require(section.has("direction") + by_angles + section.has("phase_angle_deg") == 1, caller,
            "sun", "given by direction, by elevation_deg and azimuth_deg, or by phase_angle_deg",
            "none or several of them");
    if (section.has("direction")) {
        const Vector3 direction = read_vector(section, "direction");
        require(length(direction) > 0, caller, "sun.direction", "longer than 0", "0");
        scene.to_sun = normalised(direction);
    } else if (by_angles) {
        double azimuth = 0;
        read_optional(azimuth, section, "azimuth_deg", -360, 360, "in [-360, 360]");
        scene.to_sun = direction_at(read_angle(section, "elevation_deg", -90, 90, "in [-90, 90]"),
                                    radians(azimuth));
    } else {
        const double phase_angle =
            read_angle(section, "phase_angle_deg", -180, 180, "in [-180, 180]");
        scene.to_sun = -std::cos(phase_angle) * scene.camera.forward() +
                       std::sin(phase_angle) * scene.camera.right();
    }
    if (section.has("angular_diameter_deg"))
        scene.sun_diameter = read_angle(section, "angular_diameter_deg", 0, 60, "in [0, 60]");
    if (section.has("colour")) scene.sun_colour = read_three(section, "colour", 1e6, "in [0, 1e6]");
    if (section.has("visible")) scene.sun_visible = section.flag("visible");
    require(!scene.sun_visible || scene.sun_diameter > 0, caller, "sun.angular_diameter_deg",
            "above 0 where the sun is visible", scene.sun_diameter);
}

}  // namespace stratus::scene_file
