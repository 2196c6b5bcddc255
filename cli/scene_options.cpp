#include "scene_options.h"

#include <stratus/base/argument.h>

#include "options.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace stratus {

void add_drop(CLI::App& command, std::string& names) {
    command
        .add_option("--drop", names,
                    "Effects to leave out whatever they change, even those that the scene names: "
                    "NAME[,NAME]")
        ->check(file_name());
}

void add_width(CLI::App& command, int& width) {
    command.add_option("--width", width, "Pixels, instead of the scene's; 0: the scene's")
        ->capture_default_str()
        ->check(whole_number(0, 16384));
}

void add_cache(CLI::App& command, CacheOptions& options) {
    constexpr long long mebibyte = 1 << 20;
    command.add_flag("--no-cache", options.off, "Neither look for kept tables nor keep any");
    command
        .add_option_function<long long>(
            "--cache-limit",
            [&options](const long long& size) {
                options.limit = static_cast<std::uintmax_t>(size * mebibyte);
            },
            "Size of all kept tables, in MiB, beyond which those longest unused are removed. "
            "Default: 2048")
        ->check(whole_number(0, 1LL << 40));
}

std::string panel_name(const SceneFile& file, std::size_t panel) {
    const std::string& title = file.panels[panel].title;
    if (!title.empty()) return shown(title);
    return file.panels.size() == 1 ? "the picture" : "panel " + std::to_string(panel + 1);
}

std::optional<TableCache> open_cache(const CacheOptions& options) {
    const std::filesystem::path folder = default_cache_folder();
    if (options.off || folder.empty()) return std::nullopt;
    return TableCache(folder, options.limit);
}

}  // namespace stratus
