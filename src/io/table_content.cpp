#include "table_content.h"

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/io/table_file.h>

#include "table_axes.h"

#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace stratus::io {
namespace {

static_assert(std::endian::native == std::endian::little, "checksums are of little-endian bytes");

struct MetadataField {
    const char* name;
    EntryType type;
};

constexpr std::array<MetadataField, 22> metadata_fields{{
    {"format", EntryType::text},
    {"format_version", EntryType::integer},
    {"features", EntryType::text},
    {"datasets", EntryType::text},
    {"phase_function", EntryType::text},
    {"second_phase_function", EntryType::text},
    {"family", EntryType::text},
    {"extrapolation_lengths", EntryType::numbers},
    {"below", EntryType::text},
    {"below_albedo", EntryType::number},
    {"below_phase_function", EntryType::text},
    {"layer_phase_functions", EntryType::text},
    {"layer_albedos", EntryType::numbers},
    {"layer_optical_depths", EntryType::numbers},
    {"spherical_albedo_below", EntryType::number},
    {"moments", EntryType::numbers},
    {"asymmetry", EntryType::number},
    {"path_law", EntryType::numbers},
    {"extrapolation_length", EntryType::number},
    {"tolerance", EntryType::number},
    {"measured_error", EntryType::number},
    {"highest_order", EntryType::integer},
}};

constexpr int stored_moments = 64;

/// Moments computed from a phase function's text equal the stored ones up to the rounding of the
/// machine that wrote them.
constexpr double moment_tolerance = 1e-9;

constexpr std::size_t max_dataset_bytes = std::size_t{8} << 30;

/// Deflate compresses by at most 1032; the rest allows for the padding of chunks.
constexpr std::size_t max_inflation = 1100;

/// OpenEXR keeps 255 bytes of an attribute's name, some of which are our prefix.
constexpr std::size_t max_attribute_name = 200;

const MetadataField* find_field(const std::string& name) {
    const auto found = std::find_if(metadata_fields.begin(), metadata_fields.end(),
                                    [&](const MetadataField& field) { return field.name == name; });
    return found == metadata_fields.end() ? nullptr : &*found;
}

template <class Number>
std::optional<Number> parse(std::string_view text) {
    Number value{};
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || stop != end) return std::nullopt;
    return value;
}

std::string names_of_samples(const Table& table) {
    std::string names;
    for (const SampleField& field : sample_fields) {
        if ((table.*field.samples).empty()) continue;
        if (!names.empty()) names += ' ';
        names += field.name;
    }
    return names;
}

std::string text_of_checksum(std::uint32_t sum) {
    char text[sizeof "crc32:xxxxxxxx"];
    std::snprintf(text, sizeof text, "crc32:%08x", static_cast<unsigned>(sum));
    return text;
}

/// Refuses a text that names another file: a table file must be complete, and reading it opens no
/// other.
PhaseFunction read_phase_function(const std::string& name, const std::string& text) {
    if (text.find("file") != std::string::npos)
        throw std::runtime_error("attribute " + name +
                                 " must be complete, not name a file: " + shown(text));
    return parse_phase_function(text);
}

// Kinds of lower boundary in files; without one there is no entry.
constexpr const char* surface_name = "lambert surface";
constexpr const char* layer_name = "semi-infinite layer";

void add_lower_boundary(const LowerBoundary& boundary, Metadata& metadata) {
    if (!boundary.is_present()) return;
    const bool is_surface = boundary.kind == LowerBoundary::Kind::surface;
    metadata["below"] = is_surface ? surface_name : layer_name;
    metadata["below_albedo"] = shortest_text(boundary.albedo);
    if (!is_surface) metadata["below_phase_function"] = boundary.phase_function.text();
}

