#include <stratus/io/image.h>

#include "memory_stream.h"
#include "table_content.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTileDescription.h>
#include <OpenEXR/ImfVersion.h>

#include <cstdint>
#include <stdexcept>

namespace stratus {
namespace {

constexpr const char* channels[] = {"R", "G", "B"};

/// 2^14 on a side are 3 GB of floats.
constexpr int max_side = 1 << 14;

Imf::Slice channel(const Image& image, int c, const Imath::V2i& origin) {
    return Imf::Slice::Make(Imf::FLOAT, image.rgb.data() + c, origin, image.width, image.height,
                            3 * sizeof(float), 3 * sizeof(float) * size(image.width));
}

void write_file(Imf::Header header, const std::map<std::string, Imf::Slice>& slices,
                const fs::path& path) {
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer buffer;
    for (const auto& [name, slice] : slices) {
        header.channels().insert(name, Imf::Channel(slice.type));
        buffer.insert(name, slice);
    }
    Imf::StdOSStream stream;  // in memory
    {
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(buffer);
        file.writePixels(header.dataWindow().max.y + 1);
    }  // the destructor completes the file
    write_content(path, stream.str());
}

/// Checks the sizes of pictures before OpenEXR opens them, and counts the memory that it then takes for
/// a block of lines or a tile.
void check_headers(io::MemoryInput& stream, int version, io::MemoryLimit& limit) {
    constexpr std::uintmax_t lines = 256;  // of the largest blocks, those of DWAB
    constexpr std::uintmax_t copies = 3;   // compressed, inflated and between the two
    if (Imf::isNonImage(version)) throw std::runtime_error("a picture must not be deep");
    stream.seekg(2 * sizeof version);
    do {
        Imf::Header header;
        header.readFrom(stream, version);
        if (header.readsNothing()) break;
        const Imath::Box2i& window = header.dataWindow();
        const auto side = [](std::int64_t count) {
            if (count < 1 || count > max_side)
                throw std::runtime_error(
                    "width and height of a picture and of its tiles must be in [1, 16384]");
            return static_cast<std::uintmax_t>(count);
        };
        std::uintmax_t pixels = lines * side(std::int64_t{window.max.x} - window.min.x + 1);
        side(std::int64_t{window.max.y} - window.min.y + 1);
        if (header.hasTileDescription()) {
            const Imf::TileDescription& tile = header.tileDescription();
            pixels += side(tile.xSize) * side(tile.ySize);
        }
        const Imf::ChannelList& has = header.channels();
        for (auto channel = has.begin(); channel != has.end(); ++channel)
            limit.take("a block of the picture", copies * sizeof(float) * pixels);
    } while (Imf::isMultiPart(version));
    stream.seekg(0);
}

}  // namespace

void write_exr_image(const Image& image, const std::map<std::string, std::string>& attributes,
                     const fs::path& path, Alpha alpha) {
    Imf::Header header(image.width, image.height);
    for (const auto& [name, text] : attributes) header.insert(name, Imf::StringAttribute(text));
    std::map<std::string, Imf::Slice> slices;
    for (int c = 0; c < 3; ++c) slices[channels[c]] = channel(image, c, {0, 0});
    std::vector<float> ones(size(image.width), 1);  // one row for all
    if (alpha == Alpha::opaque)
        slices["A"] =
            Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(ones.data()), sizeof(float), 0);
    write_file(header, slices, path);
}

void write_exr_texels(const char* texels, int width, int height, bool halves,
                      const fs::path& path) {
    const Imf::PixelType type = halves ? Imf::HALF : Imf::FLOAT;
    const std::size_t bytes = halves ? 2 : 4;
    std::map<std::string, Imf::Slice> slices;
    for (const char* const name : {"R", "G", "B", "A"}) {
        slices[name] = Imf::Slice::Make(type, texels, {0, 0}, width, height, 4 * bytes,
                                        4 * bytes * size(width));
        texels += bytes;
    }
    write_file(Imf::Header(width, height), slices, path);
}

Image read_exr_image(const fs::path& path, std::uintmax_t max_memory) {
    return io::naming(path, [&] {
        io::MemoryLimit limit(max_memory);
        const io::Bytes bytes = io::read_bytes(path, exr_magic, "an OpenEXR", limit);
        io::for_each_attribute(bytes, [](auto...) {});  // refuses lengths beyond the file's end
        io::MemoryInput stream(bytes, "picture");
        check_headers(stream, io::HeaderReader(bytes).flags(), limit);
        Imf::InputFile file(stream);
        const Imath::Box2i window = file.header().dataWindow();
        const Imath::V2i size = window.max - window.min + Imath::V2i(1, 1);
        const Imf::ChannelList& has = file.header().channels();
        const bool grey = has.findChannel("Y") != nullptr;
        limit.take("the picture", 3 * sizeof(float) * static_cast<std::uintmax_t>(size.x) *
                                      static_cast<std::uintmax_t>(size.y));
        Image image(size.x, size.y);
        Imf::FrameBuffer buffer;
        for (int c = 0; c < (grey ? 1 : 3); ++c) {
            const char* const name = grey ? "Y" : channels[c];
            if (!has.findChannel(name))
                throw std::runtime_error("a picture must have channels R, G, B or Y");
            buffer.insert(name, channel(image, c, window.min));
        }
        file.setFrameBuffer(buffer);
        file.readPixels(window.min.y, window.max.y);
        if (grey)
            for (std::size_t k = 0; k < image.rgb.size(); k += 3)
                image.rgb[k + 1] = image.rgb[k + 2] = image.rgb[k];
        return image;
    });
}

}  // namespace stratus
