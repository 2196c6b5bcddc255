// Each dataset of samples is one part of a multi-part file with one channel, Y. Everything else is
// text on the first part, in attributes named by what they are:
//
//     stratus:NAME      an entry of the metadata, checksum included
//     dataset:NAME      the numbers of an axis or of the diffusion exponent, separated by spaces
//     dataset:NAME.scale, dataset:NAME.units
//     part:layout, part:checksum      on every part, how its samples lie and their checksum
//
// The metadata's checksum covers the first three. Headers are gone through before OpenEXR sees
// them, because it takes memory for whatever size they name.
#include "memory_stream.h"
#include "table_content.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

namespace stratus::io {
namespace {

constexpr const char* channel_name = "Y";
constexpr std::string_view metadata_prefix = "stratus:";
constexpr std::string_view dataset_prefix = "dataset:";
constexpr const char* layout_attribute = "part:layout";
constexpr const char* checksum_attribute = "part:checksum";

/// OpenEXR counts the bytes of 16 rows of samples in an int.
constexpr std::size_t longest_side = std::size_t{1} << 24;

/// What OpenEXR keeps of a part while it inflates 32 rows of it: those rows three times.
constexpr std::size_t rows_at_once = 3 * 32;

// --- Table <-> picture ---

struct Size {
    std::size_t width, height;
};

/// Rows and columns that the samples over these axes take.
Size picture_size(std::span<const std::size_t> extents) {
    switch (extents.size()) {
        case 2: return {extents[1], extents[0]};
        case 3: return {extents[2], extents[0] * extents[1]};
        default: return {extents[1] * extents[3] * extents[4], extents[0] * extents[2]};
    }
}

std::string layout_text(std::size_t rank) {
    switch (rank) {
        case 2: return "row = albedo, column = optical_depth";
        case 3: return "row = albedo * optical_depth_count + optical_depth, column = mu_in";
        default:
            return "tiles, one row of tiles per albedo, one column of tiles per optical_depth; "
                   "inside a tile row = mu_in, column = mu_out * azimuth_count + azimuth";
    }
}

/// The sizes that a picture is laid out by: pictures of all mixtures, one beneath the other, have
/// the rows of as many more albedos.
std::vector<std::size_t> picture_extents(const Table& table, std::size_t rank) {
    std::vector<std::size_t> sizes = extents(table, rank);
    if (table.has_mixture()) {
        sizes[1] *= sizes[0];
        sizes.erase(sizes.begin());
    }
    return sizes;
}

/// Samples in the order of the picture: only those over all five axes lie otherwise in the table.
std::vector<float> to_picture(const std::vector<float>& samples, std::span<const std::size_t> n) {
    if (n.size() < 5) return samples;
    const std::size_t run = n[3] * n[4];
    std::vector<float> pixels;
    pixels.reserve(samples.size());
    for (std::size_t albedo = 0; albedo < n[0]; ++albedo)
        for (std::size_t mu_in = 0; mu_in < n[2]; ++mu_in)
            for (std::size_t depth = 0; depth < n[1]; ++depth) {
                const float* const from =
                    samples.data() + ((albedo * n[1] + depth) * n[2] + mu_in) * run;
                pixels.insert(pixels.end(), from, from + run);
            }
    return pixels;
}

/// Memory for the rows from `first_row` on.
Imf::FrameBuffer frame_buffer(std::vector<float>& pixels, std::size_t width,
                              std::size_t first_row = 0) {
    Imf::FrameBuffer buffer;
    buffer.insert(
        channel_name,
        Imf::Slice::Make(Imf::FLOAT, pixels.data(), {0, static_cast<int>(first_row)},
                         static_cast<int64_t>(width), static_cast<int64_t>(pixels.size() / width),
                         sizeof(float), sizeof(float) * width));
    return buffer;
}

// --- Headers, before OpenEXR sees them ---

/// Goes through bytes from the front and refuses to go beyond their end.
class Cursor {
  public:
    explicit Cursor(const Bytes& bytes) : rest_(bytes.data(), bytes.size()) {}

    std::string_view take(std::size_t count) {
        if (count > rest_.size()) throw std::runtime_error("a header is truncated or damaged");
        const std::string_view taken = rest_.substr(0, count);
        rest_.remove_prefix(count);
        return taken;
    }

    std::int32_t take_integer() {
        std::int32_t value;
        std::memcpy(&value, take(sizeof value).data(), sizeof value);
        return value;
    }

    /// Characters up to a zero byte, which is taken too.
    std::string_view take_name() {
        const std::string_view name = take(rest_.find('\0'));
        take(1);
        return name;
    }

