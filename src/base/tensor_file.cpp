#include <stratus/base/tensor_file.h>

#include <stratus/base/argument.h>

#include "mapped_tensors.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace stratus {
namespace {

constexpr std::size_t file_alignment = 64;  // bytes
constexpr char strings_key[] = "__metadata__";

struct TypeName {
    const char* name;
    std::size_t size;  // bytes of a number
};

/// One for each TensorType, in order.
constexpr TypeName type_names[] = {{"F16", 2}, {"F32", 4}, {"F64", 8}, {"I32", 4}};

const TypeName& type_name(TensorType type) { return type_names[static_cast<int>(type)]; }

/// How many numbers a shape has, at most `max`: `max` + 1 stands for more, or for a shape with a 0.
std::size_t count_up_to(std::size_t max, const TensorShape& shape) {
    std::size_t count = 1;
    for (const std::size_t number : shape) {
        if (number == 0 || count > max / number) return max + 1;
        count *= number;
    }
    return count;
}

constexpr std::size_t max_numbers = std::numeric_limits<std::size_t>::max() / 16;

/// Where the bytes of a tensor are, from the start of the data.
struct Extent {
    std::size_t begin, end;
    const std::string* name;
    Tensor* tensor;
};

Extent read_tensor(TensorHeaderReader& header, const std::string& name, Tensor& tensor) {
    const auto of = [&] { return " of tensor " + quoted(name); };
    std::set<std::string> given;
    std::vector<std::size_t> offsets;
    header.read_object([&](const std::string& field) {
        if (!given.insert(field).second) refuse_tensor_file(field + of(), "given once", "two");
        if (field == "dtype") {
            const std::string text = header.read_string();
            const TypeName* const found =
                std::find_if(std::begin(type_names), std::end(type_names),
                             [&](const TypeName& type) { return type.name == text; });
            if (found == std::end(type_names))
                refuse_tensor_file("dtype" + of(), "F16, F32, F64 or I32", quoted(text));
            tensor.type = static_cast<TensorType>(found - std::begin(type_names));
        } else if (field == "shape") {
            tensor.shape = header.read_integers(max_tensor_rank);
        } else if (field == "data_offsets") {
            offsets = header.read_integers(2);
        } else {
            refuse_tensor_file("a field" + of(), "dtype, shape or data_offsets", quoted(field));
        }
    });
    for (const char* const field : {"dtype", "shape", "data_offsets"})
        if (given.count(field) == 0) refuse_tensor_file(field + of(), "given", "none");
    if (offsets.size() != 2)
        refuse_tensor_file("data_offsets" + of(), "two numbers", list_text(offsets));
    return {offsets[0], offsets[1], &name, &tensor};
}

/// Checks one tensor of a file whose data take `data_bytes` from byte `data_start` on.
void require_extent(const Extent& extent, std::size_t data_start, std::size_t data_bytes) {
    const auto of = [&] { return " of tensor " + quoted(*extent.name); };
    const auto offsets = [&] { return list_text({extent.begin, extent.end}); };
    const TensorShape& shape = extent.tensor->shape;
    const TypeName& type = type_name(extent.tensor->type);
    if (extent.begin > extent.end)
        refuse_tensor_file("data_offsets" + of(), "in ascending order", offsets());
    if (extent.end > data_bytes)
        refuse_tensor_file("data_offsets" + of(),
                           "within the " + std::to_string(data_bytes) + " bytes of data",
                           offsets());
    if (std::count(shape.begin(), shape.end(), std::size_t{0}) != 0)
        refuse_tensor_file("shape" + of(), "of numbers of at least 1", list_text(shape));
    const std::size_t count = count_up_to(max_numbers, shape);
    if (count > max_numbers)
        refuse_tensor_file("shape" + of(), "of at most " + std::to_string(max_numbers) + " numbers",
                           list_text(shape));
    if (count * type.size != extent.end - extent.begin)
        refuse_tensor_file("data_offsets" + of(),
                           std::to_string(count * type.size) + " bytes apart, as its shape " +
                               list_text(shape) + " of " + type.name,
                           offsets());
    if ((data_start + extent.begin) % type.size != 0)
        refuse_tensor_file("the start" + of(),
                           "a multiple of " + std::to_string(type.size) + " bytes",
                           std::to_string(data_start + extent.begin));
}

/// Checks that each tensor begins where the one before it ends, and that the last ends the data.
void require_contiguous(std::vector<Extent>& extents, std::size_t data_bytes) {
    std::sort(extents.begin(), extents.end(),
              [](const Extent& one, const Extent& other) { return one.begin < other.begin; });
    std::size_t end = 0;
    for (const Extent& extent : extents) {
        if (extent.begin != end)
            refuse_tensor_file("data_offsets of tensor " + quoted(*extent.name),
                               "from " + std::to_string(end) + ", where the tensor before it ends",
                               list_text({extent.begin, extent.end}));
        end = extent.end;
    }
    if (end != data_bytes)
        refuse_tensor_file("the data", std::to_string(end) + " bytes, as its tensors",
                           std::to_string(data_bytes));
}

/// The index of the first number whose bits without their sign, which grow with the magnitude and are
/// largest for NaN, are beyond `largest`; `count` if there is none.
template <class Bits>
std::size_t find_beyond(Bits largest, const void* numbers, std::size_t count) {
    const auto is_beyond = [&](std::size_t i) {
        Bits bits;
        std::memcpy(&bits, static_cast<const char*>(numbers) + i * sizeof bits, sizeof bits);
        return static_cast<Bits>(bits & std::numeric_limits<Bits>::max()) > largest;
    };
    Bits beyond = 0;  // of the numbers' width and without a branch: looked at many at a time
    for (std::size_t i = 0; i < count; ++i)
        beyond = static_cast<Bits>(beyond | (is_beyond(i) ? 1 : 0));
    if (beyond == 0) return count;
    std::size_t first = 0;
    while (!is_beyond(first)) ++first;
    return first;
}

/// The index of the first number that is NaN or, unless allowed, infinite; their count if there is none.
std::size_t find_not_finite(const Tensor& tensor, Infinity infinity) {
    const int less = infinity == Infinity::allowed ? 0 : 1;  // than the bits of infinity
    const std::size_t count = tensor.count();
    switch (tensor.type) {
        case TensorType::f16:
            return find_beyond(static_cast<std::int16_t>(0x7c00 - less), tensor.data, count);
        case TensorType::f32: return find_beyond(0x7f800000 - less, tensor.data, count);
        case TensorType::f64:
            return find_beyond(std::int64_t{0x7ff0000000000000} - less, tensor.data, count);
        case TensorType::i32: break;
    }
    return count;
}

template <class Value>
const Value& found(const std::map<std::string, Value>& all, const char* kind,
                   const std::string& name) {
    const auto place = all.find(name);
    if (place == all.end()) refuse_tensor_file(kind + quoted(name), "in the file", "none");
    return place->second;
}

// ---- Checksum

/// CRC-32 of what is added, as of zlib and PNG.
class Checksum {
  public:
    void add(const void* data, std::size_t bytes) {
        const auto* const of = static_cast<const unsigned char*>(data);
        for (std::size_t i = 0; i < bytes; ++i)
            rest_ = rest_after_a_byte[(rest_ ^ of[i]) & 0xff] ^ rest_ >> 8;
    }
    /// A text and the zero byte that ends it.
    void add(const std::string& text) { add(text.c_str(), text.size() + 1); }

