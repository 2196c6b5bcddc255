#include <stratus/base/constants.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/picture/png.h>

#include "sections.h"

#include <algorithm>
#include <vector>

namespace stratus::scene_file {

std::shared_ptr<const Image> Source::image(const Section& section, double most) const {
    constexpr const char* key = "image";
    const std::filesystem::path path = directory / section.text(key);
    const std::string ending = path.extension().string();
    require(ending == ".png" || ending == ".exr", caller, section.at(key), "a .png or .exr file",
            path.string());
    const bool is_png = ending == ".png";
    require(is_png || !section.has("encoding"), caller, section.at("encoding"),
            "absent beside an .exr file, whose numbers are linear", "given");
    const PngEncoding encoding = section.choice("encoding", {"srgb", "data"}) == "srgb"
                                     ? PngEncoding::srgb
                                     : PngEncoding::data;
    std::shared_ptr<const Image>& image =
        (*images)[path.string() + (encoding == PngEncoding::srgb ? " srgb" : " data")];
    if (!image)
        image = section.placed(key, [&] {
            return std::make_shared<const Image>(is_png ? read_png(path, 0, encoding)
                                                        : read_exr_image(path));
        });
    const auto outside = std::ranges::find_if_not(
        image->rgb, [&](float value) { return value >= 0 && double{value} <= most; });
    if (outside != image->rgb.end())
        require(false, caller, section.at(key), "of numbers in [0, " + shortest_text(most) + "]",
                *outside);
    return image;
}

PhaseFunction Source::phase_function(const Section& section, const char* key) const {
    return section.phase_function(key, directory.string(), notes);
}

std::vector<PhaseFunction> Source::phase_functions(const Section& section, const char* key,
                                                   std::size_t count) const {
    return section.phase_functions(key, count, directory.string(), notes);
}

void require_exactly_one(const Section& section, const char* one, const char* other) {
    require(section.has(one) != section.has(other), caller,
            section.here() + ": exactly one of " + one + " and " + other, "given",
            section.has(one) ? "both" : "neither");
}

bool has_image(const Section& section, const char* instead) {
    require_exactly_one(section, "image", instead);
    if (!section.has("image")) require_absent(section, "encoding", "without an image");
    return section.has("image");
}

void require_absent(const Section& section, const char* key, const char* where) {
    require(!section.has(key), caller, section.at(key), std::string("absent ") + where, "one");
}

Vector3 read_vector(const Section& section, const char* key) {
    const std::vector<double> v = section.numbers(key, 3, 3);
    return {v[0], v[1], v[2]};
}

double read_angle(const Section& section, const char* key) { return radians(section.number(key)); }

Rgb read_colour(const Section& section, const char* key) {
    const Rgb3 c = section.three(key);
    return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}

unsigned read_seed(const Section& section) { return static_cast<unsigned>(section.count("seed")); }

Texture read_image(const Section& section, const Source& source, double most) {
    Texture texture;
    texture.pattern = Texture::Pattern::image;
    texture.image = source.image(section, most);
    return texture;
}

}  // namespace stratus::scene_file
