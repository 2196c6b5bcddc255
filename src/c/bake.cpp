// Recipes baked, tables packed and written.
#include <stratus/bake/bake.h>
#include <stratus/io/atomic_file.h>
#include <stratus/io/table_file.h>
#include <stratus/stratus_baker.h>

#include "handles.h"

#include <atomic>
#include <filesystem>
#include <memory>

namespace stratus::c {
namespace {

Table baked(const char* recipe, const stratus_bake_options& asked, const char* function) {
    require(asked.threads >= 0, function, "options.threads", "at least 0", asked.threads);
    BakeOptions options;
    options.threads = asked.threads;
    if (asked.note)
        options.note = [&](const std::string& line) { asked.note(asked.user, line.c_str()); };
    std::atomic<bool> stop = false;
    if (asked.progress)
        options.progress = [&](double done, const std::string& stage) {
            if (asked.progress(asked.user, done, stage.c_str()) != 0) stop = true;
        };
    options.log.stop = [&] { return stop.load(); };
    std::vector<std::string> notes;
    const Recipe read = parse_recipe(recipe, asked.folder ? asked.folder : "", &notes);
    if (options.note)
        for (const std::string& note : notes) options.note(note);
    try {
        return bake(read, options);
    } catch (const WorkStopped&) {
        throw Stopped(std::string(function) + ": stopped by the program");
    }
}

/// A table's samples.
const Table& require_samples(const stratus_table* table, const char* function) {
    require_given(table, function, "table");
    const stratus::AnyTable& own = table->shared->own;
    require(own.packed() == nullptr, function, "table", "one with samples", "a packed one");
    return own.table();
}

}  // namespace
}  // namespace stratus::c

using namespace stratus::c;

int stratus_bake(const char* recipe, const stratus_bake_options* options, stratus_table** table) {
    const char* const function = __func__;
    return run_guarded([&] {
        require_given(table, function, "table");
        *table = nullptr;
        require_given(recipe, function, "recipe");
        if (options != nullptr) require_size(*options, function, "options");
        const stratus_bake_options asked = options ? *options : stratus_bake_options{};
        *table = make_handle(std::make_shared<const SharedTable>(baked(recipe, asked, function)));
    });
}

int stratus_table_pack(const stratus_table* table, stratus_table** packed) {
    const char* const function = __func__;
    return run_guarded([&] {
        require_given(packed, function, "packed");
        *packed = nullptr;
        const std::vector<char> bytes = stratus::pack(require_samples(table, function));
        *packed = make_handle(std::make_shared<const SharedTable>(stratus::PackedTable(bytes)));
    });
}

int stratus_table_write(const stratus_table* table, const char* path) {
    const char* const function = __func__;
    return run_guarded([&] {
        const stratus::Table& samples = require_samples(table, function);
        require_given(path, function, "path");
        if (std::filesystem::path(path).extension() == stratus::packed_ending)
            return stratus::write_content_atomically(path, stratus::pack(samples));
        const std::unique_lock lock = hdf5_lock();
        stratus::write_table(samples, path);
    });
}
