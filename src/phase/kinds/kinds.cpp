#include <stratus/phase/kinds.h>

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include "phase_text.h"

namespace stratus {

Anisotropic::Anisotropic(double x_) : x(x_) {
    require(std::abs(x) <= 1, kind.name, "x", "in [-1, 1]", x);
}

Anisotropic Anisotropic::read(PhaseText& text) {
    return Anisotropic(text.number("anisotropic: x"));
}

std::string Anisotropic::parameter_text() const { return shortest_text(x); }

std::string Anisotropic::caption() const { return "anisotropic x = " + short_number(x, 3); }

HenyeyGreenstein::HenyeyGreenstein(double g_) : g(g_) {
    require(std::abs(g) < 1, kind.name, "g", "in (-1, 1)", g);
}

HenyeyGreenstein HenyeyGreenstein::read(PhaseText& text) {
    return HenyeyGreenstein(text.number("henyey_greenstein: g"));
}

std::string HenyeyGreenstein::parameter_text() const { return shortest_text(g); }

std::string HenyeyGreenstein::caption() const {
    return "Henyey-Greenstein g = " + short_number(g, 3);
}

}  // namespace stratus
