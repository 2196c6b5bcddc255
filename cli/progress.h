// Long work as a terminal sees it. Lines on stderr: refusals, notes and warnings, and its progress, which is a bar
// with rate and time left on a terminal, plain lines otherwise, and nothing when quiet. Signals, which stop it.
#pragma once

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {

/// Writes the line "stratus: MESSAGE", made fit for a terminal as shown() does, at most `max_message` bytes.
void say(std::string message);

/// A text of at most 511 bytes, as printf writes it.
template <class... Arguments>
std::string formatted(const char* format, Arguments... arguments) {
    char text[512];
    std::snprintf(text, sizeof text, format, arguments...);
    return text;
}

class Progress {
  public:
    explicit Progress(bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Share done [0, 1] of a stage; a new stage, or less done than before, starts its own clock.
    void operator()(double done, const std::string& stage);

    /// A line of its own, clear of the bar.
    void note(const std::string& line);
    /// Notes that reading a file gave.
    void notes(const std::vector<std::string>& notes) {
        for (const std::string& each : notes) note("note: " + each);
    }

  private:
    using Clock = std::chrono::steady_clock;

    void clear();

    bool quiet_;
    bool terminal_;
    bool drawn_ = false;
    std::string stage_;
    double done_ = 0;
    Clock::time_point started_, shown_;
};

// Ctrl-C stops long work in order, whose pieces in progress are finished and kept, and leaves no partial files.

/// Records SIGINT, SIGTERM and SIGHUP during its scope instead of ending the program; a second
/// signal does end it. Ignored signals stay ignored.
///
/// Threads  one object at a time in a program.
class StopOnSignal {
  public:
    StopOnSignal() {
        received_ = 0;
        struct sigaction stop = {};
        stop.sa_handler = [](int signal) { received_ = signal; };
        stop.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
        for (int n = 0; n < count; ++n) {
            sigaction(signals[n], nullptr, &before_[n]);
            if (before_[n].sa_handler != SIG_IGN) sigaction(signals[n], &stop, nullptr);
        }
    }
    ~StopOnSignal() {
        for (int n = 0; n < count; ++n) sigaction(signals[n], &before_[n], nullptr);
    }
    StopOnSignal(const StopOnSignal&) = delete;
    StopOnSignal& operator=(const StopOnSignal&) = delete;

    /// The signal received; 0: none.
    static int signal() { return received_; }

  private:
    static constexpr int signals[] = {SIGINT, SIGTERM, SIGHUP};
    static constexpr int count = 3;

    static inline std::atomic<int> received_ = 0;
    static_assert(std::atomic<int>::is_always_lock_free);

    struct sigaction before_[count];
};

/// Blocks SIGINT, SIGTERM and SIGHUP during its scope, which must be short; one received meanwhile
/// ends the program at the end of the scope.
///
/// Threads  constructed while no other thread runs; threads started in its scope inherit it.
class SignalsHeld {
  public:
    SignalsHeld() {
        sigset_t blocked;
        sigemptyset(&blocked);
        for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&blocked, signal);
        pthread_sigmask(SIG_BLOCK, &blocked, &before_);
    }
    ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsHeld(const SignalsHeld&) = delete;
    SignalsHeld& operator=(const SignalsHeld&) = delete;

  private:
    sigset_t before_;
};

/// Ends the program with the exit code of a signal, 128 + signal.
class EndedBySignal : public std::runtime_error {
  public:
    EndedBySignal(int signal, const std::string& message)
        : std::runtime_error(message), exit_code(128 + signal) {}

    const int exit_code;
};

}  // namespace stratus
