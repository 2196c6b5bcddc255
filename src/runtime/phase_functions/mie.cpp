#include <stratus/runtime/phase_functions/mie.h>

#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/number_text.h>

#include "../droplet_sizes.h"
#include "../mie_scattering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <mutex>

namespace stratus {
namespace {

constexpr const char* mie_caller = Mie::kind.name;

// ---- Droplets

void check(const Droplets& droplets) {
    const double radius = droplets.effective_radius, v = droplets.effective_variance;
    require(radius > 0 && std::isfinite(radius), mie_caller, "radius (um)", "above 0 and finite",
            radius);
    require(v == 0 || (v >= 1e-6 && v <= 0.5), mie_caller, "variance", "0 or in [1e-6, 0.5]", v);
    require(droplets.wavelength > 0 && std::isfinite(droplets.wavelength), mie_caller,
            "wavelength (um)", "above 0 and finite", droplets.wavelength);
    const std::complex<double> index = index_of_refraction(droplets);
    require(index.real() > 0 && index.real() <= 10, mie_caller, "real part of index", "in (0, 10]",
            index.real());
    require(index.imag() >= 0 && index.imag() <= 10, mie_caller,
            "imaginary part of index, which absorbs,", "in [0, 10]", index.imag());
    require(std::abs(index - 1.0) >= 1e-3, mie_caller, "index", "at least 1e-3 from 1",
            index.real());
    const double x = 2 * pi * radius / droplets.wavelength;
    require(x >= 1e-4, mie_caller, "2 pi radius / wavelength", "at least 1e-4", x);
    require(radii_of(droplets).max * x <= max_size_parameter, mie_caller,
            "2 pi radius / wavelength of the largest droplet", "at most 5000",
            radii_of(droplets).max * x);
}

// ---- Values between angles

constexpr int points = 8;              // of the polynomial between samples
constexpr std::size_t beyond_end = 4;  // samples that it needs beyond either end

/// Values of a Legendre series at Theta = pi i / intervals, i = 0 .. intervals.
std::vector<double> series_at_angles(const std::vector<double>& chi, std::size_t intervals) {
    std::vector<double> value(intervals + 1, 0.0);
    constexpr std::size_t width = 16;  // angles summed side by side
    for (std::size_t first = 0; first <= intervals; first += width) {
        double c[width], before[width] = {}, here[width], sum[width] = {};
        for (std::size_t j = 0; j < width; ++j) {
            c[j] = std::cos(pi * static_cast<double>(first + j) / static_cast<double>(intervals));
            here[j] = 1;
        }
        for (std::size_t l = 0; l < chi.size(); ++l) {
            const double order = static_cast<double>(l), share = order / (order + 1);
            const double factor = (2 * order + 1) * chi[l];
            for (std::size_t j = 0; j < width; ++j) {
                sum[j] += factor * here[j];
                const double along = c[j] * here[j];
                const double next = along + share * (along - before[j]);
                before[j] = here[j];
                here[j] = next;
            }
        }
        for (std::size_t j = 0; j < width && first + j <= intervals; ++j) value[first + j] = sum[j];
    }
    return value;
}

/// The polynomial through `points` values at 0, 1, ..., at t.
double lagrange(const double* value, double t) noexcept {
    double before[points], after[points];  // products of t - i, i on either side
    before[0] = after[points - 1] = 1;
    for (int i = 1; i < points; ++i) before[i] = before[i - 1] * (t - (i - 1));
    for (int i = points - 1; i > 0; --i) after[i - 1] = after[i] * (t - i);
    constexpr double inverse[points] = {-1.0 / 5040, 1.0 / 720, -1.0 / 240, 1.0 / 144,
                                        -1.0 / 144,  1.0 / 240, -1.0 / 720, 1.0 / 5040};
    double sum = 0;
    for (int i = 0; i < points; ++i) sum += inverse[i] * before[i] * after[i] * value[i];
    return sum;
}

// ---- Scattering

Mie::Scattering compute_scattering(const Droplets& droplets) {
    const std::complex<double> index = index_of_refraction(droplets);
    SphereScattering spheres = scattering_of(sizes_of(droplets), index);
    Mie::Scattering all;
    all.extinction_efficiency = spheres.total.extinction / spheres.total.area;
    all.albedo =
        index.imag() == 0 ? 1 : std::min(1.0, spheres.total.scattering / spheres.total.extinction);
    all.chi = std::move(spheres.moments);
    while (all.chi.size() > 1 && std::abs(all.chi.back()) < 1e-16) all.chi.pop_back();
    // Sixteen samples for each period of the shortest wave: eight of them to a polynomial leave
    // 1e-6 of that wave, and less of all others.
    const std::size_t intervals = std::max<std::size_t>(1024, 8 * all.chi.size());
    const std::vector<double> value = series_at_angles(all.chi, intervals);
    all.intervals = static_cast<double>(intervals);
    for (std::size_t i = beyond_end; i > 0; --i) all.value.push_back(value[i]);
    all.value.insert(all.value.end(), value.begin(), value.end());
    for (std::size_t i = 1; i <= beyond_end; ++i) all.value.push_back(value[intervals - i]);
    return all;
}

// ---- Text

double read_length(PhaseText& text, const std::string& parameter) {
    const std::string given = text.rest();
    const double length = text.number("mie: " + parameter);
    const std::string unit = text.name();
    if (unit == "um") return length;
    if (unit == "nm") return length / 1000;
    text.refuse("mie: " + parameter + " must have a unit, um or nm, as in " + parameter +
                "=0.55um, got '" + given + "'");
}

/// A word out of a few; returns its place among them.
std::size_t read_word(PhaseText& text, const std::string& parameter,
                      const std::array<const char*, 2>& allowed) {
    const std::string met = text.name();
    const auto found = std::find(allowed.begin(), allowed.end(), met);
    if (found == allowed.end())
        text.refuse("mie: " + parameter + " must be " + allowed[0] + " or " + allowed[1] +
                    ", got '" + met + "'");
    return static_cast<std::size_t>(found - allowed.begin());
}

/// `1.33` or `1.33+1e-6i`; a '+' without an i after its number belongs to what follows.
std::complex<double> read_index(PhaseText& text) {
    const double n = text.number("mie: index");
    PhaseText ahead = text;
    ahead.accept('+');
    double k;
    if (!ahead.accept_number(k) || !ahead.accept('i')) return n;
    text = ahead;
    return {n, k};
}

constexpr std::array<const char*, 2> distributions = {"gamma", "lognormal"};  // as in the enums
constexpr std::array<const char*, 2> materials = {"water", "ice"};

void read_value(PhaseText& text, const std::string& parameter, Droplets& droplets) {
    if (parameter == "radius") {
        droplets.effective_radius = read_length(text, parameter);
    } else if (parameter == "wavelength") {
        droplets.wavelength = read_length(text, parameter);
    } else if (parameter == "variance") {
        droplets.effective_variance = text.number("mie: variance");
    } else if (parameter == "distribution") {
        droplets.distribution =
            static_cast<Droplets::Distribution>(read_word(text, parameter, distributions));
    } else if (parameter == "material") {
        droplets.material = static_cast<Droplets::Material>(read_word(text, parameter, materials));
    } else {
        droplets.material = Droplets::Material::other;
        droplets.index = read_index(text);
    }
}

std::string index_text(std::complex<double> index) {
    return shortest_text(index.real()) +
           (index.imag() == 0 ? "" : "+" + shortest_text(index.imag()) + "i");
}

}  // namespace

/// What droplets scatter, computed when it is first asked for: a table that is only looked up has
/// the values that it needs.
class Mie::SharedScattering {
  public:
    explicit SharedScattering(const Droplets& droplets) : droplets_(droplets) {}