    bool at_zero() const noexcept { return !rest_.empty() && rest_.front() == '\0'; }

  private:
    std::string_view rest_;
};

/// A type of attribute that a table's headers have. OpenEXR reads as many bytes as the type needs,
/// whatever length the file names: unless both agree it would take memory for lengths unchecked
/// here.
struct AttributeType {
    std::string_view name;
    std::size_t size;  // 0: any, the length that the file names
};

constexpr std::array<AttributeType, 8> attribute_types{{
    {"box2i", 16},
    {"chlist", 19},
    {"compression", 1},
    {"float", 4},
    {"int", 4},
    {"lineOrder", 1},
    {"string", 0},
    {"v2f", 8},
}};

void check_attribute(std::string_view type, std::string_view value) {
    const auto found = std::find_if(attribute_types.begin(), attribute_types.end(),
                                    [&](const AttributeType& known) { return known.name == type; });
    if (found == attribute_types.end())
        throw std::runtime_error("a header has an attribute of a type that no table has");
    if (found->size != 0 && value.size() != found->size)
        throw std::runtime_error("a header has an attribute of the wrong length");
    // One channel, its name one character, ended by an empty name.
    if (type == "chlist" && (value[0] == '\0' || value[1] != '\0' || value.back() != '\0'))
        throw std::runtime_error("a part must have one channel, Y, of 32-bit numbers");
}

/// Checks that a data window begins at 0, 0 and is no larger than what the file can be inflated to,
/// and counts what OpenEXR takes for it.
void check_window(std::string_view value, std::size_t file_size, MemoryLimit& limit) {
    std::array<std::int32_t, 4> corner;  // x and y of the first, then of the last sample
    if (value.size() != sizeof corner) throw std::runtime_error("a data window is damaged");
    std::memcpy(corner.data(), value.data(), sizeof corner);
    if (corner[0] != 0 || corner[1] != 0 || corner[2] < 0 || corner[3] < 0)
        throw std::runtime_error("a data window does not begin at 0, 0");
    const std::array<std::size_t, 2> sides{static_cast<std::size_t>(corner[2]) + 1,
                                           static_cast<std::size_t>(corner[3]) + 1};
    if (std::max(sides[0], sides[1]) > longest_side)
        throw std::runtime_error("a data window is larger than any table's");
    checked_count("a data window", sides, sizeof(float), file_size);
    limit.take("a part", rows_at_once * sides[0] * sizeof(float));
}

void check_attributes(Cursor& cursor, std::size_t file_size, MemoryLimit& limit) {
    std::set<std::string_view> names;
    while (!cursor.at_zero()) {
        const std::string_view name = cursor.take_name();
        if (!names.insert(name).second)
            throw std::runtime_error("attribute " + shown(name) + " is there twice");
        const std::string_view type = cursor.take_name();
        const std::int32_t size = cursor.take_integer();
        if (size < 0) throw std::runtime_error("a header is damaged");
        const std::string_view value = cursor.take(static_cast<std::size_t>(size));
        check_attribute(type, value);
        if (name == "dataWindow") check_window(value, file_size, limit);
        if (name == "type" && value != Imf::SCANLINEIMAGE)
            throw std::runtime_error("a part is not of scan lines");
    }
    cursor.take(1);
}

void check_headers(const Bytes& bytes, MemoryLimit& limit) {
    constexpr std::int32_t version = 2;
    constexpr std::int32_t long_names = 0x400;
    constexpr std::int32_t multi_part = 0x1000;
    Cursor cursor(bytes);
    cursor.take(exr_magic.size());
    const std::int32_t flags = cursor.take_integer() & ~long_names;
    if (flags != version && flags != (version | multi_part))
        throw std::runtime_error("OpenEXR file is not one of scan lines, version 2");
    check_attributes(cursor, bytes.size(), limit);
    if (flags == version) return;
    while (!cursor.at_zero()) check_attributes(cursor, bytes.size(), limit);
}

// --- Attributes ---

using Texts = std::map<std::string, std::string>;

/// Everything about the table but its samples, by attribute name.
Texts attributes_of(const Table& table, const Metadata& metadata) {
    const std::string dataset(dataset_prefix);
    Texts texts;
    for (const auto& [name, text] : metadata) texts[std::string(metadata_prefix) + name] = text;
    for (const AxisField& field : axis_fields_of(table)) {
        const Axis& axis = table.*field.axis;
        texts[dataset + field.name] = to_text(axis.values);
        texts[dataset + field.name + ".scale"] = axis_scale_name(axis.scale);
        texts[dataset + field.name + ".units"] = field.units;
    }
    texts[dataset + diffusion_exponent_name] = to_text(table.diffusion_exponent);
    return texts;
}

/// The texts of a header that begin with a prefix, without it or with it.
Texts texts_of(const Imf::Header& header, std::string_view prefix, bool keep_prefix) {
    Texts texts;
    for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
        const std::string_view name = attribute.name();
        const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute.attribute());
        if (text && name.starts_with(prefix))
            texts[std::string(keep_prefix ? name : name.substr(prefix.size()))] = text->value();
    }
    return texts;
}

