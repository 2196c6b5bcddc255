// TABLE.exr: the same table as float images, for renderers and GPUs that already read OpenEXR.
//
// One part for each dataset, with the same name, one channel Y of 32-bit floats and a data window
// that begins at 0, 0:
//
//     reflection_multiple,     one row of tiles per albedo, one column of tiles per optical depth;
//     transmission_multiple    in a tile row = mu_in, column = mu_out * azimuth_count + azimuth
//     plane_albedo,            row = albedo * optical_depth_count + optical_depth, column = mu_in
//     diffuse_transmittance
//     spherical_albedo         row = albedo, column = optical_depth
//
// Everything else is text in attributes; equal tables make equal files:
//
//     stratus:NAME            on the first part, an attribute NAME of the root of TABLE.h5, checksum
//                             included
//     dataset:NAME            on the first part, the numbers of an axis or of the diffusion
//                             exponent, separated by spaces
//     dataset:NAME.scale, dataset:NAME.units      on the first part
//     part:layout, part:checksum      on every part, the order of its samples and their checksum
//
// The metadata's checksum covers `stratus:` and `dataset:`. Headers are checked before OpenEXR
// reads them, because it allocates memory for any size that they give.
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
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <stdexcept>
#include <string>

namespace stratus::io {
namespace {

constexpr const char* channel_name = "Y";
constexpr const char* metadata_prefix = "stratus:";
constexpr const char* dataset_prefix = "dataset:";
constexpr const char* layout_attribute = "part:layout";
constexpr const char* checksum_attribute = "part:checksum";

/// OpenEXR counts the bytes of 16 rows of samples in an int.
constexpr std::size_t max_side = std::size_t{1} << 24;

/// OpenEXR inflates 32 rows of a part at once and holds three copies of them.
constexpr std::size_t rows_in_memory = 3 * 32;

// --- Table <-> picture ---

/// How samples over some axes are laid out.
struct Picture {
    std::vector<std::size_t> extents;
    std::size_t width, height;
    const char* layout;
};

/// Returns the picture of samples over the first axes. The pictures of all members of a family are stacked
/// vertically, as if there were that many more albedos.
Picture make_picture(const Table& table, std::size_t rank) {
    std::vector<std::size_t> n = extents(table, rank);
    for (std::size_t k = 0; k < table.family.size(); ++k) {
        n[1] *= n[0];
        n.erase(n.begin());
    }
    switch (rank) {
        case 2: return {n, n[1], n[0], "row = albedo, column = optical_depth"};
        case 3:
            return {n, n[2], n[0] * n[1],
                    "row = albedo * optical_depth_count + optical_depth, column = mu_in"};
        default:
            return {n, n[1] * n[3] * n[4], n[0] * n[2],
                    "tiles, one row of tiles per albedo, one column of tiles per optical_depth; "
                    "inside a tile row = mu_in, column = mu_out * azimuth_count + azimuth"};
    }
}

/// Samples in the order of the picture, which differs from the table's only over all five axes.
std::vector<float> to_picture(const std::vector<float>& samples, Extents n) {
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

/// Describes `pixels` to OpenEXR as the rows from `first_row` on.
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

// --- Headers, checked before OpenEXR reads them ---

void check_attribute(std::string_view type, std::string_view value) {
    static const std::set<std::string_view> types{"box2i", "chlist",    "compression", "float",
                                                  "int",   "lineOrder", "string",      "v2f"};
    if (!types.contains(type))
        throw std::runtime_error("a header has an attribute of an unsupported type");
    // One channel, its name one character, ended by an empty name.
    constexpr std::size_t one_channel = 19;
    if (type == "chlist" && (value.size() != one_channel || value[1] != '\0'))
        throw std::runtime_error("a part must have one channel, Y, of 32-bit floats");
}

/// Checks that a data window begins at 0, 0 and is no larger than what the file can be inflated to,
/// and counts the memory that OpenEXR needs to read it.
void check_window(std::string_view value, std::size_t file_size, MemoryLimit& limit) {
    std::array<std::int32_t, 4> corner;  // x and y of the first and of the last sample
    if (value.size() != sizeof corner) throw std::runtime_error("a data window is damaged");
    std::memcpy(corner.data(), value.data(), sizeof corner);
    if (corner[0] != 0 || corner[1] != 0 || corner[2] < 0 || corner[3] < 0)
        throw std::runtime_error("a data window must begin at 0, 0");
    const std::array<std::size_t, 2> sides{size(corner[2]) + 1, size(corner[3]) + 1};
    if (std::max(sides[0], sides[1]) > max_side)
        throw std::runtime_error("a data window must not be larger than " +
                                 std::to_string(max_side) + " on a side");
    checked_count("a data window", sides, sizeof(float), file_size);
    limit.take("a part", rows_in_memory * sides[0] * sizeof(float));
}

void check_headers(const Bytes& bytes, MemoryLimit& limit) {
    constexpr std::int32_t version = 2;
    constexpr std::int32_t long_names = 0x400;
    if ((HeaderReader(bytes).flags() & ~long_names & ~multi_part) != version)
        throw std::runtime_error("must be an OpenEXR file of scan lines, version 2");
    std::set<std::pair<int, std::string_view>> names;  // of each part
    for_each_attribute(
        bytes, [&](int part, std::string_view name, std::string_view type, std::string_view value) {
            if (!names.insert({part, name}).second)
                throw std::runtime_error("duplicate attribute " + shown_text(name));
            check_attribute(type, value);
            if (name == "dataWindow") check_window(value, bytes.size(), limit);
            if (name == "type" && value != Imf::SCANLINEIMAGE)
                throw std::runtime_error("a part must consist of scan lines");
        });
}

// --- Attributes ---

/// Everything about the table but its samples, by attribute name.
Metadata table_attributes(const Table& table, const Metadata& metadata) {
    const std::string dataset(dataset_prefix);
    Metadata texts;
    for (const auto& [name, text] : metadata) texts[metadata_prefix + name] = text;
    for (const AxisField& field : all_axis_fields(table)) {
        texts[dataset + field.name] = to_text(table_axis(table, field).values);
        texts[dataset + field.name + ".scale"] = stored_scale_name(field, table);
        texts[dataset + field.name + ".units"] = field.units;
    }
    texts[dataset + diffusion_exponent_name] = to_text(table.diffusion_exponent);
    return texts;
}

/// The text attributes of a header whose names begin with a prefix.
Metadata text_attributes(const Imf::Header& header, std::string_view prefix, bool keep_prefix) {
    Metadata texts;
    for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
        const std::string_view name = attribute.name();
        const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute.attribute());
        if (text && name.starts_with(prefix))
            texts[std::string(keep_prefix ? name : name.substr(prefix.size()))] = text->value();
    }
    return texts;
}

Metadata read_metadata(const Imf::Header& header, bool ignore_checksums) {
    Metadata metadata = text_attributes(header, metadata_prefix, false);
    check_format(metadata);
    metadata.erase(checksum_name);

    Metadata covered = text_attributes(header, metadata_prefix, true);
    covered.merge(text_attributes(header, dataset_prefix, true));
    const auto stored = take(covered, std::string(metadata_prefix) + checksum_name);
    if (!ignore_checksums) check_checksum("the metadata", stored, checksum(covered));
    return metadata;
}

void read_axes(const Imf::Header& header, Table& table) {
    const Metadata texts = text_attributes(header, dataset_prefix, false);
    for (const AxisField& field : all_axis_fields(table)) {
        const std::string name = field.name;
        read_scale(field, table, entry(texts, name + ".scale"));
        table_axis(table, field).values = to_numbers(name, entry(texts, name));
    }
    table.diffusion_exponent =
        to_numbers(diffusion_exponent_name, entry(texts, diffusion_exponent_name));
}

// --- Parts ---

/// The header of one part. All parts of a file have the same display window.
Imf::Header part_header(const SampleField& field, const std::string& layout, const Picture& picture,
                        const Picture& display, const std::vector<float>& samples) {
    const auto window = [](const Picture& s) {
        return Imath::Box2i({0, 0},
                            {static_cast<int>(s.width) - 1, static_cast<int>(s.height) - 1});
    };
    Imf::Header header(window(display), window(picture));
    header.setName(field.name);
    header.setType(Imf::SCANLINEIMAGE);
    header.compression() = Imf::PIZ_COMPRESSION;
    header.channels().insert(channel_name, Imf::Channel(Imf::FLOAT));
    header.insert(layout_attribute, Imf::StringAttribute(layout));
    header.insert(checksum_attribute,
                  Imf::StringAttribute(checksum(std::as_bytes(std::span(samples)))));
    return header;
}

std::vector<Imf::Header> make_headers(const Table& table, const Metadata& metadata,
                                      const std::vector<SampleField>& fields) {
    const Picture display = make_picture(table, fields.front().rank);
    const std::string family_layout = !table.has_family() ? ""
                                      : is_mixture(table.family)
                                          ? "one picture per mixture, one beneath the other: "
                                          : "one picture per member, one beneath the other: ";
    std::vector<Imf::Header> headers;
    for (const SampleField& field : fields) {
        const Picture picture = make_picture(table, field.rank);
        if (std::max(picture.width, picture.height) > max_side)
            throw std::runtime_error(std::string(field.name) + " is too large for a picture, " +
                                     std::to_string(picture.width) + " x " +
                                     std::to_string(picture.height));
        headers.push_back(part_header(field, family_layout + picture.layout, picture, display,
                                      table.*field.samples));
    }
    Metadata texts = table_attributes(table, metadata);
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

void check_part(const Imf::Header& header, const std::string& name, const Picture& picture) {
    const Imath::Box2i& window = header.dataWindow();
    if (size(window.max.x) + 1 != picture.width || size(window.max.y) + 1 != picture.height)
        throw std::runtime_error("data window of " + name + " does not match its axes");
    if (header.compression() != Imf::PIZ_COMPRESSION)
        throw std::runtime_error(name + " must have PIZ compression");
    auto channel = header.channels().begin();
    if (channel == header.channels().end() || std::string_view(channel.name()) != channel_name ||
        channel.channel().type != Imf::FLOAT || channel.channel().xSampling != 1 ||
        channel.channel().ySampling != 1 || ++channel != header.channels().end())
        throw std::runtime_error(name + " must have one channel, Y, of 32-bit floats");
}

/// Fills `pixels` with the rows of a part from `first` on.
void read_rows(Imf::InputPart& part, std::size_t width, std::size_t first,
               std::vector<float>& pixels) {
    part.setFrameBuffer(frame_buffer(pixels, width, first));
    part.readPixels(static_cast<int>(first), static_cast<int>(first + pixels.size() / width) - 1);
}

/// Reads one row of tiles at a time, so as to need no second copy of all samples.
void read_tiles(Imf::InputPart& part, std::size_t width, Extents n, MemoryLimit limit,
                std::vector<float>& samples) {
    const std::size_t run = n[3] * n[4];
    limit.take("a row of tiles", n[2] * width * sizeof(float));
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
                             const Picture& picture, const MemoryLimit& limit,
                             bool ignore_checksums) {
    const std::string name = field.name;
    const int number = find_part(file, name);
    const Imf::Header& header = file.header(number);
    check_part(header, name, picture);
    Imf::InputPart part(file, number);
    std::vector<float> samples(picture.width * picture.height);
    if (field.is_flux())
        read_rows(part, picture.width, 0, samples);
    else
        read_tiles(part, picture.width, picture.extents, limit, samples);
    if (!ignore_checksums) {
        Metadata texts = text_attributes(header, checksum_attribute, true);
        check_checksum(name, take(texts, checksum_attribute),
                       checksum(std::as_bytes(std::span(samples))));
    }
    return samples;
}

}  // namespace

void write_exr(const Table& table, const Metadata& metadata, const fs::path& path,
               const WriteOptions&) {
    const std::vector<SampleField> fields = listed_samples(metadata);
    const std::vector<Imf::Header> headers = make_headers(table, metadata, fields);
    Imf::StdOSStream stream;  // in memory
    {
        Imf::MultiPartOutputFile file(stream, headers.data(), int_size(headers));
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const Picture picture = make_picture(table, fields[i].rank);
            std::vector<float> pixels = to_picture(table.*fields[i].samples, picture.extents);
            Imf::OutputPart part(file, static_cast<int>(i));
            part.setFrameBuffer(frame_buffer(pixels, picture.width));
            part.writePixels(static_cast<int>(picture.height));
        }
    }  // the destructor completes the file
    write_content(path, stream.str());
}

Table decode_exr(const Bytes& bytes, const ReadOptions& options) {
    MemoryLimit limit(options.max_memory);
    limit.take("the file", bytes.size());
    check_headers(bytes, limit);
    MemoryInput stream(bytes, "table");
    constexpr bool rebuild_missing_offsets = false;
    Imf::MultiPartInputFile file(stream, Imf::globalThreadCount(), rebuild_missing_offsets);

    const Metadata metadata = read_metadata(file.header(0), options.ignore_checksums);
    Table table = table_without_samples(metadata);
    read_axes(file.header(0), table);
    read_samples(table, metadata, bytes.size(), limit, [&](const SampleField& field) {
        return read_part(file, field, make_picture(table, field.rank), limit,
                         options.ignore_checksums);
    });
    return table;
}

}  // namespace stratus::io
