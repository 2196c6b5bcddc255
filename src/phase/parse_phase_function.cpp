#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/phase/phase_function.h>

#include "kinds/phase_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace stratus {
namespace {

using Term = PhaseFunction::Term;

struct ReadableKind : PhaseKind {
    Term (*read)(PhaseText&, const std::string& parameter);

    /// Lists what may stand after the name.
    std::vector<std::string> allowed() const {
        std::vector<std::string> names = parameter_names();
        if (may_be_a_file) names.insert(names.begin(), "file");
        return names;
    }
};

template <class Kind>
Term read_term([[maybe_unused]] PhaseText& text, [[maybe_unused]] const std::string& parameter) {
    if constexpr (Kind::kind.has_parameter())
        return Kind::read(text, parameter);
    else
        return Kind{};
}

template <class... Kinds>
std::vector<ReadableKind> list_kinds(const std::variant<Kinds...>*) {
    return {{Kinds::kind, read_term<Kinds>}...};
}

const std::vector<ReadableKind>& kinds() {
    static const std::vector<ReadableKind> all = list_kinds(static_cast<const Term*>(nullptr));
    return all;
}

const ReadableKind* kind_named(const std::string& wanted) {
    for (const ReadableKind& kind : kinds())
        if (kind.name == wanted) return &kind;
    return nullptr;
}

/// The known name that was meant: by its initials, as in "HG", or the nearest.
std::string meant_name(std::string met, const std::vector<std::string>& known) {
    for (char& letter : met) letter = static_cast<char>(std::tolower(letter));
    for (const std::string& name : known) {
        const std::size_t gap = name.find('_');
        if (gap == name.npos) continue;
        if (met == std::string{name[0], name[gap + 1]} || met == name.substr(0, gap)) return name;
    }
    return nearest_name(met, known);
}

const ReadableKind& read_kind(PhaseText& text) {
    const std::string met = text.name();
    if (met.empty()) text.refuse("a phase function must stand here, got '" + text.rest() + "'");
    const ReadableKind* const found = kind_named(met);
    if (found != nullptr) return *found;
    std::vector<std::string> known;
    for (const ReadableKind& kind : kinds()) known.emplace_back(kind.name);
    text.refuse("phase function must be one of " + joined(known) + ", got '" + met +
                "'; did you mean '" + meant_name(met, known) + "'?");
}

/// Refuses a number without the name of its parameter, as in `henyey_greenstein:0.5`.
void refuse_bare_number(PhaseText text, const ReadableKind& kind) {
    text.at_end();
    const std::size_t begin = text.at;
    double value;
    if (!text.accept_number(value)) return;
    const std::string met(text.text.substr(begin, text.at - begin));
    text.refuse("parameter of " + std::string(kind.name) + " must be written " +
                kind.parameters[0] + "=" + met + ", got '" + met + "'");
}

/// The name of the first parameter that follows a kind's; empty where there is none to follow.
std::string read_parameter_name(PhaseText& text, const ReadableKind& kind) {
    const std::string owner = kind.name;
    const std::vector<std::string> allowed = kind.allowed();
    if (allowed.empty()) {
        if (text.accept(':')) text.refuse(owner + " takes no parameter, got '" + text.rest() + "'");
        return "";
    }
    if (!text.accept(':')) text.refuse(owner + " needs " + joined(allowed, "=... or ") + "=...");
    refuse_bare_number(text, kind);
    return text.parameter(owner, allowed);
}

/// True when the '+' at `plus` joins two phase functions and is not part of a file's name: it
/// stands between blanks, or a phase function follows.
bool joins(PhaseText text, std::size_t plus) {
    const auto is_blank = [&](std::size_t i) {
        return i >= text.text.size() || text.text[i] == ' ' || text.text[i] == '\t';
    };
    if (is_blank(plus - 1) && is_blank(plus + 1)) return true;
    text.at = plus + 1;
    double weight;
    if (text.accept_number(weight) && !text.accept('*')) return false;
    return kind_named(text.name()) != nullptr;
}

/// True when the ',' at `comma` is followed by an option of a table.
bool begins_option(PhaseText text, std::size_t comma) {
    text.at = comma + 1;
    return is_listed(text.name(), Tabulated::option_names()) && text.accept('=');
}

std::string read_file_name(PhaseText& text, bool with_options) {
    text.at_end();
    const std::size_t begin = text.at;
    const auto ends = [&](char letter) {
        return (letter == '+' && joins(text, text.at)) ||
               (with_options && letter == ',' && begins_option(text, text.at));
    };
    while (text.at < text.text.size() && !ends(text.text[text.at])) ++text.at;
    std::string file(text.text.substr(begin, text.at - begin));
    file.erase(file.find_last_not_of(" \t") + 1);
    if (file.empty()) text.refuse("file must be a name, got nothing");
    return file;
}

using Notes = std::vector<std::string>;

/// Rows over the scattering angle as rows over the phase angle, which is 180 degrees less it.
void turn_to_phase_angles(PhaseColumns& columns) {
    std::vector<double>& angle = columns.values[0];
    for (std::size_t i = 0; i < angle.size(); ++i) {
        const std::string here = "scattering_angle_deg" + columns.row_name(i);
        require(i == 0 || angle[i] > angle[i - 1], Tabulated::kind.name, here,
                "above the one before it", angle[i]);
        require_in("[0, 180]", Tabulated::kind.name, here, angle[i]);
    }
    for (double& degrees : angle) degrees = 180 - degrees;
    for (std::vector<double>& column : columns.values) std::reverse(column.begin(), column.end());
    columns.row_name = [of = columns.row_name, last = angle.size() - 1](std::size_t row) {
        return of(last - row);
    };
}

PhaseFunction read_tabulated(PhaseText& text, const std::string& file, Notes& notes) {
    const Tabulated::Options options = Tabulated::read_options(text);
    PhaseColumns columns =
        text.read_file(file, {"phase_angle_deg or scattering_angle_deg", "value"});
    if (!columns.names.empty() && columns.names[0] == "scattering_angle_deg")
        turn_to_phase_angles(columns);
    Tabulated table(std::move(columns.values[0]), std::move(columns.values[1]), options,
                    columns.row_name);
    if (std::abs(table.normalisation - 1) > 1e-9)
        notes.push_back(columns.name + ": values were divided by their spherical mean " +
                        shortest_text(1 / table.normalisation));
    return PhaseFunction(std::move(table));
}

PhaseFunction read_moments(const PhaseText& text, const std::string& file, Notes& notes) {
    const PhaseColumns columns = text.read_file(file, {"l", "chi"});
    const std::vector<double>&order = columns.values[0], &chi = columns.values[1];
    for (std::size_t l = 0; l < order.size(); ++l)
        require(order[l] == static_cast<double>(l), Moments::kind.name, "l" + columns.row_name(l),
                std::to_string(l) + " (0, 1, 2, ... in order)", order[l]);
    Moments moments(chi, columns.row_name);
    if (chi[0] != 1)
        notes.push_back(columns.name +
                        ": moments were divided by chi_0 = " + shortest_text(chi[0]));
    return PhaseFunction(std::move(moments));
}

/// One term with its weight, 1 where none is given.
std::pair<double, PhaseFunction> read_part(PhaseText& text, Notes& notes) {
    double weight = 1;
    if (text.accept_number(weight) && !text.accept('*'))
        text.refuse("'*' must follow the weight " + shortest_text(weight) + ", got '" +
                    text.rest() + "'");
    if (!(weight >= 0 && std::isfinite(weight)))
        text.refuse("a weight must be finite and at least 0, got " + shortest_text(weight));
    const ReadableKind& kind = read_kind(text);
    const std::string parameter = read_parameter_name(text, kind);
    if (parameter != "file") return {weight, PhaseFunction(kind.read(text, parameter))};
    if (!text.read_file)
        text.refuse("parameter of " + std::string(kind.name) + " must be " + kind.parameters[0] +
                    " where no files are read, got 'file'");
    const bool is_table = std::string(kind.name) == Tabulated::kind.name;
    const std::string file = read_file_name(text, is_table);
    return {weight, is_table ? read_tabulated(text, file, notes) : read_moments(text, file, notes)};
}

}  // namespace

