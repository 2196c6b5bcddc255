// Long work that Ctrl-C stops, and that tells Python how far it is.
//
// The work runs on threads of its own. The thread that asked for it hands on what they tell, ten
// times a second, and raises what Python raises there: KeyboardInterrupt, or a callback's own
// exception. The work is then stopped, and nothing of it is left.
#pragma once

#include <stratus/bake/bake.h>

#include "module.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace stratus::python {

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
    options.note = [&](const std::string& line) { told.note(line); };
    options.progress = [&](double done, const std::string& stage) { told.progress(done, stage); };
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
