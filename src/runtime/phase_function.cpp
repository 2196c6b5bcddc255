#include <stratus/runtime/phase_function.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/csv.h>
#include <stratus/runtime/number_text.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <string_view>

namespace stratus {
namespace {

using Term = PhaseFunction::Term;

template <class... Functions>
struct Overloaded : Functions... {
    using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

/// Calls `function` with the kind that a term holds; unlike std::visit it throws nothing.
template <class Function, class... Kinds>
void with_kind(const std::variant<Kinds...>& term, const Function& function) noexcept {
    const auto call = [&](const auto* kind) {
        if (kind != nullptr) function(*kind);
    };
    (call(std::get_if<Kinds>(&term)), ...);
}

double sine(double cosine) noexcept {
    return std::sqrt(std::max(0.0, (1 - cosine) * (1 + cosine)));
}

// ---- values

double value_of(const Isotropic&, double) noexcept { return 1; }

double value_of(const Rayleigh&, double c) noexcept { return 0.75 * (1 + c * c); }

double value_of(const Anisotropic& term, double c) noexcept { return 1 - term.x * c; }

double value_of(const LambertSphere&, double c) noexcept {
    // [Blinn82] 3.3 with the scattering angle T = pi - a: sin a + (pi - a) cos a = sin T - T cos T
    const double s = sine(c);
    return 8 / (3 * pi) * (s - std::atan2(s, c) * c);
}

double value_of(const HenyeyGreenstein& term, double c) noexcept {
    // [Blinn82] 3.5; 1 + g^2 - 2 g c = (1 - |g|)^2 + 2 |g| (1 -+ c) keeps its precision near |g| =
    // 1
    const double size = std::abs(term.g);
    const double towards_peak = term.g < 0 ? -c : c;
    const double base = (1 - size) * (1 - size) + 2 * size * (1 - towards_peak);
    return (1 - size) * (1 + size) / (base * std::sqrt(base));
}

/// The monotone cubic of a table in the interval that starts at knot i, not yet normalised.
double hermite(const Tabulated& table, std::size_t i, double angle_deg) noexcept {
    const double width_deg = table.phase_angle_deg[i + 1] - table.phase_angle_deg[i];
    const double width = radians(width_deg);
    const double t = (angle_deg - table.phase_angle_deg[i]) / width_deg;
    const double u = 1 - t;
    return u * u * ((1 + 2 * t) * table.value[i] + t * width * table.slope[i]) +
           t * t * ((1 + 2 * u) * table.value[i + 1] - u * width * table.slope[i + 1]);
}

double value_of(const Tabulated& table, double c) noexcept {
    const std::vector<double>& knots = table.phase_angle_deg;
    const double angle_deg = degrees(std::atan2(sine(c), -c));
    const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, angle_deg);
    const std::size_t interval = static_cast<std::size_t>(above - knots.begin()) - 1;
    return table.normalisation * hermite(table, interval, angle_deg);
}

double value_of(const Moments& term, double c) noexcept {
    double next = 0, after_next = 0;  // Clenshaw, (l + 1) P_{l+1} = (2 l + 1) c P_l - l P_{l-1}
    for (std::size_t l = term.chi.size(); l-- > 0;) {
        const double order = static_cast<double>(l);
        const double here = (2 * order + 1) * (term.chi[l] + c / (order + 1) * next) -
                            (order + 1) / (order + 2) * after_next;
        after_next = next;
        next = here;
    }
    return next;
}

// ---- Legendre moments

std::vector<double> moments_of(const Isotropic&, std::size_t count) {
    std::vector<double> chi(count, 0.0);
    chi[0] = 1;
    return chi;
}

std::vector<double> moments_of(const Rayleigh&, std::size_t count) {
    std::vector<double> chi = moments_of(Isotropic{}, count);
    if (count > 2) chi[2] = 0.1;
    return chi;
}

std::vector<double> moments_of(const Anisotropic& term, std::size_t count) {
    std::vector<double> chi = moments_of(Isotropic{}, count);
    if (count > 1) chi[1] = -term.x / 3;
    return chi;
}

std::vector<double> moments_of(const LambertSphere&, std::size_t count) {
    // Twice by parts: phi'' = (8 / 3 pi) / sqrt(1 - c^2), whose even integrals against P_l are
    // (8/3) a_l, a_l = ((l-1)!! / l!!)^2. What remains for even l >= 2 is 4 a_{l-2} / (l (l+2))^2.
    std::vector<double> chi = moments_of(Isotropic{}, count);
    if (count > 1) chi[1] = -4.0 / 9;
    double a = 1;
    for (std::size_t l = 2; l < count; l += 2) {
        const double order = static_cast<double>(l);
        chi[l] = 4 * a / (order * order * (order + 2) * (order + 2));
        a *= (order - 1) * (order - 1) / (order * order);
    }
    return chi;
}

std::vector<double> moments_of(const HenyeyGreenstein& term, std::size_t count) {
    std::vector<double> chi(count, 1.0);
    for (std::size_t l = 1; l < count; ++l) chi[l] = chi[l - 1] * term.g;
    return chi;
}

std::vector<double> moments_of(const Moments& term, std::size_t count) {
    std::vector<double> chi = term.chi;
    chi.resize(count, 0.0);
    return chi;
}

/// Adds (1/2) weight P_l(c), l = 0 .. sums.size() - 1, to the sums.
void add_legendre(double weight, double c, std::vector<double>& sums) {
    double before = 0, here = 1;
    for (std::size_t l = 0; l < sums.size(); ++l) {
        sums[l] += weight / 2 * here;
        const double order = static_cast<double>(l);
        const double next = ((2 * order + 1) * c * here - order * before) / (order + 1);
        before = here;
        here = next;
    }
}

// Gauss-Legendre on [-1, 1], 8 nodes, the positive half.
constexpr double gauss_node[4] = {0.18343464249564980494, 0.52553240991632898582,
                                  0.79666647741362673959, 0.96028985649753623168};
constexpr double gauss_weight[4] = {0.36268378337836198297, 0.31370664587788728734,
                                    0.22238103445337447054, 0.10122853629037625915};

/// Moments of a table before it is normalised: (1/2) times the integral of value P_l(-cos a) sin a
/// da.
std::vector<double> raw_moments_of(const Tabulated& table, std::size_t count) {
    std::vector<double> sums(count, 0.0);
    for (std::size_t i = 0; i + 1 < table.value.size(); ++i) {
        const double begin = table.phase_angle_deg[i];
        const double width = table.phase_angle_deg[i + 1] - begin;
        // P_l turns through (l + 1/2) times the angle; two radians of that to a panel leave the
        // eight nodes an error below rounding.
        const int panels =
            static_cast<int>(std::ceil((static_cast<double>(count) + 1) * radians(width) / 2));
        const double half = width / panels / 2;
        for (int panel = 0; panel < panels; ++panel) {
            const double middle = begin + (2 * panel + 1) * half;
            for (int k = 0; k < 4; ++k)
                for (const double side : {-1.0, 1.0}) {
                    const double angle_deg = middle + side * half * gauss_node[k];
                    const double angle = radians(angle_deg);
                    const double weight = radians(half) * gauss_weight[k] * std::sin(angle);
                    add_legendre(weight * hermite(table, i, angle_deg), -std::cos(angle), sums);
                }
        }
    }
    return sums;
}

std::vector<double> moments_of(const Tabulated& table, std::size_t count) {
    std::vector<double> chi = raw_moments_of(table, count);
    for (double& moment : chi) moment *= table.normalisation;
    chi[0] = 1;
    return chi;
}

// ---- tables of values

/// Slopes of Fritsch and Carlson (1980): parabolic, then held within the circle of radius 3 that
/// keeps every interval monotone; 0 at both ends, about which phi is even.
std::vector<double> monotone_slopes(const std::vector<double>& angle_deg,
                                    const std::vector<double>& value) {
    const std::size_t count = value.size();
    std::vector<double> width(count - 1), secant(count - 1), slope(count, 0.0);
    for (std::size_t i = 0; i + 1 < count; ++i) {
        width[i] = radians(angle_deg[i + 1] - angle_deg[i]);
        secant[i] = (value[i + 1] - value[i]) / width[i];
    }
    for (std::size_t i = 1; i + 1 < count; ++i) {
        const bool turns = (secant[i - 1] > 0) != (secant[i] > 0);
        if (turns || secant[i - 1] == 0 || secant[i] == 0) continue;
        slope[i] =
            (width[i] * secant[i - 1] + width[i - 1] * secant[i]) / (width[i - 1] + width[i]);
    }
    for (std::size_t i = 0; i + 1 < count; ++i) {
        if (secant[i] == 0) continue;
        const double radius = std::hypot(slope[i] / secant[i], slope[i + 1] / secant[i]);
        if (radius <= 3) continue;
        slope[i] *= 3 / radius;
        slope[i + 1] *= 3 / radius;
    }
    return slope;
}

/// Where row i of a table stands, for messages.
using Place = std::function<std::string(std::size_t)>;

void check_table_rows(const std::vector<double>& angle_deg, const std::vector<double>& value,
                      const Place& place) {
    const char* const caller = "tabulated";
    require(angle_deg.size() == value.size(), caller, "value", "as many numbers as phase_angle_deg",
            value.size());
    require(value.size() >= 3, caller, "phase table", "at least 3 rows", value.size());
    bool dark = true;
    for (std::size_t i = 0; i < value.size(); ++i) {
        const std::string angle_here = "phase_angle_deg" + place(i);
        require(std::isfinite(value[i]) && value[i] >= 0, caller, "value" + place(i),
                "finite and at least 0", value[i]);
        require(i == 0 ? angle_deg[i] == 0 : angle_deg[i] > angle_deg[i - 1], caller, angle_here,
                i == 0 ? "0 (angles must cover 0 to 180)" : "above the one before it",
                angle_deg[i]);
        require(angle_deg[i] <= 180, caller, angle_here, "in [0, 180]", angle_deg[i]);
        dark = dark && value[i] == 0;
    }
    require(angle_deg.back() == 180, caller, "phase_angle_deg" + place(value.size() - 1),
            "180 (angles must cover 0 to 180)", angle_deg.back());
    require(!dark, caller, "value", "above 0 somewhere", 0);
}

Tabulated make_tabulated(std::vector<double> angle_deg, std::vector<double> value,
                         const Place& place) {
    check_table_rows(angle_deg, value, place);
    Tabulated table;
    table.slope = monotone_slopes(angle_deg, value);
    table.phase_angle_deg = std::move(angle_deg);
    table.value = std::move(value);
    const double mean = raw_moments_of(table, 1)[0];
    table.normalisation = 1 / mean;
    require(std::isnormal(mean) && std::isnormal(table.normalisation), "tabulated",
            "spherical mean of the values", "a number whose inverse is one too", mean);
    return table;
}

// ---- lists of moments

Moments make_moments(std::vector<double> chi, const Place& place) {
    const char* const caller = "from_moments";
    require(!chi.empty(), caller, "chi", "at least one moment", 0);
    require(std::abs(chi[0] - 1) <= 1e-6, caller, "chi_0" + place(0), "1 (to 1e-6)", chi[0]);
    for (std::size_t l = 0; l < chi.size(); ++l)
        require(std::abs(chi[l]) <= 1 + 1e-6, caller, "chi_" + std::to_string(l) + place(l),
                "in [-1, 1]", chi[l]);
    const double mean = chi[0];
    for (double& moment : chi) moment = std::clamp(moment / mean, -1.0, 1.0);
    Moments moments{std::move(chi)};
    double least = 1, greatest = 1;
    const int angles = 8 * static_cast<int>(moments.chi.size());  // eight to a swing of P_l
    for (int i = 0; i <= angles; ++i) {
        const double value = value_of(moments, std::cos(pi * i / angles));
        least = std::min(least, value);
        greatest = std::max(greatest, value);
    }
    require(least >= -1e-3 * greatest, caller, "sum of (2 l + 1) chi_l P_l",
            "no lower than -1e-3 of its largest value", least);
    return moments;
}

// ---- text

std::string text_of(const Term& term) {
    return std::visit(
        Overloaded{
            [](const Isotropic&) -> std::string { return "isotropic"; },
            [](const Rayleigh&) -> std::string { return "rayleigh"; },
            [](const Anisotropic& t) { return "anisotropic:x=" + shortest_text(t.x); },
            [](const LambertSphere&) -> std::string { return "lambert_sphere"; },
            [](const HenyeyGreenstein& t) { return "henyey_greenstein:g=" + shortest_text(t.g); },
            [](const Tabulated& t) {
                std::string points;
                for (std::size_t i = 0; i < t.value.size(); ++i)
                    points += (i == 0 ? "" : "/") + shortest_text(t.phase_angle_deg[i]) + ' ' +
                              shortest_text(t.value[i]);
                return "tabulated:points=" + points;
            },
            [](const Moments& t) {
                std::string list;
                for (const double chi : t.chi)
                    list += (list.empty() ? "" : " ") + shortest_text(chi);
                return "moments:chi=" + list;
            },
        },
        term);
}

struct Kind {
    const char* name;
    std::vector<std::string> keys;
};

const std::vector<Kind>& kinds() {
    static const std::vector<Kind> known = {
        {"isotropic", {}},
        {"rayleigh", {}},
        {"anisotropic", {"x"}},
        {"lambert_sphere", {}},
        {"henyey_greenstein", {"g"}},
        {"tabulated", {"file", "points"}},
        {"moments", {"file", "chi"}},
    };
    return known;
}

using Notes = std::vector<std::string>;

void note(Notes* notes, const std::string& line) {
    if (notes != nullptr) notes->push_back(line);
}

PhaseFunction read_table_file(const std::string& path, Notes* notes) {
    const CsvTable file = read_csv(path);
    const auto angle_column = static_cast<std::size_t>(file.column("phase_angle_deg"));
    const auto value_column = static_cast<std::size_t>(file.column("value"));
    std::vector<double> angle_deg, value;
    for (const std::vector<double>& row : file.rows) {
        angle_deg.push_back(row[angle_column]);
        value.push_back(row[value_column]);
    }
    const Place place = [&](std::size_t i) {
        return " (" + path + ", line " + std::to_string(file.lines[i]) + ")";
    };
    check_table_rows(angle_deg, value, place);
    PhaseFunction made = PhaseFunction::tabulated(std::move(angle_deg), std::move(value));
    const double scale = std::get<Tabulated>(made.terms()[0].second).normalisation;
    if (std::abs(scale - 1) > 1e-9)
        note(notes,
             path + ": values were divided by their spherical mean " + shortest_text(1 / scale));
    return made;
}

PhaseFunction read_moments_file(const std::string& path, Notes* notes) {
    const CsvTable file = read_csv(path);
    const auto order_column = static_cast<std::size_t>(file.column("l"));
    const auto chi_column = static_cast<std::size_t>(file.column("chi"));
    const Place place = [&](std::size_t i) {
        return " (" + path + ", line " + std::to_string(file.lines[i]) + ")";
    };
    std::vector<double> chi;
    for (const std::vector<double>& row : file.rows) {
        require(row[order_column] == static_cast<double>(chi.size()), "moments",
                "l" + place(chi.size()), std::to_string(chi.size()) + " (0, 1, 2, ... in order)",
                row[order_column]);
        chi.push_back(row[chi_column]);
    }
    if (!chi.empty() && chi[0] != 1)
        note(notes, path + ": moments were divided by chi_0 = " + shortest_text(chi[0]));
    return PhaseFunction::from_moments(std::move(chi));
}

/// Reads the grammar of `parse_phase_function` from left to right.
class Parser {
  public:
    Parser(const std::string& text, const std::string& directory, Notes* notes)
        : text_(text), directory_(directory), notes_(notes) {}

