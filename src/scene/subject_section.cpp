// [rings], [planet] and [slab].
#include <stratus/io/csv.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>

#include "sections.h"

#include <cstddef>
#include <string>
#include <vector>

namespace stratus::scene_file {
namespace {

/// `unit`: the planet's radius in the file's unit of length.
RingProfile read_profile(const std::filesystem::path& path, double unit) {
    const CsvTable csv = read_csv(path.string());
    struct Column {
        const char* name;
        std::vector<double> RingProfile::*values;
        double max;
        const char* allowed;
    };
    const Column columns[] = {{"radius", &RingProfile::radius, max_length, "in [0, 1e12]"},
                              {"optical_depth", &RingProfile::optical_depth, 1e4, "in [0, 1e4]"},
                              {"w1", &RingProfile::w1, 1, "in [0, 1]"},
                              {"w2", &RingProfile::w2, 1, "in [0, 1]"}};
    RingProfile profile;
    for (std::size_t r = 0; r < csv.rows.size(); ++r) {
        const std::string line = csv.name + ", line " + std::to_string(csv.lines[r]) + ": ";
        for (const Column& column : columns) {
            const double value = csv.rows[r][static_cast<std::size_t>(csv.column(column.name))];
            require(value >= 0 && value <= column.max, caller, line + column.name, column.allowed,
                    value);
            (profile.*column.values).push_back(value);
        }
        require(profile.w1[r] + profile.w2[r] <= 1, caller, line + "w1 + w2", "in [0, 1]",
                profile.w1[r] + profile.w2[r]);
        profile.radius[r] /= unit;
        require(r == 0 || profile.radius[r] > profile.radius[r - 1], caller, line + "radius",
                "above the one before", unit * profile.radius[r]);
    }
    require(csv.rows.size() >= 2, caller, csv.name, "a profile of at least 2 rows",
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

}  // namespace

Rings read_rings(const Section& root, const Source& source) {
    const Section section = section_of(
        root, "rings", {"profile", "planet_radius", "inner", "outer", "surface", "flattening"});
    Rings rings;
    double unit = 1;
    read_optional(unit, section, "planet_radius", 1e-9, max_length, "in [1e-9, 1e12]");
    const RingProfile whole = read_profile(source.directory / section.text("profile"), unit);
    double inner = whole.inner(), outer = whole.outer();
    read_optional(inner, section, "inner", inner, outer, "within the profile");
    read_optional(outer, section, "outer", inner, outer, "within the profile and above inner");
    require(inner >= 1, caller, "rings.inner", "at least the planet's radius, 1", inner);
    require(inner < outer, caller, "rings.outer", "above inner", outer);
    rings.profile = trimmed(whole, inner, outer);
    rings.surface = read_surface(section, source);
    read_optional(rings.flattening, section, "flattening", 0, 0.9, "in [0, 0.9]");
    return rings;
}

Planet read_planet(const Section& root, const Source& source) {
    return {read_surface(section_of(root, "planet", {"surface"}), source)};
}

Slab read_slab(const Section& root, const Source& source, const Camera& camera) {
    const Section section = section_of(root, "slab", {"surface", "height", "size", "image_size"});
    Slab slab;
    if (section.has("surface")) slab.surface = read_surface(section, source);
    read_optional(slab.height, section, "height", 0, 1e6, "in [0, 1e6]");
    double size = infinity;
    read_optional(size, section, "size", 1e-6, infinity, "in [1e-6, inf]");
    slab.half_size = size / 2;
    read_optional(slab.image_size, section, "image_size", 1e-6, 1e6, "in [1e-6, 1e6]");
    if (slab.surface)
        require(camera.position.z > -slab.height, caller, "camera.position",
                "above the ground, z = -slab.height", camera.position.z);
    return slab;
}

}  // namespace stratus::scene_file
