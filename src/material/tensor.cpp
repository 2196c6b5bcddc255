// "tensor_file" materials: reflection over the half vector, for renderers that read measured ones.
//
// The formats' own warp by visible microfacets is made the identity: ndf = 1, sigma = 1/4, vndf = 1.
// This leaves a table of f cos(theta_i) over theta_o and the half vector m,
//
//     theta_m = pi/2 x^2,  phi_m - phi_o = (2 y - 1) pi,  wi = 2 (wo . m) m - wo,
//
// joined by straight lines. Where wi is below the horizon, f(|mu_i|) mu_i continues it oddly. Samples
// there that lines from above the horizon end on are chosen for these lines, so that light that
// grazes is met, too, and nothing above the horizon is negative.
#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include "solved_stack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace stratus {
namespace {

constexpr int angle_count = 96, side = 96;
constexpr double least_luminance = 1e-7;  // of the largest, so that every direction may be drawn

/// Wavelengths in nm, and the colour of each: constant beyond the ends. Steps at 488 and 590 nm, 30
/// nm wide, are seen as red, green and blue within 0.04 of each, under D65.
struct Band {
    float wavelength;
    std::size_t colour;
};
const std::vector<Band> grey_bands{{550, 0}};
const std::vector<Band> colour_bands{{473, 2}, {503, 1}, {575, 1}, {605, 0}};

/// A half vector of the grid, and the incident direction that it stands for.
struct HalfVector {
    double mu_in, azimuth;  // mu_in < 0 below the horizon
    double cos_half;        // of the angle between the half vector and either direction
    double area;            // d(solid angle of m) / dx dy
};

HalfVector half_vector(double mu_out, double x, double y) {
    const double theta_m = pi / 2 * x * x, phi = (2 * y - 1) * pi;
    const double out_sine = std::sqrt((1 - mu_out) * (1 + mu_out));
    const double m[3] = {std::sin(theta_m) * std::cos(phi), std::sin(theta_m) * std::sin(phi),
                         std::cos(theta_m)};
    HalfVector half;
    half.cos_half = out_sine * m[0] + mu_out * m[2];
    const double in[3] = {2 * half.cos_half * m[0] - out_sine, 2 * half.cos_half * m[1],
                          2 * half.cos_half * m[2] - mu_out};
    half.mu_in = std::clamp(in[2], -1.0, 1.0);
    half.azimuth = std::atan2(std::abs(in[1]), -in[0]);  // 0: away from wo
    half.area = 2 * pi * pi * x * std::sin(theta_m);
    return half;
}

/// Over (theta, colour, y, x), and what directions are drawn by over (theta, y, x).
struct Grids {
    std::vector<float> values, luminance;
};

constexpr std::size_t grid_size = size(side) * side;

/// Returns the first sample of a theta and colour.
float* grid_start(std::vector<float>& values, std::size_t colours, std::size_t theta,
                  std::size_t colour) {
    return values.data() + (theta * colours + colour) * grid_size;
}

/// A place in the unit square, and its share in each of the four samples around it.
struct Place {
    std::array<std::size_t, 4> samples;
    std::array<double, 4> shares;

    Place(double x, double y) {
        const auto column =
                       std::min(static_cast<std::size_t>(x * (side - 1)), side - std::size_t{2}),
                   row = std::min(static_cast<std::size_t>(y * (side - 1)), side - std::size_t{2});
        const double right = x * (side - 1) - static_cast<double>(column),
                     down = y * (side - 1) - static_cast<double>(row);
        const std::size_t first = row * side + column;
        samples = {first, first + 1, first + side, first + side + 1};
        shares = {(1 - right) * (1 - down), right * (1 - down), (1 - right) * down, right * down};
    }

