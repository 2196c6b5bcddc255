#include <stratus/phase/mie.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "../mie_scattering.h"
#include "phase_text.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <mutex>
#include <utility>

namespace stratus {
namespace {

constexpr const char* mie_caller = Mie::kind.name;

// ---- Droplets

void check_size_rows(const std::vector<double>& radius, const std::vector<double>& number,
                     const RowName& row_name) {
    constexpr std::size_t most = 1000;
    require(radius.size() == number.size(), mie_caller, "number_per_um",
            "as many numbers as radius_um", number.size());
    require(radius.size() >= 2 && radius.size() <= most, mie_caller, "rows of a distribution",
            "2 to 1000", radius.size());
    for (std::size_t i = 0; i < radius.size(); ++i) {
        require(radius[i] >= 1e-4 && std::isfinite(radius[i]), mie_caller,
                "radius_um" + row_name(i), "at least 1e-4 and finite", radius[i]);
        require(i == 0 || radius[i] > radius[i - 1], mie_caller, "radius_um" + row_name(i),
                "above the one before it", radius[i]);
        require(number[i] >= 0 && std::isfinite(number[i]), mie_caller,
                "number_per_um" + row_name(i), "at least 0 and finite", number[i]);
    }
    require(*std::max_element(number.begin(), number.end()) > 0, mie_caller, "number_per_um",
            "above 0 somewhere", 0);
}

void check_sizes(const Droplets& droplets) {
    if (droplets.distribution == Droplets::Distribution::rows)
        return check_size_rows(droplets.radius, droplets.number, row_number);
    if (droplets.distribution == Droplets::Distribution::modified_gamma) {
        require(droplets.mode_radius > 0 && std::isfinite(droplets.mode_radius), mie_caller,
                "mode_radius (um)", "above 0 and finite", droplets.mode_radius);
        require_in("[0.1, 100]", mie_caller, "alpha", droplets.alpha);
        require_in("[0.25, 10]", mie_caller, "gamma", droplets.gamma);
        return;
    }
    const double radius = droplets.effective_radius, v = droplets.effective_variance;
    require(radius > 0 && std::isfinite(radius), mie_caller, "radius (um)", "above 0 and finite",
            radius);
    require(v == 0 || (v >= 1e-6 && v <= 0.5), mie_caller, "variance", "0 or in [1e-6, 0.5]", v);
}

void check(const Droplets& droplets) {
    check_sizes(droplets);
    require(droplets.wavelength > 0 && std::isfinite(droplets.wavelength), mie_caller,
            "wavelength (um)", "above 0 and finite", droplets.wavelength);
    require(droplets.index_wavelength == 0 || droplets.index_wavelength == droplets.wavelength,
            mie_caller, "wavelength (um)",
            shortest_text(droplets.index_wavelength) +
                ", the one at which index was read from a file (other wavelengths need a material, "
                "an index of their own or a phase function each)",
            droplets.wavelength);
    const std::complex<double> index = index_of_refraction(droplets);
    require_in("[0.01, 10]", mie_caller, "real part of index", index.real());
    require_in("[0, 10]", mie_caller, "imaginary part of index, which absorbs,", index.imag());
    require(std::abs(index - 1.0) >= 1e-3, mie_caller, "index", "at least 1e-3 from 1",
            index.real());
    const double x = 2 * pi * effective_size(droplets).radius / droplets.wavelength;
    require(x >= 1e-4, mie_caller, "2 pi radius / wavelength", "at least 1e-4", x);
    const double largest = radius_range(droplets).max * x;
    require(largest <= max_size_parameter, mie_caller,
            "2 pi radius / wavelength of the largest droplet", "at most 10000", largest);
}

// ---- Values between angles

constexpr int points = 8;              // of the polynomial between samples
constexpr std::size_t beyond_end = 4;  // samples that it needs beyond either end

/// Values of a Legendre series at Theta = pi i / intervals, i = 0 .. intervals.
std::vector<double> series_at_angles(const std::vector<double>& chi, std::size_t intervals) {
    std::vector<double> value(intervals + 1);
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
    SphereScattering spheres = sphere_scattering(sphere_sizes(droplets), index);
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

/// The numbers that a store keeps.
std::vector<double> to_numbers(const Mie::Scattering& all) {
    std::vector<double> numbers{all.albedo, all.extinction_efficiency, all.intervals,
                                static_cast<double>(all.chi.size())};
    numbers.insert(numbers.end(), all.chi.begin(), all.chi.end());
    numbers.insert(numbers.end(), all.value.begin(), all.value.end());
    return numbers;
}

Mie::Scattering from_numbers(const std::vector<double>& numbers) {
    const auto chi = numbers.begin() + 4, value = chi + static_cast<std::ptrdiff_t>(numbers[3]);
    return {numbers[0], numbers[1], {chi, value}, {value, numbers.end()}, numbers[2]};
}

Mie::Store& scattering_store() {
    static Mie::Store store;
    return store;
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

/// True where a parameter's value ends.
bool value_ends(PhaseText& text) { return text.at_end() || text.next_is(',') || text.next_is('+'); }

/// A word out of a few; returns its place among them, or nothing, and reads nothing.
std::optional<std::ptrdiff_t> read_word(PhaseText& text, const std::vector<std::string>& allowed) {
    PhaseText ahead = text;
    const auto found = std::find(allowed.begin(), allowed.end(), ahead.name());
    if (found == allowed.end() || !value_ends(ahead)) return {};
    text.at = ahead.at;
    return found - allowed.begin();
}

/// The name of a file, refused where none are read; empty where there is none.
std::string read_csv_name(PhaseText& text, const std::string& parameter,
                          const std::string& otherwise) {
    const std::string file = text.csv_name(Mie::kind.parameter_names());
    if (!file.empty() && !text.read_file)
        text.refuse("mie: " + parameter + " must be " + otherwise +
                    " where no files are read, got '" + file + "'");
    return file;
}

/// `1.33` or `1.33+1e-6i`; a '+' without an i after its number belongs to what follows.
std::optional<std::complex<double>> read_number_index(PhaseText& text) {
    double n, k;
    if (!text.accept_number(n)) return {};
    PhaseText ahead = text;
    ahead.accept('+');
    if (!ahead.accept_number(k) || !ahead.accept('i')) return n;
    text.at = ahead.at;
    return std::complex<double>(n, k);
}

const std::vector<std::string>& distributions() {  // as in the enum
    static const std::vector<std::string> names{"gamma", "lognormal", "modified_gamma"};
    return names;
}

const std::vector<std::string>& materials() {  // as in the enum
    static const std::vector<std::string> names{"water", "ice"};
    return names;
}

/// Droplets as far as their text has been read. A file of indices is read at the end, because the
/// wavelength may follow it in the text.
struct DropletText {
    Droplets droplets;
    std::string index_file;
    std::vector<std::string> given;

    bool has(const char* parameter) const { return is_listed(parameter, given); }
};

void read_index(PhaseText& text, DropletText& met) {
    const std::string before = text.rest();
    PhaseText ahead = text;
    const std::optional<std::complex<double>> number = read_number_index(ahead);
    met.droplets.material = Droplets::Material::other;
    if (!number || !value_ends(ahead)) {
        met.index_file = read_csv_name(text, "index", "n or n+ki");
        if (!met.index_file.empty()) return;
    }
    if (!number)
        text.refuse("mie: index must be a number n, n+ki or a file whose name ends in .csv, got '" +
                    before + "'");
    met.droplets.index = *number;
    text.at = ahead.at;
}

/// `0.1 30/0.2 50/0.5 10`: radius (um) and number per um.
bool read_size_rows(PhaseText& text, Droplets& droplets) {
    PhaseText ahead = text;
    double number;
    if (!ahead.accept_number(number) || !ahead.accept_number(number)) return false;
    do {
        droplets.radius.push_back(text.number("mie: the radius of a row"));
        droplets.number.push_back(text.number("mie: the number of a row"));
    } while (text.accept('/'));
    return true;
}

void read_distribution(PhaseText& text, Droplets& droplets) {
    const std::string before = text.rest();
    if (const auto word = read_word(text, distributions())) {
        droplets.distribution = static_cast<Droplets::Distribution>(*word);
        return;
    }
    droplets.distribution = Droplets::Distribution::rows;
    if (read_size_rows(text, droplets)) return;
    const std::string file =
        read_csv_name(text, "distribution", joined(distributions(), ", ") + " or rows");
    if (file.empty())
        text.refuse("mie: distribution must be " + joined(distributions(), ", ") +
                    " or a file whose name ends in .csv, got '" + before + "'");
    PhaseColumns columns = text.read_file(file, {"radius_um", "number_per_um"});
    check_size_rows(columns.values[0], columns.values[1], columns.row_name);
    droplets.radius = std::move(columns.values[0]);
    droplets.number = std::move(columns.values[1]);
}

/// A parameter that is a number, or a length.
struct DropletNumber {
    const char* parameter;
    double Droplets::*to;
    bool is_length;
};

constexpr DropletNumber droplet_numbers[] = {{"radius", &Droplets::effective_radius, true},
                                             {"wavelength", &Droplets::wavelength, true},
                                             {"variance", &Droplets::effective_variance, false},
                                             {"mode_radius", &Droplets::mode_radius, true},
                                             {"alpha", &Droplets::alpha, false},
                                             {"gamma", &Droplets::gamma, false}};

void read_value(PhaseText& text, const std::string& parameter, DropletText& met) {
    Droplets& droplets = met.droplets;
    for (const DropletNumber& number : droplet_numbers)
        if (parameter == number.parameter) {
            droplets.*number.to =
                number.is_length ? read_length(text, parameter) : text.number("mie: " + parameter);
            return;
        }
    if (parameter == "distribution") return read_distribution(text, droplets);
    if (parameter == "index") return read_index(text, met);
    const auto word = read_word(text, materials());
    if (!word)
        text.refuse("mie: material must be " + joined(materials(), " or ") + ", got '" +
                    text.rest() + "'");
    droplets.material = static_cast<Droplets::Material>(*word);
}

/// Refuses parameters that do not belong to the distribution, and those of it that are missing.
void check_parameters(const PhaseText& text, const DropletText& met) {
    const bool is_modified = met.droplets.distribution == Droplets::Distribution::modified_gamma;
    for (const char* parameter : {"mode_radius", "alpha", "gamma"}) {
        if (is_modified && !met.has(parameter))
            text.refuse(std::string("mie needs ") + parameter +
                        "=... with distribution=modified_gamma, as in "
                        "mode_radius=4um,alpha=6,gamma=1");
        if (!is_modified && met.has(parameter))
            text.refuse(std::string("mie: ") + parameter +
                        " must be absent unless distribution=modified_gamma is given, got it");
    }
    const bool is_effective = met.droplets.has_effective_parameters();
    for (const char* parameter : {"radius", "variance"})
        if (!is_effective && met.has(parameter))
            text.refuse(std::string("mie: ") + parameter + " must be absent where " +
                        (is_modified ? "mode_radius, alpha and gamma give"
                                     : "the rows of the distribution give") +
                        " the sizes, got it");
    if (is_effective && !met.has("radius")) text.refuse("mie needs radius=..., as in radius=10um");
    if (met.has("material") && met.has("index"))
        text.refuse("mie: index must be absent where material is given, got both");
}

/// The text of the size distribution, which `read` takes back.
std::string size_text(const Droplets& droplets) {
    if (droplets.distribution == Droplets::Distribution::modified_gamma)
        return "distribution=modified_gamma,mode_radius=" + shortest_text(droplets.mode_radius) +
               "um,alpha=" + shortest_text(droplets.alpha) +
               ",gamma=" + shortest_text(droplets.gamma);
    if (droplets.distribution == Droplets::Distribution::rows) {
        std::string text;
        for (std::size_t i = 0; i < droplets.radius.size(); ++i)
            text += (i == 0 ? "distribution=" : "/") + shortest_text(droplets.radius[i]) + ' ' +
                    shortest_text(droplets.number[i]);
        return text;
    }
    const std::string text = "radius=" + shortest_text(droplets.effective_radius) +
                             "um,variance=" + shortest_text(droplets.effective_variance);
    if (droplets.effective_variance == 0) return text;
    return text +
           ",distribution=" + distributions()[static_cast<std::size_t>(droplets.distribution)];
}

std::string index_text(std::complex<double> index) {
    return shortest_text(index.real()) +
           (index.imag() == 0 ? "" : "+" + shortest_text(index.imag()) + "i");
}

}  // namespace

/// The scattering of droplets, computed when it is first asked for: a table that is only looked up
/// has the values that it needs.
class Mie::SharedScattering {
  public:
    SharedScattering(const Droplets& droplets, const std::string& text)
        : droplets_(droplets), text_(text) {}

    const Scattering& get() const {
        std::call_once(known_, [this] {
            const Store& store = scattering_store();
            if (store.find)
                if (const auto numbers = store.find(text_)) {
                    scattering_ = from_numbers(*numbers);
                    return;
                }
            scattering_ = compute_scattering(droplets_);
            if (store.keep) store.keep(text_, to_numbers(scattering_));
        });
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
        const auto fresh = std::make_shared<const SharedScattering>(droplets, text);
        living[text] = fresh;
        return fresh;
    }

  private:
    Droplets droplets_;
    std::string text_;
    mutable std::once_flag known_;
    mutable Scattering scattering_{};
};

Mie::Mie(const Droplets& droplets_) : droplets(droplets_) {
    check(droplets);
    scattering_ = SharedScattering::of(droplets, parameter_text());
}

void Mie::keep_scattering_in(Store store) { scattering_store() = std::move(store); }

double Mie::albedo() const { return scattering_->get().albedo; }

double Mie::extinction_efficiency() const { return scattering_->get().extinction_efficiency; }

Mie Mie::read(PhaseText& text, const std::string& first) {
    DropletText met;
    std::string parameter = first;
    for (;;) {
        if (is_listed(parameter, met.given))
            text.refuse("mie: " + parameter + " must be given once, got it again");
        met.given.push_back(parameter);
        read_value(text, parameter, met);
        if (!text.accept(',')) break;
        parameter = text.parameter(mie_caller, kind.parameter_names());
    }
    check_parameters(text, met);
    Droplets& droplets = met.droplets;
    if (!met.index_file.empty()) {
        droplets.index = index_of_file(text.read_file(met.index_file, {"wavelength_um", "n", "k"}),
                                       droplets.wavelength);
        droplets.index_wavelength = droplets.wavelength;
    }
    return Mie(droplets);
}

std::string Mie::parameter_text() const {
    const std::string text =
        size_text(droplets) + ",wavelength=" + shortest_text(droplets.wavelength) + "um";
    if (droplets.material == Droplets::Material::other)
        return text + ",index=" + index_text(droplets.index);
    return text + ",material=" + materials()[static_cast<std::size_t>(droplets.material)];
}

double Mie::operator()(double c) const noexcept {
    if (std::isnan(c)) return c;
    const double sine = std::sqrt(std::max(0.0, (1 - c) * (1 + c)));
    const Scattering& scattering = scattering_->get();
    const double place = std::atan2(sine, c) / pi * scattering.intervals;
    const double cell = std::min(std::floor(place), scattering.intervals - 1);
    const std::size_t first = static_cast<std::size_t>(cell) + beyond_end + 1 - points / 2;
    return lagrange(&scattering.value[first], place - cell + points / 2 - 1);
}

std::vector<double> Mie::moments(std::size_t count) const {
    return continued_moments(scattering_->get().chi, count);
}

std::string Mie::caption() const {
    const std::string material = droplets.material == Droplets::Material::other
                                     ? "index " + index_text(droplets.index)
                                     : materials()[static_cast<std::size_t>(droplets.material)];
    return "Mie " + material + " " + short_number(effective_size(droplets).radius, 3) + " um at " +
           short_number(droplets.wavelength, 3) + " um";
}

}  // namespace stratus
