#include "opposition_option.h"

#include "allowed.h"

#include <cstdio>
#include <stdexcept>

namespace stratus {

void add_density_and_opposition(CLI::App& command, double& density, std::string& opposition) {
    command
        .add_option("--density", density,
                    "Share of the volume that particles fill, [0, 1): every order sees the depth "
                    "tau / (1 - density)")
        ->capture_default_str()
        ->check(number("in [0, 1)", [](double value) { return value >= 0 && value < 1; }));
    command.add_option(
        "--opposition", opposition,
        "How single scattering brightens towards the light: blinn, as wide as the density makes "
        "it, or hapke:width=0.05 or hapke:width=0.05,amplitude=0.8. Default: not at all");
}

Opposition parse_opposition(const std::string& command, const std::string& text, double density) {
    if (text.empty()) return {};
    if (text == "blinn") {
        if (density == 0)
            throw std::invalid_argument(
                command + ": --opposition blinn must come with a --density above 0, got 0");
        return Opposition::blinn(density);
    }
    double width = 0, amplitude = 1;
    int read = 0;
    const bool hapke = std::sscanf(text.c_str(), "hapke:width=%lf%n,amplitude=%lf%n", &width, &read,
                                   &amplitude, &read) >= 1 &&
                       static_cast<std::size_t>(read) == text.size();
    if (!hapke)
        throw std::invalid_argument(
            command +
            ": --opposition must be blinn or hapke:width=H or hapke:width=H,amplitude=A, got " +
            text);
    return Opposition::hapke(amplitude, width);
}

}  // namespace stratus