    double value(const float* grid) const {
        double sum = 0;
        for (std::size_t k = 0; k < 4; ++k)
            sum += shares[k] * static_cast<double>(grid[samples[k]]);
        return sum;
    }
};

/// Places of half vectors whose wi is on the horizon: eight for each row and column of samples.
std::vector<Place> horizon(double mu_out) {
    std::vector<Place> places;
    const double out_sine = std::sqrt((1 - mu_out) * (1 + mu_out));
    constexpr int count = 8 * (side - 1);
    for (int k = 0; k <= count; ++k) {
        const double at = static_cast<double>(k) / count;
        // mu_in = sin(theta_o) cos(phi) sin(2 theta_m) + mu_out cos(2 theta_m)
        const double cos_phi = std::cos((2 * at - 1) * pi);
        places.emplace_back(std::sqrt(std::atan2(mu_out, -out_sine * cos_phi) / pi), at);
        const double slope = -mu_out * std::cos(pi * at * at),
                     length = out_sine * std::sin(pi * at * at);
        if (std::abs(slope) > length) continue;
        const double turn = std::acos(slope / length) / (2 * pi);
        places.emplace_back(at, 0.5 - turn);
        places.emplace_back(at, 0.5 + turn);
    }
    return places;
}

/// The grids of one theta.
void fill(Grids& grids, const std::vector<ReflectionField>& colours, double mu_out, int t) {
    const std::size_t count = colours.size();
    float* const values = grid_start(grids.values, count, size(t), 0);
    float* const luminance = grids.luminance.data() + size(t) * grid_size;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const std::size_t at = size(y * side + x);
            const HalfVector half = half_vector(mu_out, x / (side - 1.0), y / (side - 1.0));
            const int place = angle_count - 1 - t;  // cosines ascend, angles do
            double sum = 0;
            for (std::size_t c = 0; c < count; ++c) {
                const double value =
                    colours[c](std::abs(half.mu_in), place, half.azimuth) / pi * half.mu_in;
                values[c * grid_size + at] = static_cast<float>(value);
                sum += value / static_cast<double>(count);
            }
            luminance[at] = static_cast<float>(std::max(0.0, sum) * 4 *
                                               std::max(0.0, half.cos_half) * half.area);
        }
    const float largest = *std::max_element(luminance, luminance + grid_size);
    const float least = std::max(static_cast<float>(least_luminance) * largest, 1e-30f);
    for (std::size_t at = 0; at < grid_size; ++at) luminance[at] = std::max(luminance[at], least);
}

/// Lines between samples lie off a curve by up to an eighth of its second difference, by a twelfth
/// in the mean. Taking that from every sample leaves a third of the error in the median.
void balance(std::vector<float>& values, std::size_t colours, const std::vector<float>& theta) {
    const std::vector<float> exact = values;
    const std::size_t step_t = colours * grid_size;
    for (std::size_t at = 0; at < values.size(); ++at) {
        const std::size_t x = at % side, y = at / side % side, t = at / step_t;
        const auto difference = [&](std::size_t before, std::size_t after) {
            return exact[before] - 2 * exact[at] + exact[after];
        };
        float sum = 0;
        if (x > 0 && x + 1 < side) sum += difference(at - 1, at + 1);
        const std::size_t start = at - y * side;  // the first y is the last once more
        sum += difference(start + (y == 0 ? side - 2 : y - 1) * side,
                          start + (y + 1 == side ? 1 : y + 1) * side);
        if (t > 0 && t + 1 < theta.size()) {
            const float below = theta[t] - theta[t - 1], above = theta[t + 1] - theta[t];
            const float slopes =
                (exact[at + step_t] - exact[at]) / above - (exact[at] - exact[at - step_t]) / below;
            sum += slopes * (below * below + above * above) / (below + above);
        }
        values[at] -= sum / 12;
    }
}

