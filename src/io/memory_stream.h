// An OpenEXR stream of bytes in memory (see file_bytes.h for why), which are not copied.
#pragma once

#include <stratus/io/file_bytes.h>

#include <OpenEXR/ImfIO.h>

#include <algorithm>
#include <stdexcept>

namespace stratus::io {

class MemoryInput : public Imf::IStream {
  public:
    MemoryInput(const Bytes& bytes, const char* name) : Imf::IStream(name), bytes_(bytes) {}

    bool read(char to[], int count) override {
        const auto wanted = static_cast<std::size_t>(count);
        if (count < 0 || position_ > bytes_.size() || wanted > bytes_.size() - position_)
            throw std::runtime_error("file is truncated or damaged");
        std::copy_n(bytes_.data() + position_, wanted, to);
        position_ += wanted;
        return position_ < bytes_.size();
    }
    uint64_t tellg() override { return position_; }
    void seekg(uint64_t position) override { position_ = position; }

  private:
    const Bytes& bytes_;
    std::size_t position_ = 0;
};

}  // namespace stratus::io