const std::string& part_text(const Imf::Header& header, const std::string& part, const char* name) {
    const auto* text = header.findTypedAttribute<Imf::StringAttribute>(name);
    if (!text) throw std::runtime_error(part + " lacks its attribute " + name);
    return text->value();
}

/// Metadata of a file whose checksum holds.
Metadata read_metadata(const Imf::Header& header) {
    Metadata metadata = texts_of(header, metadata_prefix, false);
    check_format(metadata);
    metadata.erase(checksum_name);

    Texts covered = texts_of(header, metadata_prefix, true);
    covered.merge(texts_of(header, dataset_prefix, true));
    const std::string name = std::string(metadata_prefix) + checksum_name;
    const std::string stored = entry(covered, name);
    covered.erase(name);
    check_checksum("the metadata", stored, checksum(covered));
    return metadata;
}

void read_axes(const Imf::Header& header, const Metadata& metadata, Table& table) {
    const Texts texts = texts_of(header, dataset_prefix, false);
    const std::vector<AxisField> axes = axis_fields_of(metadata);
    if (axes.size() == axis_fields.size() && texts.contains(mixture_field.name))
        entry(metadata, "second_phase_function");  // refuses: none is there
    for (const AxisField& field : axes) {
        const std::string name = field.name;
        Axis& axis = table.*field.axis;
        check_scale(name, axis, entry(texts, name + ".scale"));
        axis.values = to_numbers(name, entry(texts, name));
    }
    table.diffusion_exponent =
        to_numbers(diffusion_exponent_name, entry(texts, diffusion_exponent_name));
}

// --- Parts ---

/// Header of one part; all parts of a file share the display window.
Imf::Header part_header(const SampleField& field, const std::string& layout, const Size& size,
                        const Size& display, const std::vector<float>& samples) {
    const auto window = [](const Size& s) {
        return Imath::Box2i({0, 0},
                            {static_cast<int>(s.width) - 1, static_cast<int>(s.height) - 1});
    };
    Imf::Header header(window(display), window(size));
    header.setName(field.name);
    header.setType(Imf::SCANLINEIMAGE);
    header.compression() = Imf::PIZ_COMPRESSION;
    header.channels().insert(channel_name, Imf::Channel(Imf::FLOAT));
    header.insert(layout_attribute, Imf::StringAttribute(layout));
    header.insert(checksum_attribute, Imf::StringAttribute(checksum(std::span(samples))));
    return header;
}

std::vector<Imf::Header> headers_of(const Table& table, const Metadata& metadata,
                                    const std::vector<SampleField>& fields) {
    const Size display = picture_size(picture_extents(table, fields.front().rank));
    const std::string of_mixture =
        table.has_mixture() ? "one picture per mixture, one beneath the other: " : "";
    std::vector<Imf::Header> headers;
    for (const SampleField& field : fields) {
        const Size size = picture_size(picture_extents(table, field.rank));
        if (std::max(size.width, size.height) > longest_side)
            throw std::runtime_error(std::string(field.name) + " is too large for a picture, " +
                                     std::to_string(size.width) + " x " +
                                     std::to_string(size.height));
        headers.push_back(part_header(field, of_mixture + layout_text(field.rank), size, display,
                                      table.*field.samples));
    }
    Texts texts = attributes_of(table, metadata);
    const std::string sum = checksum(texts);
    texts[std::string(metadata_prefix) + checksum_name] = sum;
    for (const auto& [name, text] : texts) headers.front().insert(name, Imf::StringAttribute(text));
    return headers;
}

int find_part(const Imf::MultiPartInputFile& file, const std::string& name) {
    for (int part = 0; part < file.parts(); ++part)
        if (file.header(part).hasName() && file.header(part).name() == name) return part;
    throw std::runtime_error("part " + name + " is missing");
}