    PhaseFunction whole() {
        std::vector<std::pair<double, PhaseFunction>> parts;
        double weights = 0;
        do {
            parts.push_back(part());
            weights += parts.back().first;
        } while (took('+'));
        if (!at_end())
            refuse("'" + rest() + "' must be '+' and another phase function, or nothing");
        if (std::abs(weights - 1) > 1e-9)
            note(notes_, "'" + text_ + "': weights summed to " + shortest_text(weights) +
                             " and were divided by it");
        return PhaseFunction::sum(parts);
    }

  private:
    [[noreturn]] void refuse(const std::string& what) const {
        throw std::invalid_argument("parse_phase_function: in '" + text_ + "': " + what);
    }

    void skip_spaces() {
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    }

    bool at_end() {
        skip_spaces();
        return at_ == text_.size();
    }

    bool took(char wanted) {
        if (at_end() || text_[at_] != wanted) return false;
        ++at_;
        return true;
    }

    std::string rest() const { return text_.substr(at_); }

    static bool is_name_letter(char letter) {
        return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
               (letter >= '0' && letter <= '9') || letter == '_' || letter == '-';
    }

    std::string name() {
        skip_spaces();
        const std::size_t begin = at_;
        while (at_ < text_.size() && is_name_letter(text_[at_])) ++at_;
        return text_.substr(begin, at_ - begin);
    }