    std::string text() const {
        std::string text = "crc32:";
        for (int shift = 28; shift >= 0; shift -= 4)
            text += "0123456789abcdef"[(~rest_ >> shift) & 0xf];
        return text;
    }

  private:
    static constexpr auto rest_after_a_byte = [] {
        std::array<std::uint32_t, 256> all{};
        for (std::uint32_t byte = 0; byte < 256; ++byte) {
            std::uint32_t rest = byte;
            for (int bit = 0; bit < 8; ++bit)
                rest = (rest >> 1) ^ ((rest & 1) != 0 ? 0xedb88320u : 0u);
            all[byte] = rest;
        }
        return all;
    }();

    std::uint32_t rest_ = 0xffffffff;
};

void add_strings(Checksum& sum, const std::map<std::string, std::string>& strings) {
    for (const auto& [key, text] : strings) {
        if (key == checksum_key) continue;
        sum.add(key);
        sum.add(text);
    }
}

void add_tensor(Checksum& sum, const std::string& name, TensorType type, const TensorShape& shape,
                const void* data) {
    sum.add(name);
    sum.add(std::string(type_name(type).name));
    for (const std::size_t extent : shape) {
        const std::uint64_t wide = extent;
        sum.add(&wide, sizeof wide);
    }
    sum.add(data, element_count(shape) * type_name(type).size);
}

// ---- Writing

/// How many bytes are missing to a multiple of 64.
std::size_t padding_after(std::size_t bytes) {
    return (file_alignment - bytes % file_alignment) % file_alignment;
}

void append_bytes(std::vector<char>& bytes, const void* more, std::size_t count) {
    const char* const begin = static_cast<const char*>(more);
    bytes.insert(bytes.end(), begin, begin + count);
}

}  // namespace