LowerBoundary read_lower_boundary(const Metadata& metadata) {
    const auto kind = metadata.find("below");
    if (kind == metadata.end()) return {};
    const bool is_surface = kind->second == surface_name;
    if (!is_surface && kind->second != layer_name)
        throw std::runtime_error("attribute below must be \"" + std::string(surface_name) +
                                 "\" or \"" + layer_name + "\", got " + shown(kind->second));
    const double albedo = to_number("below_albedo", entry(metadata, "below_albedo"));
    if (is_surface) return LowerBoundary::surface(albedo);
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
    if (!metadata.contains("layer_phase_functions")) return;
    const std::vector<double> albedos =
                                  to_numbers("layer_albedos", entry(metadata, "layer_albedos")),
                              depths = to_numbers("layer_optical_depths",
                                                  entry(metadata, "layer_optical_depths"));
    std::istringstream lines(entry(metadata, "layer_phase_functions"));
    for (std::string line; std::getline(lines, line);) {
        const std::size_t k = table.layers.size();
        if (k >= albedos.size() || k >= depths.size()) break;
        table.layers.push_back(
            {read_phase_function("layer_phase_functions", line), albedos[k], depths[k]});
    }
    if (lines || table.layers.empty() || table.layers.size() != albedos.size() ||
        table.layers.size() != depths.size())
        throw std::runtime_error(
            "attributes layer_phase_functions, layer_albedos and layer_optical_depths must have as "
            "many entries as each other");
    table.spherical_albedo_below =
        to_number("spherical_albedo_below", entry(metadata, "spherical_albedo_below"));
}

// What a table may have that a reader must know of: without it, it would look up wrong values.
constexpr const char* family_feature = "family";
constexpr const char* stack_feature = "stack";
constexpr const char* path_law_feature = "path_law";
const std::vector<std::string> known_features{family_feature, stack_feature, path_law_feature};

std::string features_of(const Table& table) {
    std::vector<std::string> features;
    if (table.has_family()) features.emplace_back(family_feature);
    if (table.is_stack()) features.emplace_back(stack_feature);
    if (table.path_law) features.emplace_back(path_law_feature);
    return joined(features, " ");
}

std::string stored_features(const Metadata& metadata) {
    const auto found = metadata.find("features");
    return found == metadata.end() ? "" : found->second;
}

/// Refuses features that the other attributes do not describe, and the other way round.
void check_features(const Metadata& metadata, const Table& table) {
    const std::string stored = stored_features(metadata), described = features_of(table);
    if (stored != described)
        throw std::runtime_error("attribute features must be \"" + described +
                                 "\", as the other attributes say, got " + shown(stored));
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
    const auto listed = metadata.find("family");
    std::istringstream names(listed == metadata.end() ? "" : listed->second);
    for (std::string name; table.family.size() <= max_family_axes && names >> name;) {
        const auto parameter = parameter_named(name);
        if (!parameter)
            throw std::runtime_error("attribute family must be of names out of " +
                                     joined(parameter_names()) + ", got " + shown(name));
        table.family.push_back({*parameter, {parameter_scale(*parameter), {}}, false});
    }
    if (table.has_family())
        table.extrapolation_lengths =
            to_numbers("extrapolation_lengths", entry(metadata, "extrapolation_lengths"));
    if (mixes_two(table.family))
        table.second_phase_function =
            read_phase_function("second_phase_function", entry(metadata, "second_phase_function"));
    else if (metadata.contains("second_phase_function"))
        throw std::runtime_error(
            "attribute second_phase_function needs mixture in attribute family");
}

/// With the path law all moments that matter to it: readers sum its orders.
std::vector<double> moments_to_store(const Table& table) {
    const std::vector<double> all =
        table.path_law ? significant_moments(table.phase_function) : std::vector<double>{};
    return table.phase_function.moments(std::max(stored_moments, static_cast<int>(all.size())));
}

/// What smooths the moments that the path law leaves out: b(l) is 1 up to the first, 0 from the
/// second on.
const std::vector<double> path_law_moments{PathLaw::first_smoothed, PathLaw::smooth_moments};

void read_path_law(const Metadata& metadata, Table& table) {
    if (!metadata.contains("path_law")) return;
    const std::string text = entry(metadata, "path_law");
    if (to_numbers("path_law", text) != path_law_moments)
        throw std::runtime_error("attribute path_law must be " + to_text(path_law_moments) +
                                 ", got " + shown(text));
    // Of a family lookups work it out at the very parameters.
    table.path_law = table.has_family() ? PathOrders::of_any(table.phase_function)
                                        : PathOrders::of(table.phase_function);
    if (!table.path_law)
        throw std::runtime_error("attribute path_law needs a phase function with a narrow peak");
}