    bool took_number(double& value) {
        skip_spaces();
        const std::size_t length = read_number(std::string_view(text_).substr(at_), value);
        at_ += length;
        return length > 0;
    }

    double number(const std::string& meaning) {
        double value = 0;
        if (!took_number(value)) refuse(meaning + " must be a number, got '" + rest() + "'");
        return value;
    }

    const Kind* kind_named(const std::string& wanted) const {
        for (const Kind& kind : kinds())
            if (kind.name == wanted) return &kind;
        return nullptr;
    }

    const Kind& kind() {
        const std::string met = name();
        if (met.empty()) refuse("a phase function must stand here, got '" + rest() + "'");
        const Kind* const found = kind_named(met);
        if (found != nullptr) return *found;
        std::vector<std::string> known;
        for (const Kind& each : kinds()) known.emplace_back(each.name);
        refuse("phase function must be one of " + joined(known) + ", got '" + met +
               "'; did you mean '" + nearest_name(met, known) + "'?");
    }

    std::string key(const Kind& kind) {
        const std::string owner = kind.name;
        if (kind.keys.empty()) {
            if (took(':')) refuse(owner + " takes no parameter, got '" + rest() + "'");
            return "";
        }
        if (!took(':')) refuse(owner + " needs " + joined(kind.keys, "=... or ") + "=...");
        std::string met = name();
        if (std::find(kind.keys.begin(), kind.keys.end(), met) == kind.keys.end())
            refuse("parameter of " + owner + " must be " + joined(kind.keys, " or ") + ", got '" +
                   met + "'; did you mean '" + nearest_name(met, kind.keys) + "'?");
        if (!took('=')) refuse(owner + ": '=' must follow " + met + ", got '" + rest() + "'");
        return met;
    }