void check_part(const Imf::Header& header, const std::string& name, const Size& size) {
    const Imath::Box2i& window = header.dataWindow();
    if (static_cast<std::size_t>(window.max.x) + 1 != size.width ||
        static_cast<std::size_t>(window.max.y) + 1 != size.height)
        throw std::runtime_error("data window of " + name + " is not that of its axes");
    if (header.compression() != Imf::PIZ_COMPRESSION)
        throw std::runtime_error(name + " is not compressed as a table is");
    auto channel = header.channels().begin();
    if (channel == header.channels().end() || std::string_view(channel.name()) != channel_name ||
        channel.channel().type != Imf::FLOAT || channel.channel().xSampling != 1 ||
        channel.channel().ySampling != 1 || ++channel != header.channels().end())
        throw std::runtime_error(name + " must have one channel, Y, of 32-bit numbers");
}

/// Fills `pixels` with the rows from `first` on.
void read_rows(Imf::InputPart& part, std::size_t width, std::size_t first,
               std::vector<float>& pixels) {
    part.setFrameBuffer(frame_buffer(pixels, width, first));
    part.readPixels(static_cast<int>(first), static_cast<int>(first + pixels.size() / width) - 1);
}

/// One row of tiles after the other, so that no second copy of the samples is needed.
void read_tiles(Imf::InputPart& part, std::size_t width, std::span<const std::size_t> n,
                MemoryLimit limit, std::vector<float>& samples) {
    const std::size_t run = n[3] * n[4];
    limit.take("a row of tiles", n[2] * width * sizeof(float));  // given back below
    std::vector<float> pixels(n[2] * width);
    auto into = samples.begin();
    for (std::size_t albedo = 0; albedo < n[0]; ++albedo) {
        read_rows(part, width, albedo * n[2], pixels);
        for (std::size_t depth = 0; depth < n[1]; ++depth)
            for (std::size_t mu_in = 0; mu_in < n[2]; ++mu_in)
                into = std::copy_n(pixels.data() + mu_in * width + depth * run, run, into);
    }
}

std::vector<float> read_part(Imf::MultiPartInputFile& file, const SampleField& field,
                             std::span<const std::size_t> extents, std::size_t file_size,
                             const MemoryLimit& limit) {
    const std::string name = field.name;
    const int number = find_part(file, name);
    const Imf::Header& header = file.header(number);
    const std::size_t count = checked_count(name, extents, sizeof(float), file_size);
    const Size size = picture_size(extents);
    check_part(header, name, size);
    Imf::InputPart part(file, number);
    std::vector<float> samples(count);
    if (extents.size() < 5)
        read_rows(part, size.width, 0, samples);
    else
        read_tiles(part, size.width, extents, limit, samples);
    check_checksum(name, part_text(header, name, checksum_attribute),
                   checksum(std::span<const float>(samples)));
    return samples;
}

}  // namespace

Bytes encode_exr(const Table& table, const Metadata& metadata) {
    const std::vector<SampleField> fields = listed_samples(metadata);
    const std::vector<Imf::Header> headers = headers_of(table, metadata, fields);
    Bytes bytes;
    MemoryOutput stream(bytes, "table");
    {
        Imf::MultiPartOutputFile file(stream, headers.data(), static_cast<int>(headers.size()));
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const std::vector<std::size_t> n = picture_extents(table, fields[i].rank);
            const Size size = picture_size(n);
            std::vector<float> pixels = to_picture(table.*fields[i].samples, n);
            Imf::OutputPart part(file, static_cast<int>(i));
            part.setFrameBuffer(frame_buffer(pixels, size.width));
            part.writePixels(static_cast<int>(size.height));
        }
    }  // only its end completes the file
    return bytes;
}

Table decode_exr(const Bytes& bytes, MemoryLimit limit, std::vector<std::string>* notes) {
    check_headers(bytes, limit);
    MemoryInput stream(bytes, "table");
    constexpr bool rebuild_missing_offsets = false;
    Imf::MultiPartInputFile file(stream, Imf::globalThreadCount(), rebuild_missing_offsets);

    Table table;
    const Metadata metadata = read_metadata(file.header(0));
    take_metadata(metadata, table);
    note_version(metadata, notes);
    read_axes(file.header(0), metadata, table);
    const std::vector<SampleField> listed = listed_samples(metadata);
    take_memory(table, listed, bytes.size(), limit);
    for (const SampleField& field : listed)
        table.*field.samples =
            read_part(file, field, picture_extents(table, field.rank), bytes.size(), limit);
    prepare(table);
    return table;
}

}  // namespace stratus::io
