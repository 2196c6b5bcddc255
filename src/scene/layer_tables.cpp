#include <stratus/scene/layer_tables.h>

#include <stratus/bake/bake.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/io/file_bytes.h>
#include <stratus/table/member_and_ground.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace stratus {
namespace {

namespace fs = std::filesystem;

constexpr const char* key_attribute = "cache_key";
constexpr const char* ending = packed_ending;
constexpr const char* choices_ending = ".choices";

/// FNV-1a.
std::string text_hash(const std::string& text) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const char letter : text) {
        hash ^= static_cast<unsigned char>(letter);
        hash *= 0x100000001b3u;
    }
    std::array<char, 17> digits{};
    std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(hash));
    return digits.data();
}

/// Ranges that may be wider than asked, in the order of a file's name.
std::vector<Range> recipe_ranges(const Recipe& recipe) {
    const Range* const mixture = mixture_range(recipe);
    return {recipe.optical_depth, recipe.albedo, mixture ? *mixture : Range{1, 1},
            recipe.mu_in,         recipe.mu_out, recipe.azimuth};
}

/// Returns the part of a recipe that tables of one kind share.
std::string table_kind(Recipe recipe) {
    recipe.title.clear();
    // The semi-infinite layer alone is another kind than depths up to infinity.
    const bool infinite =
        recipe.optical_depth.min == recipe.optical_depth.max && recipe.optical_depth.max > 1e300;
    const bool to_infinity = recipe.optical_depth.max > 1e300;
    recipe.optical_depth = {1, 1};
    recipe.albedo = {1, 1};
    recipe.mu_in = recipe.mu_out = {0, 1};
    recipe.azimuth = {0, 180};
    if (Range* const mixture = mixture_range(recipe)) *mixture = {0, 1};
    recipe.reflection = recipe.transmission = true;
    return baking_program() + "\n" +
           (infinite      ? "infinite depth alone\n"
            : to_infinity ? "to infinite depth\n"
                          : "") +
           resolved_text(recipe);
}

std::string file_name(const Recipe& recipe) {
    std::vector<std::string> fields{text_hash(table_kind(recipe)),
                                    recipe.reflection ? recipe.transmission ? "rt" : "r" : "t"};
    for (const Range& range : recipe_ranges(recipe))
        for (const double end : {range.min, range.max}) fields.push_back(shortest_text(end));
    return joined(fields, "_") + ending;
}

std::string cache_key(const Recipe& recipe) {
    return file_name(recipe) + "\n" + table_kind(recipe);
}

/// The fields of a file's name; empty: of none of ours.
std::vector<std::string> name_fields(const fs::path& path) {
    if (path.extension() != ending && path.extension() != choices_ending) return {};
    std::istringstream stem(path.stem().string());
    std::vector<std::string> fields;
    for (std::string field; std::getline(stem, field, '_');) fields.push_back(field);
    const bool ours = fields.size() > 2 && fields[0].size() == 16 &&
                      fields[0].find_first_not_of("0123456789abcdef") == std::string::npos;
    return ours ? fields : std::vector<std::string>{};
}

/// Whether a file of such a name serves a recipe.
bool serves(const fs::path& path, const Recipe& recipe, const std::string& kind) {
    const std::vector<std::string> fields = name_fields(path);
    const std::vector<Range> asked = recipe_ranges(recipe);
    if (path.extension() != ending || fields.size() != 2 + 2 * asked.size() || fields[0] != kind)
        return false;
    const auto has = [&](char side) { return fields[1].find(side) != std::string::npos; };
    if ((recipe.reflection && !has('r')) || (recipe.transmission && !has('t'))) return false;
    for (std::size_t k = 0; k < asked.size(); ++k) {
        double min = 0, max = 0;
        const std::string &low = fields[2 + 2 * k], &high = fields[3 + 2 * k];
        if (read_number(low, min) != low.size() || read_number(high, max) != high.size())
            return false;
        if (min > asked[k].min || max < asked[k].max) return false;
    }
    return true;
}

