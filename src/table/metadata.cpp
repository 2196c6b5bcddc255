#include <stratus/table/metadata.h>

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include <charconv>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace stratus {
namespace {

template <class Number>
Number parsed(const std::string& what, const char* kind, std::string_view text) {
    Number value{};
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || stop != end)
        throw std::invalid_argument(what + " is not " + kind + ": " + shown_text(text));
    return value;
}

/// Refuses a text that names another file: a table file must be complete, and reading it opens no
/// other.
PhaseFunction read_phase_function(const std::string& name, const std::string& text) {
    if (text.find("file") != std::string::npos)
        throw std::invalid_argument("attribute " + name +
                                    " must be complete, not name a file: " + shown_text(text));
    return parse_phase_function(text);
}

double number_entry(const Metadata& metadata, const char* name) {
    return to_number(name, entry(metadata, name));
}

std::vector<double> numbers_entry(const Metadata& metadata, const char* name) {
    return to_numbers(name, entry(metadata, name));
}

/// The entry of this name; empty where there is none.
std::string optional_entry(const Metadata& metadata, const char* name) {
    const auto found = metadata.find(name);
    return found == metadata.end() ? "" : found->second;
}

/// Numbers that every table has.
constexpr std::pair<const char*, double Table::*> number_entries[] = {
    {"extrapolation_length", &Table::extrapolation_length},
    {"tolerance", &Table::tolerance},
    {"measured_error", &Table::measured_error}};

/// Kinds of lower boundary in files, in the order of LowerBoundary::Kind; without one there is no entry.
constexpr const char* boundary_names[] = {"", "lambert surface", "semi-infinite layer", "ground"};

void add_lower_boundary(const LowerBoundary& boundary, Metadata& metadata) {
    if (!boundary.is_present()) return;
    metadata["below"] = boundary_names[static_cast<int>(boundary.kind)];
    metadata["below_albedo"] = shortest_text(boundary.albedo);
    if (boundary.is_ground()) metadata["below_ground"] = boundary.law->text();
    if (boundary.is_layer()) metadata["below_phase_function"] = boundary.phase_function.text();
}

LowerBoundary read_lower_boundary(const Metadata& metadata) {
    const auto name = metadata.find("below");
    if (name == metadata.end()) return {};
    const auto& [none, surface, layer, ground] = boundary_names;
    if (name->second != surface && name->second != layer && name->second != ground)
        throw std::invalid_argument("attribute below must be \"" + std::string(surface) + "\", \"" +
                                    ground + "\" or \"" + layer + "\", got " +
                                    shown_text(name->second));
    const double albedo = number_entry(metadata, "below_albedo");
    if (name->second == surface) return LowerBoundary::surface(albedo);
    if (name->second == ground)
        return {LowerBoundary::Kind::ground,
                albedo,
                {},
                read_ground_law(entry(metadata, "below_ground"))};
    return LowerBoundary::layer(
        read_phase_function("below_phase_function", entry(metadata, "below_phase_function")),
        albedo);
}

void add_layers(const Table& table, Metadata& metadata) {
    if (!table.is_stack()) return;
    std::string phase_functions;  // a line each
    std::vector<double> albedos, depths;
    for (const StackLayer& layer : table.layers) {
        if (!phase_functions.empty()) phase_functions += '\n';
        phase_functions += layer.phase_function.text();
        albedos.push_back(layer.albedo);
        depths.push_back(layer.optical_depth);
    }
    metadata["layer_phase_functions"] = phase_functions;
    metadata["layer_albedos"] = to_text(albedos);
    metadata["layer_optical_depths"] = to_text(depths);
    metadata["spherical_albedo_below"] = shortest_text(table.spherical_albedo_below);
}

void read_layers(const Metadata& metadata, Table& table) {
    if (metadata.count("layer_phase_functions") == 0) return;
    const std::vector<double> albedos = numbers_entry(metadata, "layer_albedos"),
                              depths = numbers_entry(metadata, "layer_optical_depths");
    std::istringstream lines(entry(metadata, "layer_phase_functions"));
    for (std::string line; std::getline(lines, line);) {
        const std::size_t k = table.layers.size();
        if (k >= albedos.size() || k >= depths.size()) break;
        table.layers.push_back(
            {read_phase_function("layer_phase_functions", line), albedos[k], depths[k]});
    }
    if (lines || table.layers.empty() || table.layers.size() != albedos.size() ||
        table.layers.size() != depths.size())
        throw std::invalid_argument(
            "attributes layer_phase_functions, layer_albedos and layer_optical_depths must have as "
            "many entries as each other");
    table.spherical_albedo_below = number_entry(metadata, "spherical_albedo_below");
}

void add_family(const Table& table, Metadata& metadata) {
    if (!table.has_family()) return;
    std::vector<std::string> names;
    for (const FamilyAxis& axis : table.family) names.emplace_back(axis.name());
    metadata["family"] = joined(names, " ");
    metadata["extrapolation_lengths"] = to_text(table.extrapolation_lengths);
    if (mixes_two(table.family))
        metadata["second_phase_function"] = table.second_phase_function.text();
}

void read_family(const Metadata& metadata, Table& table) {
    std::istringstream names(optional_entry(metadata, "family"));
    for (std::string name; table.family.size() <= max_family_axes && names >> name;) {
        const auto parameter = parameter_named(name);
        if (!parameter)
            throw std::invalid_argument("attribute family must be of names out of " +
                                        joined(parameter_names()) + ", got " + shown_text(name));
        table.family.push_back({*parameter, {parameter_scale(*parameter), {}}, false});
    }
    if (table.has_family())
        table.extrapolation_lengths = numbers_entry(metadata, "extrapolation_lengths");
    if (mixes_two(table.family))
        table.second_phase_function =
            read_phase_function("second_phase_function", entry(metadata, "second_phase_function"));
    else if (metadata.count("second_phase_function") != 0)
        throw std::invalid_argument(
            "attribute second_phase_function needs mixture in attribute family");
}

std::string list_features(const Table& table) {
    std::vector<std::string> features;
    if (table.has_family()) features.emplace_back(family_feature);
    if (table.is_stack()) features.emplace_back(stack_feature);
    if (table.path_law) features.emplace_back(path_law_feature);
    return joined(features, " ");
}

std::vector<std::string> stored_features(const Metadata& metadata) {
    std::istringstream in(optional_entry(metadata, "features"));
    return {std::istream_iterator<std::string>(in), {}};
}

}  // namespace