void check_moments(const Metadata& metadata, const Table& table) {
    const PhaseFunction& phase_function = table.phase_function;
    const std::vector<double> expected = moments_to_store(table);
    const std::vector<double> stored = to_numbers("moments", entry(metadata, "moments"));
    bool same = stored.size() == expected.size() &&
                std::abs(to_number("asymmetry", entry(metadata, "asymmetry")) -
                         phase_function.asymmetry()) <= moment_tolerance;
    for (std::size_t l = 0; same && l < expected.size(); ++l)
        same = std::abs(stored[l] - expected[l]) <= moment_tolerance;
    if (!same)
        throw std::runtime_error(
            "attributes moments and asymmetry are not those of the phase function");
}

}  // namespace

std::string shown(std::string_view text) {
    constexpr std::size_t longest = 60;
    std::string result(text.substr(0, longest));
    std::replace_if(
        result.begin(), result.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    return '"' + result + (text.size() > longest ? "...\"" : "\"");
}

EntryType entry_type(const std::string& name) {
    const MetadataField* field = find_field(name);
    return field ? field->type : EntryType::text;
}

bool is_of_the_format(const std::string& name) { return find_field(name) != nullptr; }

Metadata metadata_of(const Table& table) {
    Metadata metadata = table.attributes;
    metadata["format"] = table_format_name;
    metadata["format_version"] = std::to_string(table_format_version);
    if (const std::string features = features_of(table); !features.empty())
        metadata["features"] = features;
    metadata["datasets"] = names_of_samples(table);
    metadata["phase_function"] = table.phase_function.text();
    add_lower_boundary(table.lower_boundary, metadata);
    add_layers(table, metadata);
    add_family(table, metadata);
    metadata["moments"] = to_text(moments_to_store(table));
    if (table.path_law) metadata["path_law"] = to_text(path_law_moments);
    metadata["asymmetry"] = shortest_text(table.phase_function.asymmetry());
    metadata["extrapolation_length"] = shortest_text(table.extrapolation_length);
    metadata["tolerance"] = shortest_text(table.tolerance);
    metadata["measured_error"] = shortest_text(table.measured_error);
    metadata["highest_order"] = std::to_string(table.highest_order);
    return metadata;
}

void check_format(const Metadata& metadata) {
    const auto format = metadata.find("format");
    const std::string wanted = std::string("is not a ") + table_format_name + " file: ";
    if (format == metadata.end()) throw std::runtime_error(wanted + "it has no attribute format");
    if (format->second != table_format_name)
        throw std::runtime_error(wanted + "its format is " + shown(format->second));

    const int version = to_integer("format_version", entry(metadata, "format_version"));
    if (version != table_format_version)
        throw std::runtime_error("attribute format_version must be " +
                                 std::to_string(table_format_version) + ", got " +
                                 std::to_string(version));
    std::istringstream features(stored_features(metadata));
    for (std::string feature; features >> feature;)
        if (std::ranges::find(known_features, feature) == known_features.end())
            throw std::runtime_error("attribute features must be of " + joined(known_features) +
                                     ", which this program knows, got " + shown(feature));
}

Table table_without_samples(const Metadata& metadata) {
    const auto number = [&](const char* name) { return to_number(name, entry(metadata, name)); };
    Table table;
    table.phase_function = read_phase_function("phase_function", entry(metadata, "phase_function"));
    table.lower_boundary = read_lower_boundary(metadata);
    read_layers(metadata, table);
    read_family(metadata, table);
    read_path_law(metadata, table);
    check_features(metadata, table);
    check_moments(metadata, table);
    table.extrapolation_length = number("extrapolation_length");
    table.tolerance = number("tolerance");
    table.measured_error = number("measured_error");
    table.highest_order = to_integer("highest_order", entry(metadata, "highest_order"));
    for (const auto& [name, text] : metadata)
        if (!find_field(name)) table.attributes[name] = text;
    return table;
}

std::vector<SampleField> listed_samples(const Metadata& metadata) {
    const std::string list = ' ' + entry(metadata, "datasets") + ' ';
    std::vector<SampleField> listed;
    for (const SampleField& field : sample_fields)
        if (list.find(std::string(" ") + field.name + ' ') != std::string::npos)
            listed.push_back(field);
    return listed;
}

void take_memory(const Table& table, const std::vector<SampleField>& listed,
                 std::uintmax_t file_size, MemoryLimit& limit) {
    std::uintmax_t bytes = 0;  // five times 8 GiB at most
    for (const SampleField& field : listed)
        bytes += sizeof(float) *
                 checked_count(field.name, extents(table, field.rank), sizeof(float), file_size);
    limit.take("the samples", bytes);
}

std::string checksum(std::span<const char> bytes) {
    return text_of_checksum(libdeflate_crc32(0, bytes.data(), bytes.size()));
}

std::string checksum(std::span<const float> values, const std::function<void()>& read) {
    constexpr std::size_t at_once = std::size_t{1} << 20;
    std::uint32_t sum = 0;
    for (; !values.empty(); values = values.subspan(std::min(at_once, values.size()))) {
        const std::span<const float> some = values.first(std::min(at_once, values.size()));
        sum = libdeflate_crc32(sum, some.data(), some.size_bytes());
        read();
    }
    return text_of_checksum(sum);
}

std::string checksum(std::span<const float> values) {
    return checksum(std::span(reinterpret_cast<const char*>(values.data()), values.size_bytes()));
}

std::string checksum(std::span<const double> values) {
    return checksum(std::span(reinterpret_cast<const char*>(values.data()), values.size_bytes()));
}

std::string checksum(const Metadata& metadata) {
    std::string canonical;
    for (const auto& [name, text] : metadata) {
        canonical.append(name).push_back('\0');
        canonical.append(text).push_back('\0');
    }
    return checksum(std::span<const char>(canonical));
}

std::optional<std::string> take(Metadata& metadata, const std::string& name) {
    const auto taken = metadata.extract(name);
    return taken ? std::optional(taken.mapped()) : std::nullopt;
}

void check_checksum(const std::string& what, const std::optional<std::string>& stored,
                    const std::string& computed) {
    if (!stored) throw NotAsSealed(what + " has no checksum");
    if (*stored != computed)
        throw NotAsSealed(what + " was changed or damaged since it was sealed (checksum " +
                          computed + ", sealed with " + shown(*stored) + ")");
}

std::size_t checked_count(const std::string& dataset, std::span<const std::size_t> extents,
                          std::size_t element_size, std::uintmax_t stored) {
    const std::size_t largest = max_dataset_bytes / element_size;
    std::size_t count = 1;
    for (const std::size_t extent : extents) {
        if (extent == 0) throw std::runtime_error(dataset + " is empty");
        if (extent > largest / count) throw std::runtime_error(dataset + " is larger than 8 GiB");
        count *= extent;
    }
    if (count * element_size / max_inflation > stored)
        throw std::runtime_error(dataset + " is larger than what the file holds");
    return count;
}

std::string to_text(std::span<const double> values) {
    std::string text;
    for (const double value : values) {
        if (!text.empty()) text += ' ';
        text += shortest_text(value);
    }
    return text;
}

double to_number(const std::string& what, std::string_view text) {
    const auto value = parse<double>(text);
    if (!value) throw std::runtime_error(what + " is not a number: " + shown(text));
    return *value;
}

int to_integer(const std::string& what, std::string_view text) {
    const auto value = parse<int>(text);
    if (!value) throw std::runtime_error(what + " is not an integer: " + shown(text));
    return *value;
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

const std::string& entry(const Metadata& metadata, const std::string& name) {
    const auto found = metadata.find(name);
    if (found == metadata.end()) throw std::runtime_error("attribute " + name + " is missing");
    return found->second;
}

void check_table(const Table& table, bool with_samples) {
    if (with_samples) check(table);
    for (const auto& [name, text] : table.attributes) {
        require(!name.empty() && name.size() <= max_attribute_name, "write_table",
                "an attribute's name", "1 to 200 bytes long", shown(name));
        require(name.find('\n') == std::string::npos, "write_table", "an attribute's name",
                "free of line breaks", shown(name));
        require(!find_field(name) && name != checksum_name && name != checksum_covers,
                "write_table", "an attribute's name", "one that the format does not reserve",
                shown(name));
        require((name + text).find('\0') == std::string::npos, "write_table",
                "attribute " + shown(name), "free of zero bytes", shown(text));
    }
}

}  // namespace stratus::io
