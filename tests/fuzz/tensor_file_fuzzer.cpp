// Arbitrary bytes as a file of tensors are refused or read, every number of them.
#include "tensor_file.h"

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

void read_numbers(const stratus::TensorFile& file, const std::string& name) {
    using stratus::TensorType;
    const stratus::Tensor& tensor = file.tensor(name);
    const std::size_t rank = tensor.shape.size();
    switch (tensor.type) {
        case TensorType::f16: (void)file.numbers<stratus::Half>(name, rank); break;
        case TensorType::f32: (void)file.numbers<float>(name, rank); break;
        case TensorType::f64: (void)file.numbers<double>(name, rank); break;
        case TensorType::i32: (void)file.numbers<std::int32_t>(name, rank); break;
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::vector<std::uint8_t> bytes(data, data + size);  // aligned
    try {
        const stratus::TensorFile file(bytes.data(), bytes.size());
        for (const auto& named : file.tensors()) read_numbers(file, named.first);
    } catch (const std::invalid_argument&) {
    }
    return 0;
}
