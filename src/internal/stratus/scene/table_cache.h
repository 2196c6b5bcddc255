// Packed tables kept between runs: a folder with a file for each, found again by recipe.
//
// A file is named by a hash of what must be the same (phase functions, tolerance, discretisation,
// the program's version and the format's) and by what may be wider than asked: sides and ranges. It
// says both in full in its attribute `cache_key`. The scattering of droplets lies beside them, a file for
// each text of their parameters. A file that is damaged, foreign, or of another
// program is passed over, and replaced by the next table of its name. Each use makes a file the
// youngest; beyond the limit the oldest are removed.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/io/checkpoint.h>
#include <stratus/table/packed_table.h>

#include <cstdint>

namespace stratus {

class TableCache {
  public:
    /// The folder is made when the first table is kept. `limit` in bytes.
    TableCache(fs::path folder, std::uintmax_t limit);

    /// A table that serves the recipe: its own, or one with more sides or wider ranges.
    std::optional<PackedTable> find(const Recipe& recipe);

    /// Keeps a packed table, unless it alone exceeds the limit; what its file holds. `header`: the
    /// table with or without its samples.
    std::vector<char> keep(const Recipe& recipe, Table header, std::vector<char> packed);

    /// The choices that a plan has made of a recipe's discretisation, as pieces of its bake's log, and
    /// the place to keep more of them until the recipe's table is kept; null where there is no place.
    std::unique_ptr<Checkpoint> open_choices(const Recipe& recipe);

    /// Has the scattering of droplets kept in the folder, too, and found there.
    void keep_droplets() const;

    /// Why tables could not be kept; empty: they could.
    const std::string& trouble() const { return trouble_; }

  private:
    void remove_oldest(const fs::path& newest) const;

    fs::path folder_;
    std::uintmax_t limit_;
    std::string trouble_;
};

/// The limit of kept tables unless another is asked for, in bytes.
constexpr std::uintmax_t default_cache_limit = std::uintmax_t{2} << 30;

/// $STRATUS_CACHE, else $XDG_CACHE_HOME/stratus, else $HOME/.cache/stratus; empty where none is set.
fs::path default_cache_folder();

}  // namespace stratus
