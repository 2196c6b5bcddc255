#include "table_content.h"

#include <stratus/base/number_text.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <libdeflate.h>

namespace stratus::io {

namespace {

static_assert(std::endian::native == std::endian::little, "checksums are of little-endian bytes");

/// Files of samples have these entries beside those of all formats.
constexpr std::array<MetadataEntry, 6> entries_of_samples{{
    {"format"},
    {"format_version", MetadataEntry::integer},
    {"datasets"},
    {"moments", MetadataEntry::numbers},
    {"asymmetry", MetadataEntry::number},
    {"path_law", MetadataEntry::numbers},
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

const MetadataEntry* find_entry(const std::string& name) {
    const MetadataEntry* const own = stratus::find_entry(entries_of_samples, name);
    return own ? own : stratus::find_entry(shared_entries, name);
}

std::string names_of_samples(const Table& table) {
    std::vector<std::string> names;
    for (const SampleField& field : sample_fields)
        if (!(table.*field.samples).empty()) names.emplace_back(field.name);
    return joined(names, " ");
}

/// With the path law all moments that matter to it: readers sum its orders.
std::vector<double> moments_to_store(const Table& table) {
    const std::vector<double> all =
        table.path_law ? significant_moments(table.phase_function) : std::vector<double>{};
    return table.phase_function.moments(std::max(stored_moments, int_size(all)));
}

/// Smoothing of the moments that the path law leaves out: b(l) is 1 up to the first, 0 from the
/// second on.
const std::vector<double> path_law_moments{PathLaw::first_smoothed, PathLaw::smooth_moments};

void read_path_law(const Metadata& metadata, Table& table) {
    if (!metadata.contains("path_law")) return;
    const std::string text = entry(metadata, "path_law");
    if (to_numbers("path_law", text) != path_law_moments)
        throw std::runtime_error("attribute path_law must be " + to_text(path_law_moments) +
                                 ", got " + shown_text(text));
    // Lookups of a family evaluate it at the chosen parameters.
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

MetadataEntry::Type entry_type(const std::string& name) {
    const MetadataEntry* const found = find_entry(name);
    return found ? found->type : MetadataEntry::text;
}

bool is_of_the_format(const std::string& name) { return find_entry(name) != nullptr; }

Metadata make_metadata(const Table& table) {
    Metadata metadata = shared_metadata(table);
    metadata["format"] = table_format_name;
    metadata["format_version"] = std::to_string(table_format_version);
    metadata["datasets"] = names_of_samples(table);
    metadata["moments"] = to_text(moments_to_store(table));
    if (table.path_law) metadata["path_law"] = to_text(path_law_moments);
    metadata["asymmetry"] = shortest_text(table.phase_function.asymmetry());
    return metadata;
}

void check_format(const Metadata& metadata) {
    const auto format = metadata.find("format");
    const std::string wanted = std::string("is not a ") + table_format_name + " file: ";
    if (format == metadata.end()) throw std::runtime_error(wanted + "it has no attribute format");
    if (format->second != table_format_name)
        throw std::runtime_error(wanted + "its format is " + shown_text(format->second));

    const int version = to_integer("format_version", entry(metadata, "format_version"));
    if (version != table_format_version)
        throw std::runtime_error("attribute format_version must be " +
                                 std::to_string(table_format_version) + ", got " +
                                 std::to_string(version));
    check_features_known(metadata);
}

Table table_without_samples(const Metadata& metadata) {
    Table table = table_of_metadata(metadata);
    read_path_law(metadata, table);
    check_features(metadata, table);
    check_moments(metadata, table);
    for (const auto& [name, text] : metadata)
        if (!is_of_the_format(name)) table.attributes[name] = text;
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

void read_samples(Table& table, const Metadata& metadata, std::uintmax_t file_size,
                  MemoryLimit& limit,
                  const std::function<std::vector<float>(const SampleField& field)>& read) {
    const std::vector<SampleField> listed = listed_samples(metadata);
    std::uintmax_t bytes = 0;  // five times 8 GiB at most
    for (const SampleField& field : listed)
        bytes += sizeof(float) *
                 checked_count(field.name, extents(table, field.rank), sizeof(float), file_size);
    limit.take("the samples", bytes);
    for (const SampleField& field : listed) table.*field.samples = read(field);
    prepare(table);
}

std::string checksum(std::span<const std::byte> bytes, const std::function<void()>& read) {
    constexpr std::size_t at_once = std::size_t{1} << 22;
    std::uint32_t sum = 0;
    while (!bytes.empty()) {
        const std::span<const std::byte> some = bytes.first(std::min(at_once, bytes.size()));
        sum = libdeflate_crc32(sum, some.data(), some.size());
        bytes = bytes.subspan(some.size());
        if (read) read();
    }
    char text[sizeof "crc32:xxxxxxxx"];
    std::snprintf(text, sizeof text, "crc32:%08x", static_cast<unsigned>(sum));
    return text;
}

std::string checksum(const Metadata& metadata) {
    std::string canonical;
    for (const auto& [name, text] : metadata) {
        canonical.append(name).push_back('\0');
        canonical.append(text).push_back('\0');
    }
    return checksum(std::as_bytes(std::span(canonical)));
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
                          computed + ", sealed with " + shown_text(*stored) + ")");
}

std::size_t checked_count(const std::string& dataset, Extents extents, std::size_t element_size,
                          std::uintmax_t stored) {
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

void check_table(const Table& table, bool with_samples) {
    if (with_samples) check(table);
    for (const auto& [name, text] : table.attributes) {
        require(!name.empty() && name.size() <= max_attribute_name, "write_table",
                "an attribute's name", "1 to 200 bytes long", shown_text(name));
        require(name.find('\n') == std::string::npos, "write_table", "an attribute's name",
                "free of line breaks", shown_text(name));
        require(!is_of_the_format(name) && name != checksum_name && name != checksum_covers,
                "write_table", "an attribute's name", "one that the format does not reserve",
                shown_text(name));
        require((name + text).find('\0') == std::string::npos, "write_table",
                "attribute " + shown_text(name), "free of zero bytes", shown_text(text));
    }
}

void read_scale(const AxisField& field, Table& table, const std::string& stored) {
    if (field.axis == nullptr && stored == discrete_scale_name) {
        table.family[field.family].is_discrete = true;
        return;
    }
    for (const AxisScale scale : field.scales) {
        if (stored != axis_scale_name(scale) &&
            (scale != AxisScale::linear || stored != mixture_scale_name))
            continue;
        table_axis(table, field).scale = scale;
        return;
    }
    throw std::runtime_error(std::string("scale of axis ") + field.name + " must be " +
                             allowed_scales(field) + ", got " + shown_text(stored));
}

}  // namespace stratus::io
