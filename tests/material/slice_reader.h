// A reader of slices, written from docs/exports.md: straight lines between even samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {

class SliceReader {
  public:
    explicit SliceReader(const std::string& bytes) : bytes_(bytes) {
        std::uint64_t length = 0;
        std::memcpy(&length, bytes.data(), sizeof length);
        header_ = bytes.substr(8, length);
        data_ = 8 + length;
    }

    bool has(const std::string& name) const {
        return header_.find('"' + name + "\":") != std::string::npos;
    }

    /// A string of "__metadata__".
    std::string text(const std::string& key) const {
        const std::string from = after(key);
        const std::size_t first = from.find('"') + 1;
        return from.substr(first, from.find('"', first) - first);
    }

    std::vector<std::size_t> shape(const std::string& name) const { return list(name, "shape"); }

    template <class Number>
    std::vector<Number> numbers(const std::string& name) const {
        const std::vector<std::size_t> offsets = list(name, "data_offsets");
        std::vector<Number> values((offsets.at(1) - offsets.at(0)) / sizeof(Number));
        std::memcpy(values.data(), &bytes_.at(data_ + offsets[0]), values.size() * sizeof(Number));
        return values;
    }

    /// A side, read once for many lookups.
    class Side {
      public:
        Side(const SliceReader& file, const std::string& name)
            : shape_(file.shape(name)), samples_(file.numbers<float>(name)) {
            if (shape_.size() != 4) throw std::runtime_error("shape");
        }

        double operator()(double mu_in, double mu_out, double azimuth,
                          std::size_t colour = 0) const {
            const double places[3] = {std::asin(std::sqrt(mu_in)) * 2 / pi_,
                                      std::asin(std::sqrt(mu_out)) * 2 / pi_, azimuth / pi_};
            std::array<std::size_t, 3> low;
            std::array<double, 3> share;
            for (std::size_t a = 0; a < 3; ++a) {
                const double at = places[a] * static_cast<double>(shape_[a + 1] - 1);
                low[a] = std::min(static_cast<std::size_t>(at), shape_[a + 1] - 2);
                share[a] = at - static_cast<double>(low[a]);
            }
            double sum = 0;
            for (std::size_t corner = 0; corner < 8; ++corner) {
                double weight = 1;
                std::size_t index = colour;
                for (std::size_t a = 0; a < 3; ++a) {
                    const std::size_t up = corner >> a & 1;
                    weight *= up ? share[a] : 1 - share[a];
                    index = index * shape_[a + 1] + low[a] + up;
                }
                sum += weight * static_cast<double>(samples_.at(index));
            }
            return sum / (mu_in + mu_out);
        }

      private:
        static constexpr double pi_ = 3.14159265358979323846;
        std::vector<std::size_t> shape_;
        std::vector<float> samples_;
    };

    Side side(const std::string& name) const { return {*this, name}; }

  private:
    std::string after(const std::string& name) const {
        const std::size_t at = header_.find('"' + name + "\":");
        if (at == std::string::npos) throw std::runtime_error(name + " is missing");
        return header_.substr(at + name.size() + 3);
    }

    std::vector<std::size_t> list(const std::string& name, const std::string& field) const {
        const std::string of = after(name);
        std::size_t at = of.find('[', of.find(field)) + 1;
        std::vector<std::size_t> numbers;
        for (const std::size_t end = of.find(']', at); at < end; ++at) {
            std::size_t length = 0;
            numbers.push_back(std::stoul(of.substr(at), &length));
            at += length;
        }
        return numbers;
    }

    std::string bytes_, header_;
    std::size_t data_;
};

}  // namespace stratus::test
