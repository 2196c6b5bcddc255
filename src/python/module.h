// The extension _stratus: the libraries' own functions over flat NumPy arrays.
//
// Users see the Python package over it, src/python/stratus, which broadcasts arrays, names
// arguments and documents them. Functions here take arrays of equal lengths, contiguous, and let
// other Python threads run while they compute.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/base/argument.h>
#include <stratus/layer/effects.h>
#include <stratus/layer/lower_boundary.h>

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <future>
#include <limits>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace stratus::python {

namespace py = pybind11;

constexpr int contiguous = py::array::c_style | py::array::forcecast;
using Doubles = py::array_t<double, contiguous>;
using Floats = py::array_t<float, contiguous>;

void add_phase(py::module_& module);
void add_solve(py::module_& module);
void add_bake(py::module_& module);
void add_table(py::module_& module);
void add_slice(py::module_& module);
void add_scene(py::module_& module);
void add_fit(py::module_& module);

/// Returns work(), during which other Python threads run.
template <class Work>
auto without_lock(const Work& work) {
    const py::gil_scoped_release release;
    return work();
}

inline std::size_t element_count(const py::array& array) {
    return static_cast<std::size_t>(array.size());
}

/// An array that takes over what a vector holds.
template <class Number>
py::array_t<Number> numpy_array(std::vector<Number> values) {
    auto* const kept = new std::vector<Number>(std::move(values));
    const py::capsule owner(kept, [](void* of) { delete static_cast<std::vector<Number>*>(of); });
    return py::array_t<Number>(static_cast<py::ssize_t>(kept->size()), kept->data(), owner);
}

/// The range that a number must be in.
struct Allowed {
    double lowest, highest;
    const char* text;
    bool above_lowest = false;  // which is not allowed itself

    bool holds(double value) const {
        return value <= highest && (above_lowest ? value > lowest : value >= lowest);
    }
};

constexpr Allowed allowed_cosine{0, 1, "in (0, 1]", true};

constexpr Allowed allowed_angle{std::numeric_limits<double>::lowest(),
                                std::numeric_limits<double>::max(), "finite, in radians"};
constexpr Allowed allowed_random{0, 1, "in [0, 1]"};

/// Refuses the first of many numbers that is not allowed.
template <class Number>
void require_all(const Number* values, std::size_t count, const char* function,
                 const char* argument, const Allowed& allowed) {
    for (std::size_t i = 0; i < count; ++i)
        if (!allowed.holds(static_cast<double>(values[i])))  // not-a-number never holds
            require(false, function, argument, allowed.text, values[i]);
}

/// None, the albedo of a surface, or a phase function with an albedo.
LowerBoundary make_lower_boundary(const py::object& below);

/// Law, "", "blinn" or "hapke"; width, 0: of the density; amplitude.
using OppositionParts = std::tuple<std::string, double, double>;
Opposition make_opposition(const OppositionParts& parts);

// Long work that Ctrl-C stops, and that tells Python how far it is.
//
// The work runs on threads of its own. The thread that asked for it hands on what they tell, ten
// times a second, and raises what Python raises there: KeyboardInterrupt, or a callback's own
// exception. The work is then stopped, and nothing of it is left.

/// Messages of working threads that Python does not know yet.
class Told {
  public:
    void note(const std::string& line) {
        const std::lock_guard lock(mutex_);
        notes_.push_back(line);
    }

    void progress(double done, const std::string& stage) {
        const std::lock_guard lock(mutex_);
        if (!stages_.empty() && stages_.back().second == stage)
            stages_.back().first = done;
        else
            stages_.emplace_back(done, stage);
    }

    void hand_on(const py::object& note, const py::object& progress) {
        std::vector<std::string> notes;
        std::vector<std::pair<double, std::string>> stages;
        {
            const std::lock_guard lock(mutex_);
            notes.swap(notes_);
            stages.swap(stages_);
        }
        if (!note.is_none())
            for (const std::string& line : notes) note(line);
        if (!progress.is_none())
            for (const auto& [done, stage] : stages) progress(done, stage);
    }

  private:
    std::mutex mutex_;
    std::vector<std::string> notes_;
    std::vector<std::pair<double, std::string>> stages_;
};

/// work(options) with `threads` threads. `note`, `progress`: callables or None.
template <class Work>
auto run_long(int threads, const py::object& note, const py::object& progress, const Work& work,
              BakeOptions options = {}) {
    require(threads >= 0 && threads <= 1024, "stratus", "threads", "in [0, 1024]", threads);
    Told told;
    std::atomic<bool> stop{false};
    options.threads = threads;
    options.note = std::bind_front(&Told::note, &told);
    options.progress = std::bind_front(&Told::progress, &told);
    options.log.stop = [&] { return stop.load(); };
    auto result = std::async(std::launch::async, [&] { return work(options); });
    for (bool done = false; !done;) {
        {
            const py::gil_scoped_release release;
            done = result.wait_for(std::chrono::milliseconds(100)) == std::future_status::ready;
        }
        try {
            told.hand_on(note, progress);
            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        } catch (...) {
            stop = true;
            const py::gil_scoped_release release;
            result.wait();
            throw;
        }
    }
    return result.get();
}

}  // namespace stratus::python
