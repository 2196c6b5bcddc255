// Compares the path tracer's pictures with direct lookups.
//
//     check_pictures TABLE SUNLIT.ppm SUN FURNACE.ppm SKY
//
// SUNLIT has no sky, and light that bounced once; FURNACE has no sun. Prints nothing if they agree.
#include <stratus/base/constants.h>
#include <stratus/io/table_file.h>
#include <stratus/table/lookup.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

// The same as in the path tracer.
constexpr std::array albedo{1.0, 0.97, 0.9};
constexpr double half_width = 1.6;
const double root_half = std::sqrt(0.5), root_third = std::sqrt(1.0 / 3);

using stratus::infinity, stratus::pi;

struct Vector {
    double x, y, z;
};

/// Pixels by their coordinates to the right and up, in [-half_width, half_width].
class Picture {
  public:
    explicit Picture(const std::string& path) {
        std::ifstream file(path);
        std::string kind;
        double white = 0;
        file >> kind >> size_ >> size_ >> white;
        for (double value; file >> value;) value_.push_back(value / white);
        if (kind != "P3" || value_.size() != 3 * size_ * size_)
            throw std::runtime_error(path + " must be a square PPM picture, P3");
    }

    /// Mean of nine pixels around a point.
    double at(double right, double up, std::size_t channel) const {
        double sum = 0;
        for (const double r : {-1, 0, 1})
            for (const double u : {-1, 0, 1})
                sum += value(place(-up + u * pixel()), place(right + r * pixel()), channel);
        return sum / 9;
    }
    double value(std::size_t row, std::size_t column, std::size_t channel) const {
        return value_[3 * (row * size_ + column) + channel];
    }

    /// The middle of the pixel that a coordinate lies in.
    double middle(double coordinate) const {
        return ((static_cast<double>(place(coordinate)) + 0.5) / static_cast<double>(size_) * 2 -
                1) *
               half_width;
    }
    std::size_t size() const { return size_; }

  private:
    double pixel() const { return 2 * half_width / static_cast<double>(size_); }
    std::size_t place(double coordinate) const {
        return static_cast<std::size_t>((coordinate / half_width + 1) / 2 *
                                        static_cast<double>(size_));
    }
    std::size_t size_ = 0;
    std::vector<double> value_;
};

bool all_right = true;

void expect_within(const std::string& what, double met, double low, double high) {
    if (met >= low && met <= high) return;
    all_right = false;
    std::cerr << what << ": " << met << " is not in [" << low << ", " << high << "]\n";
}

/// Radiance towards the camera of a facet that faces the sun and sees nothing else.
double sunlit(const stratus::TableView& table, double w, double sun, const Vector& normal) {
    const double mu_in = (normal.x - normal.y + normal.z) * root_third;
    const double mu_out = (normal.z - normal.y) * root_half;
    if (mu_in <= 0) return 0;
    // Light travels along (-1, 1, -1), then along (0, -1, 1): the product of their parts along the facet.
    const double along = -2 * root_third * root_half + mu_in * mu_out;
    const double sines = std::sqrt((1 - mu_in * mu_in) * (1 - mu_out * mu_out));
    const double azimuth = std::acos(sines > 0 ? std::clamp(along / sines, -1.0, 1.0) : 1.0);
    const double R = stratus::reflection(table, w, infinity, {mu_in, mu_out, azimuth}).total();
    return sun * mu_in * R / pi;
}

/// Share of a white sky that a facet sends towards mu_out: midpoints, exact to 1e-3.
double share_of_sky(const stratus::TableView& table, double w, double mu_out) {
    constexpr int cosines = 100, azimuths = 20;
    double sum = 0;
    for (int i = 0; i < cosines; ++i)
        for (int k = 0; k < azimuths; ++k) {
            const double mu = (i + 0.5) / cosines;
            sum += 2 * mu / (cosines * azimuths) *
                   stratus::reflection(table, w, infinity, {mu, mu_out, (k + 0.5) * pi / azimuths})
                       .total();
        }
    return sum;
}

/// The sphere's normal at a point to the right and up of the picture's centre.
Vector normal_at(double right, double up) {
    const double towards = std::sqrt(1 - right * right - up * up);
    return {right, (up - towards) * root_half, (up + towards) * root_half};
}

void check_sunlit(const Picture& picture, const stratus::TableView& table, double sun) {
    // 0.5 %: binding adds a quarter of the table's 0.1 %, and pixels are as wide as 2 degrees.
    const auto expect_about = [](const std::string& what, double met, double expected) {
        expect_within(what, met, 0.995 * expected, 1.005 * expected);
    };
    struct Facet {
        const char* name;
        double right, up;
    };
    for (std::size_t c = 0; c < 3; ++c) {
        const std::string of = " in channel " + std::to_string(c);
        for (const Facet& at : {Facet{"top", 0, root_half}, Facet{"centre", 0, 0},
                                Facet{"sunny side", 0.6, 0.1}, Facet{"evening", -0.5, 0.5}}) {
            const Vector normal = normal_at(picture.middle(at.right), picture.middle(at.up));
            expect_about(at.name + of, picture.at(at.right, at.up, c),
                         sunlit(table, albedo[c], sun, normal));
        }
        expect_within("night" + of, picture.at(-0.8, 0.5, c), 0, 0);
        expect_within("shadow" + of, picture.at(-1.3, 0, c), 0, 0);
        expect_about("ground" + of, picture.at(1.3, -1, c),
                     sunlit(table, albedo[c], sun, {0, 0, 1}));
    }
}

void check_furnace(const Picture& picture, const stratus::TableView& table, double sky) {
    double sum = 0;
    for (std::size_t row = 0; row < picture.size(); ++row)
        for (std::size_t column = 0; column < picture.size(); ++column) {
            const double value = picture.value(row, column, 0);
            sum += value;
            // Without absorption as bright as the sky, but for the noise of 32 paths.
            expect_within("pixel in the furnace", value, 0.8 * sky, 1.2 * sky);
        }
    const double mean = sum / static_cast<double>(picture.size() * picture.size());
    expect_within("mean of the furnace", mean, 0.997 * sky, 1.003 * sky);
    for (const std::size_t c : {1u, 2u}) {
        const double expected = sky * share_of_sky(table, albedo[c], root_half);
        expect_within("top in the furnace", picture.at(0, root_half, c), 0.98 * expected,
                      1.02 * expected);
    }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        if (argc != 6) throw std::invalid_argument("five arguments are needed");
        const stratus::Table table = stratus::read_table(argv[1]);
        check_sunlit(Picture(argv[2]), table.view(), std::atof(argv[3]));
        check_furnace(Picture(argv[4]), table.view(), std::atof(argv[5]));
    } catch (const std::exception& error) {
        std::cerr << "check_pictures: " << error.what() << '\n';
        return 1;
    }
    return all_right ? 0 : 1;
}
