#include <stratus/io/phase_file.h>
#include <stratus/picture/png.h>
#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>

#include "sections.h"

#include <utility>

namespace stratus::scene_file {

std::shared_ptr<const Image> Source::image(const Section& section, const char* key) const {
    const std::filesystem::path path = directory / section.text(key);
    const std::string ending = path.extension().string();
    require(ending == ".png" || ending == ".exr", caller, section.full_name(key),
            "a .png or .exr file", path.string());
    return std::make_shared<const Image>(ending == ".png" ? read_png(path) : read_exr_image(path));
}

PhaseFunction Source::phase_function(const std::string& text) const {
    return read_phase_function(text, directory.string(), notes);
}

Section section_of(const Section& root, const char* name, std::vector<std::string> known) {
    const std::string form = std::string("a table: [") + name + "]";
    return {root.table(name, form.c_str()), caller, name, std::move(known)};
}

void require_exactly_one(const Section& section, const char* one, const char* other) {
    require(section.has(one) != section.has(other), caller,
            "exactly one of " + section.full_name(one) + " and " + section.full_name(other),
            "given", section.has(one) ? "both" : "neither");
}

void read_optional(double& value, const Section& section, const char* key, double min, double max,
                   const char* allowed) {
    if (section.has(key)) value = section.number(key, min, max, allowed);
}

Vector3 read_vector(const Section& section, const char* key) {
    const std::vector<double> v =
        section.numbers(key, -max_length, max_length, "in [-1e12, 1e12], three of them");
    require(v.size() == 3, caller, section.full_name(key), "a list of three numbers", v.size());
    return {v[0], v[1], v[2]};
}

double read_angle(const Section& section, const char* key, double min, double max,
                  const char* allowed) {
    return radians(section.number(key, min, max, allowed));
}

std::array<double, 3> read_three(const Section& section, const char* key, double max,
                                 const char* allowed) {
    if (!section.is_list(key)) {
        const double grey = section.number(key, 0, max, allowed);
        return {grey, grey, grey};
    }
    const std::vector<double> v = section.numbers(key, 0, max, allowed);
    require(v.size() == 3, caller, section.full_name(key), "a number, or a list of three",
            v.size());
    return {v[0], v[1], v[2]};
}

Rgb read_colour(const Section& section, const char* key, double max, const char* allowed) {
    const std::array<double, 3> c = read_three(section, key, max, allowed);
    return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}

unsigned read_seed(const Section& section) {
    return static_cast<unsigned>(section.count("seed", 0, 1000000000));
}

Texture read_image(const Section& section, const Source& source) {
    Texture texture;
    texture.pattern = Texture::Pattern::image;
    texture.image = source.image(section, "image");
    return texture;
}

}  // namespace stratus::scene_file