    std::pair<double, PhaseFunction> part() {
        double weight = 1;
        if (took_number(weight) && !took('*'))
            refuse("'*' must follow the weight " + shortest_text(weight) + ", got '" + rest() +
                   "'");
        if (!(weight >= 0 && std::isfinite(weight)))
            refuse("a weight must be finite and at least 0, got " + shortest_text(weight));
        const Kind& met = kind();
        return {weight, with_parameter(met.name, key(met))};
    }

    PhaseFunction with_parameter(const std::string& kind, const std::string& key) {
        if (kind == "rayleigh") return PhaseFunction::rayleigh();
        if (kind == "lambert_sphere") return PhaseFunction::lambert_sphere();
        if (kind == "anisotropic") return PhaseFunction::anisotropic(number("anisotropic: x"));
        if (kind == "henyey_greenstein")
            return PhaseFunction::henyey_greenstein(number("henyey_greenstein: g"));
        if (key == "points") return points();
        if (key == "chi") return moment_list();
        if (key == "file" && kind == "tabulated") return read_table_file(file_path(), notes_);
        if (key == "file") return read_moments_file(file_path(), notes_);
        return PhaseFunction::isotropic();
    }

    PhaseFunction points() {
        std::vector<double> angle_deg, value;
        do {
            angle_deg.push_back(number("tabulated: the angle of a point"));
            value.push_back(number("tabulated: the value of a point"));
        } while (took('/'));
        return PhaseFunction::tabulated(std::move(angle_deg), std::move(value));
    }

