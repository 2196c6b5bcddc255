#include <stratus/scene/table_cache.h>

#include <stratus/bake/bake.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/io/file_bytes.h>
#include <stratus/phase/mie.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace stratus {
namespace {

constexpr const char* key_attribute = "cache_key";
constexpr const char* choices_ending = ".choices";
constexpr const char* droplets_ending = ".droplets";
constexpr const char* scattering_piece = "scattering";

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
    const bool to_infinity = recipe.optical_depth.max > 1e300,
               infinite = to_infinity && recipe.optical_depth.min == recipe.optical_depth.max;
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
    return joined(fields, "_") + packed_ending;
}

/// The fields of a file's name; empty: of none of ours.
std::vector<std::string> name_fields(const fs::path& path) {
    const bool of_droplets = path.extension() == droplets_ending;
    if (path.extension() != packed_ending && path.extension() != choices_ending && !of_droplets)
        return {};
    std::istringstream stem(path.stem().string());
    std::vector<std::string> fields;
    for (std::string field; std::getline(stem, field, '_');) fields.push_back(field);
    const bool ours = (of_droplets ? fields.size() == 1 : fields.size() > 2) &&
                      fields[0].size() == 16 &&
                      fields[0].find_first_not_of("0123456789abcdef") == std::string::npos;
    return ours ? fields : std::vector<std::string>{};
}

/// Whether a file of such a name serves a recipe.
bool serves(const fs::path& path, const Recipe& recipe, const std::string& kind) {
    const std::vector<std::string> fields = name_fields(path);
    const std::vector<Range> asked = recipe_ranges(recipe);
    if (path.extension() != packed_ending || fields.size() != 2 + 2 * asked.size() ||
        fields[0] != kind)
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

/// Makes a file the youngest.
void mark_used(const fs::path& path) {
    std::error_code ignored;  // of a folder that is only read
    fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);
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
        mark_used(file.path);
        return table;
    }
    return std::nullopt;
}

std::vector<char> TableCache::keep(const Recipe& recipe, Table header, std::vector<char> packed) {
    header.attributes[key_attribute] = file_name(recipe) + "\n" + table_kind(recipe);
    packed = restated({packed.data(), packed.size()}, header);
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

void TableCache::keep_droplets() const {
    if (limit_ == 0) return;
    const auto path_of = [folder = folder_](const std::string& droplets) {
        return folder / (text_hash(droplets) + droplets_ending);
    };
    const auto open = [=](const std::string& droplets) {
        fs::create_directories(path_of(droplets).parent_path());
        return Checkpoint(path_of(droplets), {baking_program(), droplets});
    };
    Mie::Store store;
    store.find = [=](const std::string& droplets) -> std::optional<std::vector<double>> {
        try {
            const auto bytes = open(droplets).find(scattering_piece);
            if (!bytes) return std::nullopt;
            mark_used(path_of(droplets));
            std::vector<double> numbers(bytes->size() / sizeof(double));
            std::memcpy(numbers.data(), bytes->data(), numbers.size() * sizeof(double));
            return numbers;
        } catch (const std::exception&) {  // of another process, or of a folder that is only read
            return std::nullopt;
        }
    };
    store.keep = [=](const std::string& droplets, const std::vector<double>& numbers) {
        try {
            open(droplets).keep(scattering_piece, {reinterpret_cast<const char*>(numbers.data()),
                                                   numbers.size() * sizeof(double)});
        } catch (const std::exception&) {
        }
    };
    Mie::keep_scattering_in(std::move(store));
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

}  // namespace stratus