PhaseFunction parse_phase_function(const std::string& text, std::vector<std::string>* told,
                                   const PhaseFileReader& read_file) {
    Notes unread;
    Notes& notes = told != nullptr ? *told : unread;
    PhaseText left{text, 0, read_file};
    std::vector<std::pair<double, PhaseFunction>> parts;
    double weights = 0;
    do {
        parts.push_back(read_part(left, notes));
        weights += parts.back().first;
    } while (left.accept('+'));
    if (!left.at_end())
        left.refuse("'" + left.rest() + "' must be '+' and another phase function, or nothing");
    for (const auto& [weight, part] : parts)
        if (const auto* const table = std::get_if<Tabulated>(&part.terms()[0].second);
            table != nullptr && !table->continuation().empty())
            notes.push_back("tabulated: " + table->continuation());
    if (std::abs(weights - 1) > 1e-9)
        notes.push_back("'" + text + "': weights summed to " + shortest_text(weights) +
                        " and were divided by it");
    return PhaseFunction::sum(parts);
}

std::string phase_function_help() {
    std::size_t width = 0;
    for (const ReadableKind& kind : kinds())
        width = std::max(width, std::string(kind.example).size());
    std::string help;
    for (const ReadableKind& kind : kinds()) {
        const std::string example = kind.example;
        help += example + std::string(width + 2 - example.size(), ' ') + kind.help + '\n';
    }
    return help + "or a sum: 0.6*lambert_sphere + 0.4*isotropic";
}

