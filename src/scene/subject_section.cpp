// [rings], [planet] and [slab]; [lobes] and [lambert].
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/io/csv.h>

#include "sections.h"

#include <cmath>
#include <utility>

namespace stratus::scene_file {
namespace {

/// `unit`: the planet's radius in the file's unit of length. Refusals name the file's line.
RingProfile read_profile(const fs::path& path, double unit) {
    const CsvTable csv = read_csv(path.string());
    struct Column {
        const char* name;
        std::vector<double> RingProfile::*values;
        NumberRange range;
    };
    const Column columns[] = {{"radius", &RingProfile::radius, "[0, 1e12]"},
                              {"optical_depth", &RingProfile::optical_depth, "[0, 1e4]"},
                              {"w1", &RingProfile::w1, "[0, 1]"},
                              {"w2", &RingProfile::w2, "[0, 1]"}};
    RingProfile profile;
    for (std::size_t r = 0; r < csv.rows.size(); ++r) {
        const std::string line = csv.name + ", line " + std::to_string(csv.lines[r]);
        auto check = [&](bool holds, const char* name, const std::string& allowed, double value) {
            require(holds, line.c_str(), name, allowed, value);
        };
        for (const Column& column : columns) {
            const double value = csv.rows[r][size(csv.column(column.name))];
            check(column.range.holds(value), column.name, "in " + column.range.text, value);
            (profile.*column.values).push_back(value);
        }
        const double both = profile.w1[r] + profile.w2[r];
        check(both <= 1, "w1 + w2", "in [0, 1]", both);
        const double radius = profile.radius[r];
        profile.radius[r] /= unit;
        check(r == 0 || profile.radius[r] > profile.radius[r - 1], "radius", "above the one before",
              radius);
    }
    require(csv.rows.size() >= 2, csv.name.c_str(), "the profile", "of at least 2 rows",
            csv.rows.size());
    return profile;
}

/// The part of a profile within [inner, outer], with rows at both.
RingProfile trimmed(const RingProfile& whole, double inner, double outer) {
    RingProfile part;
    auto add = [&](double radius) {
        const Matter matter = whole.at(radius, {1, 1, 1});
        part.radius.push_back(radius);
        part.optical_depth.push_back(matter.optical_depth);
        part.w1.push_back(matter.mixture * matter.albedo[0]);
        part.w2.push_back((1 - matter.mixture) * matter.albedo[0]);
    };
    add(inner);
    for (const double radius : whole.radius)
        if (radius > inner && radius < outer) add(radius);
    add(outer);
    return part;
}

/// Refuses a camera in the globe or in its shell, from which rays meet nothing.
void require_outside(const Section& root, Vector3 camera, double flattening, double shell) {
    camera.z /= 1 - flattening;
    const double top = 1 + shell;
    std::string allowed = "outside the planet, whose equatorial radius is 1";
    if (shell > 0) allowed += ", and its shell, which ends at " + short_number(top, 6);
    root.section("camera").require(
        length(camera) > top, "position", allowed,
        short_number(length(camera), 6) + " of its radius from the middle");
}

}  // namespace

Rings read_rings(const Section& root, const Source& source, const Camera& camera) {
    const Section section = root.section("rings");
    Rings rings;
    const double unit = section.number("planet_radius");
    const fs::path path = source.directory / section.text("profile");
    const RingProfile whole = section.placed("profile", [&] { return read_profile(path, unit); });
    double inner = whole.inner(), outer = whole.outer();
    for (const auto& [key, radius] : {std::pair("inner", &inner), std::pair("outer", &outer)}) {
        const std::string profile =
            "within the profile, [" + short_number(inner) + ", " + short_number(outer) + "]";
        if (section.has(key)) *radius = section.number(key, inner, outer, profile.c_str());
    }
    section.require(inner >= 1, "inner", "at least the planet's radius, 1", inner);
    section.require(inner < outer, "outer", "above inner", outer);
    rings.profile = trimmed(whole, inner, outer);
    const Section planet = root.section("planet");
    const bool has_layer = root.has("planet");
    if (has_layer) {
        require_absent(section, "surface", "beside [planet], which has it");
        planet.require(planet.has("layer"), "layer",
                       "present beside [rings], whose surface is that of a planet without one",
                       "nothing");
        require_absent(planet, "shell", "beside [rings]");
        rings.planet_layer = read_layer(planet.section("layer", "layer"), source, false);
    }
    const Section& its = has_layer ? planet : section;
    rings.surface = read_surface(its, source);
    its.require(!rings.surface.mirror, "surface", "no ocean within rings", "wind");
    rings.flattening = section.number("flattening");
    require_outside(root, camera.position, rings.flattening, 0);
    return rings;
}

Planet read_planet(const Section& root, const Source& source, const Camera& camera) {
    const Section section = root.section("planet");
    require_absent(section, "layer", "without [rings]: the layer of a planet alone is [layer]");
    Planet planet{read_surface(section, source), section.number("shell")};
    require_outside(root, camera.position, 0, planet.shell);
    return planet;
}

Slab read_slab(const Section& root, const Source& source, const Camera& camera) {
    const Section section = root.section("slab");
    Slab slab;
    if (section.has("surface")) slab.surface = read_surface(section, source);
    slab.height = section.number("height");
    slab.half_size = section.number("size") / 2;
    slab.image_size = section.number("image_size");
    if (slab.surface)
        root.section("camera").require(camera.position.z > -slab.height, "position",
                                       "above the ground, z = -slab.height", camera.position.z);
    return slab;
}

LobeFigure read_lobes(const Section& root, const Source& source) {
    const Section section = root.section("lobes");
    LobeFigure figure;
    figure.phase_function = section.phase_function("phase_function", source);
    for (const double angle : section.numbers("incident_deg", 1, 8)) {
        section.require(std::abs(angle - 90) > 0.1, "incident_deg", "not along the layer, 90",
                        angle);
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
    figure.phase_function = section.phase_function("phase_function", source);
    figure.albedo = section.number("albedo");
    figure.optical_depth = section.number("optical_depth");
    figure.mu_in = section.numbers("mu_in", 1, 8);
    figure.title = root.text("title");
    return figure;
}

}  // namespace stratus::scene_file
