#include "bake.h"

#include <algorithm>
#include <cstdlib>
#include <dlfcn.h>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace stratus {
namespace {

namespace fs = std::filesystem;

/// A number in the environment; 0 where there is none.
int number_in(const char* variable) {
    const char* const text = std::getenv(variable);
    return text == nullptr ? 0 : std::max(0, std::atoi(text));
}

/// Ranks announced by mpirun (OpenMPI, or with a PMI) or by srun with a PMI of its own; 1: none.
int announced_count() {
    int count = 1;
    for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
        count = std::max(count, number_in(variable));
    if (std::getenv("PMIX_RANK") != nullptr)
        count = std::max(count, number_in("SLURM_STEP_NUM_TASKS"));
    return count;
}

bool was_started_as_rank() {
    for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"})
        if (std::getenv(variable) != nullptr) return true;
    return false;
}

/// The plugin lies beside the program, or where both are installed.
void* load_plugin() {
    constexpr const char* name = "libstratus_ranks.so";
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    for (const fs::path& folder : {program, program / STRATUS_PLUGINS_FROM_PROGRAM})
        if (fs::exists(folder / name, ignored)) {
            void* const plugin = ::dlopen((folder / name).c_str(), RTLD_NOW | RTLD_GLOBAL);
            if (plugin == nullptr) throw std::runtime_error(::dlerror());
            return plugin;
        }
    throw std::runtime_error(std::string(name) + " is missing: stratus was built without MPI");
}

}  // namespace

std::unique_ptr<RankTransport> started_ranks() {
    if (!was_started_as_rank()) return nullptr;
    const int announced = announced_count();
    try {
        const auto start = reinterpret_cast<StartRanks*>(::dlsym(load_plugin(), start_ranks_name));
        if (start == nullptr) throw std::runtime_error(::dlerror());
        std::unique_ptr<RankTransport> ranks(start());
        if (ranks->count() < announced)
            throw std::runtime_error("the library of MPI is not that of this mpirun or srun");
        return ranks;
    } catch (const std::exception& error) {
        if (announced == 1) return nullptr;
        throw std::runtime_error("started as one of " + std::to_string(announced) +
                                 " ranks, but: " + error.what());
    }
}

int threads_of_rank(const RankTransport& ranks) {
    const long all = ::sysconf(_SC_NPROCESSORS_ONLN);
    const long own = std::thread::hardware_concurrency();  // that it may run on
    return static_cast<int>(
        std::max(1L, std::min(own, all / std::max(1, ranks.count_on_this_machine()))));
}

}  // namespace stratus
