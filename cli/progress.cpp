#include "progress.h"

#include <stratus/base/argument.h>
#include <stratus/base/size.h>

#include <iostream>
#include <unistd.h>

namespace stratus {
namespace {

constexpr int bar_width = 30;
constexpr double redraw_seconds = 0.1;
constexpr double line_seconds = 5;

double seconds(std::chrono::steady_clock::duration time) {
    return std::chrono::duration<double>(time).count();
}

}  // namespace

void say(std::string message) {
    std::ranges::replace(message, '\n', ' ');
    std::cerr << "stratus: " + shown(message, max_message) + '\n';
}

Progress::Progress(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { clear(); }

void Progress::operator()(double done, const std::string& stage) {
    if (quiet_) return;
    const auto now = Clock::now();
    if (stage != stage_ || done < done_) {
        stage_ = stage;
        started_ = shown_ = now;
    }
    done_ = done;
    const double elapsed = seconds(now - started_);
    const bool last = done >= 1;
    if (seconds(now - shown_) < (terminal_ ? redraw_seconds : line_seconds) && !(last && terminal_))
        return;
    shown_ = now;
    const double rate = elapsed > 0 ? 100 * done / elapsed : 0;
    const double left = done > 0 ? elapsed * (1 - done) / done : 0;
    if (!terminal_) {
        std::fprintf(stderr, "%s: %.0f %%, %.1f %%/s, %.0f s left\n", stage.c_str(), 100 * done,
                     rate, left);
        return;
    }
    const int filled = std::clamp(static_cast<int>(done * bar_width), 0, bar_width);
    std::fprintf(stderr, "\r\033[K%-9s [%s%s] %3.0f %%  %.1f %%/s  %.0f s left", stage.c_str(),
                 std::string(size(filled), '#').c_str(),
                 std::string(size(bar_width - filled), '.').c_str(), 100 * done, rate, left);
    std::fflush(stderr);
    drawn_ = true;
    if (last) clear();
}

void Progress::note(const std::string& line) {
    if (quiet_) return;
    clear();
    std::fprintf(stderr, "%s\n", shown(line, max_message).c_str());
}

void Progress::clear() {
    if (!drawn_) return;
    std::fprintf(stderr, "\r\033[K");
    std::fflush(stderr);
    drawn_ = false;
}

}  // namespace stratus