/// Chooses the samples of one theta and colour below the horizon that cells across it end on: least
/// squares of the relative errors of f cos at 4 x 4 places of these cells, as far as they lie above.
void meet_horizon(float* values, const ReflectionField& field, double mu_out, int out) {
    constexpr int parts = 4, rounds = 40;
    constexpr double least_cosine = 0.002;  // relative errors count less below it
    struct Known {
        Place place;
        double value, weight;
    };
    std::vector<char> crossed(grid_size), free(grid_size);
    for (const Place& place : horizon(mu_out)) crossed[place.samples[0]] = 1;
    std::vector<Known> known;
    for (std::size_t cell = 0; cell < grid_size; ++cell) {
        if (!crossed[cell]) continue;
        const auto place_in = [&](double right, double down) {
            return std::pair((static_cast<double>(cell % side) + right) / (side - 1),
                             (static_cast<double>(cell / side) + down) / (side - 1));
        };
        for (int k = 0; k < 4; ++k) {
            const auto [x, y] = place_in(k % 2, k / 2);
            free[cell + size(k % 2 + k / 2 * side)] = half_vector(mu_out, x, y).mu_in <= 0;
        }
        for (int k = 0; k < parts * parts; ++k) {
            const auto [x, y] = place_in((k % parts + 0.5) / parts, (k / parts + 0.5) / parts);
            const HalfVector half = half_vector(mu_out, x, y);
            if (half.mu_in <= 0) continue;
            const double f = field(half.mu_in, out, half.azimuth) / pi,
                         scale = f * (half.mu_in + least_cosine);
            if (scale > 0) known.push_back({{x, y}, f * half.mu_in, 1 / (scale * scale)});
        }
    }
    for (int round = 0; round < rounds; ++round) {
        std::vector<double> change(grid_size), weight(grid_size);
        for (const auto& [place, value, known_weight] : known) {
            const double missing = value - place.value(values);
            double free_share = 0;
            for (std::size_t k = 0; k < 4; ++k)
                if (free[place.samples[k]]) free_share += place.shares[k];
            for (std::size_t k = 0; k < 4; ++k) {
                if (!free[place.samples[k]]) continue;
                change[place.samples[k]] += known_weight * place.shares[k] * missing;
                weight[place.samples[k]] += known_weight * place.shares[k] * free_share;
            }
        }
        for (std::size_t at = 0; at < grid_size; ++at)
            if (weight[at] > 0) values[at] += static_cast<float>(change[at] / weight[at]);
    }
}

/// Lifts samples below the horizon until lines are negative nowhere on it, at thetas and eleven steps
/// between each two.
void lift(std::vector<float>& values, std::size_t colours, const std::vector<float>& theta) {
    constexpr int parts = 12;
    for (std::size_t step = 0; step <= parts * (theta.size() - 1); ++step) {
        const std::size_t t = std::min(step / parts, theta.size() - 2);
        const double along = static_cast<double>(step) / parts - static_cast<double>(t);
        const double mu_out = std::cos((1 - along) * static_cast<double>(theta[t]) +
                                       along * static_cast<double>(theta[t + 1]));
        const std::vector<Place> places = horizon(std::max(mu_out, grazing));
        for (std::size_t c = 0; c < colours; ++c) {
            const std::pair<float*, double> ends[] = {
                {grid_start(values, colours, t, c), 1 - along},
                {grid_start(values, colours, t + 1, c), along}};
            for (const Place& place : places) {
                double above = 0, below = 0;
                for (const auto& [grid, share] : ends)
                    for (std::size_t k = 0; k < 4; ++k) {
                        const double part =
                            share * place.shares[k] * static_cast<double>(grid[place.samples[k]]);
                        (part > 0 ? above : below) += std::abs(part);
                    }
                if (below <= above) continue;
                for (const auto& [grid, share] : ends)
                    for (const std::size_t at : place.samples)
                        if (share > 0 && grid[at] < 0)
                            grid[at] *= static_cast<float>(above / below);
            }
        }
    }
}

Grids make_grids(const Material& material, const std::vector<float>& theta,
                 const std::vector<double>& mu, const MaterialOptions& options) {
    const SolvedColours solved = solve_colours(material, mu, options);
    std::vector<ReflectionField> colours;
    for (std::size_t c = 0; c < solved.size(); ++c)
        colours.emplace_back(material.colours[c], solved[c], mu, options.threads);
    Grids grids{std::vector<float>(angle_count * colours.size() * grid_size),
                std::vector<float>(angle_count * grid_size)};
    const auto mu_at = [&](int t) { return mu[size(angle_count - 1 - t)]; };
    parallel_for(angle_count, options.threads, [&](int t) { fill(grids, colours, mu_at(t), t); });
    balance(grids.values, colours.size(), theta);
    parallel_for(angle_count, options.threads, [&](int t) {
        for (std::size_t c = 0; c < colours.size(); ++c)
            meet_horizon(grid_start(grids.values, colours.size(), size(t), c), colours[c], mu_at(t),
                         angle_count - 1 - t);
    });
    lift(grids.values, colours.size(), theta);
    return grids;
}