bool fills_a_gap(const std::string& name) { return name.rfind(padding_prefix, 0) == 0; }

TensorFile::TensorFile(const void* data, std::size_t bytes) {
    require(reinterpret_cast<std::uintptr_t>(data) % tensor_header_start == 0, "TensorFile", "data",
            "aligned to 8 bytes", data);
    if (bytes < tensor_header_start)
        refuse_tensor_file("the file", "of at least 8 bytes", std::to_string(bytes));
    std::uint64_t length = 0;
    std::memcpy(&length, data, sizeof length);
    const std::size_t max_length = std::min(max_tensor_header, bytes - tensor_header_start);
    if (length > max_length)
        refuse_tensor_file("the length of the header",
                           "at most " + std::to_string(max_length) + " bytes",
                           std::to_string(length));
    const char* const header_begin = static_cast<const char*>(data) + tensor_header_start;
    const char* const data_begin = header_begin + length;
    const std::size_t data_start = tensor_header_start + static_cast<std::size_t>(length);
    if (length == 0 || *header_begin != '{')
        refuse_tensor_file("the header", "a JSON object from its first byte on",
                           length == 0 ? "nothing" : quoted(std::string(1, *header_begin)));

    bool has_strings = false;
    std::vector<Extent> extents;
    TensorHeaderReader header(header_begin, data_begin);
    header.read_object([&](const std::string& name) {
        if (name == strings_key) {
            if (has_strings) refuse_tensor_file(strings_key, "given once", "two");
            has_strings = true;
            header.read_object([&](const std::string& key) {
                if (strings_.size() == max_tensors)
                    refuse_tensor_file("the strings", "at most " + std::to_string(max_tensors),
                                       "more");
                if (!strings_.emplace(key, header.read_string()).second)
                    refuse_tensor_file("string " + quoted(key), "given once", "two");
            });
            return;
        }
        if (extents.size() == max_tensors)
            refuse_tensor_file("the tensors", "at most " + std::to_string(max_tensors), "more");
        const auto [place, is_new] = tensors_.emplace(name, Tensor{});
        if (!is_new) refuse_tensor_file("tensor " + quoted(name), "given once", "two");
        extents.push_back(read_tensor(header, place->first, place->second));
    });
    header.expect_end();

    for (const Extent& extent : extents) {
        require_extent(extent, data_start, bytes - data_start);
        extent.tensor->data = data_begin + extent.begin;
    }
    require_contiguous(extents, bytes - data_start);
}

bool TensorFile::is_intact() const {
    const auto stated = strings_.find(checksum_key);
    if (stated == strings_.end()) return false;
    Checksum sum;
    add_strings(sum, strings_);
    for (const auto& [name, tensor] : tensors_)
        if (!fills_a_gap(name)) add_tensor(sum, name, tensor.type, tensor.shape, tensor.data);
    return sum.text() == stated->second;
}

const std::string& TensorFile::text(const std::string& key) const {
    return found(strings_, "string ", key);
}

const Tensor& TensorFile::tensor(const std::string& name) const {
    return found(tensors_, "tensor ", name);
}

const Tensor& TensorFile::checked(const std::string& name, TensorType type, std::size_t rank,
                                  Infinity infinity) const {
    const Tensor& met = tensor(name);
    const auto described = [](TensorType of_type, std::size_t of_rank) {
        return type_name(of_type).name + std::string(" of rank ") + std::to_string(of_rank);
    };
    if (met.type != type || met.shape.size() != rank)
        refuse_tensor_file("tensor " + quoted(name), described(type, rank),
                           described(met.type, met.shape.size()));
    const std::size_t bad = find_not_finite(met, infinity);
    if (bad != met.count())
        refuse_tensor_file("tensor " + quoted(name),
                           infinity == Infinity::allowed ? "without NaN" : "finite",
                           "another number at index " + std::to_string(bad));
    return met;
}