std::vector<AxisField> all_axis_fields(const Table& table) {
    std::vector<AxisField> fields;
    for (std::size_t k = 0; k < table.family.size(); ++k) {
        const auto& [parameter, axis, is_discrete] = table.family[k];
        fields.push_back({parameter_name(parameter),
                          parameter_unit(parameter),
                          parameter == PhaseParameter::mixture
                              ? "share of phase_function in all that is scattered"
                              : "parameter of phase_function",
                          nullptr,
                          k,
                          {axis.scale, axis.scale}});
    }
    fields.insert(fields.end(), axis_fields.begin(), axis_fields.end());
    return fields;
}

std::vector<std::size_t> extents(const Table& table, std::size_t rank) {
    std::vector<std::size_t> sizes;
    for (const FamilyAxis& axis : table.family) sizes.push_back(axis.axis.values.size());
    for (std::size_t k = 0; k < rank; ++k)
        sizes.push_back((table.*axis_fields[k].axis).values.size());
    return sizes;
}

std::string allowed_scales(const AxisField& field) {
    const auto [usual, other] = field.scales;
    return axis_scale_name(usual) +
           (other == usual ? "" : std::string(" or ") + axis_scale_name(other));
}

const char* stored_scale_name(const AxisField& field, const Table& table) {
    const AxisScale scale = table_axis(table, field).scale;
    if (field.axis != nullptr) return axis_scale_name(scale);
    if (table.family[field.family].is_discrete) return discrete_scale_name;
    return scale == AxisScale::linear ? mixture_scale_name : axis_scale_name(scale);
}

Metadata shared_metadata(const Table& table) {
    Metadata metadata = table.attributes;
    if (const std::string features = list_features(table); !features.empty())
        metadata["features"] = features;
    metadata["phase_function"] = table.phase_function.text();
    add_lower_boundary(table.lower_boundary, metadata);
    add_layers(table, metadata);
    add_family(table, metadata);
    for (const auto& [name, number] : number_entries) metadata[name] = shortest_text(table.*number);
    metadata["highest_order"] = std::to_string(table.highest_order);
    return metadata;
}

void check_features_known(const Metadata& metadata) {
    static const std::vector<std::string> known{family_feature, stack_feature, path_law_feature};
    for (const std::string& feature : stored_features(metadata))
        if (!is_listed(feature, known))
            throw std::invalid_argument("attribute features must be of " + joined(known) +
                                        ", which this program knows, got " + shown_text(feature));
}

bool has_feature(const Metadata& metadata, const char* feature) {
    return is_listed(feature, stored_features(metadata));
}

Table table_of_metadata(const Metadata& metadata) {
    Table table;
    table.phase_function = read_phase_function("phase_function", entry(metadata, "phase_function"));
    table.lower_boundary = read_lower_boundary(metadata);
    read_layers(metadata, table);
    read_family(metadata, table);
    for (const auto& [name, number] : number_entries) table.*number = number_entry(metadata, name);
    table.highest_order = to_integer("highest_order", entry(metadata, "highest_order"));
    return table;
}

void check_features(const Metadata& metadata, const Table& table) {
    const std::string stored = optional_entry(metadata, "features"),
                      described = list_features(table);
    if (stored != described)
        throw std::invalid_argument("attribute features must be \"" + described +
                                    "\", as the other attributes say, got " + shown_text(stored));
}

const std::string& entry(const Metadata& metadata, const std::string& name) {
    const auto found = metadata.find(name);
    if (found == metadata.end()) throw std::invalid_argument("attribute " + name + " is missing");
    return found->second;
}

std::string to_text(const std::vector<double>& values) {
    std::string text;
    for (const double value : values) {
        if (!text.empty()) text += ' ';
        text += shortest_text(value);
    }
    return text;
}

double to_number(const std::string& what, std::string_view text) {
    return parsed<double>(what, "a number", text);
}

int to_integer(const std::string& what, std::string_view text) {
    return parsed<int>(what, "an integer", text);
}

std::vector<double> to_numbers(const std::string& what, std::string_view text) {
    std::vector<double> values;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find(' '), text.size());
        values.push_back(to_number(what, text.substr(0, end)));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return values;
}

std::string shown_text(std::string_view text) {
    constexpr std::size_t longest = 60;
    std::string result(text.substr(0, longest));
    std::replace_if(
        result.begin(), result.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    return '"' + result + (text.size() > longest ? "...\"" : "\"");
}

}  // namespace stratus
