#include "table_option.h"

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/table/family_member.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>

namespace stratus {
namespace {

/// A family's first member, as an example.
std::string example_point(const std::vector<FamilyAxis>& family) {
    std::vector<std::string> parts;
    for (const FamilyAxis& axis : family)
        parts.push_back(std::string(axis.name()) + "=" + shortest_text(axis.axis.values.front()));
    return joined(parts, ",");
}

}  // namespace

double parameter_value(const std::string& text, PhaseParameter parameter) {
    double value = 0;
    const std::size_t end = read_number(text, value);
    const std::string unit = end > 0 ? text.substr(end) : "?";
    const bool is_length = parameter_unit(parameter) == std::string("um");
    if (unit.empty() || (is_length && unit == "um")) return value;
    return is_length && unit == "nm" ? value / 1000 : std::numeric_limits<double>::quiet_NaN();
}

std::string at_help(const std::string& more) {
    return "Member of a table's family, such as radius=8,wavelength=0.55: all parameters that the "
           "table varies (g, variance, mixture; radius and wavelength in um)" +
           more;
}

FamilyPoint parse_point(const char* caller, const std::string& at,
                        const std::vector<FamilyAxis>& family, const std::string& path) {
    if (family.empty()) {
        require(at.empty(), caller, "--at",
                "left out for " + path + ", which is of one phase function", at);
        return {};
    }
    const std::string example = "as in " + example_point(family);
    require(!at.empty(), caller, "--at", "given for " + path + ", " + example, "nothing");
    std::vector<double> values(family.size(), std::numeric_limits<double>::quiet_NaN());
    std::istringstream parts(at);
    for (std::string part; std::getline(parts, part, ',');) {
        const std::size_t equals = part.find('=');
        const std::string name = part.substr(0, equals);
        std::size_t axis = 0;
        while (axis < family.size() && family[axis].name() != name) ++axis;
        require(equals != std::string::npos && axis < family.size() && std::isnan(values[axis]),
                caller, "--at", "NAME=VALUE of each parameter of " + path + ", " + example, at);
        values[axis] = parameter_value(part.substr(equals + 1), family[axis].parameter);
        require(holds(family[axis], values[axis]), caller, "--at " + name,
                allowed_text(family[axis]), part.substr(equals + 1));
    }
    for (std::size_t k = 0; k < family.size(); ++k)
        require(!std::isnan(values[k]), caller, "--at",
                "NAME=VALUE of each parameter of " + path + ", " + example, at);
    return FamilyPoint(values);
}

PackedTable read_member(const char* caller, const std::string& path, const ReadOptions& options,
                        const std::string& at) {
    if (at.empty()) {
        PackedTable table = read_packed_table(path, options);
        parse_point(caller, at, table.header().family, path);
        return table;
    }
    const Table table = read_samples(path, options);
    return PackedTable(pack(table_at(table, parse_point(caller, at, table.family, path))));
}

}  // namespace stratus