namespace {

bool is_name_letter(char letter) {
    return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
           (letter >= '0' && letter <= '9') || letter == '_' || letter == '-';
}

}  // namespace

void PhaseText::refuse(const std::string& what) const {
    throw std::invalid_argument(std::string(caller) + ": in '" + shown(std::string(text)) +
                                "': " + shown(what, max_message - 2 * max_shown));
}

bool PhaseText::at_end() {
    while (at < text.size() && (text[at] == ' ' || text[at] == '\t')) ++at;
    return at == text.size();
}

bool PhaseText::next_is(char letter) { return !at_end() && text[at] == letter; }

bool PhaseText::accept(char letter) {
    if (!next_is(letter)) return false;
    ++at;
    return true;
}

bool PhaseText::accept_number(double& value) {
    if (at_end()) return false;
    const std::size_t length = read_number(text.substr(at), value);
    at += length;
    return length > 0;
}

double PhaseText::number(const std::string& meaning) {
    double value = 0;
    if (!accept_number(value)) refuse(meaning + " must be a number, got '" + rest() + "'");
    return value;
}

std::string PhaseText::name() {
    at_end();
    const std::size_t begin = at;
    while (at < text.size() && is_name_letter(text[at])) ++at;
    return std::string(text.substr(begin, at - begin));
}

std::string PhaseText::csv_name(const std::vector<std::string>& parameters) {
    at_end();
    const std::size_t begin = at;
    const auto begins_parameter = [&](std::size_t comma) {
        PhaseText ahead{text, comma + 1, {}};
        return is_listed(ahead.name(), parameters) && ahead.accept('=');
    };
    for (std::size_t end = begin; end < text.size(); ++end) {
        if (text[end] == ',' && begins_parameter(end)) break;
        if (text.compare(end, 3, " + ") == 0) break;
        if (end == begin || text.compare(end, 4, ".csv") != 0) continue;
        PhaseText behind{text, end + 4, {}};
        if (!behind.at_end() && !behind.next_is(',') && !behind.next_is('+')) continue;
        at = end + 4;
        return std::string(text.substr(begin, at - begin));
    }
    return "";
}

std::string PhaseText::parameter(const std::string& owner,
                                 const std::vector<std::string>& allowed) {
    const std::size_t begin = at;
    std::string met = name();
    if (!is_listed(met, allowed)) {
        if (!accept('='))
            refuse("parameter of " + owner + " must be written " + joined(allowed, "=... or ") +
                   "=..., got '" +
                   std::string(text.substr(begin, text.find_first_of(" \t", begin) - begin)) + "'");
        refuse("parameter of " + owner + " must be " + joined(allowed, " or ") + ", got '" + met +
               "'; did you mean '" + nearest_name(met, allowed) + "'?");
    }
    if (!accept('=')) refuse(owner + ": '=' must follow " + met + ", got '" + rest() + "'");
    return met;
}

std::map<std::string, double> PhaseText::numbers(const std::string& owner,
                                                 const std::vector<std::string>& allowed) {
    std::map<std::string, double> met;
    do {
        const std::string known = parameter(owner, allowed);
        if (met.count(known) > 0) refuse(owner + ": " + known + " must stand once, got it twice");
        met[known] = number(owner + ": " + known);
    } while (accept(','));
    if (!at_end()) refuse("nothing may follow, got '" + rest() + "'");
    return met;
}

}  // namespace stratus