    const Scattering& get() const {
        std::call_once(computed_, [this] { scattering_ = compute_scattering(droplets_); });
        return scattering_;
    }

    /// That of the droplets of this text which live, or a new one. A scene reads the same text once
    /// a panel, and once more with its table.
    static std::shared_ptr<const SharedScattering> of(const Droplets& droplets,
                                                      const std::string& text) {
        static std::mutex mutex;
        static std::map<std::string, std::weak_ptr<const SharedScattering>> living;
        const std::lock_guard<std::mutex> lock(mutex);
        const auto found = living.find(text);
        if (found != living.end())
            if (auto shared = found->second.lock()) return shared;
        for (auto each = living.begin(); each != living.end();)
            each = each->second.expired() ? living.erase(each) : std::next(each);
        const auto fresh = std::make_shared<const SharedScattering>(droplets);
        living[text] = fresh;
        return fresh;
    }

  private:
    Droplets droplets_;
    mutable std::once_flag computed_;
    mutable Scattering scattering_{};
};

Mie::Mie(const Droplets& droplets_) : droplets(droplets_) {
    check(droplets);
    scattering_ = SharedScattering::of(droplets, parameter_text());
}

double Mie::albedo() const { return scattering_->get().albedo; }

double Mie::extinction_efficiency() const { return scattering_->get().extinction_efficiency; }

Mie Mie::read(PhaseText& text, const std::string& first) {
    Droplets droplets;
    std::vector<std::string> given;
    std::string parameter = first;
    for (;;) {
        if (std::find(given.begin(), given.end(), parameter) != given.end())
            text.refuse("mie: " + parameter + " must be given once, got it again");
        given.push_back(parameter);
        read_value(text, parameter, droplets);
        if (!text.accept(',')) break;
        parameter = text.parameter(mie_caller, kind.parameter_names());
    }
    const auto has = [&](const char* name) {
        return std::find(given.begin(), given.end(), name) != given.end();
    };
    if (!has("radius")) text.refuse("mie needs radius=..., as in radius=10um");
    if (has("material") && has("index"))
        text.refuse("mie: index must be absent where material is given, got both");
    return Mie(droplets);
}

std::string Mie::parameter_text() const {
    std::string text = "radius=" + shortest_text(droplets.effective_radius) +
                       "um,variance=" + shortest_text(droplets.effective_variance);
    if (droplets.effective_variance > 0)
        text += std::string(",distribution=") +
                distributions[static_cast<std::size_t>(droplets.distribution)];
    text += ",wavelength=" + shortest_text(droplets.wavelength) + "um";
    if (droplets.material == Droplets::Material::other)
        return text + ",index=" + index_text(droplets.index);
    return text + ",material=" + materials[static_cast<std::size_t>(droplets.material)];
}

double Mie::operator()(double c) const noexcept {
    const double sine = std::sqrt(std::max(0.0, (1 - c) * (1 + c)));
    const Scattering& scattering = scattering_->get();
    const double place = std::atan2(sine, c) / pi * scattering.intervals;
    const double cell = std::min(std::floor(place), scattering.intervals - 1);
    const std::size_t first = static_cast<std::size_t>(cell) + beyond_end + 1 - points / 2;
    return lagrange(&scattering.value[first], place - cell + points / 2 - 1);
}

std::vector<double> Mie::moments(std::size_t count) const {
    std::vector<double> first = scattering_->get().chi;
    first.resize(count, 0.0);
    return first;
}

std::string Mie::caption() const {
    const char* const what = droplets.material == Droplets::Material::water ? "water"
                             : droplets.material == Droplets::Material::ice ? "ice"
                                                                            : "";
    const std::string material = *what != '\0' ? what : "index " + index_text(droplets.index);
    return "Mie " + material + " " + short_number(droplets.effective_radius, 3) + " um at " +
           short_number(droplets.wavelength, 3) + " um";
}

}  // namespace stratus
