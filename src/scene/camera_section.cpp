// [picture], [camera] and [sun].
#include <stratus/base/argument.h>

#include "sections.h"

#include <cmath>

namespace stratus::scene_file {
namespace {

Vector3 read_position(const Section& section, const Vector3& look_at) {
    require_exactly_one(section, "position", "distance");
    if (section.has("position")) {
        for (const char* angle : {"elevation_deg", "azimuth_deg"})
            require_absent(section, angle, "where position is given");
        return read_vector(section, "position");
    }
    const double elevation = read_angle(section, "elevation_deg"),
                 azimuth = read_angle(section, "azimuth_deg");
    return look_at + section.number("distance") * direction_at(elevation, azimuth);
}

}  // namespace

void read_picture(const Section& root, Scene& scene) {
    const Section section = root.section("picture");
    scene.width = section.count("width");
    scene.height = section.count("height");
    scene.samples = section.count("samples");
    scene.white = section.number("white");
}

Camera read_camera(const Section& root) {
    const Section section = root.section("camera");
    Camera camera;
    camera.look_at = read_vector(section, "look_at");
    camera.position = read_position(section, camera.look_at);
    require(length(camera.look_at - camera.position) > 0, caller, section.at("position"),
            "another point than look_at", "the same");
    require_exactly_one(section, "field_of_view_deg", "orthographic_width");
    camera.orthographic = section.has("orthographic_width");
    camera.width = camera.orthographic ? section.number("orthographic_width")
                                       : read_angle(section, "field_of_view_deg");
    return camera;
}

void read_sun(const Section& root, Scene& scene) {
    const Section section = root.section("sun");
    const bool by_angles = section.has("elevation_deg") || section.has("azimuth_deg");
    require(section.has("direction") + by_angles + section.has("phase_angle_deg") == 1, caller,
            section.here(),
            "given by direction, by elevation_deg and azimuth_deg, or by phase_angle_deg",
            "none or several of them");
    if (section.has("direction")) {
        const Vector3 direction = read_vector(section, "direction");
        require(length(direction) > 0, caller, section.at("direction"), "longer than 0", "0");
        scene.to_sun = normalised(direction);
    } else if (by_angles) {
        scene.to_sun =
            direction_at(read_angle(section, "elevation_deg"), read_angle(section, "azimuth_deg"));
    } else {
        const double phase_angle = read_angle(section, "phase_angle_deg");
        scene.to_sun = -std::cos(phase_angle) * scene.camera.forward() +
                       std::sin(phase_angle) * scene.camera.right();
    }
    scene.sun_diameter = read_angle(section, "angular_diameter_deg");
    scene.sun_colour = section.three("colour");
    scene.sun_visible = section.flag("visible");
    require(!scene.sun_visible || scene.sun_diameter > 0, caller, section.at("visible"),
            "false where angular_diameter_deg is 0", "true");
}

}  // namespace stratus::scene_file
