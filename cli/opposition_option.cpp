#include "opposition_option.h"

#include <cstddef>
#include <cstdio>
#include <stdexcept>

namespace stratus {
namespace {

/// True when `format`, which ends in %n, reads all of `text`.
template <class... Values>
bool reads(const std::string& text, const char* format, Values*... values) {
    int read = -1;
    std::sscanf(text.c_str(), format, values..., &read);
    return read >= 0 && static_cast<std::size_t>(read) == text.size();
}

}  // namespace

void add_density_and_opposition(CLI::App& command, std::string& density, std::string& opposition) {
    command
        .add_option("--density", density,
                    "Share of the volume that particles fill, [0, 1), or number=N,radius=R of the "
                    "particles, N per cubed unit of R: every order sees the depth "
                    "tau / (1 - density)")
        ->capture_default_str();
    command.add_option(
        "--opposition", opposition,
        "How single scattering brightens towards the light: blinn or hapke, as wide as the density "
        "makes it, or hapke:width=0.05,amplitude=0.8 or one of these two. Default: not at all");
}

double parse_density(const std::string& command, const std::string& text) {
    double density = 0, number = 0, radius = 0;
    if (reads(text, "number=%lf,radius=%lf%n", &number, &radius))
        return volume_fraction(number, radius);
    if (!reads(text, "%lf%n", &density) || !(density >= 0 && density < 1))
        throw std::invalid_argument(
            command + ": --density must be in [0, 1) or number=N,radius=R, got " + text);
    return density;
}

Opposition parse_opposition(const std::string& command, const std::string& text, double density) {
    if (text.empty()) return {};
    double width = 0, amplitude = 1;
    const bool without_width =
        text == "blinn" || text == "hapke" || reads(text, "hapke:amplitude=%lf%n", &amplitude);
    if (without_width && density == 0)
        throw std::invalid_argument(command + ": --opposition " + text +
                                    " must come with a --density above 0, got 0");
    if (text == "blinn") return Opposition::blinn();
    if (without_width) return Opposition::hapke(amplitude);
    if (!reads(text, "hapke:width=%lf%n", &width) &&
        !reads(text, "hapke:width=%lf,amplitude=%lf%n", &width, &amplitude))
        throw std::invalid_argument(
            command +
            ": --opposition must be blinn or hapke or hapke:width=H,amplitude=A or one of "
            "these two, got " +
            text);
    return Opposition::hapke(amplitude, width);
}

}  // namespace stratus