void TensorWriter::require_count(const std::string& name, const TensorShape& shape,
                                 std::size_t count) {
    require(count == count_up_to(max_numbers, shape), "TensorWriter",
            "shape of tensor " + quoted(name), "of " + std::to_string(count) + " numbers",
            list_text(shape));
}

std::size_t TensorWriter::checked_count(const std::string& name, const TensorShape& shape) const {
    constexpr char function[] = "TensorWriter";
    require(names_.count(name) == 0 && name != strings_key && !fills_a_gap(name), function,
            "name of a tensor", "new and neither '__metadata__' nor 'padding_...'", quoted(name));
    require(is_utf8(name), function, "name of a tensor", "UTF-8", quoted(name));
    const std::size_t count = count_up_to(max_numbers, shape);
    require(shape.size() <= max_tensor_rank && count <= max_numbers, function,
            "shape of tensor " + quoted(name),
            "at most " + std::to_string(max_tensor_rank) + " numbers of at least 1",
            list_text(shape));
    return count;
}

void TensorWriter::refer(const std::string& name, TensorType type, const TensorShape& shape,
                         const void* data) {
    const std::size_t count = checked_count(name, shape);
    names_.insert(name);
    entries_.push_back(
        {name, type, shape, static_cast<const char*>(data), count * type_name(type).size, {}});
}

void TensorWriter::set(const std::string& key, const std::string& text) {
    require(is_utf8(key) && is_utf8(text), "TensorWriter", "string " + quoted(key), "UTF-8",
            quoted(text));
    strings_[key] = text;
}

std::vector<char> TensorWriter::finish() {
    Checksum sum;
    add_strings(sum, strings_);
    std::map<std::string, const Entry*> by_name;
    for (const Entry& entry : entries_) by_name[entry.name] = &entry;
    for (const auto& [name, entry] : by_name)
        add_tensor(sum, name, entry->type, entry->shape, entry->data);
    strings_[checksum_key] = sum.text();
    std::vector<std::string> strings, members;
    for (const auto& [key, text] : strings_)
        strings.push_back(json_string(key) + ':' + json_string(text));
    if (!strings.empty())
        members.push_back(json_string(strings_key) + ":{" + joined(strings, ",") + '}');
    std::size_t end = 0;
    const auto append_member = [&](const std::string& name, TensorType type,
                                   const TensorShape& shape, std::size_t size) {
        members.push_back(json_string(name) + ":{\"dtype\":\"" + type_name(type).name +
                          "\",\"shape\":" + list_text(shape) +
                          ",\"data_offsets\":" + list_text({end, end + size}) + '}');
        end += size;
    };
    std::size_t paddings = 0;
    for (const Entry& entry : entries_) {
        if (const std::size_t padding = padding_after(end); padding != 0)
            append_member(std::string(padding_prefix) + std::to_string(++paddings), TensorType::f16,
                          {padding / type_name(TensorType::f16).size}, padding);
        append_member(entry.name, entry.type, entry.shape, entry.size);
    }

    std::string header = '{' + joined(members, ",") + '}';
    header.append(padding_after(tensor_header_start + header.size()), ' ');
    require(header.size() <= max_tensor_header, "TensorWriter", "the header",
            "at most " + std::to_string(max_tensor_header) + " bytes", header.size());
    const auto require_few = [](const char* what, std::size_t count) {
        require(count <= max_tensors, "TensorWriter", what,
                "at most " + std::to_string(max_tensors), count);
    };
    require_few("the tensors with their padding", entries_.size() + paddings);
    require_few("the strings", strings_.size());

    const std::uint64_t length = header.size();
    std::vector<char> file;
    file.reserve(tensor_header_start + header.size() + end);
    append_bytes(file, &length, sizeof length);
    append_bytes(file, header.data(), header.size());
    for (Entry& entry : entries_) {
        file.insert(file.end(), padding_after(file.size()), '\0');
        append_bytes(file, entry.data, entry.size);
        entry.held = nullptr;
    }
    return file;
}

}  // namespace stratus
