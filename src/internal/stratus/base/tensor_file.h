// Named arrays of numbers and named strings in one file of the `safetensors` layout, which Python,
// JavaScript and Rust read with what they have:
//
//   8 bytes   length of the header, little-endian
//   header    JSON: {"__metadata__": {"key": "text", ...},
//                    "name": {"dtype": "F32", "shape": [2, 3], "data_offsets": [0, 24]}, ...}
//             and spaces; offsets count from the end of the header
//   data      little-endian, the last index fastest; one array after the other, without a gap
//
// Since readers refuse gaps, TensorWriter fills them with arrays of zeros named padding_1,
// padding_2, ..., so that every other array starts at a multiple of 64 bytes from the start of the
// file. Files of other writers may be aligned to no more than the numbers themselves.
//
// The string `checksum` is "crc32:" and the CRC-32 (of zlib and PNG) in eight hexadecimal digits of all other strings
// and of all tensors but those that fill gaps, either sorted by name, as these bytes one after the other:
// key, 0, text, 0; and name, 0, dtype, 0, the extents as 8 bytes each, the numbers.
//
// Such files come from strangers: TensorFile checks everything before it is used.
#pragma once

#include <stratus/base/half.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "files of tensors are read in place, which needs a little-endian machine"
#endif

namespace stratus {

constexpr const char* padding_prefix = "padding_";
constexpr const char* checksum_key = "checksum";

constexpr std::size_t max_tensor_header = std::size_t{16} << 20;  // bytes
constexpr std::size_t max_tensors = 100000;                       // and as many strings
constexpr std::size_t max_tensor_rank = 8;

enum class TensorType { f16, f32, f64, i32 };  // "F16", "F32", "F64", "I32"

template <class Number>
constexpr TensorType tensor_type() = delete;
template <>
constexpr TensorType tensor_type<Half>() {
    return TensorType::f16;
}
template <>
constexpr TensorType tensor_type<float>() {
    return TensorType::f32;
}
template <>
constexpr TensorType tensor_type<double>() {
    return TensorType::f64;
}
template <>
constexpr TensorType tensor_type<std::int32_t>() {
    return TensorType::i32;
}

/// Extents, the last one contiguous; none of a single number.
using TensorShape = std::vector<std::size_t>;

/// How many numbers a shape has: its product.
inline std::size_t element_count(const TensorShape& shape) noexcept {
    std::size_t count = 1;
    for (const std::size_t extent : shape) count *= extent;
    return count;
}

/// An array of numbers, in place.
struct Tensor {
    TensorType type;
    TensorShape shape;  // each at least 1
    const void* data;   // aligned to the size of a number

    std::size_t count() const noexcept { return element_count(shape); }
};

/// A tensor whose type and rank are known.
template <class Number>
struct TensorOf {
    const Number* data;
    TensorShape shape;

    std::size_t count() const noexcept { return element_count(shape); }
    const Number* begin() const noexcept { return data; }
    const Number* end() const noexcept { return data + count(); }
};

enum class Infinity { refused, allowed };

/// A text in quotation marks, with what JSON wants escaped.
std::string json_string(const std::string& utf8);

/// Whether a tensor's name says that it fills a gap.
bool fills_a_gap(const std::string& name);

class TensorFile {
  public:
    /// Reads the header, and refers to the numbers in `data`, which must outlive this object and
    /// all that it returns.
    ///
    /// Range    data: aligned to 8 bytes.
    /// Errors   std::invalid_argument: one sentence on what is wrong with the file.
    /// Cost     of the header alone.
    TensorFile(const void* data, std::size_t bytes);

    const std::map<std::string, std::string>& strings() const noexcept { return strings_; }
    const std::map<std::string, Tensor>& tensors() const noexcept { return tensors_; }
    bool has(const std::string& name) const noexcept { return tensors_.count(name) != 0; }

    /// Whether the file has a checksum, and strings and numbers are those that it was made of.
    ///
    /// Cost     of reading every number, some 2 ms a megabyte.
    bool is_intact() const;

    /// The string `key`.
    ///
    /// Errors   std::invalid_argument if there is none.
    const std::string& text(const std::string& key) const;

    /// Errors   std::invalid_argument if there is none.
    const Tensor& tensor(const std::string& name) const;

    /// The tensor `name`, each of whose numbers is looked at. Number: Half, float, double or
    /// std::int32_t.
    ///
    /// Errors   std::invalid_argument if there is none, for another type or rank, and for NaN, and
    ///          infinities unless allowed, among the numbers.
    template <class Number>
    TensorOf<Number> numbers(const std::string& name, std::size_t rank,
                             Infinity infinity = Infinity::refused) const {
        const Tensor& met = checked(name, tensor_type<Number>(), rank, infinity);
        return {static_cast<const Number*>(met.data), met.shape};
    }

  private:
    const Tensor& checked(const std::string& name, TensorType type, std::size_t rank,
                          Infinity infinity) const;

    std::map<std::string, std::string> strings_;
    std::map<std::string, Tensor> tensors_;
};

/// Collects copies of tensors and strings and lays them out as a file.
class TensorWriter {
  public:
    /// Adds a tensor, a copy of these numbers.
    ///
    /// Errors   std::invalid_argument for a name that is taken, "__metadata__", starts with
    ///          "padding_" or is not UTF-8, and for shapes that TensorFile refuses.
    template <class Number>
    void add(const std::string& name, const TensorShape& shape, const Number* data) {
        const std::size_t count = checked_count(name, shape);
        add(name, shape, std::vector<Number>(data, data + count));
    }

    /// Adds a tensor, which takes the numbers over; also refuses a shape that is not of as many.
    template <class Number>
    void add(const std::string& name, const TensorShape& shape, std::vector<Number> numbers) {
        require_count(name, shape, numbers.size());
        const auto held = std::make_shared<const std::vector<Number>>(std::move(numbers));
        refer(name, tensor_type<Number>(), shape, held->data());
        entries_.back().held = held;
    }

    /// Adds a tensor whose numbers stay where they are until finish() returns.
    void refer(const std::string& name, TensorType type, const TensorShape& shape,
               const void* data);

    /// Sets the string `key`; finish() overwrites that of the checksum.
    ///
    /// Errors   std::invalid_argument if either is not UTF-8.
    void set(const std::string& key, const std::string& text);

    /// The file: tensors in the order in which they were added. The writer lets go of them on the way,
    /// so that memory holds them once.
    ///
    /// Errors   std::invalid_argument for a longer header, more tensors or more strings than
    ///          TensorFile reads.
    std::vector<char> finish();

  private:
    struct Entry {
        std::string name;
        TensorType type;
        TensorShape shape;
        const char* data;
        std::size_t size;                  // bytes
        std::shared_ptr<const void> held;  // null: others keep the data
    };

    /// Returns how many numbers a new tensor has.
    std::size_t checked_count(const std::string& name, const TensorShape& shape) const;
    static void require_count(const std::string& name, const TensorShape& shape, std::size_t count);

    std::map<std::string, std::string> strings_;
    std::vector<Entry> entries_;
    std::set<std::string> names_;  // of the entries
};

}  // namespace stratus
