// Options that the commands on scenes share: --drop, --width, and the cache of tables.
#pragma once

#include <stratus/scene/scene.h>
#include <stratus/scene/table_cache.h>

#include <CLI/CLI.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace stratus {

struct CacheOptions {
    bool off = false;
    std::uintmax_t limit = default_cache_limit;
};

void add_drop(CLI::App& command, std::string& names);
void add_width(CLI::App& command, int& width);
void add_cache(CLI::App& command, CacheOptions& options);

/// Returns the name that messages give a panel: its title, or its number.
std::string panel_name(const SceneFile& file, std::size_t panel);

/// None where it is switched off or no folder is known.
std::optional<TableCache> open_cache(const CacheOptions& options);

}  // namespace stratus