/// The colours of bands in place of colours.
std::vector<float> spread(const std::vector<float>& values, std::size_t colours,
                          const std::vector<Band>& bands) {
    std::vector<float> spectra;
    for (std::size_t t = 0; t < angle_count; ++t)
        for (const Band& band : bands) {
            const float* const first =
                values.data() + (t * colours + (colours == 1 ? 0 : band.colour)) * grid_size;
            spectra.insert(spectra.end(), first, first + grid_size);
        }
    return spectra;
}

/// Fields of a file, and their encoding.
class TensorBsdfFile {
  public:
    /// Numbers: float or std::uint8_t.
    template <class Number>
    void add(const std::string& name, const std::vector<std::uint64_t>& shape,
             const std::vector<Number>& values) {
        Encoder bytes;
        bytes.put(values);
        const std::uint8_t type = std::is_same_v<Number, float> ? 10 : 1;
        fields_.push_back({name, shape, type, bytes.finish()});
    }

    std::vector<char> encode() const {
        std::uint64_t offset = 18;
        for (const Field& field : fields_)
            offset += 2 + field.name.size() + 2 + 1 + 8 + 8 * field.shape.size();
        Encoder file;
        file.put(std::string_view("tensor_file\0\x01\0", 14));
        file.put(static_cast<std::uint32_t>(fields_.size()));
        for (const Field& field : fields_) {
            file.put(static_cast<std::uint16_t>(field.name.size()));
            file.put(std::string_view(field.name));
            file.put(static_cast<std::uint16_t>(field.shape.size()));
            file.put(field.type);
            file.put(offset);
            file.put(field.shape);
            offset += field.bytes.size();
        }
        for (const Field& field : fields_) file.put(field.bytes);
        return file.finish();
    }

  private:
    struct Field {
        std::string name;
        std::vector<std::uint64_t> shape;
        std::uint8_t type;
        std::vector<char> bytes;
    };

    std::vector<Field> fields_;
};

}  // namespace

MaterialFile make_tensor(const Material& material, bool rgb, const MaterialOptions& options) {
    MaterialFile file;
    note_transmission(material, file.notes);
    const std::vector<double> mu = ReflectionField::cosines(angle_count);
    std::vector<float> theta;
    for (int t = 0; t < angle_count; ++t)
        theta.push_back(
            static_cast<float>(pi / 2 * (1 - std::pow(1 - t / (angle_count - 1.0), 1.5))));

    const Grids grids = make_grids(material, theta, mu, options);
    const std::size_t colours = material.colours.size();

    TensorBsdfFile tensor;
    const std::string text = describe(material);
    tensor.add("description", {text.size()}, std::vector<std::uint8_t>(text.begin(), text.end()));
    tensor.add("jacobian", {1}, std::vector<std::uint8_t>{1});
    tensor.add("theta_i", {angle_count}, theta);
    tensor.add("phi_i", {1}, std::vector<float>{0});
    tensor.add("ndf", {2, 2}, std::vector<float>(4, 1));
    tensor.add("sigma", {2, 2}, std::vector<float>(4, 0.25f));
    tensor.add("vndf", {1, angle_count, 2, 2}, std::vector<float>(4 * angle_count, 1));
    tensor.add("luminance", {1, angle_count, side, side}, grids.luminance);
    if (rgb) {
        tensor.add("rgb", {1, angle_count, 3, side, side},
                   spread(grids.values, colours, {{0, 0}, {0, 1}, {0, 2}}));
    } else {
        const std::vector<Band>& bands = colours == 1 ? grey_bands : colour_bands;
        std::vector<float> wavelengths;
        for (const Band& band : bands) wavelengths.push_back(band.wavelength);
        tensor.add("wavelengths", {bands.size()}, wavelengths);
        tensor.add("spectra", {1, angle_count, bands.size(), side, side},
                   spread(grids.values, colours, bands));
        if (colours == 3)
            file.notes.push_back("blue is up to 473 nm, green from 503 to 575, red from 605");
    }
    file.write = writing(tensor.encode());
    return file;
}

}  // namespace stratus
