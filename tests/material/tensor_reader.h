// A reader of "tensor_file" materials, written from their layout: evaluates them as the renderers
// of measured materials do, over the half vector, by straight lines.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {

class TensorReader {
  public:
    struct Field {
        int type;
        std::vector<std::size_t> shape;
        std::vector<float> values;  // of 32-bit floats
        std::string text;           // of bytes
    };

    explicit TensorReader(const std::string& bytes) : bytes_(bytes) {
        if (bytes.substr(0, 14) != std::string("tensor_file\0\x01\0", 14))
            throw std::runtime_error("magic");
        std::size_t at = 18;
        for (std::uint32_t f = number<std::uint32_t>(14); f > 0; --f) {
            const std::size_t length = number<std::uint16_t>(at);
            const std::string name = bytes.substr(at + 2, length);
            at += 2 + length;
            const int dimensions = number<std::uint16_t>(at);
            Field& field = fields[name];
            field.type = number<std::uint8_t>(at + 2);
            const std::size_t offset = number<std::uint64_t>(at + 3);
            at += 11;
            std::size_t count = 1;
            for (int d = 0; d < dimensions; ++d, at += 8) {
                field.shape.push_back(number<std::uint64_t>(at));
                count *= field.shape.back();
            }
            if (offset + count * (field.type == 10 ? 4 : 1) > bytes.size())
                throw std::runtime_error(name + " is truncated");
            if (field.type == 1) field.text = bytes.substr(offset, count);
            if (field.type != 10) continue;
            field.values.resize(count);
            std::memcpy(field.values.data(), bytes.data() + offset, 4 * count);
        }
    }

    std::map<std::string, Field> fields;

    /// f of a band or colour; what is negative stays so, as in Mitsuba. Cosines are above 0; azimuth between the directions, both away from
    /// the surface.
    double operator()(double mu_o, double mu_i, double azimuth, std::size_t band = 0) const {
        const Half half(mu_o, mu_i, azimuth);
        const std::string name = fields.count("rgb") ? "rgb" : "spectra";
        const double value = interpolated(fields.at(name), mu_o, half, band);
        return value * constant("ndf") / (4 * constant("sigma") * mu_i);
    }

    /// Density per steradian with which a renderer draws wi.
    double pdf(double mu_o, double mu_i, double azimuth) const {
        const Half half(mu_o, mu_i, azimuth);
        const Field& luminance = fields.at("luminance");
        const std::size_t side = luminance.shape.back();
        const double cells = static_cast<double>((side - 1) * (side - 1));
        double sum = 0;  // of the bilinear function over the unit square
        for (std::size_t y = 0; y + 1 < side; ++y)
            for (std::size_t x = 0; x + 1 < side; ++x) {
                const auto mean = [&](double t) {
                    const Half at{(static_cast<double>(x) + 0.5) / static_cast<double>(side - 1),
                                  (static_cast<double>(y) + 0.5) / static_cast<double>(side - 1)};
                    return interpolated(luminance, t, at, 0);
                };
                sum += mean(mu_o) / cells;
            }
        const double area = 2 * pi_ * pi_ * half.x * std::sin(pi_ / 2 * half.x * half.x);
        return interpolated(luminance, mu_o, half, 0) / sum / (area * 4 * half.cosine);
    }

  private:
    static constexpr double pi_ = 3.14159265358979323846;

    /// Place of a half vector in the unit square, and its cosine to either direction.
    struct Half {
        double x, y, cosine = 0;

        Half(double u, double v) : x(u), y(v) {}
        Half(double mu_o, double mu_i, double azimuth) {
            const double so = std::sqrt(1 - mu_o * mu_o), si = std::sqrt(1 - mu_i * mu_i);
            double m[3] = {so + si * std::cos(azimuth), si * std::sin(azimuth), mu_o + mu_i};
            const double length = std::hypot(m[0], m[1], m[2]);
            for (double& component : m) component /= length;
            x = std::sqrt(std::atan2(std::hypot(m[0], m[1]), m[2]) * 2 / pi_);
            y = std::atan2(m[1], m[0]) / (2 * pi_) + 0.5;
            cosine = so * m[0] + mu_o * m[2];
        }
    };

    double constant(const std::string& name) const {
        const std::vector<float>& values = fields.at(name).values;
        if (std::ranges::adjacent_find(values, std::not_equal_to<>()) != values.end())
            throw std::runtime_error(name + " is not constant");
        return static_cast<double>(values.at(0));
    }

    double interpolated(const Field& field, double mu_o, const Half& half, std::size_t band) const {
        if (constant("vndf") != 1) throw std::runtime_error("vndf");
        const std::vector<float>& theta = fields.at("theta_i").values;
        const double angle = std::acos(mu_o);
        std::size_t t = 0;
        while (t + 2 < theta.size() && static_cast<double>(theta[t + 1]) <= angle) ++t;
        const double along =
            (angle - static_cast<double>(theta[t])) / static_cast<double>(theta[t + 1] - theta[t]);
        const std::size_t side = field.shape.back(),
                          bands = field.shape.size() == 5 ? field.shape[2] : 1;
        const double px = half.x * static_cast<double>(side - 1),
                     py = half.y * static_cast<double>(side - 1);
        const auto x = std::min(static_cast<std::size_t>(px), side - 2),
                   y = std::min(static_cast<std::size_t>(py), side - 2);
        double sum = 0;
        for (std::size_t dt = 0; dt < 2; ++dt)
            for (std::size_t dy = 0; dy < 2; ++dy)
                for (std::size_t dx = 0; dx < 2; ++dx)
                    sum += share(along, dt) * share(py - static_cast<double>(y), dy) *
                           share(px - static_cast<double>(x), dx) *
                           static_cast<double>(field.values.at(
                               (((t + dt) * bands + band) * side + y + dy) * side + x + dx));
        return sum;
    }

    static double share(double along, std::size_t end) { return end == 0 ? 1 - along : along; }

    template <class Number>
    Number number(std::size_t at) const {
        Number value;
        if (at + sizeof value > bytes_.size()) throw std::runtime_error("truncated");
        std::memcpy(&value, bytes_.data() + at, sizeof value);
        return value;
    }

    std::string bytes_;
};

}  // namespace stratus::test