    PhaseFunction moment_list() {
        std::vector<double> chi = {number("moments: chi")};
        while (!at_end() && text_[at_] != '+') chi.push_back(number("moments: chi"));
        return PhaseFunction::from_moments(std::move(chi));
    }

    /// True when the '+' at `plus` joins two phase functions and is not a letter of a file name:
    /// it stands between blanks, or a phase function follows.
    bool joins(std::size_t plus) const {
        const auto blank = [this](std::size_t i) {
            return i >= text_.size() || text_[i] == ' ' || text_[i] == '\t';
        };
        if (blank(plus - 1) && blank(plus + 1)) return true;
        Parser ahead(*this);
        ahead.at_ = plus + 1;
        double weight;
        if (ahead.took_number(weight) && !ahead.took('*')) return false;
        return kind_named(ahead.name()) != nullptr;
    }

    std::string file_path() {
        skip_spaces();
        const std::size_t begin = at_;
        while (at_ < text_.size() && !(text_[at_] == '+' && joins(at_))) ++at_;
        std::string file = text_.substr(begin, at_ - begin);
        file.erase(file.find_last_not_of(" \t") + 1);
        if (file.empty()) refuse("file must be a name, got nothing");
        return (std::filesystem::path(directory_) / file).string();
    }

    std::string text_;
    std::string directory_;
    Notes* notes_;
    std::size_t at_ = 0;
};

std::string row_number(std::size_t row) { return " (row " + std::to_string(row + 1) + ")"; }

}  // namespace

PhaseFunction::PhaseFunction() : terms_{{1.0, Isotropic{}}} {}

PhaseFunction::PhaseFunction(Term term) { terms_.emplace_back(1.0, std::move(term)); }

PhaseFunction PhaseFunction::isotropic() { return PhaseFunction(Isotropic{}); }

PhaseFunction PhaseFunction::rayleigh() { return PhaseFunction(Rayleigh{}); }

PhaseFunction PhaseFunction::anisotropic(double x) {
    require(std::abs(x) <= 1, "anisotropic", "x", "in [-1, 1]", x);
    return PhaseFunction(Anisotropic{x});
}

PhaseFunction PhaseFunction::lambert_sphere() { return PhaseFunction(LambertSphere{}); }

PhaseFunction PhaseFunction::henyey_greenstein(double g) {
    require(std::abs(g) < 1, "henyey_greenstein", "g", "in (-1, 1)", g);
    return PhaseFunction(HenyeyGreenstein{g});
}

PhaseFunction PhaseFunction::tabulated(std::vector<double> phase_angle_deg,
                                       std::vector<double> value) {
    return PhaseFunction(make_tabulated(std::move(phase_angle_deg), std::move(value), row_number));
}

PhaseFunction PhaseFunction::from_moments(std::vector<double> chi) {
    return PhaseFunction(make_moments(std::move(chi), [](std::size_t) { return std::string(); }));
}

PhaseFunction PhaseFunction::sum(const std::vector<std::pair<double, PhaseFunction>>& parts) {
    double total = 0;
    std::size_t count = 0;
    for (const auto& [weight, part] : parts) {
        require(weight >= 0 && std::isfinite(weight), "sum", "weight", "finite and at least 0",
                weight);
        total += weight;
        count += part.terms_.size();
    }
    require(total > 0 && std::isfinite(total), "sum", "total weight", "above 0 and finite", total);
    // Weights that have been divided once sum to 1 but for rounding; dividing them again would
    // change their last bits, and text() would not come back as the same function.
    const double rounding = static_cast<double>(count) * std::numeric_limits<double>::epsilon();
    const double divisor = std::abs(total - 1) <= rounding ? 1 : total;
    PhaseFunction whole;
    whole.terms_.clear();
    for (const auto& [weight, part] : parts) {
        if (weight == 0) continue;
        for (const auto& [share, term] : part.terms_)
            whole.terms_.emplace_back(weight / divisor * share, term);
    }
    return whole;
}

PhaseFunction PhaseFunction::mixture(double share_of_first, const PhaseFunction& first,
                                     const PhaseFunction& second) {
    return sum({{share_of_first, first}, {1 - share_of_first, second}});
}

double PhaseFunction::operator()(double cos_scattering_angle) const noexcept {
    const double c = std::clamp(cos_scattering_angle, -1.0, 1.0);
    double value = 0;
    for (const auto& [weight, term] : terms_)
        with_kind(term,
                  [&, share = weight](const auto& kind) { value += share * value_of(kind, c); });
    return value;
}

std::vector<double> PhaseFunction::moments(int count) const {
    require(count >= 1, "moments", "count", "at least 1", count);
    std::vector<double> chi(static_cast<std::size_t>(count), 0.0);
    for (const auto& [weight, term] : terms_) {
        const std::vector<double> part =
            std::visit([&](const auto& t) { return moments_of(t, chi.size()); }, term);
        for (std::size_t l = 0; l < chi.size(); ++l) chi[l] += weight * part[l];
    }
    chi[0] = 1;
    return chi;
}

double PhaseFunction::asymmetry() const { return moments(2)[1]; }

bool PhaseFunction::is_isotropic() const noexcept {
    const auto flat = Overloaded{
        [](const Isotropic&) { return true; },
        [](const Anisotropic& t) { return t.x == 0; },
        [](const HenyeyGreenstein& t) { return t.g == 0; },
        [](const Moments& t) {
            return std::all_of(t.chi.begin() + 1, t.chi.end(), [](double m) { return m == 0; });
        },
        [](const auto&) { return false; },
    };
    bool all = true;
    for (const auto& part : terms_)
        with_kind(part.second, [&](const auto& kind) { all = all && flat(kind); });
    return all;
}

std::string PhaseFunction::text() const {
    if (terms_.size() == 1) return text_of(terms_[0].second);
    std::string whole;
    for (const auto& [weight, term] : terms_)
        whole += (whole.empty() ? "" : " + ") + shortest_text(weight) + "*" + text_of(term);
    return whole;
}

PhaseFunction parse_phase_function(const std::string& text, const std::string& directory,
                                   std::vector<std::string>* notes) {
    return Parser(text, directory, notes).whole();
}

}  // namespace stratus
