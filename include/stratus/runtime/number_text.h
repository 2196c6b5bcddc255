// Numbers as text: in full, so that they can be read back, and in short, for people.
#pragma once

#include <string>

namespace stratus {

/// The shortest text that reads back as the same double.
std::string shortest_text(double value);

/// So many significant digits, as printf's %g has them.
std::string short_number(double value, int digits = 2);

}  // namespace stratus