struct KeptFile {
    fs::path path;
    std::uintmax_t size;
    fs::file_time_type used;
};

/// Our files in a folder; none where it cannot be read.
std::vector<KeptFile> kept_files(const fs::path& folder) {
    std::vector<KeptFile> files;
    std::error_code failure;
    for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
         entry.increment(failure)) {
        if (name_fields(entry->path()).empty()) continue;
        std::error_code unknown;
        const KeptFile file{entry->path(), entry->file_size(unknown),
                            entry->last_write_time(unknown)};
        if (!unknown) files.push_back(file);
    }
    return files;
}

/// The table of a file; none where it is not what its name says.
std::optional<PackedTable> read_kept(const fs::path& path) {
    try {
        PackedTable table(path.string());
        if (!table.is_intact()) return std::nullopt;
        const auto& attributes = table.header().attributes;
        const auto key = attributes.find(key_attribute);
        if (key == attributes.end() || !key->second.starts_with(path.filename().string() + "\n"))
            return std::nullopt;
        return table;
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

}  // namespace

TableCache::TableCache(fs::path folder, std::uintmax_t limit)
    : folder_(std::move(folder)), limit_(limit) {}

std::optional<PackedTable> TableCache::find(const Recipe& recipe) {
    const std::string kind = table_kind(recipe), hash = text_hash(kind);
    std::vector<KeptFile> files = kept_files(folder_);
    std::erase_if(files, [&](const KeptFile& file) { return !serves(file.path, recipe, hash); });
    // Its own first, then the smallest.
    const std::string own = file_name(recipe);
    std::ranges::sort(files, {}, [&](const KeptFile& file) {
        return std::pair(file.path.filename() != own, file.size);
    });
    for (const KeptFile& file : files) {
        std::optional<PackedTable> table = read_kept(file.path);
        if (!table || !table->header().attributes.at(key_attribute).ends_with("\n" + kind))
            continue;
        std::error_code ignored;  // of a folder that is only read
        fs::last_write_time(file.path, fs::file_time_type::clock::now(), ignored);
        return table;
    }
    return std::nullopt;
}

std::vector<char> TableCache::keep(const Recipe& recipe, Table header, std::vector<char> packed) {
    header.attributes[key_attribute] = cache_key(recipe);
    packed = restated(std::move(packed), header);
    try {
        fs::create_directories(folder_);
        const fs::path path = folder_ / file_name(recipe);
        write_content_atomically(path, packed);
        fs::remove(fs::path(path).replace_extension(choices_ending));
        remove_oldest(path);
    } catch (const std::exception& error) {
        trouble_ = error.what();
    }
    return packed;
}

std::unique_ptr<Checkpoint> TableCache::open_choices(const Recipe& recipe) {
    if (limit_ == 0) return nullptr;
    try {
        fs::create_directories(folder_);
        return std::make_unique<Checkpoint>(
            (folder_ / file_name(recipe)).replace_extension(choices_ending),
            CheckpointOwner{baking_program(), resolved_text(recipe)});
    } catch (const std::exception&) {  // of another process, or of a folder that is only read
        return nullptr;
    }
}

void TableCache::remove_oldest(const fs::path& newest) const {
    std::vector<KeptFile> files = kept_files(folder_);
    std::uintmax_t size = 0;
    for (const KeptFile& file : files) size += file.size;
    // The newest last, however coarse the clock of the file system.
    std::ranges::sort(
        files, {}, [&](const KeptFile& file) { return std::pair(file.path == newest, file.used); });
    for (const KeptFile& file : files) {
        if (size <= limit_) break;
        std::error_code ignored;
        fs::remove(file.path, ignored);
        size -= file.size;
    }
}

fs::path default_cache_folder() {
    const auto set = [](const char* name) {
        const char* const value = std::getenv(name);
        return value ? fs::path(value) : fs::path();
    };
    if (const fs::path own = set("STRATUS_CACHE"); !own.empty()) return own;
    if (const fs::path caches = set("XDG_CACHE_HOME"); !caches.empty()) return caches / "stratus";
    if (const fs::path home = set("HOME"); !home.empty()) return home / ".cache" / "stratus";
    return {};
}

std::shared_ptr<const LayerTable> make_layer_table(PackedTable table) {
    Axis mixture{AxisScale::linear, {}};
    std::vector<Table> headers;
    const Table& header = table.header();
    if (header.has_family()) mixture = header.family[0].axis;
    for (std::size_t m = 0; m < header.member_count(); ++m) {
        Table& one = headers.emplace_back(header);
        for_each_of_members(
            [&](auto& numbers) {
                const auto size =
                    static_cast<std::ptrdiff_t>(numbers.size() / header.member_count());
                const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(m) * size;
                numbers = {first, first + size};
            },
            one);
    }
    return std::make_shared<const LayerTable>(
        LayerTable{std::move(mixture), std::move(headers), std::move(table)});
}

BakeOptions table_options(BakeOptions options) {
    options.checked_points = 1000;
    return options;
}

std::shared_ptr<const LayerTable> bake_layer_table(Recipe recipe, const BakeOptions& options,
                                                   TableCache* cache) {
    recipe.text = resolved_text(recipe);
    if (cache)
        if (std::optional<PackedTable> table = cache->find(recipe))
            return make_layer_table(std::move(*table));
    std::vector<char> packed;
    BakeOptions straight = table_options(options);
    straight.packed = &packed;
    const std::unique_ptr<Checkpoint> choices = cache ? cache->open_choices(recipe) : nullptr;
    if (choices) straight.log.find = [&](const std::string& piece) { return choices->find(piece); };
    Table header = bake(recipe, straight);
    if (cache) packed = cache->keep(recipe, std::move(header), std::move(packed));
    return make_layer_table(PackedTable(packed));
}

namespace {

/// The tables of a scene, from the first of those of channel_scenes, which are taken away; none where
/// none is needed.
std::shared_ptr<const LayerTables> take_tables(const Scene& scene,
                                               std::span<const LayerTables>& own) {
    const auto all = std::make_shared<LayerTables>();
    const auto take = [&]() -> const LayerTables& {
        const LayerTables& first = own[0];
        own = own.subspan(1);
        return first;
    };
    const auto needed = [](const LayerTables& some) {
        const auto any = [](const auto& tables) {
            return std::ranges::any_of(tables, [](const auto& each) { return !!each; });
        };
        return any(some.paths) || any(some.channels) || some.planet;
    };
    if (scene.layer.channels.empty())
        all->paths = take().paths;
    else
        for (auto& channel : all->channels)
            if (const LayerTables& tables = take(); needed(tables))
                channel = std::make_shared<const LayerTables>(tables);
    if (const std::optional<Scene> planet = planet_scene(scene))
        all->planet = take_tables(*planet, own);
    return needed(*all) ? all : nullptr;
}

/// The tables of each of several scenes, from those of all their channel_scenes.
SceneTables scene_tables(const std::vector<Scene>& scenes, std::span<const LayerTables> own) {
    SceneTables tables;
    for (const Scene& scene : scenes) tables.push_back(take_tables(scene, own));
    return tables;
}

/// The point of a table's family where it has a scene's phase function.
FamilyPoint family_point(const Table& table, const PhaseFunction& phase_function) {
    std::vector<double> values;
    for (const FamilyAxis& axis : table.family) {
        const std::optional<double> value = find_parameter(phase_function, axis.parameter);
        require(value.has_value(), "scene", "table.family",
                "one of parameters of the scene's phase function, " +
                    phase_function.text().substr(0, 80),
                axis.name());
        require(holds(axis, *value), "scene", axis.name() + std::string(" of the phase function"),
                allowed_text(axis), *value);
        values.push_back(*value);
    }
    return FamilyPoint(values);
}

/// A table given for scenes, prepared once; of a family once for each member that is asked for.
class GivenTable {
  public:
    explicit GivenTable(PackedTable table) {
        if (table.header().varies_parameters())
            family_ = table.unpacked();
        else
            made_[""] = make_layer_table(std::move(table));
    }

    /// For a light path of a scene of one phase function, or of two that mix.
    std::shared_ptr<const LayerTable> serve(const Scene& scene, const NeededRecipe& needed) {
        const Recipe& recipe = needed.recipe;
        std::shared_ptr<const LayerTable>& made = made_[family_ ? recipe.phase_text : ""];
        if (!made) {
            require(mixture_range(recipe) == nullptr, "scene", "table",
                    "one with a mixture axis alone where there are rings of two components",
                    "another family");
            made = make_layer_table(PackedTable(
                pack(table_at(*family_, family_point(*family_, recipe.phase_function)))));
        }
        check_table(scene, needed, made->packed);
        served_ = true;
        return made;
    }

    bool has_served() const noexcept { return served_; }

  private:
    std::optional<Table> family_;
    std::map<std::string, std::shared_ptr<const LayerTable>> made_;  // by phase function, or ""
    bool served_ = false;
};

/// The first of several tables that serves a light path of a scene. All are tried, so that those that
/// serve nothing are known.
std::shared_ptr<const LayerTable> served(std::vector<GivenTable>& given, const Scene& scene,
                                         const NeededRecipe& needed) {
    std::shared_ptr<const LayerTable> first;
    std::string refusal;
    for (GivenTable& table : given) {
        try {
            const std::shared_ptr<const LayerTable> serving = table.serve(scene, needed);
            if (!first) first = serving;
        } catch (const std::invalid_argument& refused) {
            refusal = refused.what();
        }
    }
    if (first) return first;
    if (needed.path != LightPath::sunlight)
        refusal += std::string(" (a table for ") + light_path_name(needed.path) +
                   ", or one for all light paths, is missing)";
    throw std::invalid_argument(refusal);
}

}  // namespace

SceneTables adopt_tables(const std::vector<Scene>& scenes, std::vector<PackedTable> tables) {
    std::vector<GivenTable> given;
    for (PackedTable& table : tables) given.emplace_back(std::move(table));
    std::vector<LayerTables> adopted;
    bool needs_any = false;
    for (const Scene& scene : channel_scenes(scenes)) {
        LayerTables& own = adopted.emplace_back();
        for (const NeededRecipe& needed : needed_recipes(scene)) {
            own.paths[static_cast<std::size_t>(needed.path)] = served(given, scene, needed);
            needs_any = true;
        }
    }
    for (std::size_t k = 0; k < given.size(); ++k)
        require(given[k].has_served() || !needs_any, "scene", "--table",
                "a table of something that the scene needs", "number " + std::to_string(k + 1));
    return scene_tables(scenes, adopted);
}

SceneTables bake_for(const std::vector<Scene>& scenes, const BakeOptions& options,
                     TableCache* cache) {
    return make_tables(
        scenes, [&](const Recipe& recipe) { return bake_layer_table(recipe, options, cache); });
}

SceneTables make_tables(const std::vector<Scene>& scenes, const TableMaker& make) {
    const std::vector<Scene> channels = channel_scenes(scenes);
    std::vector<LayerTables> made(channels.size());
    for (const SharedRecipe& shared : shared_recipes(channels)) {
        const std::shared_ptr<const LayerTable> table = make(shared.recipe);
        for (const std::size_t s : shared.scenes)
            made[s].paths[static_cast<std::size_t>(shared.path)] = table;
    }
    return scene_tables(scenes, made);
}

}  // namespace stratus
