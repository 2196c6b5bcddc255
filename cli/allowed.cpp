#include "allowed.h"

#include <stratus/base/number_text.h>

#include <charconv>

namespace stratus {
namespace {

std::string refusal(const std::string& allowed, const std::string& met) {
    return "must be " + allowed + ", got " + (met.empty() ? "nothing" : met);
}

}  // namespace

CLI::Validator number(const std::string& allowed, bool (*holds)(double value)) {
    const auto check = [=](std::string& text) {
        double value = 0;
        const bool is_number = !text.empty() && read_number(text, value) == text.size();
        return is_number && holds(value) ? std::string() : refusal(allowed, text);
    };
    return {check, ""};
}

CLI::Validator whole_number(long long min, long long max) {
    const std::string allowed =
        "a whole number in [" + std::to_string(min) + ", " + std::to_string(max) + "]";
    const auto check = [=](std::string& text) {
        long long value = 0;
        const char* const end = text.data() + text.size();
        const auto read = std::from_chars(text.data(), end, value);
        if (read.ec != std::errc() || read.ptr != end || value < min || value > max)
            return refusal(allowed, text);
        text = std::to_string(value);  // CLI11 reads a leading zero as octal
        return std::string();
    };
    return {check, ""};
}

CLI::Validator file_name() {
    const auto check = [](std::string& text) {
        return text.empty() ? refusal("the name of a file", text) : std::string();
    };
    return {check, ""};
}

void add_threads(CLI::App& command, int& threads, const std::string& more) {
    command.add_option("--threads", threads, "Threads; 0: one for each processor" + more)
        ->capture_default_str()
        ->check(whole_number(0, 1024));
}

void add_accuracy(CLI::App& command, int& nodes, double& tolerance, bool& accept,
                  const std::string& more) {
    CLI::Option* const fixed =
        command
            .add_option("--nodes", nodes,
                        "Gauss nodes of the solver, [1, 512], in place of --tolerance" + more)
            ->check(whole_number(1, 512));
    command
        .add_option("--tolerance", tolerance,
                    "Relative error of R and T, or of fluxes, [1e-12, 1]: the solver chooses nodes "
                    "to meet it, and gives estimated errors")
        ->capture_default_str()
        ->check(number("in [1e-12, 1]", [](double t) { return t >= 1e-12 && t <= 1; }))
        ->excludes(fixed);
    command.add_flag("--accept", accept, "Go on even if 512 nodes do not meet the tolerance");
}

void add_keys(CLI::App& command, const std::string& files, Keys keys) {
    std::string text = key_columns(keys);
    text.pop_back();  // CLI11 ends the line
    command.set_version_flag("--keys", text,
                             "Print every key of " + files +
                                 " with its form, unit, range, default and meaning, and exit");
}

}  // namespace stratus
