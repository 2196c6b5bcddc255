// exchange_tensors write FILE: writes a file of tensors for other languages to read.
// exchange_tensors list FILE: prints what a file of tensors of another language holds, sorted.
#include "base/mapped_tensors.h"

#include <stratus/base/tensor_file.h>

#include <cstdio>
#include <exception>
#include <fstream>
#include <string>
#include <vector>

namespace {

using namespace stratus;

void write(const char* path) {
    TensorWriter writer;
    writer.set("title", "\u03c4 \"8\"\\\n\t\U0001f308");
    std::vector<float> floats(6);
    for (std::size_t i = 0; i < floats.size(); ++i) floats[i] = 0.5f * static_cast<float>(i) - 1;
    writer.add("floats", {2, 3}, floats);
    writer.add("halves", {3}, std::vector<Half>{to_half(0.25f), to_half(-1), to_half(65504)});
    writer.add("doubles", {2, 1}, std::vector<double>{1.0 / 3, -1e300});
    writer.add("integers", {4}, std::vector<std::int32_t>{0, -1, 2147483647, -2147483647});
    writer.add("single", {}, std::vector<double>{7});
    const std::vector<char> bytes = writer.finish();
    std::ofstream(path, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

double value(double number) { return number; }
double value(Half number) { return to_float(number); }

template <class Number>
void print(const TensorFile& file, const std::string& name, const char* type) {
    const TensorOf<Number> numbers =
        file.numbers<Number>(name, file.tensor(name).shape.size(), Infinity::allowed);
    std::printf("%s %s [", name.c_str(), type);
    for (const std::size_t extent : numbers.shape) std::printf(" %zu", extent);
    std::printf(" ]");
    for (const Number number : numbers) std::printf(" %.17g", value(number));
    std::printf("\n");
}

void list(const char* path) {
    const MappedFile mapped(path);
    const TensorFile file(mapped.data(), mapped.bytes());
    for (const auto& [key, text] : file.strings())
        std::printf("%s = %s\n", key.c_str(), text.c_str());
    for (const auto& [name, tensor] : file.tensors()) switch (tensor.type) {
            case TensorType::f16: print<Half>(file, name, "F16"); break;
            case TensorType::f32: print<float>(file, name, "F32"); break;
            case TensorType::f64: print<double>(file, name, "F64"); break;
            case TensorType::i32: print<std::int32_t>(file, name, "I32"); break;
        }
}

}  // namespace

int main(int count, char** arguments) {
    try {
        if (count != 3) return 2;
        std::string(arguments[1]) == "write" ? write(arguments[2]) : list(arguments[2]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
