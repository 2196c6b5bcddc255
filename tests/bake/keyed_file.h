// Files of dotted keys, for tests to change: what every row of toml_section.h must keep.
#pragma once

#include <stratus/bake/toml_section.h>

#include "refusal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace stratus::test {

/// Full names and values, a line each.
class KeyedFile {
  public:
    using Lines = std::vector<std::pair<std::string, std::string>>;

    KeyedFile(const Lines& lines) : lines_(lines) {}

    bool has(const std::string& name) const {
        for (const auto& line : lines_)
            if (line.first == name || line.first.starts_with(name + ".")) return true;
        return false;
    }

    /// With the key's value, in the last line; a table is replaced by a value and the reverse.
    KeyedFile with(const std::string& name, const std::string& value) const {
        KeyedFile file(*this);
        std::erase_if(file.lines_, [&](const auto& line) {
            return line.first == name || line.first.starts_with(name + ".") ||
                   name.starts_with(line.first + ".");
        });
        file.lines_.emplace_back(name, value);
        return file;
    }

    KeyedFile with(const Lines& more) const {
        KeyedFile file(*this);
        file.lines_.insert(file.lines_.end(), more.begin(), more.end());
        return file;
    }

    std::string text() const {
        std::string text;
        for (const auto& [name, value] : lines_) text += name + " = " + value + "\n";
        return text;
    }
    std::string last_line() const { return "line " + std::to_string(lines_.size()); }

  private:
    Lines lines_;
};

/// Values that no number is, and just outside the range that the row of a number states, whatever else it
/// may be; none for other rows.
inline std::vector<std::string> values_out_of_range(const Key& key) {
    const std::string form = key.form;
    const bool whole = form == "whole number";
    char opens, closes;
    double low, high;
    if ((!whole && !form.starts_with("number")) ||
        std::sscanf(key.range, "%c%lf, %lf%c", &opens, &low, &high, &closes) != 4)
        return {};
    const auto beyond = [&](double bound, bool is_open, double sign) {
        const double step = is_open ? 0 : whole ? 1 : 1e-9 * std::max(1.0, std::abs(bound));
        char text[40];
        std::snprintf(text, sizeof text, whole ? "%.0f" : "%.17e", bound + sign * step);
        return std::string(text);
    };
    std::vector<std::string> values{"1979-05-27", beyond(low, opens == '(', -1)};
    if (std::isfinite(high)) values.push_back(beyond(high, closes == ')', 1));
    values.push_back(whole ? "2.5" : "nan");
    if (std::string(key.range).find("inf") == std::string::npos) values.push_back("inf");
    return values;
}

/// Every key stands once in its table and is read, every default allowed, and every number refused beyond
/// its range. A key that is not read would take a date, which no key may be: texts and numbers are refused by
/// their form. `full_name` is the full name of a key in these files, each of which must be taken as it is, and
/// empty where another test reads the key.
inline void expect_keys_are_read(Keys keys, const std::string& caller,
                                 const std::vector<KeyedFile>& files,
                                 const std::function<void(const std::string&)>& parse,
                                 const std::function<std::string(const Key&)>& full_name) {
    const auto refusal_of = [&](const KeyedFile& file) {
        return refusal([&] { parse(file.text()); });
    };
    for (const KeyedFile& file : files) EXPECT_EQ(refusal_of(file), "") << file.text();
    std::set<std::string> names;
    for (const Key& key : keys) {
        EXPECT_TRUE(names.insert(key.name).second) << key.name;
        const std::string name = full_name(key);
        if (name.empty()) continue;
        bool read = false;
        for (const KeyedFile& file : files) {
            if (!file.has(name)) continue;
            const KeyedFile dated = file.with(name, "1979-05-27");
            const std::string start = caller + ": " + dated.last_line() + ": " + name + " must be ",
                              what = key.form == std::string("string") ? "a string" : "";
            if (!refusal_of(dated).starts_with(start + what)) continue;
            read = true;
            for (const std::string& value : values_out_of_range(key))
                expect_holds(refusal_of(file.with(name, value)),
                             {start + "a " + key.form + " in " + key.range + ", got "});
            if (*key.default_value == '(') continue;
            EXPECT_EQ(refusal_of(file.with(name, key.default_value)), "") << name;
        }
        EXPECT_TRUE(read) << name << " is in no file here, or not read";
    }
}

}  // namespace stratus::test
