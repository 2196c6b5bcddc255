// A reader of SCATFUN tables, written from their layout: evaluates them as their renderer does, by
// cubic splines through four nodes of either cosine and a sum of cosines.
#pragma once

#include "../base/indices.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {

class FourierReader {
  public:
    explicit FourierReader(const std::string& bytes) : bytes_(bytes) {
        if (bytes.substr(0, 8) != std::string("SCATFUN\x01")) throw std::runtime_error("magic");
        if (number<std::uint32_t>(8) != 1) throw std::runtime_error("flags");
        const std::size_t nodes = number<std::uint32_t>(12);
        const std::size_t terms = number<std::uint32_t>(16);
        longest = static_cast<int>(number<std::uint32_t>(20));
        channels = static_cast<int>(number<std::uint32_t>(24));
        if (number<std::uint32_t>(28) != 1) throw std::runtime_error("bases");
        const std::size_t text_length = number<std::uint32_t>(32);
        if (number<std::uint32_t>(36) != 0 || number<std::uint32_t>(40) != 0)
            throw std::runtime_error("parameters");
        if (number<float>(44) != 1) throw std::runtime_error("eta");
        std::size_t at = 64;
        mu = numbers<float>(at, nodes);
        cdf = numbers<float>(at, nodes * nodes);
        places_ = numbers<std::int32_t>(at, 2 * nodes * nodes);
        terms_ = numbers<float>(at, terms);
        text = bytes.substr(at, text_length);
        if (at + text_length != bytes.size()) throw std::runtime_error("length");
    }

    std::vector<float> mu, cdf;
    int channels = 0, longest = 0;
    std::string text;

    int length(std::size_t o, std::size_t i) const { return place(o, i)[1]; }

    /// Mean over azimuth of f |mu_i| at a pair of nodes, of the first channel.
    float mean(std::size_t o, std::size_t i) const {
        return length(o, i) == 0 ? 0 : terms_.at(static_cast<std::size_t>(place(o, i)[0]));
    }

    /// f: one value, or red, green and blue.
    std::vector<double> operator()(double mu_o, double mu_i, double azimuth) const {
        const Spline outer = spline(mu_o), inner = spline(mu_i);
        std::vector<std::vector<double>> series(
            static_cast<std::size_t>(channels),
            std::vector<double>(static_cast<std::size_t>(longest)));
        for (int b = 0; b < 4; ++b)
            for (int a = 0; a < 4; ++a) {
                const double weight = outer.weight[static_cast<std::size_t>(b)] *
                                      inner.weight[static_cast<std::size_t>(a)];
                if (weight == 0) continue;
                const std::int32_t* const at = place(static_cast<std::size_t>(outer.first + b),
                                                     static_cast<std::size_t>(inner.first + a));
                for (int c = 0; c < channels; ++c)
                    for (int k = 0; k < at[1]; ++k)
                        series[static_cast<std::size_t>(c)][static_cast<std::size_t>(k)] +=
                            weight * static_cast<double>(terms_.at(
                                         static_cast<std::size_t>(at[0] + c * at[1] + k)));
            }
        std::vector<double> sums;
        for (const std::vector<double>& of : series) {
            double sum = 0;
            for (const auto k : indices(of))
                sum += of[k] * std::cos(static_cast<double>(k) * azimuth);
            sums.push_back(sum / std::abs(mu_i));
        }
        if (channels == 1) return sums;
        const double green = 1.39829 * sums[0] - 0.100913 * sums[2] - 0.297375 * sums[1];
        return {sums[1], green, sums[2]};
    }

    /// Light scattered out of a direction to both sides, from the integrals in the file.
    double albedo(double mu_o) const {
        const Spline outer = spline(mu_o);
        double sum = 0;
        for (int b = 0; b < 4; ++b) {
            const double weight = outer.weight[static_cast<std::size_t>(b)];
            if (weight == 0) continue;
            const auto row = static_cast<std::size_t>(outer.first + b);
            sum += weight * static_cast<double>(cdf.at(row * mu.size() + mu.size() - 1));
        }
        return 2 * 3.14159265358979323846 * sum;
    }

  private:
    struct Spline {
        int first;
        std::array<double, 4> weight;
    };

    const std::int32_t* place(std::size_t o, std::size_t i) const {
        return &places_.at(2 * (o * mu.size() + i));
    }

    double node(int k) const { return static_cast<double>(mu.at(static_cast<std::size_t>(k))); }

    /// Cubic Hermite on the interval that x is in, with slopes from the nodes' neighbours.
    Spline spline(double x) const {
        const int last = static_cast<int>(mu.size()) - 1;
        int k = 0;
        while (k < last - 1 && node(k + 1) <= x) ++k;
        const double width = node(k + 1) - node(k), t = (x - node(k)) / width;
        Spline spline{k - 1, {0, 0, 0, 0}};
        spline.weight[1] = (1 + 2 * t) * (1 - t) * (1 - t);
        spline.weight[2] = t * t * (3 - 2 * t);
        const auto add_slope = [&](int at, double weight) {
            const int before = at == 0 ? 0 : at - 1, after = at == last ? last : at + 1;
            const double per_value = weight * width / (node(after) - node(before));
            spline.weight[static_cast<std::size_t>(after - spline.first)] += per_value;
            spline.weight[static_cast<std::size_t>(before - spline.first)] -= per_value;
        };
        add_slope(k, t * (1 - t) * (1 - t));
        add_slope(k + 1, -t * t * (1 - t));
        return spline;
    }

    template <class Number>
    Number number(std::size_t at) const {
        Number value;
        if (at + sizeof value > bytes_.size()) throw std::runtime_error("truncated");
        std::memcpy(&value, bytes_.data() + at, sizeof value);
        return value;
    }

    template <class Number>
    std::vector<Number> numbers(std::size_t& at, std::size_t count) const {
        if (count > (bytes_.size() - at) / sizeof(Number)) throw std::runtime_error("truncated");
        std::vector<Number> values(count);
        std::memcpy(values.data(), bytes_.data() + at, count * sizeof(Number));
        at += count * sizeof(Number);
        return values;
    }

    std::string bytes_;
    std::vector<std::int32_t> places_;
    std::vector<float> terms_;
};

}  // namespace stratus::test
